//! The same part in m-kg-s and mm-t-s.

use dcb_formats::component::Units;
use dcb_samples::{SpatialBeam, UnitScale, in_units, spatial_beam};

use crate::support::{Folder, says};

/// A beam: translations and rotations stand side by side, so a wrong factor anywhere shows.
#[test]
fn both_systems_give_one_superelement() {
    let beam = spatial_beam(&SpatialBeam::default());
    let folder = Folder::with(&beam);
    dcb_samples::write(
        &in_units(&beam, &UnitScale::mm_t_s()),
        &folder.path("."),
        "mm",
    )
    .unwrap();
    folder.done("part.mtx --modes 8");
    let shown = folder.run("mm.mtx --modes 8 -v").stdout;
    says!(shown, " t\n", " mm\n", "t·mm²");
    folder.done("verify mm.dcb.h5 --component mm.mtx");
    let shown = folder.done("compare part.dcb.h5 mm.dcb.h5 -v");
    says!(shown, "m kg s", "mm t s");
    let mut compared = 0;
    for line in shown
        .lines()
        .filter(|line| line.contains('[') || line.contains("scaled difference"))
    {
        if let Some(Ok(difference)) = line.split_whitespace().last().map(str::parse::<f64>) {
            assert!(difference < 1e-9, "{line}");
            compared += 1;
        }
    }
    assert!(compared >= 12, "{shown}");
    assert_eq!(shown.matches("1.000000 with").count(), 8, "{shown}");
}

#[test]
fn a_frequency_limit_is_in_hertz_whatever_the_units() {
    let beam = spatial_beam(&SpatialBeam::default());
    let folder = Folder::with(&beam);
    let units = Units {
        time: "ms".into(),
        ..beam.units.clone()
    };
    let scale = UnitScale {
        units,
        length: 1.0,
        mass: 1.0,
        time: 1e3,
    };
    dcb_samples::write(&in_units(&beam, &scale), &folder.path("."), "ms").unwrap();
    folder.done("part.mtx --max-frequency 1000");
    folder.done("ms.mtx --max-frequency 1000");
    let count = |name: &str| folder.mode_count(name);
    assert!(count("part.dcb.h5") > 2);
    assert_eq!(count("part.dcb.h5"), count("ms.dcb.h5"));
}
