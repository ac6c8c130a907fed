//! Does `docs/stability.md` show what `docs/data/weak_form_map.jsonl` holds, and does the criterion say what happened there?

use dcb_tests::hard::dynamics::weak_form_map::{
    FULL, MARKERS, RULE_MARKERS, cells, measure, render, render_rules, write_picture,
};

fn docs(file: &str) -> String {
    std::fs::read_to_string(format!("{}/../docs/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[test]
fn the_page_is_what_the_raw_lines_render_to() {
    let page = docs("stability.md");
    let (_, rest) = page.split_once(MARKERS[0]).expect("the first marker");
    let (generated, _) = rest.split_once(MARKERS[1]).expect("the second marker");
    assert!(
        generated == render(&docs("data/weak_form_map.jsonl")),
        "paste what `--example weak_form_map -- --render` prints"
    );
}

#[test]
fn the_rules_are_what_the_raw_lines_render_to() {
    let page = docs("stability.md");
    let (_, rest) = page.split_once(RULE_MARKERS[0]).expect("the first marker");
    let (generated, _) = rest.split_once(RULE_MARKERS[1]).expect("the second marker");
    assert!(generated == render_rules(&docs("data/weak_form_map.jsonl")));
}

#[test]
fn the_picture_is_what_the_raw_lines_draw() {
    let folder = tempfile::tempdir().unwrap();
    write_picture(&docs("data/weak_form_map.jsonl"), folder.path());
    let drawn = std::fs::read_to_string(folder.path().join("weak-form-map.svg")).unwrap();
    assert!(drawn == docs("pictures/weak-form-map.svg"));
}

#[test]
fn the_criterion_holds_in_every_cell() {
    let raw = docs("data/weak_form_map.jsonl");
    assert!(raw.lines().next().unwrap().contains("\"machine\""));
    let cells = cells(&raw);
    assert_eq!(
        cells.len(),
        FULL.steps.len() * FULL.radii.len() * FULL.modes.len()
    );
    for cell in cells {
        assert!(!cell.contradicts(), "{cell:?}");
    }
}

/// `cargo test --release -p dcb-tests --test published pages::stability -- --ignored`
#[test]
#[ignore = "364 runs of up to 20000 steps"]
fn the_map_comes_out_again() {
    for (now, then) in measure(&FULL)
        .iter()
        .zip(cells(&docs("data/weak_form_map.jsonl")))
    {
        assert_eq!(
            (now.steps, now.radius, now.modes),
            (then.steps, then.radius, then.modes)
        );
        assert_eq!(now.is_stable(), then.is_stable(), "{now:?}, {then:?}");
    }
}
