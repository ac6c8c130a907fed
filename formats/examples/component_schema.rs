//! Prints the JSON schema of the component file: `docs/component.schema.json` is its output.

fn main() {
    println!("{:#}", dcb_formats::component_schema());
}
