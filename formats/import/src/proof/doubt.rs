//! Why a stiffness resists rigid motions of the mesh: what an analyst would look at first.

use crate::part::{Part, first_ten};
use crate::request::NodeOrder;
use crate::rigid_motions::{Resistance, resistance};
use crate::rows::order::{nodes_in_order, row_places};
use dcb_formats::mesh::{Dof, MatrixRow};

/// Up to here K R isn't worth a word; the exports of most programs stay below 1e-12.
pub(crate) const QUIET: f64 = 1e-9;
/// Beyond this, rows and mesh don't belong together, or the digits are too few.
pub(crate) const TOLERATED: f64 = 1e-7;
/// Digits below which K R may come from printing alone.
const FEW_DIGITS: u32 = 10;

/// A part whose stiffness resists rigid motions.
pub(crate) struct Doubt<'a> {
    pub part: &'a Part,
    pub resistance: Resistance,
}

impl Doubt<'_> {
    /// The first thing that explains it.
    pub fn message(&self) -> String {
        let residual = match self.resistance.worst() {
            small @ ..0.01 => format!("{small:.1e}"),
            large => format!("{large:.2}"),
        };
        let mut sources = self.part.sources.iter();
        let mesh = sources.find(|source| source.role == "mesh");
        let mesh = mesh.map_or(String::new(), |mesh| format!(" {}", mesh.file_name));
        let found = format!(
            "rigid motions of the mesh{mesh} are resisted, K R = {residual} (expected below {TOLERATED:e})"
        );
        let reason = self
            .few_digits()
            .or_else(|| self.exchanged())
            .or_else(|| self.other_order())
            .or_else(|| self.direction_after_direction())
            .or_else(|| self.unknown_labels())
            .or_else(|| self.nodes_without_rows())
            .unwrap_or_else(|| self.in_general());
        format!("{found}: {reason}")
    }

    fn few_digits(&self) -> Option<String> {
        let digits = self.part.digits.filter(|digits| *digits < FEW_DIGITS)?;
        let of_digits = 100.0 * 10_f64.powi(-(digits as i32));
        (self.resistance.worst() <= of_digits).then(|| {
            format!(
                "the numbers have {digits} significant digits, which explains up to {of_digits:.0e}; export more digits, or a binary file"
            )
        })
    }

    /// The mass resists no rigid motion.
    fn exchanged(&self) -> Option<String> {
        let part = self.part;
        let other = resistance(&part.mass, &row_places(&part.mesh, &part.rows)).worst();
        (other <= TOLERATED).then(|| {
            format!(
                "the second matrix meets no resistance, K R = {other:.1e}: it is the stiffness, which comes first; exchange the two"
            )
        })
    }

    /// All rows of one direction, then those of the next.
    fn direction_after_direction(&self) -> Option<String> {
        let other = self.part.by_direction()?.1.worst();
        (other <= TOLERATED).then(|| {
            format!(
                "the rows go direction after direction (all ux, then all uy, ...), with K R = {other:.1e}; add --repair-order, or give the node and direction of each row with --dofs FILE"
            )
        })
    }

    /// The nodes in the other order.
    fn other_order(&self) -> Option<String> {
        let (part, labels) = (self.part, self.part.mesh.labels.as_ref()?);
        if !part.is_positional || labels.is_sorted() {
            return None;
        }
        let (by_file, by_label) = (
            nodes_in_order(&part.mesh, NodeOrder::File),
            nodes_in_order(&part.mesh, NodeOrder::Label),
        );
        let is_by_file = part.rows.first() == self.first_row_of(by_file[0]).as_ref();
        let (from, to, option) = match is_by_file {
            true => (by_file, by_label, "label"),
            false => (by_label, by_file, "file"),
        };
        let mut new = vec![0; from.len()];
        for (from, to) in from.iter().zip(&to) {
            new[*from as usize] = *to;
        }
        let rows: Vec<MatrixRow> = part
            .rows
            .iter()
            .map(|owner| match owner {
                MatrixRow::Nodal(Dof { node, direction }) => MatrixRow::Nodal(Dof {
                    node: new[*node as usize],
                    direction: *direction,
                }),
                MatrixRow::Internal => MatrixRow::Internal,
            })
            .collect();
        let other = resistance(&part.stiffness, &row_places(&part.mesh, &rows)).worst();
        (other <= TOLERATED).then(|| {
            format!(
                "the rows follow the nodes in the other order, with K R = {other:.1e}; add --node-order {option}"
            )
        })
    }

    fn first_row_of(&self, node: u32) -> Option<MatrixRow> {
        let direction = self.part.rows.first()?.dof()?.direction;
        Some(MatrixRow::Nodal(Dof { node, direction }))
    }

    fn unknown_labels(&self) -> Option<String> {
        let (labels, _) = &self.part.unknown;
        (!labels.is_empty()).then(|| {
            format!(
                "rows have labels that the mesh doesn't have: {}; was it another mesh? Abaqus numbers the nodes of parts and assemblies anew (switch on the model's \
                 attribute \"do not use parts and assemblies in input files\"); CalculiX expands shells and beams to solids with new nodes (use solid elements)",
                first_ten(labels)
            )
        })
    }

    fn nodes_without_rows(&self) -> Option<String> {
        let part = self.part;
        let has_rows = part.has_rows();
        let in_cells = part.mesh.cells.iter().flat_map(|block| &block.nodes);
        let mut without: Vec<u32> = in_cells
            .copied()
            .filter(|node| !has_rows[*node as usize])
            .collect();
        without.sort_unstable();
        without.dedup();
        (!without.is_empty()).then(|| {
            format!(
                "{} nodes of the mesh have no rows (labels {}): they were held, or depend on others; a superelement is a free part, so export the matrices \
                 without supports",
                without.len(),
                part.first_labels(&without)
            )
        })
    }

    fn in_general(&self) -> String {
        let row = self.resistance.worst_row;
        let place = match self.part.rows.get(row) {
            Some(MatrixRow::Nodal(Dof { node, direction })) => {
                format!(
                    "row {} (node {} {})",
                    row + 1,
                    self.part.label(*node),
                    direction.name()
                )
            }
            _ => format!("row {}", row + 1),
        };
        format!(
            "most in {place}. Either the part is held (export it without supports), or its rows don't follow this mesh (rows: {}): give the table that the program \
             wrote with the matrices, --dofs FILE, or let the order be found from the stiffness, --repair-order",
            self.part.order
        )
    }
}
