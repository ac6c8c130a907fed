//! What a newcomer types first: drafts, scenes from standard input, comments, options of other commands, and mistakes in a first scene.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::support::{Folder, says};

/// A row of a table by the names of its columns; the header is row 0, the last one -1.
fn row(folder: &Folder, name: &str, index: isize) -> BTreeMap<String, f64> {
    let table = folder.read(name);
    let lines: Vec<&str> = table.lines().collect();
    let line = lines[index.rem_euclid(lines.len() as isize) as usize];
    let names = lines[0]
        .split(',')
        .map(|name| name.split(' ').next().unwrap().to_owned());
    names
        .zip(line.split(',').map(|number| number.parse().unwrap()))
        .collect()
}

#[test]
fn a_draft_runs_as_it_stands() {
    let folder = Folder::slider_crank();
    folder.done("init rod.dcb.h5 -o one.json");
    let text = folder.read("one.json");
    assert!(
        text.contains("// ") && text.contains("\"gravity\""),
        "{text}"
    );
    let answer = folder.done("one.json");
    assert!(!answer.stderr.contains("warning"), "{}", answer.stderr);
    // Two of the same part are one behind the other.
    folder.done("init rod.dcb.h5 rod.dcb.h5 -o two.json");
    folder.done("two.json --end 0.01 --csv two.csv");
    let first = row(&folder, "two.csv", 1);
    assert!((first["tip.x"] - 0.6).abs() < 1e-9 && first["tip.y"].abs() < 1e-9);
    folder.refused("init rod.dcb.h5 -o two.json", &["two.json", "--force"]);
    folder.refused("init rod.dcb.h5 -o rod.dcb.h5 --force", &["rod.dcb.h5"]);
    folder.refused("init nothing.dcb.h5 -o n.json", &["nothing.dcb.h5"]);
}

/// The draft falls as a rigid pendulum does, whose period for small angles is known: the free fall of its start is that of a rod about its end.
#[test]
fn a_draft_falls_as_a_rod_on_a_hinge() {
    let folder = Folder::slider_crank();
    folder.done("init rod.dcb.h5 -o one.json");
    folder.done("one.json --end 0.02 --csv one.csv");
    let last = row(&folder, "one.csv", -1);
    // A uniform rod from the horizontal: angular acceleration 3 g/(2 l), so that the tip falls 3/4 g t².
    let (time, tip) = (last["time"], last["tip.y"]);
    let expected = -0.75 * 9.81 * time * time;
    assert!((tip / expected - 1.0).abs() < 0.02, "{tip} {expected}");
}

#[test]
fn comments_keep_the_places_of_errors() {
    let folder = Folder::slider_crank();
    let text = folder.read("scene.json");
    let with = text.replacen(
        '{',
        "{ // a slider-crank: http://example.org\n/* two\nlines */",
        1,
    );
    folder.write("commented.json", with.clone());
    folder.done("commented.json --end 1e-4");
    folder.write("wrong.json", with.replace("\"rigid\"", "\"rigit\""));
    folder.refused("wrong.json", &["wrong.json:", "rigit"]);
    folder.write("open.json", text.replacen('{', "{ /* no end", 1));
    folder.refused("open.json", &["open.json"]);
    // A string that looks like a comment is none.
    let mut scene: Value = serde_json::from_str(&text).unwrap();
    scene["constants"] = json!({"rate": 150});
    scene["drives"]["motor"]["angle"] = json!({"joint": "axle", "formula": "rate*t/1"});
    folder.write("formula.json", scene.to_string());
    folder.done("formula.json --end 1e-4");
}

#[test]
fn options_of_other_commands_name_them() {
    let folder = Folder::slider_crank();
    folder.refused(
        "scene.json --modes 3",
        &["--modes", "`simulate study`", "`reduce`"],
    );
    folder.refused("plot scene.h5 --step 3", &["--step", "`simulate`"]);
    folder.refused(
        "scene.json --nonsense",
        &["unexpected argument '--nonsense'"],
    );
}

#[test]
fn a_first_scene_is_told_what_to_write() {
    let folder = Folder::slider_crank();
    let scene: Value = serde_json::from_str(&folder.read("scene.json")).unwrap();
    let refused = |change: &dyn Fn(&mut Value), said: &[&str]| {
        let mut changed = scene.clone();
        change(&mut changed);
        folder.write("changed.json", changed.to_string());
        folder.refused("changed.json", said);
    };
    refused(
        &|scene| scene["gravity"] = json!(-9.81),
        &["gravity", "[0, 0, -9.81]"],
    );
    refused(
        &|scene| scene["integrator"]["hht"] = json!({"step": 1e-4, "end": 1}),
        &["`generalized_alpha`", "`hht`", "only one kind"],
    );
    refused(
        &|scene| {
            scene["drives"]["motor"]["angle"] = json!({"joint": "axle", "formula": "mini(t, 1)"})
        },
        &["`mini`", "min", "atan2", "step"],
    );
    refused(
        &|scene| scene["integrator"]["generalized_alpha"]["step"] = json!(1),
        &["step", "end"],
    );
    let typed = scene.to_string().replace(
        "{\"revolute\":{\"a\":\"ground\",\"b\":\"crank/axle\"}}",
        "{\"type\":\"revolute\",\"a\":\"ground\",\"b\":\"crank/axle\"}",
    );
    folder.write("changed.json", typed);
    folder.refused("changed.json", &["{\"revolute\": {...}}", "\"type\""]);
    let mut allowed = scene.clone();
    allowed["bodies"]["slider"]["position"] = json!([0.95, 0]);
    folder.write("far.json", allowed.to_string());
    let far = folder.run("far.json");
    assert_eq!(far.code, Some(1));
    says!(far.stderr, "bodies.slider.position", " m away", "allow_gap");
    allowed["bodies"]["slider"]["position"] = json!([0.95, 0]);
    allowed["initial"] = json!({"allow_gap": 1});
    folder.write("allowed.json", allowed.to_string());
    let answer = folder.done("allowed.json --end 1e-4");
    assert!(
        answer
            .stderr
            .contains("assembly moved body \"slider\" by 0.5000 m to close"),
        "{}",
        answer.stderr
    );
}

#[test]
fn colours_are_as_asked() {
    let folder = Folder::slider_crank();
    let plain = folder.refused("nothing.json", &["nothing.json"]);
    assert!(!plain.contains('\u{1b}'));
    let coloured = folder
        .command("nothing.json --color always")
        .output()
        .unwrap();
    assert!(coloured.stderr.contains(&0x1b));
}

#[test]
fn components_are_named_and_pictures_drawn_again() {
    let folder = Folder::slider_crank();
    folder.done("scene.json --end 0.001");
    folder.done("csv scene.h5 slider_position.x -o x.csv");
    let header = folder.read("x.csv").lines().next().unwrap().to_owned();
    assert!(
        header.ends_with("slider_position.x [m]") && header.matches(',').count() == 1,
        "{header}"
    );
    folder.done("csv scene.h5 slider_position.y,crank_angle slider_position -o y.csv");
    let header = folder.read("y.csv").lines().next().unwrap().to_owned();
    let names: Vec<&str> = header.split(',').skip(1).collect();
    assert_eq!(names[..2], ["slider_position.y [m]", "crank_angle [rad]"]);
    // The rest of the channel, of which y was there already.
    assert_eq!(names[2..], ["slider_position.x [m]"]);
    folder.refused(
        "csv scene.h5 slider_position.w -o w.csv",
        &["slider_position.w"],
    );
    folder.refused(
        "csv scene.h5 nothing.x -o w.csv",
        &["nothing.x", "isn't a channel"],
    );
    folder.done("plot scene.h5 slider_position.x");
    folder.done("plot scene.h5 crank_angle");
    folder.write("other.svg", "no picture");
    folder.refused("plot scene.h5 -o other.svg", &["other.svg", "--force"]);
}

/// A moment and an energy have one dimension, but are no one quantity.
#[test]
fn moments_and_energies_have_their_own_charts() {
    let folder = Folder::slider_crank();
    let mut scene: Value = serde_json::from_str(&folder.read("scene.json")).unwrap();
    scene["outputs"] = json!({"balance": "energy", "torque": {"drive_effort": {"drive": "motor"}}});
    folder.write("scene.json", scene.to_string());
    folder.done("scene.json --end 0.001");
    folder.done("plot scene.h5");
    let picture = folder.read("scene.svg");
    assert!(
        picture.contains("energy [J]") && picture.contains("torque [N·m]"),
        "{picture}"
    );
}
