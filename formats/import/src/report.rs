//! What an import has recognised and done, for people.

use std::fmt::Write as _;

use dcb_formats::SparseMatrix;
use dcb_formats::component::Units;

use crate::rigid_motions::RowPlace;

/// An import in numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportReport {
    /// Formats of stiffness, mass and mesh.
    pub formats: [String; 3],
    /// Rows of the matrices.
    pub rows: usize,
    /// Those that belong to no node.
    pub internal_rows: usize,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Fewest significant digits of any number, where they are printed.
    pub digits: Option<u32>,
    /// How rows were tied to nodes.
    pub order: String,
    /// max |K r| over max |K| for rigid motions r, without unit.
    pub resistance: f64,
    /// Mass and centre.
    pub mass_centre: MassCentre,
    /// Units of the numbers.
    pub units: Units,
    /// Node sets and how many nodes they have.
    pub sets: Vec<(String, usize)>,
    /// Remarks.
    pub notes: Vec<String>,
}

/// Mass and centre of mass, from the mass matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassCentre {
    /// Mean over the translations.
    pub mass: f64,
    /// In the axes of the mesh.
    pub centre: [f64; 3],
    /// How far rigid motions contradict each other: masses along the axes, and what translations and rotations say of the centre, over the mass
    /// and the part's size.
    pub contradiction: f64,
}

impl MassCentre {
    /// With unit translations t_a and turns r_c about the axes through the origin, m = t_aᵀ M t_a (the mean over a) and t_aᵀ M r_c = m (e_c × centre)_a.
    /// Rows of rotations and of no node count: what turns with a node may be far from it.
    pub(crate) fn of(mass: &SparseMatrix, places: &[RowPlace]) -> Self {
        let moved = |place: &RowPlace, axis: usize| match place {
            Some((_, direction)) => !direction.is_rotation() && direction.axis() == axis,
            None => false,
        };
        let turned = |place: &RowPlace, axis: usize| match place {
            Some((_, direction)) if direction.is_rotation() => {
                f64::from(u8::from(direction.axis() == axis))
            }
            Some((point, direction)) => turn(axis, point)[direction.axis()],
            None => 0.0,
        };
        let has = [0, 1, 2].map(|axis| places.iter().any(|place| moved(place, axis)));
        let (mut moments, mut cross) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for (column, place) in places.iter().enumerate() {
            let rows = mass.row_idx_of_col_raw(column).iter();
            for (row, value) in rows.zip(mass.val_of_col(column)) {
                let Some((_, direction)) = places[*row as usize] else {
                    continue;
                };
                if direction.is_rotation() {
                    continue;
                }
                let along = direction.axis();
                let sums = moments[along].iter_mut().zip(&mut cross[along]);
                for (axis, (moment, cross)) in sums.enumerate() {
                    *moment += value * turned(place, axis);
                    if moved(place, axis) {
                        *cross += value;
                    }
                }
            }
        }
        let total = [0, 1, 2].map(|axis| cross[axis][axis]);
        let axes = has.iter().filter(|has| **has).count().max(1);
        let mass = total.iter().sum::<f64>() / axes as f64;
        let mut centre = [0.0; 3];
        let mut contradiction = 0.0_f64;
        let size = size_of(places);
        for (of, coordinate) in centre.iter_mut().enumerate() {
            // The turn about `axis` moves what is at the end of `of` along `along`; the axes across it must be there.
            let pairs = [((of + 1) % 3, (of + 2) % 3), ((of + 2) % 3, (of + 1) % 3)];
            let pairs = pairs.map(|(along, axis)| {
                let sign = turn(axis, &unit(of))[along];
                (has[of] && has[along]).then_some(sign * moments[along][axis] / mass)
            });
            let known: Vec<f64> = pairs.into_iter().flatten().collect();
            if !known.is_empty() && mass != 0.0 {
                *coordinate = known.iter().sum::<f64>() / known.len() as f64;
            }
            if let ([Some(first), Some(second)], true) = (pairs, size > 0.0) {
                contradiction = contradiction.max((first - second).abs() / size);
            }
            for (other, found) in cross[of].iter().enumerate() {
                let expected = if other == of { mass } else { 0.0 };
                if has[of] && has[other] {
                    contradiction = contradiction.max(((found - expected) / mass).abs());
                }
            }
        }
        Self {
            mass,
            centre,
            contradiction,
        }
    }
}

/// The largest side of the box of the nodes.
fn size_of(places: &[RowPlace]) -> f64 {
    let points = || places.iter().flatten().map(|(point, _)| point);
    let side = |axis: usize| {
        let (low, high) = points()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| {
                (low.min(point[axis]), high.max(point[axis]))
            });
        high - low
    };
    (0..3).map(side).fold(0.0, f64::max)
}

fn unit(axis: usize) -> [f64; 3] {
    let mut unit = [0.0; 3];
    unit[axis] = 1.0;
    unit
}

/// Where a turn of one about an axis moves a point: e × p.
fn turn(axis: usize, point: &[f64; 3]) -> [f64; 3] {
    let mut moved = [0.0; 3];
    moved[(axis + 1) % 3] = -point[(axis + 2) % 3];
    moved[(axis + 2) % 3] = point[(axis + 1) % 3];
    moved
}

impl ImportReport {
    /// For the terminal.
    pub fn text(&self) -> String {
        let [stiffness, mass, mesh] = &self.formats;
        let matrices = match stiffness == mass {
            true => stiffness.to_owned(),
            false => format!("{stiffness}, {mass}"),
        };
        let internal = match self.internal_rows {
            0 => String::new(),
            count => format!(", {count} of them internal"),
        };
        let digits = match self.digits {
            Some(digits) => format!("{digits} significant"),
            None => "all".to_owned(),
        };
        let Units {
            length, mass: unit, ..
        } = &self.units;
        let MassCentre { mass, centre, .. } = self.mass_centre;
        let sets: Vec<String> = self
            .sets
            .iter()
            .map(|(name, count)| format!("{name} ({count} nodes)"))
            .collect();
        let mut text = String::new();
        for (label, value) in [
            ("matrices", matrices),
            ("mesh", format!("{mesh}, {} nodes", self.nodes)),
            ("rows", format!("{}{internal}", self.rows)),
            ("order", self.order.clone()),
            ("digits", digits),
            (
                "K R",
                format!(
                    "{:.1e} (rigid motions must meet no resistance)",
                    self.resistance
                ),
            ),
            ("mass", format!("{mass:.9e} {unit}")),
            (
                "centre",
                format!(
                    "{:.9e} {:.9e} {:.9e} {length}",
                    centre[0], centre[1], centre[2]
                ),
            ),
            (
                "sets",
                if sets.is_empty() {
                    "none".into()
                } else {
                    sets.join(", ")
                },
            ),
        ] {
            let _ = writeln!(text, "{label:<10}{value}");
        }
        text
    }
}
