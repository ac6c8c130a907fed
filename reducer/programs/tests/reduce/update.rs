//! `reduce update`: measured modes from a CSV file.

use crate::support::{Folder, says, stored};

fn bracket() -> Folder {
    let folder = Folder::empty();
    let part = dcb_samples::bracket(2);
    dcb_samples::write(&part, &folder.path("."), "bracket").unwrap();
    folder.done("bracket.mtx --modes 12 -q");
    let modes = std::fs::read(stored("samples/data/bracket/modes.csv")).unwrap();
    folder.write("modes.csv", modes);
    folder
}

#[test]
fn measured_modes_are_shown_and_taken_over() {
    let folder = bracket();
    let shown = folder.done("update bracket.dcb.h5 --measured modes.csv");
    says!(
        shown,
        "bracket: 5 measured modes beside 12 computed ones of the free part",
        "1882.191227",
        "0.9968",
        "nothing was written"
    );
    assert!(!folder.path("bracket.updated.dcb.h5").exists());
    let shown =
        folder.done("update bracket.dcb.h5 --measured modes.csv --replace damping,frequencies");
    says!(
        shown,
        "written  bracket.updated.dcb.h5 with measured damping and frequencies"
    );
    let found = folder.inspected("bracket.updated.dcb.h5");
    assert!((found["damping"][0].as_f64().unwrap() - 0.0031).abs() < 1e-12);
    assert!((found["frequencies_hz"][0].as_f64().unwrap() - 1843.6).abs() < 1e-9);
    assert_eq!(found["options"]["measured"]["modes"][3]["mode"], 5);
    let inputs = found["inputs"].as_array().unwrap();
    assert!(inputs.iter().any(|input| input["role"] == "measured"));
    let warning = found["warnings"][0].as_str().unwrap();
    assert!(warning.contains("modal frequencies are those measured in modes.csv"));
    // Again, and over the part itself.
    folder.refused(
        "update bracket.dcb.h5 --measured modes.csv --replace damping",
        &["bracket.updated.dcb.h5", "--force"],
    );
    folder.refused(
        "update bracket.dcb.h5 --measured modes.csv --replace damping -o bracket.dcb.h5 --force",
        &["bracket.dcb.h5"],
    );
}

#[test]
fn mistakes_are_named() {
    let folder = bracket();
    for (text, told) in [
        (
            "frequency [Hz],damping\n100\n",
            "modes.csv:2: has 1 entries",
        ),
        (
            "frequency [Hz],900000.ux\n100,1\n",
            "node 900000 has no field ux",
        ),
        (
            "frequency [Hz],0.ux\n100,1\n200,1\n",
            "2 modes, but shapes at 1 places only",
        ),
        ("hertz\n100\n", "column \"hertz\" isn't known"),
    ] {
        folder.write("modes.csv", text);
        folder.refused("update bracket.dcb.h5 --measured modes.csv", &[told]);
    }
    folder.refused("update bracket.dcb.h5 --measured none.csv", &["none.csv"]);
    folder.refused(
        "update bracket.dcb.h5 --measured modes.csv --replace shapes",
        &["damping", "frequencies"],
    );
}

/// The converter on the page gives the modes of universal files back: shapes, complex ones, and accelerances.
#[test]
fn universal_files_come_through_the_converter_of_the_page() {
    let page = std::fs::read_to_string(stored("docs/measured.md")).unwrap();
    let programs = page.split("```python\n").skip(1);
    let program = programs
        .map(|rest| rest.split("```").next().unwrap())
        .find(|program| program.contains("import pyuff"))
        .unwrap();
    let folder = Folder::empty();
    folder.write("uff_to_csv.py", program);
    let arguments = [folder.path("uff_to_csv.py"), folder.path(".")];
    let arguments = arguments.each_ref().map(|path| path.as_os_str());
    let said = dcb_tests::python::run("universal_files.py", &arguments).unwrap();
    assert_eq!(said.trim(), "ok");
}
