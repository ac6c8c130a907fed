//! How a superelement was made: files of 1.4 say it in datasets, older ones in the provenance, and all programs find it in one place.

use std::path::Path;

use dcb_formats::dcb::{Compression, SuperelementFile, read_superelement};
use dcb_formats::mesh::Dimension::{self, Planar, Spatial};
use dcb_formats::superelement::{
    CouplingSource, Derivation, InterfaceDirections, SelectionRecord, Superelement,
};
use dcb_tests::synthetic;
use hdf5::H5Type;
use hdf5::file::LibraryVersion;
use serde_json::{Value, json};

use crate::hdf5_file::{self, set_text};

fn edit(path: &Path, change: impl FnOnce(&hdf5::File)) {
    hdf5_file::edit(path, LibraryVersion::V110, change);
}

fn refusal(path: &Path) -> String {
    read_superelement(path).unwrap_err().to_string()
}

/// Gives a changed file the hash or the digest that it should have.
fn sign(path: &Path, dataset: Option<&str>) {
    let message = refusal(path);
    let right = message.rsplit_once("give ").expect(&message).1[..64].to_owned();
    edit(path, |file| match dataset {
        Some(name) => set_text(&file.dataset(name).unwrap(), "sha256", &right),
        None => set_text(file, "digest", &right),
    });
}

fn written(path: &Path, of: &Superelement) {
    synthetic::write(path, of, Compression::None).unwrap();
}

/// The message where one entry of a dataset is another.
fn with_entry<T: H5Type + Copy>(path: &Path, dataset: &str, place: usize, value: T) -> String {
    written(path, &synthetic::enriched(Planar));
    edit(path, |file| {
        let data = file.dataset(dataset).unwrap();
        let mut values = data.read_raw::<T>().unwrap();
        values[place] = value;
        data.write_raw(&values).unwrap();
    });
    sign(path, Some(dataset));
    sign(path, None);
    refusal(path)
}

#[test]
fn datasets_that_contradict_each_other_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    let integers = [
        ("interface_directions", 0, 8, "8 directions of 7"),
        ("interface_directions", 0, -1, "none may be negative"),
        ("internal_rows", 0, -72, "none may be negative"),
        ("selection_modes", 0, 2, "names selection 2 of 2"),
        ("selection_modes", 1, 2, "says 2 of a mode"),
        ("selection_modes", 1, -1, "none may be negative"),
        (
            "selection_modes",
            1,
            0,
            "has 5 modes before it; the one before it kept 4",
        ),
        (
            "selection_modes",
            19,
            0,
            "has 3 modes of the last selection; the superelement has 4",
        ),
        ("selection_force_interfaces", 0, 2, "names selection 2 of 2"),
        ("selection_force_interfaces", 1, 3, "names interface 3 of 3"),
        (
            "selection_force_interfaces",
            1,
            1,
            "isn't one of interface \"Auge-ü\"",
        ),
    ];
    for (dataset, place, value, expected) in integers {
        let message = with_entry(&path, &format!("/derivation/{dataset}"), place, value);
        // Forces and their interfaces are one matter.
        let of = dataset.trim_end_matches("_interfaces");
        assert!(
            message.contains(of) && message.contains(expected),
            "{dataset} {place} {value}: {message}"
        );
    }
    for dataset in [
        "/derivation/selection_first_omitted_eigenvalues",
        "/derivation/selection_frequency_limits",
    ] {
        for value in [-1.0, f64::NAN, f64::NEG_INFINITY] {
            let message = with_entry(&path, dataset, 1, value);
            let expected = format!("{dataset}: entry 1 is {value}");
            assert!(message.contains(&expected), "{message}");
        }
    }
    let message = with_entry(&path, "/derivation/selection_forces", 0, f64::NAN);
    assert!(
        message.contains("/derivation/selection_forces"),
        "{message}"
    );
}

#[test]
fn a_part_of_the_story_is_not_enough() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    for name in [
        "/derivation/coupling_source",
        "/derivation/selection_modes",
        "/derivation/selection_first_omitted_eigenvalues",
        "/derivation/selection_frequency_limits",
        "/derivation/selection_forces",
        "/derivation/selection_force_interfaces",
    ] {
        written(&path, &synthetic::enriched(Spatial));
        edit(&path, |file| file.unlink(name).unwrap());
        sign(&path, None);
        let message = refusal(&path);
        let expected = format!("{name}: is missing");
        assert!(message.contains(&expected), "{message}");
    }
}

/// The writer refuses what the reader would.
#[test]
fn nothing_is_written_that_could_not_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    let refused = |change: &dyn Fn(&mut Derivation)| {
        let mut of = synthetic::enriched(Planar);
        change(of.derivation.as_mut().unwrap());
        let refused = synthetic::write(&path, &of, Compression::None);
        assert!(!path.exists());
        refused.unwrap_err().to_string()
    };
    let along = |of: &mut Derivation, name: &str, forces: Vec<Vec<f64>>| {
        of.selections[1]
            .loaded_along
            .insert(name.to_owned(), forces);
    };
    for (message, expected) in [
        (
            refused(&|of| {
                of.selections[1].modes.pop();
            }),
            "has 3 modes of the last selection; the superelement has 4",
        ),
        (
            refused(&|of| of.left_out_columns.push("spin zz".to_owned())),
            "twice",
        ),
        (
            refused(&|of| of.left_out_columns.push("spin xx".to_owned())),
            "/enrichment/names",
        ),
        (
            refused(&|of| of.left_out_columns.push(String::new())),
            "1 to 4096 bytes",
        ),
        (
            refused(&|of| along(of, "nowhere", vec![vec![1.0]])),
            "no interface",
        ),
        (
            refused(&|of| along(of, "Auge-ü", vec![vec![1.0]])),
            "2 are needed",
        ),
        (refused(&|of| along(of, "Auge-ü", vec![])), "along no force"),
        (
            refused(&|of| along(of, "Auge-ü", vec![vec![f64::NAN, 0.0]])),
            "finite",
        ),
    ] {
        assert!(message.contains(expected), "{message}");
    }
}

/// A file of 1.3: the same without the datasets of 1.4.
fn older(path: &Path, dimension: Dimension, quality: Value, options: Value) -> Option<Derivation> {
    let mut of = synthetic::enriched(dimension);
    of.derivation = None;
    of.provenance.quality = quality;
    of.provenance.options = options;
    written(path, &of);
    edit(path, |file| set_text(file, "format_version", "1.3"));
    sign(path, None);
    let file = SuperelementFile::open(path).unwrap();
    assert_eq!(file.format_version().to_string(), "1.3");
    file.superelement().unwrap().derivation
}

#[test]
fn files_before_1_4_say_it_in_the_provenance() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    for dimension in [Planar, Spatial] {
        let now = Derivation {
            // Nothing before 1.5 knows of any.
            internal_rows: 0,
            ..synthetic::enriched(dimension).derivation.unwrap()
        };
        let mut selections = json!(now.selections);
        for listed in selections.as_array_mut().unwrap() {
            listed["observed"] = json!([]);
            listed["dropped"] = json!(["gone"]);
            listed["further_columns"] = json!([0]);
        }
        let quality = json!({
            "couplings": "nodal",
            "interface_reduction": { "wanted": 5, "kept": 5, "available": 7 },
            "enrichment": { "left_out": now.left_out_columns },
        });
        let options = json!({ "selections": selections });
        let then = older(&path, dimension, quality.clone(), options.clone()).unwrap();
        // serde_json reads some numbers a digit off.
        for (then, now) in then.selections.iter().zip(&now.selections) {
            let off = |(a, b): (&f64, &f64)| assert!((a - b).abs() < 1e-15, "{a} {b}");
            let numbers = |of: &SelectionRecord| -> Vec<f64> {
                of.loaded_along
                    .values()
                    .flatten()
                    .flatten()
                    .copied()
                    .collect()
            };
            numbers(then).iter().zip(&numbers(now)).for_each(off);
            assert_eq!(numbers(then).len(), numbers(now).len());
        }
        let rounded = |of: &Derivation| {
            let mut of = of.clone();
            for record in &mut of.selections {
                let forces = record.loaded_along.values_mut().flatten().flatten();
                forces.for_each(|force| *force = 0.0);
            }
            of
        };
        assert_eq!(rounded(&then), rounded(&now));

        // A file of 1.4 goes by its datasets alone.
        let mut of = synthetic::enriched(dimension);
        of.derivation = None;
        of.provenance.quality = quality;
        of.provenance.options = options;
        written(&path, &of);
        assert_eq!(read_superelement(&path).unwrap().derivation, None);
    }
}

/// The digest doesn't cover the provenance: nothing in it makes an old file unreadable.
#[test]
fn an_old_provenance_that_says_something_else_is_read_as_far_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    let read = |quality, options| older(&path, Planar, quality, options);
    for options in [
        Value::Null,
        json!({ "selections": null }),
        json!("selections"),
        json!([1]),
    ] {
        assert_eq!(read(Value::Null, options.clone()), None);
        let said = read(json!({ "orthogonality": 1e-15 }), options);
        assert_eq!(said, Some(Derivation::default()));
    }
    let strange = read(
        json!({ "couplings": 3, "interface_reduction": { "kept": -1, "available": 4 } }),
        json!({ "selections": [
            "everything",
            { "modes": [0], "of_modes": 1, "loaded_along": { "gone": [[1.0]], "big end": [[1.0]], "Auge-ü": [[1.0, 2.0]] } },
        ] }),
    );
    let strange = strange.unwrap();
    assert_eq!(strange.coupling_source, CouplingSource::Unknown);
    let directions = InterfaceDirections {
        kept: 0,
        available: 4,
    };
    assert_eq!(strange.interface_directions, Some(directions));
    assert_eq!(strange.selections[0], SelectionRecord::default());
    let along = &strange.selections[1].loaded_along;
    assert_eq!(along.len(), 2);
    assert_eq!(along["Auge-ü"], [[1.0, 2.0]]);
    assert!(along["big end"].is_empty(), "not over its rows");
}
