//! How much a page has room for, so that it stays below 5 MB.

/// Bytes of all arrays of a page before they are compressed. As text they take a third more, and the script 0.7 MB.
pub const BYTES: usize = 2_900_000;
/// Bytes that shapes may have, however much the rest of a page takes.
pub const LEAST_BYTES_OF_SHAPES: usize = 600_000;
/// Bytes of a node of a surface: its place, its number, and the corners of about two triangles.
pub const NODE_BYTES: usize = 40;
/// Bytes of a node's displacement in one pattern.
pub const DISPLACEMENT_BYTES: usize = 6;

/// Bytes of a mesh with so many nodes and patterns.
pub fn of_mesh(nodes: usize, patterns: usize) -> usize {
    nodes * (NODE_BYTES + DISPLACEMENT_BYTES * patterns)
}

/// How many patterns of a mesh with so many nodes have room.
pub fn patterns(nodes: usize) -> usize {
    BYTES.saturating_sub(NODE_BYTES * nodes) / (DISPLACEMENT_BYTES * nodes).max(1)
}
