//! `reduce assemble`.

use std::fs;

use crate::support::{Folder, stored};

/// Two rotors, end to end: one is turned half round about x, so that equal bearings meet.
const PAIR: &str = r#"{
  "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
  "bodies": {
    "first": {"superelement": "rotor.dcb.h5"},
    "second": {"superelement": "rotor.dcb.h5", "position": [0, 0, 1], "orientation": [0, 1, 0, 0]}
  },
  "joints": {"coupling": {"fixed": {"a": "first/bearing-right", "b": "second/bearing-right"}}},
  "interfaces": {"left": "first/bearing-left", "right": "second/bearing-left"}
}"#;

fn pair() -> Folder {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 8");
    fs::write(folder.path("pair.json"), PAIR).unwrap();
    folder
}

#[test]
fn two_rotors_are_one() {
    let folder = pair();
    let shown = folder.done("assemble pair.json --modes 6 -v");
    for part in [
        "pair: 2 bodies as one, free; ",
        "accuracy the parts'",
        "limited by",
        "written  pair.dcb.h5",
    ] {
        assert!(shown.contains(part), "{part}:\n{shown}");
    }
    let shown = folder.done("inspect pair.dcb.h5");
    assert!(
        shown.contains("bound with the parts' truncation") && shown.contains("fields   "),
        "{shown}"
    );
    folder.done("verify pair.dcb.h5");
    folder.done("report pair.dcb.h5");
    let of = |name: &str| -> serde_json::Value {
        serde_json::from_str(&folder.done(&format!("inspect {name} --json"))).unwrap()
    };
    let (whole, part) = (of("pair.dcb.h5"), of("rotor.dcb.h5"));
    let mass = |of: &serde_json::Value| of["mass"].as_f64().unwrap();
    assert!((mass(&whole) / mass(&part) - 2.0).abs() < 1e-12);
    assert_eq!(whole["inputs"].as_array().unwrap().len(), 2);
    assert!(whole.pointer("/quality/assembly/modes/0/lower").is_some());
    // Nothing of the inside, if that is asked for; the next level takes it all the same.
    folder.done("assemble pair.json --without-fields -o secret.dcb.h5");
    assert!(
        folder
            .done("inspect secret.dcb.h5")
            .contains("fields   none; mesh none")
    );
    let next = PAIR
        .replace("rotor.dcb.h5", "secret.dcb.h5")
        .replace("bearing-right", "right")
        .replace("bearing-left", "left")
        .replace("[0, 0, 1]", "[0, 0, 2]");
    fs::write(folder.path("four.json"), next).unwrap();
    folder.done("assemble four.json");
    let four = of("four.dcb.h5");
    assert!((mass(&four) / mass(&part) - 4.0).abs() < 1e-12);
}

#[test]
fn mistakes_are_named_and_nothing_is_written() {
    let folder = pair();
    let write = |name: &str, from: &str, to: &str| {
        assert!(PAIR.contains(from));
        fs::write(folder.path(name), PAIR.replace(from, to)).unwrap();
    };
    write("units.json", r#""length": "m""#, r#""length": "mm""#);
    folder.write(
        "flat.json",
        r#"{"dimension": 2, "units": {"length": "m", "mass": "kg", "time": "s"},
          "bodies": {"first": {"superelement": "rotor.dcb.h5"}}, "interfaces": {"left": "first/bearing-left"}}"#,
    );
    write(
        "twice.json",
        r#", "position": [0, 0, 1], "orientation": [0, 1, 0, 0]"#,
        "",
    );
    write("gap.json", "[0, 0, 1]", "[0, 0, 1.001]");
    write("name.json", "first/bearing-right", "first/bearing");
    write("missing.json", "\"rotor.dcb.h5\", ", "\"motor.dcb.h5\", ");
    write("loose.json", r#""fixed""#, r#""spherical""#);
    write(
        "table.json",
        r#""interfaces""#,
        r#""springs": {"s": {"spring": {"a": "ground", "b": "first/bearing-left", "stiffness": [[0, 0], [1, 2]]}}}, "interfaces""#,
    );
    folder.refused_each(&[
        (
            "assemble units.json",
            &[
                "bodies.first",
                "is in m, kg, s and the assembly in mm, kg, s",
            ],
        ),
        (
            "assemble flat.json",
            &["bodies.first", "has 3 dimensions, the assembly 2"],
        ),
        (
            "assemble twice.json",
            &[
                "bodies.second",
                "at the place of \"first\", which is the same file",
            ],
        ),
        (
            "assemble gap.json",
            &["joints.coupling.fixed", "don't meet", "1.000000e-3 m apart"],
        ),
        (
            "assemble name.json",
            &["no interface \"bearing\"", "bearing-left"],
        ),
        ("assemble missing.json", &["motor.dcb.h5", "cannot read"]),
        ("assemble loose.json", &["isn't one body: 3 motion(s)"]),
        ("assemble table.json", &["springs.s.spring", "is a table"]),
        ("assemble rotor.dcb.h5", &["is an HDF5 file"]),
        ("assemble rotor.mtx", &["is a matrix"]),
        (
            "assemble pair.json -o rotor.dcb.h5 --force",
            &["rotor.dcb.h5"],
        ),
        ("assemble none.json", &["none.json", "cannot read"]),
    ]);
    folder.done("assemble loose.json --allow-loose");
    folder.done("assemble pair.json");
    folder.refused("assemble pair.json", &["exists already"]);
}

#[test]
fn the_shipped_arm_is_put_together() {
    let folder = Folder::empty();
    let arm = stored("samples/arm/assembly.json");
    let shown = folder.done(&format!("assemble {} -o arm.dcb.h5", arm.display()));
    assert!(shown.contains("arm: 3 bodies as one, free"), "{shown}");
}
