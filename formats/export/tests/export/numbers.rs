//! Every number of every export, read by Python and computed anew there.

use std::ffi::OsStr;

use dcb_export::Axes;
use dcb_formats::superelement::Stiffening;
use dcb_formats::{Superelement, scene::Compatibility};
use dcb_reducer::{EnrichmentSource, Reduction};
use dcb_superelement::DynamicCoordinates;
use dcb_tests::parts;
use faer::Mat;
use serde_json::json;

use crate::support::{Folder, asked, stored};

/// The largest relative difference of the first seven squares of two lists.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert!(a.len() == b.len() && !a.is_empty());
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn primal_forms_keep_rigid_motions_mass_and_frequencies() {
    let folder = Folder::rotor();
    let text = folder.exported("npz", "part.npz");
    assert!(
        text.contains("inertia that follows the deflection"),
        "{text}"
    );
    assert!(
        text.contains("error bounds: four power moments over 12 rows"),
        "{text}"
    );
    let found = folder.checked("npz", "part.npz", None);
    found.all_below(&["K R"], 2e-15);
    found.all_below(&["free", "rigid inertia"], 2e-13);
    found.all_below(
        &["K", "M", "positions", "rigid", "orientations", "symmetric"],
        1e-10,
    );
    assert_eq!(found.0["boundary"], json!(true));
    assert_eq!(found.0["n_modes"], 18);
    assert_eq!(found.0["names"], json!(["bearing-left", "bearing-right"]));

    // The rotor held at one bearing, beside its finite elements under the same condition.
    let (matrix, mass) = (
        stored("samples/data/rotor/rotor.mtx"),
        stored("samples/data/rotor/rotor.mass.mtx"),
    );
    let source = folder.source();
    let whole = asked(&[
        OsStr::new("clamped-finite-elements"),
        source.as_os_str(),
        matrix.as_os_str(),
        mass.as_os_str(),
    ]);
    let off = apart(
        &found.numbers("clamped"),
        &dcb_tests::reference::numbers(&whole.0),
    );
    assert!(off < 3.5e-5, "clamped: {off:e}");

    folder.exported("simscape", "part.mat");
    let oracle = "tests/data/exchange/out/rotor_simscape.mat";
    let mat = folder.checked("simscape", "part.mat", Some(oracle));
    mat.all_below(&["K R"], 2e-15);
    mat.all_below(&["origins", "axes"], 1e-15);
    mat.all_below(&["oracle K", "oracle M", "oracle clamped"], 1e-8);
}

#[test]
fn nastran_loses_nothing_by_output4_and_digits_by_dmig() {
    let folder = Folder::rotor();
    folder.exported("npz", "part.npz");
    let op4 = folder.export("nastran", "four.bdf", |usual| {
        usual.in_dialect("op4").unwrap()
    });
    assert_eq!(op4.unwrap().files.len(), 2);
    let found = folder.checked("nastran", "four.op4", None);
    found.all_below(&["K R"], 2e-15);
    let npz = folder.checked("npz", "part.npz", None);
    assert_eq!(found.numbers("clamped"), npz.numbers("clamped"));

    let text = folder.exported("nastran", "part.bdf");
    assert!(
        text.contains("K2GG = KAAX") && text.contains("11 to 12 digits"),
        "{text}"
    );
    let found = folder.checked("nastran", "part.bdf", None);
    found.all_below(&["K", "M", "places"], 1e-10);
    found.all_below(&["rigid inertia"], 1e-9);
}

#[test]
fn exudyn_gets_its_own_integrals() {
    let folder = Folder::rotor();
    let text = folder.exported("exudyn", "part.hdf5");
    assert!(text.contains("meshNodeNumbers=["), "{text}");
    let oracle = "tests/data/exchange/out/rotor_exudyn.hdf5";
    let found = folder.checked("exudyn", "part.hdf5", Some(oracle));
    found.all_below(
        &[
            "K",
            "M",
            "J",
            "mass",
            "N",
            "L3",
            "P",
            "L1",
            "I3",
            "modeBasis",
            "xRef",
        ],
        1e-13,
    );
    found.all_below(
        &[
            "oracle w2",
            "oracle J",
            "oracle mass",
            "oracle S",
            "oracle flex",
        ],
        1e-8,
    );
    found.all_below(&["oracle area"], 1e-12);
    assert_eq!(found.0["info"], json!([24, 115, 3, 4, 7, 31]));
    assert!(
        found.0["volume"].as_f64().unwrap() > 0.0,
        "triangles are seen from inside"
    );
    let component = |usual: dcb_export::Export| usual.about(Axes::Component);
    folder.export("exudyn", "moved.hdf5", component).unwrap();
    for file in ["part.hdf5", "moved.hdf5"] {
        let file = folder.path(file);
        let mass = stored("samples/data/rotor/rotor.mass.mtx");
        let arguments = [
            OsStr::new("exudyn-integrals"),
            file.as_os_str(),
            mass.as_os_str(),
        ];
        let found = asked(&arguments);
        found.all_below(&["integrals"], 1e-12);
        found.all_below(&["orthonormality"], 1e-9);
    }
}

#[test]
fn frames_without_fields_are_four_nodes_each_for_exudyn() {
    let rotor = dcb_tests::lowest(&parts::rotor(), 12);
    let folder = Folder::bare(&rotor.superelement);
    let text = folder.exported("exudyn", "part.hdf5");
    assert!(text.contains("four nodes for each frame"), "{text}");
    let found = folder.checked("exudyn", "part.hdf5", None);
    found.all_below(&["four nodes a frame", "N", "P", "L3"], 1e-13);
    assert_eq!(found.0["info"][1], 8);
}

/// Symmetric matrices with every number different.
fn noise(seed: usize, count: usize, n: usize) -> Vec<Mat<f64>> {
    let value = |of: usize, i: usize, j: usize| {
        (12.9898 * (1 + i + j) as f64 + 78.233 * (i * j) as f64 + (seed + of) as f64).sin()
    };
    (0..count)
        .map(|of| Mat::from_fn(n, n, |i, j| value(of, i, j)))
        .collect()
}

/// The rotor with damping and geometric stiffness of its own.
fn stiffened_and_damped() -> Superelement {
    let mut element = dcb_tests::lowest(&parts::rotor(), 6).superelement;
    let (n, n_b) = (element.basis_count(), element.rows.len());
    element.stiffening = Stiffening {
        centrifugal: noise(1, 6, n),
        interface: noise(7, n_b, n),
    };
    element.modes.damping = (0..6).map(|k| 0.01 * f64::from(k)).collect();
    element.modes.residual_damping = 0.05;
    element
}

#[test]
fn mbdyn_gets_all_records() {
    let folder = Folder::rotor();
    let text = folder.exported("mbdyn", "part.fem");
    assert!(
        text.contains("joint: JOINT, modal, BODY,\n    24,\n    from file"),
        "{text}"
    );
    assert!(
        text.contains("    2,\n    \"bearing-left\", NODE_1, null,"),
        "{text}"
    );
    let oracle = "tests/data/exchange/out/rotor.fem";
    let found = folder.checked("mbdyn", "part.fem", Some(oracle));
    let all = [
        "places", "shapes", "M", "K", "D", "mass", "J", "N", "L3", "P", "L1", "I3",
    ];
    found.all_below(&all, 1e-13);
    found.all_below(
        &[
            "oracle w2",
            "oracle J",
            "oracle mass",
            "oracle S",
            "oracle flex",
        ],
        1e-8,
    );
    assert_eq!(
        found.0["records"],
        json!([1, 2, 5, 6, 7, 8, 9, 10, 12, 13, 14, 15, 16, 17, 18])
    );

    let folder = Folder::bare(&stiffened_and_damped());
    let text = folder.exported("mbdyn", "part.fem");
    assert!(text.contains("use automatic differentiation;"), "{text}");
    let found = folder.checked("mbdyn", "part.fem", None);
    found.all_below(&all, 1e-13);
    found.all_below(&["K0 1", "K0 6", "KG 0", "KG 11"], 1e-13);
    assert_eq!(found.0["records"].as_array().unwrap().last().unwrap(), 19);
}

#[test]
fn standard_input_data_have_the_integrals_in_both_dialects() {
    for element in [
        dcb_tests::lowest(&parts::rotor(), 6).superelement,
        stiffened_and_damped(),
    ] {
        let folder = Folder::bare(&element);
        for dialect in ["vector", "matrix"] {
            let output = format!("{dialect}.SID_FEM");
            let change = |usual: dcb_export::Export| usual.in_dialect(dialect).unwrap();
            folder.export("sid", &output, change).unwrap();
            let found = folder.checked("sid", &output, None);
            let all = [
                "J", "I1", "Gr", "Ge", "Oe", "Cr", "Ct", "Ke", "De", "Me", "mass", "mdCM", "node",
                "L3",
            ];
            found.all_below(&all, 1e-11);
        }
    }
}

/// Files of another program obey what ours are made by.
#[test]
fn real_standard_input_data_obey_the_identities_to_their_digits() {
    for (file, modes) in [("balken1m", 1), ("Beam_3m", 4), ("beam", 11)] {
        let path = stored(&format!("tests/data/exchange/sid_fem/{file}.SID_FEM"));
        let found = asked(&[OsStr::new("sid-identities"), path.as_os_str()]);
        found.all_below(&["Gr", "Oe", "Ge", "Ct", "L3"], 1e-11);
        assert_eq!(found.0["modes"], modes, "{file}");
    }
}

#[test]
fn pictures_show_the_modes() {
    let folder = Folder::rotor();
    folder.exported("gltf", "part.glb");
    let found = folder.checked("gltf", "part.glb", None);
    found.all_below(&["positions", "targets"], 1e-6);
    assert_eq!(found.0["animations"], 12);
    assert_eq!(found.0["mode"], 4);
    let names = found.0["names"][0].as_str().unwrap();
    assert!(names.starts_with("mode 1: 104.637"), "{names}");

    // A planar rod of line cells.
    let rod = parts::rod(4);
    let folder = Folder::of(&rod, &dcb_tests::lowest(&rod, 3));
    folder.exported("gltf", "part.glb");
    let found = folder.checked("gltf", "part.glb", None);
    found.all_below(&["positions", "targets"], 1e-6);
    assert_eq!(found.0["mode"], 1);
}

#[test]
fn grids_have_the_fields_of_the_file() {
    let folder = Folder::rotor();
    folder.exported("vtu", "part.vtu");
    let found = folder.checked("vtu", "part.vtu", None);
    found.all_below(&["positions", "fields"], 1e-14);
    let names = found.0["names"][0].as_str().unwrap();
    assert!(names.starts_with("mode 1: 104.637"), "{names}");
    let rod = parts::rod(4);
    let folder = Folder::of(&rod, &dcb_tests::lowest(&rod, 3));
    folder.exported("vtu", "part.vtu");
    let found = folder.checked("vtu", "part.vtu", None);
    found.all_below(&["positions", "fields"], 1e-14);
    assert_eq!(found.0["cells"], 4);
}

#[test]
fn damping_goes_where_there_is_a_place_for_it() {
    let folder = Folder::bare(&stiffened_and_damped());
    folder.exported("npz", "part.npz");
    folder
        .checked("npz", "part.npz", None)
        .all_below(&["C"], 1e-9);
    let text = folder.exported("exudyn", "part.hdf5");
    assert!(text.contains("damping of 17 of 18 coordinates"), "{text}");
    assert!(
        text.contains("geometric stiffness by spin: 6 matrices"),
        "{text}"
    );
    assert!(
        text.contains("geometric stiffness by interface forces: 12 matrices"),
        "{text}"
    );
}

/// Further columns stay, as coordinates that no frame sees.
#[test]
fn further_columns_are_kept_in_the_primal_form() {
    let rotor = parts::rotor();
    let options = Reduction {
        enrichment: vec![EnrichmentSource::Spin],
        ..Reduction::lowest(12)
    };
    let element = dcb_tests::with(&rotor, &options).superelement;
    let coordinates = DynamicCoordinates::of(&element, Compatibility::Strong).unwrap();
    assert!(coordinates.stiffness.len() > 24);
    let folder = Folder::bare(&element);
    folder.exported("npz", "part.npz");
    let npz = folder.path("part.npz");
    let found = asked(&[OsStr::new("primal-squares"), npz.as_os_str()]);
    found.all_below(&["K R"], 2e-15);
    let mut squares = coordinates.stiffness;
    squares.sort_by(f64::total_cmp);
    let off = apart(&found.numbers("squares")[6..], &squares);
    assert!(off < 1e-9, "free: {off:e}");
}
