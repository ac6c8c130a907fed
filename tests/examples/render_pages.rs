//! Puts the raw lines of `docs/data` into their pages: `cargo run --release -p dcb-tests --example render_pages`.

use dcb_tests::pages::{
    campbell, damping, exchange, fuzzing, hard_cases, html_pages, machine, python, random_response,
    read_matrices, scene_driven, stress,
};

fn main() {
    for page in [
        exchange::READ,
        exchange::WRITTEN,
        read_matrices::PAGE,
        python::COST,
        python::LOOP,
        fuzzing::PAGE,
        html_pages::PAGE,
        campbell::PAGE,
        hard_cases::PAGE,
        scene_driven::PAGE,
        damping::PAGE,
        random_response::PAGE,
        machine::ASSEMBLY,
        machine::RESPONSES,
        stress::PAGE,
    ] {
        page.write();
    }
}
