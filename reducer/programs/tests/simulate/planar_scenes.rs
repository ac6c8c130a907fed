//! Planar scenes of spatial superelements.

use dcb_formats::component::Component;
use dcb_formats::dcb::{Contents, read_superelement};
use dcb_formats::mesh::Dimension;
use dcb_reducer::{Reduction, reduce};
use dcb_samples::SolidElement;
use dcb_tests::parts::steel_box;
use serde_json::{Value, json};

use crate::support::{Folder, node_at, says, with_ends};

/// A steel block of 0.4 m x 0.1 m x 0.06 m with both ends as interfaces; `lug` are nodes of its upper face besides.
pub(super) fn block(lug: impl Fn([f64; 3]) -> bool) -> Component {
    with_ends(&steel_box([4, 2, 2], SolidElement::Hexahedron20), lug)
}

/// `block.dcb.h5` with its fields, and a pendulum of it about z that falls with a force at its end, in space and in the plane.
fn folder(block: &Component) -> Folder {
    let node = node_at(block, [0.2, 0.1, 0.06]);
    let scene = |dimension: u8| {
        let planar = dimension == 2;
        let point = |at: [f64; 3]| json!(at[..usize::from(dimension)]);
        let hinge = match planar {
            true => json!({"a": "ground/pin", "b": "block/left"}),
            false => json!({"a": "ground/pin", "b": "block/left", "axis": [0, 0, 1]}),
        };
        json!({
            "dimension": dimension,
            "units": {"length": "m", "mass": "kg", "time": "s"},
            "gravity": point([0.0, -9.81, 0.0]),
            "ground": {"points": {"pin": point([0.0, 0.05, 0.03])}},
            "bodies": {"block": {"superelement": "block.dcb.h5"}},
            "joints": {"hinge": {"revolute": hinge}},
            "loads": {"push": {"force": {"at": "block/right", "components": point([3e4, 2e5, 0.0])}}},
            "outputs": {
                "tip": {"position": {"at": "block/right"}},
                "node": {"node_position": {"body": "block", "node": node}},
                "bent": {"node_displacement": {"body": "block", "node": node}},
                "pull": {"reaction": {"joint": "hinge"}}
            },
            "integrator": {"generalized_alpha": {"step": 2e-5, "end": 4e-3}}
        })
    };
    let folder = Folder::with(&scene(2));
    folder.write("space.json", scene(3).to_string());
    write_reduced(&folder, block);
    folder
}

/// `block.dcb.h5` with ten modes and its fields.
pub(super) fn write_reduced(folder: &Folder, block: &Component) {
    let reduced = reduce(block, &Reduction::lowest(10), &mut ()).unwrap();
    let contents = Contents {
        superelement: &reduced.superelement,
        recovery: Some(&reduced.recovery),
        mesh: Some(&block.mesh),
    };
    folder.store_contents("block.dcb.h5", &contents);
}

#[test]
fn a_spatial_part_moves_in_a_planar_scene_as_in_space() {
    let folder = folder(&block(|_| false));
    folder.done("space.json --model everything");
    let answer = folder.done("scene.json --model everything");
    says!(
        answer.stderr,
        "body \"block\" without ",
        "6 of 10 modes, 6 of 12 interface directions that lead out of the plane across z"
    );
    let [space, plane] = ["space.h5", "scene.h5"].map(|name| {
        let results = folder.results_of(name);
        ["tip", "node", "bent", "pull"]
            .map(|output| results.history(&format!("outputs/{output}")).unwrap())
    });
    for (space, plane) in space.iter().zip(&plane) {
        let space = space.subcols(0, 2);
        let plane = plane.subcols(0, 2);
        let range = space.norm_max();
        let apart = (space - plane).norm_max();
        println!("apart {apart:.1e} of {range:.1e}");
        assert!(range > 1e-4, "nothing happens: {range:e}");
        assert!(apart < 1e-8 * range, "{apart:e} of {range:e}");
    }
    // What is left out is listed, and stored.
    let explained = folder.done("scene.json --force --explain").stdout;
    let listed = "without 6 of 10 modes, 6 of 12 interface directions that lead out of the plane across z: the scene is planar, and the spatial part is symmetric to the plane";
    assert!(explained.contains(listed), "{explained}");
    let results = folder.results();
    let left_out = &results.provenance("options").unwrap()["left_out"]["block"];
    assert_eq!(left_out[0], json!(listed));
    let warnings: Value = results.provenance("warnings").unwrap();
    says!(warnings[0].as_str().unwrap(), "body \"block\"");
}

/// The superelement is taken as it is: its component isn't asked for.
#[test]
fn a_planar_scene_of_a_spatial_part_is_prepared() {
    let folder = folder(&block(|_| false));
    folder.write("block.mtx", "no matrix");
    folder.done("scene.json -o all.h5 --model everything");
    folder.done("prepare scene.json --tolerance 1e-2 -o small --reduce ./nobody");
    let small = read_superelement(&folder.path("small/block.dcb.h5")).unwrap();
    assert_eq!(small.dimension, Dimension::Planar);
    folder.done("small/scene.json -o small.h5 --model everything");
    let [all, small] = ["all.h5", "small.h5"].map(|name| {
        let results = folder.results_of(name);
        results.history("outputs/bent").unwrap()
    });
    let apart = (&all - &small).norm_max();
    assert!(apart < 1e-2 * all.norm_max(), "{apart:e}");
}

#[test]
fn a_part_that_is_not_symmetric_is_refused_with_how_far_it_is_from_that() {
    let one_sided = folder(&block(|[x, y, z]| y > 0.099 && x < 0.11 && z > 0.029));
    one_sided.refused(
        "scene.json",
        &[
            "bodies.block.superelement",
            "block.dcb.h5 is spatial, but the scene is planar",
            "isn't symmetric about the plane across z",
            "of the most that they could (allowed 1e-6)",
        ],
    );
    let upper_face = folder(&block(|[x, y, _]| y > 0.099 && x < 0.11));
    upper_face.done("scene.json");
}

#[test]
fn fields_of_a_spatial_part_are_not_drawn_in_the_plane() {
    let folder = folder(&block(|_| false));
    folder.set_scene(
        "fields",
        json!([{"body": "block", "times": [1e-3], "directory": "fields"}]),
    );
    folder.refused("scene.json", &["fields[0].body", "in the plane"]);
}
