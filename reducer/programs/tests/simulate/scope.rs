//! Runs beyond what their superelements were made for: told with the number, and not told where there is nothing.

use dcb_formats::dcb::read_superelement;
use dcb_formats::mesh::Direction;
use dcb_superelement::selection::{InterfaceSelection, Selection};
use serde_json::{Value, json};

use crate::support::{Answer, Folder, says};

/// A beam that is clamped at `a` with this force at `b`.
fn pushed(force: Value, modes: usize) -> Folder {
    let scene = json!({
        "dimension": 3,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "bodies": {"beam": {"superelement": "beam.dcb.h5", "damping": {"modal": 0.1}}},
        "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
        "loads": {"push": {"force": {"at": "beam/b", "components": force}}},
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 0.05}}
    });
    Folder::beam_with_modes(&scene, modes)
}

/// The beam's attachments at `b` answer to forces in these directions from now on.
fn made_for(folder: &Folder, directions: &[Direction]) {
    let whole = read_superelement(&folder.path("beam.dcb.h5")).unwrap();
    let mut names = whole.interfaces.iter().map(|interface| &interface.name);
    let b = names.position(|name| name == "b").unwrap();
    let along = InterfaceSelection::along(&whole, b, directions);
    let selection = Selection::everything(&whole);
    let selection = selection.with_interface("b", along).unwrap();
    let along = selection.superelement(&whole).unwrap();
    folder.store_superelement("beam.dcb.h5", &along);
}

fn told(answer: &Answer) -> Vec<&str> {
    let lines = answer.stderr.lines();
    lines
        .filter(|line| line.contains("made for") || line.contains("is in motion above"))
        .collect()
}

#[test]
fn forces_along_directions_that_were_left_out_are_told_with_their_share() {
    let folder = pushed(json!([0, 3, 4]), 3);
    assert!(told(&folder.done("scene.json -o all.h5")).is_empty());
    // 4 of 5 newtons act along z.
    made_for(&folder, &[Direction::Ux, Direction::Uy]);
    for options in ["", "--force --model everything"] {
        let answer = folder.done(&format!("scene.json {options}"));
        let lines = told(&answer);
        println!("{lines:?}");
        assert_eq!(lines.len(), 1, "{answer:?}");
        for text in [
            "interface \"b\" of body \"beam\"",
            "by 80 % of its largest force",
            "reduce --scene",
        ] {
            assert!(lines[0].contains(text), "no {text:?} in {lines:?}");
        }
        let stored = folder.told().join("\n");
        assert_eq!(
            stored.matches("by 80 % of its largest force").count(),
            1,
            "{stored}"
        );
    }
    // An equilibrium as well.
    folder.set_scene("analysis", "static");
    let answer = folder.done("scene.json --force");
    says!(told(&answer)[0], "by 80 %");
    let within = pushed(json!([1, 3, 0]), 3);
    made_for(&within, &[Direction::Ux, Direction::Uy]);
    assert!(told(&within.done("scene.json")).is_empty());
}

#[test]
fn motion_above_the_modes_is_told_and_slow_motion_is_not() {
    let of_modes = |folder: &Folder| {
        let superelement = read_superelement(&folder.path("beam.dcb.h5")).unwrap();
        superelement.modes.first_omitted_eigenvalue.sqrt()
    };
    let omitted = of_modes(&pushed(json!([0, 1, 0]), 6));
    let shaken = |times: f64| {
        let omega = times * omitted;
        let force = json!({"formula": format!("sin({omega:e}*t)*(1 - exp(-({omega:e}*t/60)^2))")});
        let folder = pushed(json!([0, force, 0]), 6);
        folder.edit("scene.json", |scene| {
            let step = 2e-2 / omega.max(omitted);
            scene["integrator"]["generalized_alpha"]["step"] = json!(step);
            scene["integrator"]["generalized_alpha"]["end"] = json!(12000.0 * step);
            scene["record"] = json!({"every": 7});
        });
        folder.done("scene.json --model everything")
    };
    let slow = shaken(0.02);
    assert!(told(&slow).is_empty(), "{slow:?}");
    let fast = shaken(2.0);
    let lines = told(&fast);
    assert_eq!(lines.len(), 1, "{fast:?}");
    let percent = lines[0].split(" % of").next().unwrap();
    let percent = percent.split_whitespace().last().unwrap();
    println!("{lines:?}");
    assert!(percent.parse::<f64>().unwrap() > 50.0, "{lines:?}");
    says!(lines[0], "where its superelement's modes end");
}
