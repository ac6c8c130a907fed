//! A linear system as arrays of NumPy: names, shapes and units are listed in `docs/linear-systems.md`.

use dcb_formats::linear_system::{LinearSystem, Pole};

use crate::files::arrays::Arrays;

pub(super) fn bytes(system: &LinearSystem) -> std::io::Result<Vec<u8>> {
    let mut arrays = Arrays::new();
    arrays.matrix("A", &system.a)?;
    arrays.matrix("B", &system.b)?;
    arrays.matrix("C", &system.c)?;
    arrays.matrix("D", &system.d)?;
    for (name, of, offset) in [
        ("state", &system.states, None),
        ("input", &system.inputs, Some("u0")),
        ("output", &system.outputs, Some("y0")),
    ] {
        let count = [of.len()];
        arrays.texts(&format!("{name}_names"), &count, &super::names(of))?;
        arrays.texts(&format!("{name}_units"), &count, &super::units(of))?;
        if let Some(offset) = offset {
            arrays.reals(offset, &count, &super::values(of))?;
        }
    }
    arrays.complex("poles", &super::poles(system))?;
    let of_poles = |of: fn(&Pole) -> f64| system.poles.iter().map(of).collect::<Vec<f64>>();
    let count = [system.poles.len()];
    arrays.reals("frequency", &count, &of_poles(Pole::frequency))?;
    arrays.reals("damping_ratio", &count, &of_poles(Pole::damping_ratio))?;
    arrays.reals("time", &[], &[system.time])?;
    arrays.integers("is_equilibrium", &[], &[i64::from(system.is_equilibrium)])?;
    let units = &system.units;
    arrays.texts("units", &[3], &[&units.length, &units.mass, &units.time])?;
    if let Some(truncation) = &system.truncation {
        arrays.reals("hankel", &[truncation.hankel.len()], &truncation.hankel)?;
        arrays.reals("bound", &[], &[truncation.bound])?;
        arrays.matrix("bounds", &truncation.bounds)?;
        arrays.integers("full_order", &[], &[truncation.full_order as i64])?;
        arrays.integers("kept_apart", &[], &[truncation.kept_apart as i64])?;
    }
    arrays.finish()
}
