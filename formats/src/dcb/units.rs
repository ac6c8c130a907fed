//! Units of datasets, derived from the component's: monomials in mass, length and time.
//!
//! A generalised coordinate of the reduced basis has a unit of its own: a mode's is √mass·length, an attachment
//! column's is the force or moment of its row, a further column's is 1. Every entry's unit follows from those of
//! its row and its column.

use crate::component::{StressQuantity, Units};
use crate::superelement::BoundaryRow;

/// mass^(m/2) · length^(l/2) · time^(t/2): half exponents, because mass-normalized shapes have 1/√mass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unit {
    mass: i32,
    length: i32,
    time: i32,
}

pub(super) const ONE: Unit = Unit {
    mass: 0,
    length: 0,
    time: 0,
};
pub(super) const LENGTH: Unit = Unit {
    mass: 0,
    length: 2,
    time: 0,
};
pub(super) const MASS: Unit = Unit {
    mass: 2,
    length: 0,
    time: 0,
};
pub(super) const TIME: Unit = Unit {
    mass: 0,
    length: 0,
    time: 2,
};
pub(super) const FIRST_MOMENT: Unit = MASS.times(LENGTH);
pub(super) const INERTIA: Unit = FIRST_MOMENT.times(LENGTH);
pub(super) const MODAL: Unit = Unit {
    mass: 1,
    length: 2,
    time: 0,
};
pub(super) const FORCE: Unit = Unit {
    mass: 2,
    length: 2,
    time: -4,
};
const STRESS: Unit = FORCE.over(LENGTH).over(LENGTH);
pub(super) const MOMENT: Unit = FORCE.times(LENGTH);
/// Displacements `ux uy uz rx ry rz`.
const FIELD_DIRECTIONS: [Unit; 6] = [LENGTH, LENGTH, LENGTH, ONE, ONE, ONE];

impl Unit {
    /// Product of two units.
    pub(super) const fn times(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            length: self.length + other.length,
            time: self.time + other.time,
        }
    }

    /// Quotient of two units.
    pub(super) const fn over(self, other: Self) -> Self {
        Self {
            mass: self.mass - other.mass,
            length: self.length - other.length,
            time: self.time - other.time,
        }
    }

    /// As text in the component's units: `kg*m/s^2`, `1/(sqrt(kg)*m)`, `1`.
    pub(super) fn text(self, units: &Units) -> String {
        let bases = [
            (&units.mass, self.mass),
            (&units.length, self.length),
            (&units.time, self.time),
        ];
        let factors = |sign: i32| -> Vec<String> {
            bases
                .iter()
                .filter(|(_, exponent)| exponent * sign > 0)
                .map(|(name, exponent)| power(name, exponent * sign))
                .collect()
        };
        let above = factors(1);
        let below = factors(-1);
        let numerator = if above.is_empty() {
            "1".to_owned()
        } else {
            above.join("*")
        };
        match below.as_slice() {
            [] => numerator,
            [single] => format!("{numerator}/{single}"),
            several => format!("{numerator}/({})", several.join("*")),
        }
    }
}

/// `name` to the power `halves`/2, `halves` > 0.
fn power(name: &str, halves: i32) -> String {
    let plain = !name.is_empty() && name.chars().all(char::is_alphabetic);
    let base = if plain {
        name.to_owned()
    } else {
        format!("({name})")
    };
    match (halves / 2, halves % 2) {
        (1, 0) => base,
        (whole, 0) => format!("{base}^{whole}"),
        (0, _) if plain => format!("sqrt({base})"),
        (0, _) => format!("sqrt{base}"),
        _ => format!("{base}^({halves}/2)"),
    }
}

/// How the unit changes along one axis of a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Factor {
    /// Not at all.
    Uniform(Unit),
    /// One row of L_b each: its displacement, length or radian.
    Displacement,
    /// One row of L_b each: its force or moment.
    Force,
    /// One row of L_b each: 1/(force or moment).
    PerForce,
    /// One row of L_b each: √mass·length/(force or moment); a pair of them makes a generalised mass.
    MassPerForce,
    /// One row of L_b each: mass·length²/(force or moment)².
    MassPerForceSquared,
    /// One basis column each: the unit given over the coordinate's.
    PerCoordinate(Unit),
    /// One basis column each: √mass·length/coordinate; a pair makes a generalised mass.
    MassPerCoordinate,
    /// One basis column each: √mass·length/(time·coordinate); a pair makes a generalised stiffness.
    StiffnessPerCoordinate,
    /// One attachment or further column each: the unit given over the coordinate's.
    PerResidual(Unit),
    /// One row of a stress field each: stress or strain, times the unit given.
    StressRow(Unit),
    /// One field dof each, displacement: told by dof index through `/fields/dofs`.
    Field,
}

pub(super) const PER_MODAL: Factor = Factor::Uniform(ONE.over(MODAL));
pub(super) const SAME: Factor = Factor::Uniform(ONE);

/// How the unit of a dataset follows from what its axes stand for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rule {
    /// Fixed text.
    Text(&'static str),
    /// `rad^2/time^2`.
    AngularFrequencySquared,
    /// A product of one factor per axis: one axis is rows; two are rows, columns; three are layers, rows, columns.
    /// Axes without a factor (tensor components) are uniform.
    Product(&'static [Factor]),
}

/// Facts of a file that its units depend on.
#[derive(Clone, Debug)]
pub(super) struct UnitSystem<'a> {
    pub(super) units: &'a Units,
    pub(super) rows: &'a [BoundaryRow],
    pub(super) mode_count: usize,
    pub(super) enrichment_count: usize,
    pub(super) stress_rows: &'a [StressQuantity],
    pub(super) fields_have_rotations: bool,
}

/// The unit attributes of one dataset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct UnitAttributes {
    /// `units`: one for all entries, or `mixed`.
    pub(super) units: String,
    /// `layer_units`, `row_units`, `column_units`, `direction_units` as needed.
    pub(super) axes: Vec<(&'static str, Vec<String>)>,
}

impl UnitSystem<'_> {
    /// The unit attributes that a rule gives a dataset of this shape.
    pub(super) fn attributes(&self, rule: Rule, shape: &[usize]) -> UnitAttributes {
        let uniform = |units: String| UnitAttributes {
            units,
            axes: Vec::new(),
        };
        match rule {
            Rule::Text(text) => uniform(text.to_owned()),
            Rule::AngularFrequencySquared => {
                let per_time_squared = ONE.over(TIME).over(TIME).text(self.units);
                uniform(format!("rad^2{}", per_time_squared.trim_start_matches('1')))
            }
            Rule::Product(factors) => self.product(factors, shape),
        }
    }

    fn product(&self, factors: &[Factor], shape: &[usize]) -> UnitAttributes {
        let axes: Vec<Vec<Unit>> = factors.iter().map(|&factor| self.along(factor)).collect();
        let is_uniform = |axis: &[Unit]| axis.windows(2).all(|pair| pair[0] == pair[1]);
        if axes.iter().all(|axis| is_uniform(axis)) {
            let unit = axes
                .iter()
                .filter_map(|axis| axis.first())
                .fold(ONE, |product, &unit| product.times(unit));
            return UnitAttributes {
                units: unit.text(self.units),
                axes: Vec::new(),
            };
        }
        let names: &[&'static str] = match factors.len() {
            3 => &["layer_units", "row_units", "column_units"],
            _ => &["row_units", "column_units"],
        };
        let mut named = Vec::new();
        for (((&name, axis), &factor), &length) in names.iter().zip(axes).zip(factors).zip(shape) {
            let text = |unit: &Unit| unit.text(self.units);
            match factor {
                Factor::Uniform(_) if name == "layer_units" => {}
                Factor::Uniform(unit) => named.push((name, vec![text(&unit); length])),
                Factor::Field => named.push((
                    "direction_units",
                    FIELD_DIRECTIONS.iter().map(text).collect(),
                )),
                _ => named.push((name, axis.iter().map(text).collect())),
            }
        }
        UnitAttributes {
            units: "mixed".to_owned(),
            axes: named,
        }
    }

    /// The units along an axis; one, whatever its length, where the axis is uniform.
    fn along(&self, factor: Factor) -> Vec<Unit> {
        let rows = |unit: fn(&BoundaryRow) -> Unit| self.rows.iter().map(unit).collect();
        let columns = |top: Unit| {
            self.coordinates()
                .into_iter()
                .map(|coordinate| top.over(coordinate))
                .collect()
        };
        match factor {
            Factor::Uniform(unit) => vec![unit],
            Factor::Displacement => rows(displacement),
            Factor::Force => rows(force),
            Factor::PerForce => rows(|row| ONE.over(force(row))),
            Factor::MassPerForce => rows(|row| MODAL.over(force(row))),
            Factor::MassPerForceSquared => rows(|row| INERTIA.over(force(row)).over(force(row))),
            Factor::PerCoordinate(top) => columns(top),
            Factor::PerResidual(top) => columns(top).split_off(self.mode_count),
            Factor::MassPerCoordinate => columns(MODAL),
            Factor::StiffnessPerCoordinate => columns(MODAL.over(TIME)),
            Factor::StressRow(unit) => (self.stress_rows.iter())
                .map(|quantity| match quantity {
                    StressQuantity::Stress => STRESS.times(unit),
                    StressQuantity::Strain => unit,
                })
                .collect(),
            Factor::Field if self.fields_have_rotations => FIELD_DIRECTIONS.to_vec(),
            Factor::Field => vec![LENGTH],
        }
    }

    /// Units of the generalised coordinates, in column order.
    fn coordinates(&self) -> Vec<Unit> {
        let modes = std::iter::repeat_n(MODAL, self.mode_count);
        let further = std::iter::repeat_n(ONE, self.enrichment_count);
        modes
            .chain(self.rows.iter().map(force))
            .chain(further)
            .collect()
    }
}

/// Rows of an explicit boundary count as translations.
fn is_rotation(row: &BoundaryRow) -> bool {
    row.direction >= 3
}

fn displacement(row: &BoundaryRow) -> Unit {
    if is_rotation(row) { ONE } else { LENGTH }
}

fn force(row: &BoundaryRow) -> Unit {
    if is_rotation(row) { MOMENT } else { FORCE }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_read_as_an_engineer_writes_them() {
        let si = Units {
            length: "m".into(),
            mass: "kg".into(),
            time: "s".into(),
        };
        let odd = Units {
            length: "m".into(),
            mass: "10^3 kg".into(),
            time: "s".into(),
        };
        assert_eq!(FORCE.text(&si), "kg*m/s^2");
        assert_eq!(ONE.over(MODAL).text(&si), "1/(sqrt(kg)*m)");
        assert_eq!(LENGTH.over(FORCE).text(&si), "s^2/kg");
        assert_eq!(ONE.text(&si), "1");
        assert_eq!(MODAL.times(MASS).text(&si), "kg^(3/2)*m");
        assert_eq!(MODAL.text(&odd), "sqrt(10^3 kg)*m");
    }
}
