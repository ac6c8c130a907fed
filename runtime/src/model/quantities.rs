//! Channels of recorded quantities, with their units.

use dcb_formats::component::Units;
use dcb_formats::mesh::Dimension;
use dcb_formats::results::{Channel, Column};
use dcb_formats::units::DerivedUnits;

use crate::system::System;

/// A number of a channel.
pub(super) fn column(name: &str, unit: &str) -> Column {
    Column {
        name: name.to_owned(),
        unit: unit.to_owned(),
    }
}

/// Units of what is recorded.
pub(crate) struct Quantities {
    pub(crate) length: String,
    pub(crate) time: String,
    pub(crate) velocity: String,
    pub(crate) acceleration: String,
    pub(crate) angular_velocity: String,
    pub(crate) force: String,
    pub(crate) moment: String,
    pub(crate) energy: String,
    pub(crate) momentum: String,
    pub(crate) angular_momentum: String,
    pub(crate) modal: String,
    pub(crate) stress: String,
}

impl Quantities {
    pub(crate) fn of(units: &Units) -> Self {
        let (l, m, t) = (&units.length, &units.mass, &units.time);
        let derived = DerivedUnits::of(l, m, t);
        Self {
            length: l.clone(),
            time: t.clone(),
            velocity: format!("{l}/{t}"),
            acceleration: format!("{l}/{t}^2"),
            angular_velocity: format!("rad/{t}"),
            force: derived.force,
            moment: derived.moment,
            energy: derived.energy,
            momentum: format!("{m}*{l}/{t}"),
            angular_momentum: format!("{m}*{l}^2/{t}"),
            stress: derived.stress,
            modal: format!("sqrt({m})*{l}"),
        }
    }

    pub(super) fn vector(
        &self,
        path: &str,
        dimension: Dimension,
        unit: &str,
        description: &str,
    ) -> Channel {
        let names: &[&str] = match dimension {
            Dimension::Planar => &["x", "y"],
            Dimension::Spatial => &["x", "y", "z"],
        };
        Channel::vector(path, names, unit, description)
    }

    pub(super) fn wrench(&self, path: &str, dimension: Dimension, description: &str) -> Channel {
        let (forces, moments): (&[&str], &[&str]) = match dimension {
            Dimension::Planar => (&["fx", "fy"], &["mz"]),
            Dimension::Spatial => (&["fx", "fy", "fz"], &["mx", "my", "mz"]),
        };
        let columns = forces.iter().map(|name| column(name, &self.force));
        let moments = moments.iter().map(|name| column(name, &self.moment));
        Channel {
            path: path.to_owned(),
            columns: columns.chain(moments).collect(),
            description: description.to_owned(),
        }
    }

    /// λ of rows, a force or a moment each.
    pub(super) fn effort(
        &self,
        path: &str,
        system: &System,
        rows: &std::ops::Range<usize>,
    ) -> Channel {
        let one = |row: usize| {
            let measure = &system.terms[system.rows[row].terms.start].measure;
            let unit = if measure.is_length() {
                &self.force
            } else {
                &self.moment
            };
            let name = match rows.len() {
                1 => String::new(),
                _ => (row - rows.start + 1).to_string(),
            };
            column(&name, unit)
        };
        Channel {
            path: path.to_owned(),
            columns: rows.clone().map(one).collect(),
            description: "force or moment conjugate to the coordinate, on its second body".into(),
        }
    }

    /// Energies stored at a state that no motion over time led to.
    pub(super) fn stored_energy(&self, path: &str) -> Channel {
        let names = ["kinetic", "strain", "gravity", "springs"];
        Channel::vector(path, &names, &self.energy, "energy stored")
    }

    pub(super) fn energy(&self, path: &str) -> Channel {
        let names = [
            "kinetic",
            "strain",
            "gravity",
            "springs",
            "drives",
            "loads",
            "dissipated",
            "defect",
        ];
        Channel::vector(
            path,
            &names,
            &self.energy,
            "energy stored, work of drives and loads since the start, heat, and what the balance lacks",
        )
    }
}
