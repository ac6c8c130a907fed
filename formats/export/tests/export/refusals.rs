//! What a target can't hold at all, by name; nothing is written then.

use dcb_export::{Axes, Export, Source, TARGETS, Target};
use dcb_formats::component::{InterfaceKind, Role};
use dcb_formats::output::Replace;
use dcb_samples::SolidElement;
use dcb_tests::{assert_says, parts};

use crate::support::Folder;

#[test]
fn planar_parts_are_refused_where_the_target_knows_space_only() {
    let rod = parts::rod(4);
    let folder = Folder::of(&rod, &dcb_tests::lowest(&rod, 3));
    let pictures = ["gltf", "vtu"];
    for target in TARGETS
        .iter()
        .filter(|target| !pictures.contains(&target.name))
    {
        let told = folder.refused(target.name);
        let name = format!("`{}` takes spatial parts only", target.name);
        assert_says(&told, &["is the planar part", &name]);
    }
}

#[test]
fn rows_that_depend_on_each_other_are_named() {
    // Two frames on the same nodes.
    let block = parts::steel_box([4, 1, 1], SolidElement::Hexahedron);
    let nodes = block.mesh.point_sets["x_min"].clone();
    let twice = ["first", "second"]
        .map(|name| parts::interface(name, InterfaceKind::Average, nodes.clone()));
    let component = parts::with_interfaces(&block, twice.to_vec());
    let folder = Folder::of(&component, &dcb_tests::lowest(&component, 4));
    for target in ["npz", "simscape", "nastran"] {
        assert_says(
            &folder.refused(target),
            &["for 12 rows", "first/", "second/"],
        );
    }
    // Other forms take them.
    folder.exported("mbdyn", "part.fem");
}

#[test]
fn interfaces_that_are_no_frames_are_named() {
    let block = parts::steel_box([4, 1, 1], SolidElement::Hexahedron);
    let node = vec![block.mesh.point_sets["x_min"][0]];
    let frame = parts::interface(
        "end",
        InterfaceKind::Average,
        block.mesh.point_sets["x_max"].clone(),
    );
    let interfaces = vec![parts::interface("pin", InterfaceKind::Nodes, node), frame];
    let component = parts::with_interfaces(&block, interfaces);
    let folder = Folder::of(&component, &dcb_tests::lowest(&component, 4));
    for target in ["npz", "simscape", "nastran"] {
        assert_says(
            &folder.refused(target),
            &["\"pin\" has no row for rx, ry, rz", "`average` or `rigid`"],
        );
    }
    let text = folder.exported("mbdyn", "part.fem");
    assert!(
        text.contains(
            "\"pin\" has no row for rx, ry, rz: there it turns with the body frame alone"
        ),
        "{text}"
    );
}

#[test]
fn observed_interfaces_are_nodes_or_left_out() {
    let block = parts::steel_box([4, 1, 1], SolidElement::Hexahedron);
    let frame = |name: &str, set: &str| {
        parts::interface(
            name,
            InterfaceKind::Average,
            block.mesh.point_sets[set].clone(),
        )
    };
    let mut sensor = frame("sensor", "x_min");
    sensor.role = Role::Output;
    let component = parts::with_interfaces(&block, vec![sensor, frame("end", "x_max")]);
    let folder = Folder::of(&component, &dcb_tests::lowest(&component, 4));
    let text = folder.exported("npz", "part.npz");
    assert!(
        text.contains("interfaces that are only observed: \"sensor\""),
        "{text}"
    );
    folder.exported("mbdyn", "part.fem");
    folder
        .checked("mbdyn", "part.fem", None)
        .all_below(&["shapes", "P"], 1e-12);
}

#[test]
fn pictures_need_fields() {
    let rotor = dcb_tests::lowest(&parts::rotor(), 4);
    let folder = Folder::bare(&rotor.superelement);
    for target in ["gltf", "vtu"] {
        assert_says(
            &folder.refused(target),
            &["has no nodal fields", "--without-fields"],
        );
    }
}

#[test]
fn outputs_that_are_there_stay() {
    let folder = Folder::rotor();
    std::fs::write(folder.path("part.op4"), "mine").unwrap();
    let names = folder.names();
    let op4 = |usual: Export| usual.in_dialect("op4").unwrap();
    let told = folder.export("nastran", "part.bdf", op4).unwrap_err();
    assert_says(&told.to_string(), &["part.op4: exists already"]);
    assert_eq!(folder.names(), names);
    assert_eq!(std::fs::read(folder.path("part.op4")).unwrap(), b"mine");
    let force = |usual: Export| op4(usual).replacing(Replace::Overwrite);
    folder.export("nastran", "part.bdf", force).unwrap();
    let told = folder
        .export("npz", "part.dcb.h5", force_plain)
        .unwrap_err();
    assert_says(&told.to_string(), &["is the superelement that is exported"]);
    let told = Export::to(Target::named("mbdyn").unwrap()).in_dialect("op4");
    assert_says(
        &told.err().unwrap().to_string(),
        &["\"op4\" is no form of `mbdyn`", "one form only"],
    );
    assert!(Source::open(&folder.path("part.bdf")).is_err());
}

fn force_plain(usual: Export) -> Export {
    usual.replacing(Replace::Overwrite).about(Axes::Component)
}
