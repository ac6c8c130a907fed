//! Components whose numbers can't be those of a free elastic part.

use dcb_samples::hard::{self, Hinge};
use serde_json::json;

use crate::support::{Folder, says};

#[test]
fn a_negative_mass_is_named_by_node() {
    let folder = Folder::rotor();
    folder.set_diagonal("rotor.mass.mtx", 4, |value| format!("{:?}", -value));
    folder.refused(
        "rotor.mtx",
        &[
            "rotor.mass.mtx: the mass matrix",
            "1 negative diagonal",
            "node 1 uy",
            "positive semi-definite",
        ],
    );
}

#[test]
fn an_indefinite_stiffness_is_counted_and_placed() {
    let folder = Folder::rotor();
    folder.set_diagonal("rotor.mtx", 49, |value| format!("{:?}", 0.3 * value));
    folder.refused(
        "rotor.mtx",
        &[
            "rotor.mtx: ",
            "indefinite",
            // At node 16 uy or one that is eliminated after it: which, the ordering decides.
            "1 negative pivot(s), at node ",
            "positive semi-definite",
        ],
    );
}

#[test]
fn dofs_without_stiffness_are_listed() {
    let component = hard::orphan_dof_block();
    let node = component.mesh.node_count() - 1;
    Folder::with(&component).refused(
        "part.mtx",
        &[
            "part.mtx: 1 dof(s) have no stiffness",
            &format!("node {node} ux"),
            "remove them",
        ],
    );
}

#[test]
fn a_held_part_is_refused_with_advice_and_can_be_allowed() {
    let folder = Folder::with(&hard::grounded_block());
    folder.refused(
        "part.mtx",
        &[
            "part.mtx: the part is held: only 0 of 6",
            "node ",
            "joint",
            "--allow-grounded",
        ],
    );
    let answer = folder.run("part.mtx --modes 4 --allow-grounded");
    assert_eq!(answer.code, Some(0), "{answer:?}");
    assert_eq!(folder.inspected("part.dcb.h5")["frame"]["kind"], "given");
    folder.done("verify part.dcb.h5 --component part.mtx");
}

#[test]
fn loose_pieces_are_listed_and_can_be_allowed() {
    let folder = Folder::with(&hard::two_loose_blocks());
    folder.refused(
        "part.mtx",
        &[
            "part.mtx: the part is in 2 pieces",
            "piece 1 of 45 node(s)",
            "piece 2 of 45 node(s)",
            "--allow-loose",
        ],
    );
    let answer = folder.run("part.mtx --modes 8 --allow-loose");
    assert_eq!(answer.code, Some(0), "{answer:?}");
    let eigenvalues = folder.inspected("part.dcb.h5")["eigenvalues"].clone();
    let zeros = eigenvalues
        .as_array()
        .unwrap()
        .iter()
        .filter(|value| **value == json!(0.0));
    assert_eq!(zeros.count(), 6, "{eigenvalues}");
    folder.done("inspect part.dcb.h5");
    folder.done("verify part.dcb.h5 --component part.mtx");
    folder.run("part.mtx --modes 8 --allow-loose --without-fields --force");
    folder.done("verify part.dcb.h5 --component part.mtx");
}

#[test]
fn a_mechanism_is_counted_and_placed() {
    for (hinge, motions) in [(Hinge::Edge, 1), (Hinge::Node, 3)] {
        Folder::with(&hard::hinged_blocks(hinge)).refused(
            "part.mtx",
            &[
                "part.mtx: the part is a mechanism",
                &format!("{motions} motion(s)"),
                "node ",
                "--allow-loose",
            ],
        );
    }
}

#[test]
fn a_mesh_in_another_node_order_is_recognised() {
    let folder = Folder::rotor();
    folder.edit("rotor.json", |json| {
        json["points"].as_array_mut().unwrap().reverse()
    });
    folder.refused(
        "rotor.mtx",
        &[
            "rotor.mtx: the mesh and the matrices don't belong together",
            "another node order",
            "worst at node ",
        ],
    );
}

#[test]
fn cells_in_another_node_order_get_a_warning() {
    let folder = Folder::rotor();
    let answer = folder.run("rotor.mtx --modes 4");
    assert!(!answer.stderr.contains("cells"), "{answer:?}");
    folder.edit("rotor.json", |json| {
        for cell in json["cells"][0]["data"].as_array_mut().unwrap() {
            for node in cell.as_array_mut().unwrap() {
                *node = json!(114 - node.as_u64().unwrap());
            }
        }
    });
    let answer = folder.run("rotor.mtx --modes 4 --force");
    assert_eq!(answer.code, Some(0), "{answer:?}");
    says!(answer.stderr, "of 48 cells looked at join nodes");
}

#[test]
fn mixed_units_get_a_warning() {
    for (units, says) in [
        (
            json!({"length": "mm", "mass": "kg", "time": "s"}),
            "denser than any material",
        ),
        (
            json!({"length": "m", "mass": "t", "time": "s"}),
            "denser than any material",
        ),
        (
            json!({"length": "m", "mass": "mg", "time": "s"}),
            "lighter than a foam",
        ),
        (
            json!({"length": "m", "mass": "kg", "time": "us"}),
            "wave speed",
        ),
        (
            json!({"length": "ell", "mass": "kg", "time": "s"}),
            "ell, kg, s are not all known by name",
        ),
    ] {
        let folder = Folder::rotor();
        folder.set("rotor.json", "component/units", units);
        folder.warned("rotor.mtx --modes 3", &[says]);
        let kept = folder.inspected("rotor.dcb.h5")["warnings"].to_string();
        assert!(kept.contains(says), "{kept}");
    }
}

#[test]
fn a_part_without_interfaces_gets_a_warning() {
    let folder = Folder::rotor();
    folder.set("rotor.json", "component/interfaces", json!([]));
    let answer = folder.warned("rotor.mtx --modes 3", &["no interface"]);
    says!(answer.stdout, "no interface: nothing can be attached");
    let shown = folder.done("inspect rotor.dcb.h5 -v");
    says!(shown, "no interface: nothing can be attached");
    folder.done("verify rotor.dcb.h5 --component rotor.mtx");
    folder.done("compare rotor.dcb.h5 rotor.dcb.h5");
}
