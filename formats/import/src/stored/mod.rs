//! Matrices as files store them: before duplicates are summed, triangles completed and rows tied to the nodes of a mesh.

pub mod row_key;

use dcb_formats::SparseMatrix;
use dcb_formats::matrix::blocks::Entries;
use dcb_formats::mesh::Direction;

/// A matrix of a file, before it is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Name in the file, `/` between groups or structures; empty where the format has none.
    pub name: String,
    /// Rows and columns; `None` where only reading the whole of it would tell.
    pub shape: Option<(u64, u64)>,
    /// Why it can't be a stiffness or mass matrix: `complex`, `rectangular`; `None` where nothing shows.
    pub obstacle: Option<String>,
}

/// Matrices read from one file.
#[derive(Debug)]
pub struct Reading {
    /// As many as were asked for, in that order.
    pub matrices: Vec<StoredMatrix>,
    /// SHA-256 of the file's bytes, hexadecimal.
    pub sha256: String,
}

impl Reading {
    /// Of a file with one matrix, which may not be asked for.
    pub(crate) fn of_one(wanted: &[usize], matrix: StoredMatrix, sha256: String) -> Self {
        let matrices = match wanted {
            [] => Vec::new(),
            _ => vec![matrix],
        };
        Self { matrices, sha256 }
    }
}

/// A square matrix as a file stores it.
#[derive(Debug)]
pub struct StoredMatrix {
    /// Name in the file; empty where the format has none.
    pub name: String,
    /// Rows, as many as columns.
    pub size: usize,
    /// Which triangles are stored, as far as the format says.
    pub triangles: Triangles,
    /// Entries.
    pub content: Content,
    /// Labels of the rows, where the file has them.
    pub rows: Rows,
    /// Fewest significant digits that any value is printed with, and could have been more; `None` for binary files.
    pub digits: Option<u32>,
    /// Remarks for the user, a sentence each.
    pub notes: Vec<String>,
}

impl StoredMatrix {
    /// Nothing is said beside name, size and entries: no labels, triangles or digits.
    pub(crate) fn unlabelled(name: String, size: usize, content: Content) -> Self {
        Self {
            name,
            size,
            triangles: Triangles::Unsaid,
            content,
            rows: Rows::Unlabelled,
            digits: None,
            notes: Vec::new(),
        }
    }
}

/// Triangles of a symmetric matrix that are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Triangles {
    /// Both.
    Both,
    /// One place of each pair. Where both are stored, they must agree and count once.
    One,
    /// The format doesn't say; told by the entries.
    Unsaid,
}

/// Entries of a matrix.
#[derive(Debug)]
pub enum Content {
    /// 0-based places, in file order, block after block; repeated places add up.
    Entries(Vec<Entries>),
    /// Compressed, sorted, every place once; rows and columns may have changed places.
    Compressed(SparseMatrix),
}

/// Labels of rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rows {
    /// None: rows follow a mesh or a table.
    Unlabelled,
    /// One for each row, all different.
    Labelled(Vec<RowLabel>),
}

/// Label of a row. Nodes come before internal rows, and both by rising label.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RowLabel {
    /// A direction of a node.
    Nodal {
        /// Label of the node, up to 2³¹ - 1.
        node: u32,
        /// Direction.
        direction: Direction,
    },
    /// A row that belongs to no node: an internal node of an element, a scalar point.
    Internal {
        /// Label of the internal node or scalar point.
        point: u32,
        /// 1-based number of the row among those of the point; 0 for a scalar point.
        number: u32,
    },
}

/// Largest label of a node.
pub const LARGEST_LABEL: u32 = i32::MAX as u32;
