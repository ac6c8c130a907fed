//! A linear system as a MATLAB file: the variables of the npz, lists of names as cells, numbers as 1 x 1, lists as columns.

use dcb_formats::linear_system::{LinearSystem, Pole};
use faer::Mat;

use crate::files::mat5::MatFile;

/// Elements of a MATLAB file have 32-bit lengths.
const MOST: usize = 16_000;

pub(super) fn bytes(system: &LinearSystem) -> Result<Vec<u8>, String> {
    let largest = system
        .order()
        .max(system.outputs.len())
        .max(system.inputs.len());
    if largest > MOST {
        return Err(format!(
            "the system has a matrix with {largest} rows or columns, and one in a MATLAB file of version 5 has at most {MOST}; write .h5 or .npz"
        ));
    }
    let mut file = MatFile::new(
        "MATLAB 5.0 MAT-file: linear system x' = A x + B (u - u0), y = y0 + C x + D (u - u0)",
    );
    file.matrix("A", &system.a);
    file.matrix("B", &system.b);
    file.matrix("C", &system.c);
    file.matrix("D", &system.d);
    let column = |values: &[f64]| Mat::from_fn(values.len(), 1, |i, _| values[i]);
    for (name, of, offset) in [
        ("state", &system.states, None),
        ("input", &system.inputs, Some("u0")),
        ("output", &system.outputs, Some("y0")),
    ] {
        file.texts(&format!("{name}_names"), &super::names(of));
        file.texts(&format!("{name}_units"), &super::units(of));
        if let Some(offset) = offset {
            file.matrix(offset, &column(&super::values(of)));
        }
    }
    file.complex("poles", &super::poles(system));
    let of_poles =
        |of: fn(&Pole) -> f64| column(&system.poles.iter().map(of).collect::<Vec<f64>>());
    file.matrix("frequency", &of_poles(Pole::frequency));
    file.matrix("damping_ratio", &of_poles(Pole::damping_ratio));
    file.matrix("time", &column(&[system.time]));
    file.matrix(
        "is_equilibrium",
        &column(&[f64::from(u8::from(system.is_equilibrium))]),
    );
    let units = &system.units;
    file.texts("units", &[&units.length, &units.mass, &units.time]);
    if let Some(truncation) = &system.truncation {
        file.matrix("hankel", &column(&truncation.hankel));
        file.matrix("bound", &column(&[truncation.bound]));
        file.matrix("bounds", &truncation.bounds);
        file.matrix("full_order", &column(&[truncation.full_order as f64]));
        file.matrix("kept_apart", &column(&[truncation.kept_apart as f64]));
    }
    Ok(file.finish())
}
