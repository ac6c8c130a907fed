//! Prints the JSON schema of the scene file: `docs/scene.schema.json` is its output.

fn main() {
    println!("{:#}", dcb_formats::scene::scene_schema());
}
