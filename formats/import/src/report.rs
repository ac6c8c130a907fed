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
}

impl MassCentre {
    /// With unit translations t_a and the positions p of the rows, m = t_aᵀ M t_a, c_b = t_aᵀ M (p_b t_a) / m, means over the axes a.
    pub(crate) fn of(mass: &SparseMatrix, places: &[RowPlace]) -> Self {
        let (mut total, mut moment) = ([0.0; 3], [0.0; 3]);
        for (row, place) in places.iter().enumerate() {
            let Some((point, direction)) = place.filter(|(_, direction)| !direction.is_rotation())
            else {
                continue;
            };
            let entries = mass.row_idx_of_col_raw(row).iter();
            for (column, value) in entries.zip(mass.val_of_col(row)) {
                let same = places[*column as usize].filter(|(_, other)| *other == direction);
                if same.is_some() {
                    total[direction.axis()] += value;
                    for axis in 0..3 {
                        moment[axis] += value * point[axis];
                    }
                }
            }
        }
        let axes = total.iter().filter(|sum| **sum != 0.0).count().max(1);
        let sum: f64 = total.iter().sum();
        Self {
            mass: sum / axes as f64,
            centre: moment.map(|moment| if sum == 0.0 { 0.0 } else { moment / sum }),
        }
    }
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
        let MassCentre { mass, centre } = self.mass_centre;
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
