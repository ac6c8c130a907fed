//! Superelements that a scene can't use, and interfaces that a joint can't.

use dcb_formats::Superelement;
use dcb_formats::dcb::read_superelement;
use dcb_samples::{RodSection, UnitScale, in_units, planar_rod};
use serde_json::{Value, json};

use crate::scene_folder::spatial;
use crate::support::{Folder, says};

/// A beam, clamped by the joint that is given.
fn beam(joint: Value) -> Value {
    spatial(json!({
        "bodies": {"beam": {"superelement": "beam.dcb.h5"}},
        "joints": {"clamp": joint},
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 1e-3}}
    }))
}

fn fixed_at(interface: &str) -> Value {
    beam(json!({"fixed": {"a": "ground", "b": interface}}))
}

#[test]
fn a_missing_superelement_is_named() {
    let folder = Folder::slider_crank();
    std::fs::remove_file(folder.path("rod.dcb.h5")).unwrap();
    folder.refused(
        "scene.json",
        &["scene.json: bodies.rod.superelement: there is no file rod.dcb.h5"],
    );
    // From elsewhere too: paths start at the folder of the scene.
    std::fs::create_dir(folder.path("sub")).unwrap();
    let moved = folder.path("sub/scene.json");
    std::fs::copy(folder.path("scene.json"), moved).unwrap();
    folder.refused("sub/scene.json", &["there is no file sub/rod.dcb.h5"]);
}

#[test]
fn damaged_superelements_are_refused() {
    let folder = Folder::slider_crank();
    let whole = folder.bytes("rod.dcb.h5");
    for part in [0, 1, 100, whole.len() / 2, whole.len() - 1] {
        folder.write("rod.dcb.h5", &whole[..part]);
        folder.refused("scene.json", &["rod.dcb.h5"]);
    }
    let mut corrupt = whole.clone();
    for byte in corrupt.iter_mut().skip(200).step_by(64) {
        *byte ^= 0x55;
    }
    folder.write("rod.dcb.h5", corrupt);
    folder.refused("scene.json", &["rod.dcb.h5"]);
    folder.write("rod.dcb.h5", "not at all");
    folder.refused("scene.json", &["rod.dcb.h5", "HDF5"]);
}

/// Matrices with right digests that can't belong together change a motion by 3 % to 1300 %: no run starts with them.
#[test]
fn superelements_that_contradict_themselves_are_refused() {
    type Change = fn(&mut Superelement);
    let cases: [(&str, Change); 9] = [
        ("/residual/flexibility", |it| {
            it.residual.flexibility *= faer::Scale(-1.0)
        }),
        ("/residual/flexibility", |it| {
            it.residual.flexibility *= faer::Scale(10.0)
        }),
        ("/residual/flexibility", |it| {
            it.residual.flexibility *= faer::Scale(0.0)
        }),
        ("/residual/sigma2", |it| {
            let squares = it.residual.sigma_squared.iter_mut();
            squares.for_each(|square| *square *= 100.0);
        }),
        ("/residual/mass", |it| it.residual.mass *= faer::Scale(2.0)),
        ("/residual/transform", |it| {
            it.residual.transform *= faer::Scale(0.1)
        }),
        ("/residual/mass_diagonal0", |it| {
            it.modes.interface_shapes *= faer::Scale(3.0)
        }),
        ("/inertia/L3", |it| it.inertia.l3[0] *= faer::Scale(1e6)),
        ("/inertia/I1", |it| {
            let blocks = it.inertia.i1.iter_mut();
            blocks.for_each(|block| block[2][2] *= 1e6);
        }),
    ];
    let folder = Folder::slider_crank();
    let whole = read_superelement(&folder.path("rod.dcb.h5")).unwrap();
    for (names, change) in cases {
        let mut changed = whole.clone();
        change(&mut changed);
        folder.store_superelement("rod.dcb.h5", &changed);
        folder.refused(
            "scene.json",
            &[
                "rod.dcb.h5",
                names,
                "contradict each other",
                "reduce verify",
            ],
        );
    }
}

#[test]
fn a_later_major_version_is_refused() {
    let folder = Folder::slider_crank();
    let mut bytes = folder.bytes("rod.dcb.h5");
    let find = |bytes: &[u8], from: usize, text: &[u8]| {
        let found = bytes[from..]
            .windows(text.len())
            .position(|part| part == text);
        from + found.unwrap()
    };
    let format = find(&bytes, 0, b"dcb-superelement\x02");
    let version = find(&bytes, format, b"1.0");
    assert!(version - format < 64);
    bytes[version] = b'9';
    folder.write("rod.dcb.h5", bytes);
    folder.refused("scene.json", &["rod.dcb.h5", "9.0", "1."]);
}

#[test]
fn dimension_and_units_must_be_those_of_the_scene() {
    let folder = Folder::beam(&fixed_at("beam/a"));
    let rod = planar_rod(4, &RodSection::default());
    folder.store("rod.dcb.h5", &rod);
    folder.set_scene("bodies/beam/superelement", "rod.dcb.h5");
    folder.refused(
        "scene.json",
        &[
            "bodies.beam.superelement",
            "rod.dcb.h5 is planar, but the scene is spatial",
        ],
    );
    let folder = Folder::slider_crank();
    std::fs::remove_file(folder.path("rod.dcb.h5")).unwrap();
    folder.store("rod.dcb.h5", &in_units(&rod, &UnitScale::mm_t_s()));
    folder.refused(
        "scene.json",
        &[
            "bodies.rod.superelement",
            "is in mm, t, s, but the scene is in m, kg, s",
        ],
    );
}

#[test]
fn unknown_interfaces_have_a_nearest_name() {
    let folder = Folder::beam(&fixed_at("beam/piar"));
    folder.refused(
        "scene.json",
        &["joints.clamp.fixed.b", "\"piar\"", "did you mean \"pair\"?"],
    );
    folder.set_scene("joints/clamp/fixed/b", "beam/zzzzzz");
    folder.refused("scene.json", &["it has a, b, pair, watched, bare"]);
}

#[test]
fn interfaces_that_have_no_frame_say_what_would() {
    Folder::beam(&fixed_at("beam/pair")).refused(
        "scene.json",
        &[
            "joints.clamp.fixed.b",
            "\"pair\"",
            "`nodes`",
            "`average` or `rigid`",
        ],
    );
    Folder::beam(&fixed_at("beam/watched")).refused(
        "scene.json",
        &["joints.clamp.fixed.b", "\"beam/watched\" is an output only"],
    );
}

#[test]
fn rotation_rows_are_needed_by_what_turns_and_the_body_can_lend_its_own() {
    let folder = Folder::beam(&fixed_at("beam/bare"));
    folder.refused(
        "scene.json",
        &[
            "joints.clamp.fixed.b",
            "\"beam/bare\" has no rotation rows",
            "\"orientation\": \"body\"",
        ],
    );
    // A spherical joint needs none; a torque has no such key and doesn't speak of it.
    let mut spherical = beam(json!({"spherical": {"a": "ground", "b": "beam/bare"}}));
    // The beam is drawn half its length away from the joint.
    spherical["initial"] = json!({"allow_gap": 1});
    Folder::beam(&spherical).done("scene.json");
    let mut loaded = fixed_at("beam/a");
    loaded["loads"] = json!({"twist": {"torque": {"at": "beam/bare", "components": [1, 0, 0]}}});
    let answer = Folder::beam(&loaded).run("scene.json");
    answer.is_error(2, &["loads.twist.torque.at", "no rotation rows"]);
    assert!(!answer.stderr.contains("orientation"), "{}", answer.stderr);
    folder.set_scene("joints/clamp/fixed/orientation", "body");
    folder.set_scene("initial", json!({"allow_gap": 1}));
    let answer = folder.done("scene.json");
    says!(
        answer.stderr,
        "joint \"clamp\": rotations are those of the body frame"
    );
    let warnings = folder.results().provenance("warnings").unwrap();
    says!(warnings.to_string(), "clamp");
}

/// Fields of a node, which are read alone, and the rows of the interface that consists of this node.
#[test]
fn a_node_moves_as_the_interface_that_it_is() {
    let folder = Folder::slider_crank();
    let rod = read_superelement(&folder.path("rod.dcb.h5")).unwrap();
    let node_of = |interface: usize| {
        let row = rod.rows.iter().find(|row| row.interface == interface);
        row.unwrap().node
    };
    for modes in [json!(null), json!(2)] {
        if !modes.is_null() {
            folder.set_scene("bodies/rod/modes", &modes);
        }
        let outputs = json!({
            "a": {"position": {"at": "rod/a"}},
            "b": {"position": {"at": "rod/b"}},
            "node_a": {"node_position": {"body": "rod", "node": node_of(0)}},
            "node_b": {"node_position": {"body": "rod", "node": node_of(1)}},
        });
        folder.set_scene("outputs", outputs);
        folder.done("scene.json --force");
        let results = folder.results();
        for (interface, node) in [("a", "node_a"), ("b", "node_b")] {
            let [interface, node] = [interface, node].map(|name| results.history(name).unwrap());
            assert_eq!(interface.ncols(), 2);
            let apart = (&interface - &node).norm_max();
            assert!(apart < 1e-12, "{modes}: {apart:e}");
        }
    }
    folder.set_scene("outputs/node_a/node_position/node", 77);
    folder.refused(
        "scene.json --force",
        &["outputs.node_a", "node: is 77", "counted from 0"],
    );
}
