//! Do `docs/speed-against-error.md` and its pictures show what `docs/data/speed_against_error.jsonl` holds?

use dcb_tests::pages::speed_against_error::{MARKERS, pictures, render, write};

fn docs(file: &str) -> String {
    std::fs::read_to_string(format!("{}/../docs/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[test]
fn the_page_is_what_the_raw_lines_render_to() {
    let page = docs("speed-against-error.md");
    let (_, rest) = page.split_once(MARKERS[0]).expect("the first marker");
    let (generated, _) = rest.split_once(MARKERS[1]).expect("the second marker");
    assert!(
        generated == render(&docs("data/speed_against_error.jsonl")),
        "paste what `--example speed_against_error` prints"
    );
}

#[test]
fn the_pictures_are_what_the_raw_lines_draw() {
    let raw = docs("data/speed_against_error.jsonl");
    let folder = tempfile::tempdir().unwrap();
    write(&raw, folder.path());
    let page = docs("speed-against-error.md");
    for (name, _) in pictures(&raw) {
        let drawn = std::fs::read_to_string(folder.path().join(&name)).unwrap();
        assert!(drawn == docs(&format!("pictures/{name}")), "{name}");
        assert!(page.contains(&format!("(pictures/{name})")), "{name}");
    }
}
