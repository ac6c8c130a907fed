//! What of a superelement a target has no place for, as found in this one.

use dcb_formats::Error;
use dcb_formats::component::Role;
use dcb_formats::units::{hertz, hertz_unit};
use nalgebra::Matrix3;

use crate::part::Part;
use crate::part::frames::Frame;
use crate::part::names::listed;

/// What a target can hold beside mass, stiffness and interfaces on which forces act.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Holds {
    /// Inertia that follows the deflection: I1, L3, I2.
    pub inertia_change: bool,
    /// Geometric stiffness.
    pub stiffening: bool,
    /// Damping.
    pub damping: bool,
    /// Interfaces that are only observed.
    pub outputs: bool,
    /// Axes of the interfaces.
    pub axes: bool,
    /// Displacements of nodes.
    pub fields: bool,
}

/// One line each.
pub(crate) fn left_out(part: &Part<'_>, holds: Holds) -> Result<Vec<String>, Error> {
    let element = part.superelement;
    let basis = &part.basis;
    let mut lines = vec![format!(
        "the dual form: F_res and M_res of {} rows; the target has the strong form's {}",
        element.rows.len(),
        part.coordinates()
    )];
    if let Some(moments) = &element.moments {
        let bound = moments.eigenvalue_bound;
        let bound = match bound.is_finite() {
            true => {
                let time = &element.units.time;
                format!(
                    ", and that no omitted frequency is below {:.4} {}",
                    hertz(bound, time),
                    hertz_unit(time)
                )
            }
            false => String::new(),
        };
        lines.push(format!(
            "error bounds: four power moments over {} rows{bound}",
            moments.first.nrows()
        ));
    }
    if basis.has_massless_flexibility {
        lines.push("flexibility without mass: the interfaces are stiffer here by what no coordinate carries".to_owned());
    }
    if !holds.inertia_change {
        lines.push(format!(
            "inertia that follows the deflection (I1, L3, I2 over {} coordinates): the matrices are those of small motions about the rest shape",
            basis.count()
        ));
    }
    if !holds.stiffening {
        let stiffening = [
            ("spin", basis.centrifugal.len()),
            ("interface forces", basis.interface.len()),
        ];
        let present = stiffening.iter().filter(|(_, count)| *count > 0);
        lines.extend(
            present.map(|(of, count)| format!("geometric stiffness by {of}: {count} matrices")),
        );
    }
    let damped = basis.damping.iter().filter(|value| **value > 0.0).count();
    if damped > 0 && !holds.damping {
        lines.push(format!(
            "damping of {damped} of {} coordinates",
            basis.count()
        ));
    }
    lines.extend(of_frames(part, holds));
    if !element.loads.is_empty() {
        let loads: Vec<String> = element
            .loads
            .iter()
            .map(|load| format!("{:?}", load.name))
            .collect();
        lines.push(format!("loads on the inside: {}", listed(&loads)));
    }
    if !holds.fields && part.source.has_fields()? {
        lines.push("nodal fields: displacements inside the part".to_owned());
    }
    Ok(lines)
}

/// Interfaces and axes that have no place.
fn of_frames(part: &Part<'_>, holds: Holds) -> Vec<String> {
    let mut lines = Vec::new();
    let names = |frames: Vec<&Frame>| -> Vec<String> {
        frames
            .iter()
            .map(|frame| format!("{:?}", frame.name))
            .collect()
    };
    let outputs: Vec<&Frame> = (part.frames.iter())
        .filter(|frame| frame.role == Role::Output)
        .collect();
    if !holds.outputs && !outputs.is_empty() {
        lines.push(format!(
            "interfaces that are only observed: {}",
            listed(&names(outputs))
        ));
    }
    let turned: Vec<&Frame> = (part.frames.iter())
        .filter(|frame| frame.orientation != Matrix3::identity())
        .collect();
    if !holds.axes && !turned.is_empty() {
        lines.push(format!(
            "axes of the interfaces {}: displacements are along the component's axes",
            listed(&names(turned))
        ));
    }
    lines
}

/// Numbers stay in the component's units; said where these aren't SI.
pub(crate) fn unit_note(part: &Part<'_>) -> Option<String> {
    let units = &part.superelement.units;
    let is_si = (
        units.length.as_str(),
        units.mass.as_str(),
        units.time.as_str(),
    ) == ("m", "kg", "s");
    (!is_si).then(|| {
        format!(
            "numbers are in {}, {}, {}, as in the superelement: the other program has to use the same units",
            units.length, units.mass, units.time
        )
    })
}
