//! How the nodes of a superelement move.

use dcb_formats::Superelement;
use dcb_formats::units::{hertz, hertz_unit};

pub(crate) mod node_shapes;

/// Modes as pictures name them, by number and frequency.
pub(crate) fn mode_names(element: &Superelement) -> Vec<String> {
    let time = &element.units.time;
    let modes = element.modes.eigenvalues.iter().enumerate();
    let name = |(k, square): (usize, &f64)| {
        let (frequency, unit) = (hertz(*square, time), hertz_unit(time));
        format!("mode {}: {frequency:.4} {unit}", k + 1)
    };
    modes.map(name).collect()
}
