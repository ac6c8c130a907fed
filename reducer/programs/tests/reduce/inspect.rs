//! `reduce inspect`.

use dcb_formats::Superelement;
use dcb_formats::dcb::read_superelement;
use dcb_superelement::Selection;
use serde_json::json;

use crate::support::{Folder, list, number, says, stored};

#[test]
fn json_has_what_the_reduction_found() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    let found = folder.inspected("rotor.dcb.h5");
    assert_eq!(found["name"], "rotor");
    assert_eq!(found["dimension"], 3);
    assert_eq!(
        found["units"],
        json!({"length": "m", "mass": "kg", "time": "s"})
    );
    assert_eq!(found["frame"]["kind"], "mean-axis");
    assert_eq!(found["interfaces"][0]["name"], "bearing-left");
    assert_eq!(
        found["interfaces"][1]["rows"],
        json!(["ux", "uy", "uz", "rx", "ry", "rz"])
    );
    // From the Ansys model's documentation, to its digits.
    assert!((number(&found["mass"]) - 77.97).abs() < 0.005);
    assert!((number(&found["frequencies_hz"][0]) - 104.637).abs() < 5e-4);
    assert_eq!(list(&found["inertia"]).len(), 3);
    assert_eq!(found["residual_rank"], 12);
    assert_eq!(found["has_fields"], true);
    assert_eq!(found["warnings"], json!([]));
    assert_eq!(
        found["quality"]["mode_count"]["counted"],
        found["quality"]["mode_count"]["found"]
    );
}

#[test]
fn text_shows_the_same_in_columns() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    let shown = folder.done("inspect rotor.dcb.h5 -v");
    says!(
        shown,
        "rotor: spatial superelement, format 1.6, units m kg s, frame mean-axis",
        "mass      7.796604705e+01 kg",
        "   1          104.637010551",
        "bearing-left   average",
        "made from rotor.mass.mtx (mass, sha256 "
    );
    let lines: Vec<&str> = shown.lines().collect();
    let tensor = lines
        .iter()
        .position(|line| line.starts_with("inertia"))
        .unwrap();
    let ends: Vec<usize> = lines[tensor..tensor + 3]
        .iter()
        .map(|line| line.rfind('e').unwrap_or(0))
        .collect();
    let numbers = |line: &str| {
        line.split_whitespace()
            .filter(|word| word.parse::<f64>().is_ok())
            .count()
    };
    assert!(
        lines[tensor..tensor + 3]
            .iter()
            .all(|line| numbers(line) == 3),
        "{shown}"
    );
    let columns = |line: &str| {
        line.match_indices("e-")
            .chain(line.match_indices("e+"))
            .map(|(at, _)| at)
            .max()
    };
    assert_eq!(
        columns(lines[tensor]),
        columns(lines[tensor + 2]),
        "{shown} {ends:?}"
    );
}

/// Residuals stand beside the modes that they are of, also where modes in between were left out after the report.
#[test]
fn residuals_of_selected_modes_are_their_own() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 6");
    let mut whole = read_superelement(&folder.path("rotor.dcb.h5")).unwrap();
    whole.provenance.quality["mode_residuals"] = json!([1e-11, 2e-11, 3e-11, 4e-11, 5e-11, 6e-11]);
    // Twice: the second selection counts among the modes of the first.
    let selected = |of: &Superelement, modes: &[usize]| {
        let selection = Selection::everything(of).with_modes(modes.iter().copied());
        selection.unwrap().superelement(of).unwrap()
    };
    let first = selected(&whole, &[0, 1, 3, 5]);
    let second = selected(&first, &[1, 2, 3]);
    let residuals = |element: &Superelement| -> Vec<String> {
        folder.store_superelement("rotor.dcb.h5", element);
        let shown = folder.done("inspect rotor.dcb.h5 -v");
        let lines = shown.lines().skip_while(|line| !line.starts_with("mode "));
        let lines = lines.skip(1).take(element.mode_count());
        lines
            .map(|line| line.split_whitespace().last().unwrap().to_owned())
            .collect()
    };
    assert_eq!(
        residuals(&whole),
        [
            "1.0e-11", "2.0e-11", "3.0e-11", "4.0e-11", "5.0e-11", "6.0e-11"
        ]
    );
    assert_eq!(
        residuals(&first),
        ["1.0e-11", "2.0e-11", "4.0e-11", "6.0e-11"]
    );
    assert_eq!(residuals(&second), ["2.0e-11", "4.0e-11", "6.0e-11"]);
    let verified = folder.done("verify rotor.dcb.h5 --component rotor.mtx -v");
    says!(verified, "taken out of a larger superelement");
}

#[test]
fn a_planar_part_is_shown_in_its_plane() {
    let folder = Folder::rod();
    folder.done("rod.mtx");
    let found = folder.inspected("rod.dcb.h5");
    assert_eq!(found["dimension"], 2);
    assert!(found["inertia"].is_f64());
    assert_eq!(found["first_omitted_eigenvalue"], json!(null));
    let shown = folder.done("inspect rod.dcb.h5 -v");
    says!(
        shown,
        "planar superelement",
        "every finite mode is kept",
        "attachment coordinates: 0 for 4 rows; the modes say all there is"
    );
}

#[test]
fn a_frozen_file_of_the_first_version_is_shown() {
    for name in ["planar-1.0.dcb.h5", "spatial-1.0.dcb.h5"] {
        let path = stored("tests/data/frozen").join(name);
        let folder = Folder::empty();
        let shown = folder.done(&format!("inspect {} -v", path.display()));
        says!(shown, "format 1.0");
        folder.inspected(&path.display().to_string());
    }
}

#[test]
fn errors_are_shown_between_their_bounds() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    let found = folder.inspected("rotor.dcb.h5");
    let errors = &found["errors"];
    assert_eq!(errors["loss_factor"], 0.02);
    for form in ["strong", "static"] {
        for measure in ["collocated", "transfer"] {
            let bounds = &errors[form][measure]["largest"];
            let bound = |key: &str| number(&bounds[key]);
            assert!(
                0.0 < bound("lower") && bound("lower") < bound("upper"),
                "{form} {measure}: {bounds}"
            );
        }
    }
    let of = |form: &str| errors[form]["collocated"]["largest"]["upper"].as_f64();
    assert!(of("strong") < of("static"), "{errors}");
    let shown = folder.done("inspect rotor.dcb.h5 --band 1:20 -v");
    says!(
        shown,
        "errors, rigorous bounds from 1.0000 to 20.0000 Hz, loss factor 0.02",
        "collocated response",
        "kept free frequencies              up to "
    );
    folder.refused_each(&[
        (
            "inspect rotor.dcb.h5 --band 10:1000",
            &["1000", "first frequency left out", "keep more modes"],
        ),
        ("inspect rotor.dcb.h5 --band 100", &["10:2000"]),
    ]);
    let old = stored("tests/data/frozen/planar-1.1.dcb.h5");
    folder.refused(
        &format!("inspect {} --band 1:2", old.display()),
        &["no moments", "reduce the part again"],
    );
    assert_eq!(
        folder.inspected(&old.display().to_string())["errors"],
        json!(null)
    );
}

#[test]
fn errors_can_be_left_out() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4 -o with.dcb.h5");
    folder.done("rotor.mtx --modes 4 -o without.dcb.h5 --without-estimate");
    let [with, without] = ["with.dcb.h5", "without.dcb.h5"].map(|file| folder.inspected(file));
    assert!(with["errors"].is_object() && without["errors"].is_null());
    assert_eq!(with["eigenvalues"], without["eigenvalues"]);
    assert_eq!(without["warnings"], json!([]));
    folder.done("verify without.dcb.h5 --component rotor.mtx");
}

#[test]
fn other_files_are_refused() {
    let folder = Folder::rotor();
    folder.refused_each(&[
        ("inspect nowhere.h5", &["nowhere.h5", "cannot read"]),
        ("inspect rotor.json", &["rotor.json", "isn't an HDF5 file"]),
        ("inspect .", &[".", "isn't a file"]),
    ]);
    folder.write("empty.h5", "");
    folder.refused("inspect empty.h5", &["empty.h5"]);
    folder.done("rotor.mtx");
    let whole = folder.bytes("rotor.dcb.h5");
    folder.write("half.h5", &whole[..whole.len() / 2]);
    folder.refused("inspect half.h5", &["half.h5"]);
}
