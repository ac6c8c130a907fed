//! Puts the raw lines of `docs/data` on other programs' files into their pages: `cargo run --release -p dcb-tests --example render_pages`.

use dcb_tests::pages::{exchange, fuzzing, read_matrices};

fn main() {
    for page in [
        exchange::READ,
        exchange::WRITTEN,
        read_matrices::PAGE,
        fuzzing::PAGE,
    ] {
        page.write();
    }
}
