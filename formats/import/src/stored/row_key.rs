//! Labels of rows in one word, which compare and hash quickly.

use std::fmt;

use dcb_formats::mesh::Direction;

use crate::stored::RowLabel;

/// A [`RowLabel`] in one word, in the same order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RowKey(u64);

/// Set in those of internal rows; the 31 bits behind it are the label, the 32 lowest the direction or number.
const INTERNAL: u64 = 1 << 63;

impl RowKey {
    /// A direction of a node.
    #[inline(always)]
    pub fn nodal(node: u32, direction: Direction) -> Self {
        Self(u64::from(node) << 32 | direction.index() as u64)
    }

    /// A row of an internal node.
    #[inline(always)]
    pub fn internal(point: u32, number: u32) -> Self {
        Self(INTERNAL | u64::from(point) << 32 | u64::from(number))
    }

    /// The label that it stands for.
    pub fn label(self) -> RowLabel {
        let label = ((self.0 & !INTERNAL) >> 32) as u32;
        let number = self.0 as u32;
        match Direction::from_index(number as usize) {
            Some(direction) if self.0 & INTERNAL == 0 => RowLabel::Nodal {
                node: label,
                direction,
            },
            _ => RowLabel::Internal {
                point: label,
                number,
            },
        }
    }
}

/// As messages name rows: `node 17 uy`.
impl fmt::Display for RowKey {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.label() {
            RowLabel::Nodal { node, direction } => {
                write!(formatter, "node {node} {}", direction.name())
            }
            RowLabel::Internal { point, number } => {
                write!(formatter, "internal node {point} number {number}")
            }
        }
    }
}

/// The direction with a number of Abaqus and CalculiX, 1 to 6.
#[inline(always)]
pub fn direction(number: u64) -> Option<Direction> {
    Direction::from_index((number as usize).wrapping_sub(1))
}

/// Why a degree of freedom that isn't a direction can't be used.
#[cold]
pub fn no_direction(node: u32, number: u64) -> String {
    let what = match number {
        7 => " (warping)",
        8 => " (pressure)",
        9 => " (electric potential)",
        11..=30 => " (temperature)",
        _ => "",
    };
    format!(
        "degree of freedom {number}{what} of node {node}; only displacements (1 to 3) and rotations (4 to 6) are supported"
    )
}
