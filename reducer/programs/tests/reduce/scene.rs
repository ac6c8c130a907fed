//! Reducing a part for a scene: what is printed, what is written, what is refused.

use std::fs;

use dcb_runtime::{Mechanism, Scene};
use dcb_samples::SolidElement;
use dcb_tests::parts::steel_box;
use serde_json::json;

use crate::support::{Folder, list, node_at, number, says, stored, with_ends};

/// The planar rod and the slider-crank that it belongs to, whose steps are ten times as long, so that the rod's four elements have enough modes.
fn slider_crank() -> Folder {
    let folder = Folder::rod();
    let scene = fs::read_to_string(stored("samples/slider-crank/scene.json")).unwrap();
    folder.write("scene.json", scene);
    folder.set("scene.json", "integrator/generalized_alpha/step", 1e-4);
    folder
}

#[test]
fn the_rod_of_the_slider_crank_is_reduced_for_it() {
    let folder = slider_crank();
    let shown = folder.done("rod.mtx --scene scene.json --tolerance 1e-3");
    says!(
        shown,
        "in scene.json the part's responses are right within",
        "(allowed 1.0e-03)",
        " dynamic attachments (",
        "fields of 1 of 5 nodes"
    );
    assert!(!shown.contains("which asks"), "{shown}");
    let shown = folder
        .run("rod.mtx --scene scene.json --tolerance 1e-3 --force -v")
        .stdout;
    says!(
        shown,
        "made for scene.json, which asks",
        "interface    \"a\" takes fx fy from joints.wrist",
        "node         2 for outputs.midpoint_deflection",
        "fields of 1 of 5 nodes",
        " dynamic attachments (",
        "error of the responses certified between",
        "tolerance 1.0e-03"
    );
    folder.done("verify rod.dcb.h5");
    let verified = folder.done("verify rod.dcb.h5 --component rod.mtx -v");
    says!(verified, "taken out of a larger superelement");
    // It is all in the file.
    let inspected = folder.done("inspect rod.dcb.h5 -v");
    says!(inspected, "made for scene.json, which asks");
    let found = folder.inspected("rod.dcb.h5");
    let fit = &found["quality"]["scene"];
    assert!(
        number(&fit["certified"]) <= 0.5e-3 && number(&fit["total"]) <= 1e-3,
        "{fit}"
    );
    assert!(number(&fit["certified"]) <= number(&fit["total"]));
    assert_eq!(fit["bodies"], json!(["rod"]));
    assert_eq!(
        found["options"]["scene"],
        json!({"file": "scene.json", "bodies": ["rod"], "tolerance": 1e-3})
    );
    let modes = list(&found["eigenvalues"]).len();
    assert_eq!(fit["kept"]["modes"]["kept"], json!(modes));
    assert_eq!(list(&found["quality"]["mode_residuals"]).len(), modes);
}

/// By accuracy no step says which motion matters: the scene says so itself, and the result is as certain as with steps.
#[test]
fn a_scene_by_accuracy_says_which_motion_matters() {
    let folder = slider_crank();
    let end = folder.json("scene.json")["integrator"]["generalized_alpha"]["end"].clone();
    let radau = |more: serde_json::Value| {
        let mut all = json!({"tolerance": 1e-5, "end": end});
        for (key, value) in more.as_object().unwrap() {
            all[key] = value.clone();
        }
        folder.set("scene.json", "integrator", json!({"radau": all}));
    };
    radau(json!({}));
    let shown = folder.done("rod.mtx --scene scene.json --tolerance 1e-3");
    assert!(!shown.contains("(allowed 1.0e-03)"), "{shown}");
    radau(json!({"highest_frequency": 537}));
    let shown = folder.done("rod.mtx --scene scene.json --tolerance 1e-3 --force");
    says!(
        shown,
        "in scene.json the part's responses are right within",
        "(allowed 1.0e-03)"
    );
    let fit = folder.inspected("rod.dcb.h5")["quality"]["scene"].clone();
    assert!(number(&fit["certified"]) <= 0.5e-3, "{fit}");
    folder.done("verify rod.dcb.h5");
    radau(json!({"highest_frequency": -1}));
    folder.refused(
        "rod.mtx --scene scene.json --force",
        &["integrator.radau.highest_frequency", "is -1"],
    );
}

#[test]
fn bodies_are_found_by_file_or_named() {
    let folder = slider_crank();
    // By the part's own name, whatever the output is called.
    folder.done("rod.mtx --scene scene.json -o other.dcb.h5");
    folder.set("scene.json", "bodies/rod/superelement", "arm.dcb.h5");
    folder.done("rod.mtx --scene scene.json -o arm.dcb.h5");
    folder.done("rod.mtx --scene scene.json --body rod");
    let says = [
        "scene.json: no body is made of x.dcb.h5",
        "\"rod\" (arm.dcb.h5)",
        "\"crank\" (rigid)",
        "--body",
    ];
    folder.refused("rod.mtx --scene scene.json -o x.dcb.h5", &says);
    let says = [
        "no superelement is called \"crank\"",
        "\"rod\" (arm.dcb.h5)",
    ];
    folder.refused_each(&[
        ("rod.mtx --scene scene.json -o x.dcb.h5 --body crank", &says),
        (
            "rod.mtx --scene scene.json -o x.dcb.h5 --body rod,wheel",
            &["no superelement is called \"wheel\""],
        ),
    ]);
}

#[test]
fn slips_and_broken_scenes_are_refused() {
    let folder = slider_crank();
    for (arguments, says) in [
        ("--scene scene.json --tolerance 0", "above 0 and below 1"),
        ("--scene scene.json --tolerance 1", "above 0 and below 1"),
        (
            "--scene scene.json --tolerance -1e-3",
            "above 0 and below 1",
        ),
        ("--scene scene.json --tolerance nan", "above 0 and below 1"),
        ("--tolerance 1e-3", "--scene <SCENE.json>"),
        ("--body rod", "--scene <SCENE.json>"),
        (
            "--scene scene.json --max-frequency 100",
            "cannot be used with",
        ),
        (
            "--scene scene.json --interface-modes 2",
            "cannot be used with",
        ),
        ("--scene scene.json --without-fields", "cannot be used with"),
        ("--scene none.json", "none.json"),
        ("--scene rod.json", "rod.json"),
        ("--scene scene.json -o scene.json --force", "is the scene"),
        ("--scene scene.json --timings scene.json", "is the scene"),
    ] {
        folder.refused(&format!("rod.mtx {arguments}"), &[says]);
    }
    let sound = folder.json("scene.json");
    let load = json!({"wind": {"part_load": {"body": "rod", "load": "wind", "factor": 1}}});
    for (place, value, says) in [
        (
            "joints/pin/revolute/a",
            json!("rod/c"),
            ["joints.pin.revolute.a", "no interface \"c\""],
        ),
        (
            "outputs/midpoint_deflection/chord_deflection/node",
            json!(9),
            [
                "outputs.midpoint_deflection names node 9",
                "mesh of 5 nodes",
            ],
        ),
        (
            "units/length",
            json!("mm"),
            ["in mm, kg, s,", "but the component is in m, kg, s"],
        ),
        ("loads", load, ["no load \"wind\"", "it has none"]),
        ("joints", json!([]), ["scene.json:", "expected an object"]),
    ] {
        folder.write("scene.json", sound.to_string());
        folder.set("scene.json", place, value);
        folder.refused(
            "rod.mtx --scene scene.json",
            &["scene.json", says[0], says[1]],
        );
    }
    folder.write("scene.json", "{");
    folder.refused(
        "rod.mtx --scene scene.json",
        &["scene.json", "scene.json:1"],
    );
    folder.write("scene.json", sound.to_string());
    folder.write("rod.dcb.h5", "precious");
    folder.refused("rod.mtx --scene scene.json", &["exists already", "--force"]);
}

/// A steel block with both ends as interfaces, some of its nodes fixed to each other as a `lug`, and a planar pendulum of it with a force at its end.
fn pendulum_of_a_block(lug: impl Fn([f64; 3]) -> bool) -> Folder {
    let block = steel_box([4, 2, 2], SolidElement::Hexahedron);
    let block = block.changed(|draft| draft.name = "part".into()).unwrap();
    let block = with_ends(&block, lug);
    let middle = node_at(&block, [0.2, 0.1, 0.06]);
    let folder = Folder::with(&block);
    let scene = json!({
        "dimension": 2,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "gravity": [0, -9.81],
        "ground": {"points": {"pin": [0, 0.05]}},
        "bodies": {"block": {"superelement": "part.dcb.h5"}},
        "joints": {"hinge": {"revolute": {"a": "ground/pin", "b": "block/left"}}},
        "loads": {"push": {"force": {"at": "block/right", "components": [3e4, 2e5]}}},
        "outputs": {
            "tip": {"position": {"at": "block/right"}},
            "bent": {"node_displacement": {"body": "block", "node": middle}}
        },
        "integrator": {"generalized_alpha": {"step": 4e-6, "end": 4e-3}}
    });
    folder.write("scene.json", scene.to_string());
    folder
}

/// Displacements of the node after some steps of the scene.
fn bent(folder: &Folder) -> Vec<f64> {
    let scene = Scene::read(&folder.path("scene.json")).unwrap();
    let mut mechanism = Mechanism::start(&scene).unwrap();
    for _ in 0..500 {
        mechanism.step(4e-6).unwrap();
    }
    mechanism.output("bent").unwrap().to_vec()
}

#[test]
fn a_spatial_part_is_reduced_for_a_planar_scene_that_runs_it() {
    let folder = pendulum_of_a_block(|_| false);
    let shown = folder
        .run("part.mtx --scene scene.json --tolerance 1e-3 -v")
        .stdout;
    says!(
        shown,
        "interface    \"left\" takes fx fy from joints.hinge",
        "the scene is planar: the spatial part is taken through its plane of symmetry",
        "that lead out of the plane across z",
        "error of the responses certified between"
    );
    folder.done("verify part.dcb.h5");
    folder.done("verify part.dcb.h5 --component part.mtx");
    let inspected = folder.done("inspect part.dcb.h5 -v");
    says!(
        inspected,
        "part: planar superelement",
        "errors, rigorous bounds from"
    );
    // A force that sets in at once excites everything: the tighter, the closer.
    let loose = bent(&folder);
    folder.done("part.mtx --scene scene.json --tolerance 1e-6 --force");
    let tight = bent(&folder);
    folder.done("part.mtx --modes 120 --force");
    let all = bent(&folder);
    let apart = |a: &[f64], b: &[f64]| -> f64 {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let size = apart(&all, &[0.0, 0.0]);
    let errors = [&loose, &tight].map(|found| apart(found, &all) / size);
    println!("{errors:?} of {size:e}");
    assert!(
        size > 1e-6 && errors[0] < 5e-2 && errors[1] < 1e-3,
        "{errors:?}"
    );
}

#[test]
fn a_spatial_part_that_is_not_symmetric_is_not_for_planar_scenes() {
    let folder = pendulum_of_a_block(|[x, y, z]| y > 0.099 && x < 0.11 && z > 0.029);
    folder.refused(
        "part.mtx --scene scene.json",
        &[
            "scene.json",
            "the scene is planar, but the component is spatial",
            "isn't symmetric about the plane across z",
            "of the most that they could (allowed 1e-6)",
        ],
    );
    assert!(!folder.path("part.dcb.h5").exists());
}

#[test]
fn a_tolerance_that_is_not_reached_is_a_failure_with_numbers() {
    let folder = slider_crank();
    let says = ["with 1 modes", "5.0e-7", "--modes 1", "--tolerance"];
    folder.failed(
        1,
        "rod.mtx --scene scene.json --tolerance 1e-6 --modes 1",
        &says,
    );
    // Enough of them; what is more than needed is left out again.
    folder.done("rod.mtx --scene scene.json --tolerance 1e-2 --modes 12");
}

#[test]
fn a_body_that_nothing_refers_to_could_be_rigid() {
    let folder = slider_crank();
    folder.set(
        "scene.json",
        "bodies/spare",
        json!({"superelement": "spare.dcb.h5"}),
    );
    let answer = folder.warned(
        "rod.mtx --scene scene.json -o spare.dcb.h5",
        &[
            "nothing shows a deflection of spare",
            "a rigid body would do",
        ],
    );
    says!(answer.stdout, "no mode is kept");
    let found = folder.inspected("spare.dcb.h5");
    assert_eq!(found["eigenvalues"], json!([]));
    assert_eq!(found["interfaces"], json!([]));
    folder.run("verify spare.dcb.h5");
}

#[test]
fn loads_that_act_get_columns_and_others_go() {
    let folder = slider_crank();
    for name in ["wind", "idle"] {
        let mut text = String::from("%%MatrixMarket matrix array real general\n15 1\n");
        for dof in 0..15 {
            text += if dof % 3 == 1 { "1\n" } else { "0\n" };
        }
        folder.write(&format!("rod.load.{name}.mtx"), text);
    }
    folder.set("scene.json", "loads", json!({"gust": {"part_load": {"body": "rod", "load": "wind", "factor": {"formula": "sin(9*t)"}}}}));
    let shown = folder
        .run("rod.mtx --scene scene.json --tolerance 1e-2 -v")
        .stdout;
    says!(
        shown,
        "without loads \"idle\": the scene doesn't apply them",
        "load wind"
    );
}
