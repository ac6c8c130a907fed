//! `simulate campbell`.

use crate::support::Folder;

const ROTOR: &str = r#"{
  "dimension": 3, "units": {"length": "mm", "mass": "t", "time": "ms"},
  "ground": {"points": {"left": [0, 0, -100], "right": [0, 0, 100]}},
  "bodies": {"rotor": {"rigid": {"mass": 3e-3, "inertia": [20, 20, 10], "points": {"left": [0, 0, -100], "right": [0, 0, 100]}}, "angular_velocity": [0, 0, 0.1]}},
  "springs": {
    "left": {"bushing": {"a": "ground/left", "b": "rotor/left", "translation": [2e-4, 2e-4, 1e-4]}},
    "right": {"bushing": {"a": "ground/right", "b": "rotor/right", "translation": [2e-4, 2e-4, 1e-4]}}
  },
  "analysis": {"modes": {"count": 8}}
}"#;

#[test]
fn speeds_are_in_rpm_whatever_the_unit_of_time() {
    let folder = Folder::empty();
    folder.write("rotor.json", ROTOR);
    let shown = folder
        .done("campbell rotor.json --rpm 500:8000:16 --csv whirl.csv --svg whirl.svg")
        .stdout;
    // The bounce: √(4e-4 t/ms² / 3e-3 t) in rad/ms.
    let bounce = (4e-4_f64 / 3e-3).sqrt() * 1e3 * 60.0 / std::f64::consts::TAU;
    let line = shown
        .lines()
        .find(|line| line.contains(&format!("{bounce:.2}")))
        .unwrap();
    assert!(line.trim_end().ends_with('1'), "{shown}");
    let table = folder.read("whirl.csv");
    assert!(
        table.starts_with("speed [rpm],mode,frequency [Hz],motion,damping [1]\n"),
        "{table}"
    );
    assert!(table.contains(",backward,") && table.contains(",along,"));
    assert!(folder.read("whirl.svg").contains("per revolution"));
    folder.refused(
        "campbell rotor.json --rpm 500:8000:16 --csv whirl.csv",
        &["whirl.csv", "--force"],
    );
}

#[test]
fn mistakes_are_named() {
    let folder = Folder::empty();
    folder.write("rotor.json", ROTOR);
    for (arguments, told) in [
        ("campbell rotor.json --rpm 0:100:10", "FROM:TO:COUNT"),
        ("campbell rotor.json --rpm 100:50:10", "FROM:TO:COUNT"),
        ("campbell rotor.json", "--rpm"),
        (
            "campbell rotor.json --rpm 1:100:4 --rotor disk",
            "there is no body \"disk\"",
        ),
        ("campbell none.json --rpm 1:100:4", "none.json"),
    ] {
        folder.refused(arguments, &[told]);
    }
    folder.write(
        "rotor.json",
        ROTOR.replace(
            "\"translation\": [2e-4, 2e-4, 1e-4]}},",
            "\"translation\": [2e-4, 3e-4, 1e-4]}},",
        ),
    );
    folder.refused(
        "campbell rotor.json --rpm 1000:2000:4",
        &["rotor.json", "springs", "aren't alike in all directions"],
    );
}
