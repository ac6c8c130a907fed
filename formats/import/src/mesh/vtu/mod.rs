//! VTK's unstructured grids (`.vtu`): points and cells, as text, base64 or raw bytes, with or without zlib.
//!
//! The format has no labels and no sets of nodes. A point array of whole numbers that is called `label`, `node_id` or the like is taken for
//! labels, with a note.

mod cells;
mod data_array;
mod document;

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::snapshot::read_small;

use super::FoundMesh;
use super::cells::Cells;
use super::fields;
use super::nodes::LabelIndex;
use cells::cell_of;
use document::Document;

/// Bytes of the longest mesh.
const LONGEST_FILE: u64 = 1 << 36;
/// Text in which the first element stands.
const HEAD: usize = 4096;

/// Whether a text begins as a file of VTK in XML.
pub(crate) fn recognises(start: &[u8]) -> bool {
    let head = &start[..start.len().min(HEAD)];
    let text = head
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(head)
        .trim_ascii_start();
    let tag = b"<VTKFile";
    text.starts_with(b"<") && text.windows(tag.len()).any(|bytes| bytes == tag)
}

/// Reads a grid.
///
/// # Errors
/// [`Error::Location`] for arrays that can't be read or don't fit each other, [`Error::File`] for other kinds of VTK files.
pub(crate) fn read(path: &Path) -> Result<(FoundMesh, String), Error> {
    let (bytes, sha256) = read_small(path, LONGEST_FILE)?;
    let document = Document::of(&bytes).map_err(|message| Error::File {
        path: path.into(),
        message,
    })?;
    let mesh = mesh(&document).map_err(|(place, message)| Error::Location {
        path: path.into(),
        location: place.into(),
        message,
    })?;
    Ok((mesh, sha256))
}

/// A place in the file and what is wrong there.
type Fault = (&'static str, String);

fn mesh(document: &Document) -> Result<FoundMesh, Fault> {
    let at = |place: &'static str| move |message: String| (place, message);
    let missing = |place: &'static str| (place, "isn't there".to_owned());
    let layout = document.layout;
    let points = document.points.ok_or_else(|| missing("Points"))?;
    let count = document.point_count.checked_mul(3);
    let count = count.ok_or_else(|| ("Points", "are more than any file has".to_owned()))?;
    let coordinates = points.reals(count, layout).map_err(at("Points"))?;
    let (points, _) = coordinates.as_chunks::<3>();
    if points.is_empty() {
        return Err(("Points", "has no points".into()));
    }
    let kinds = document.types.ok_or_else(|| missing("types"))?;
    let kinds = kinds
        .integers(document.cell_count, layout)
        .map_err(at("types"))?;
    let ends = document.offsets.ok_or_else(|| missing("offsets"))?;
    let ends = ends
        .integers(document.cell_count, layout)
        .map_err(at("offsets"))?;
    let all = ends.last().copied().unwrap_or(0);
    let all = usize::try_from(all).map_err(|_| ("offsets", format!("ends with {all}")))?;
    let nodes = document
        .connectivity
        .ok_or_else(|| missing("connectivity"))?;
    let nodes = nodes.integers(all, layout).map_err(at("connectivity"))?;
    let mut mesh = FoundMesh {
        cells: grouped(&kinds, &ends, &nodes, points.len())?.finish(),
        ..FoundMesh::default()
    };
    mesh.labels = labels(document, &mut mesh.notes);
    mesh.points = points.to_vec();
    Ok(mesh)
}

/// Cells by their kind.
fn grouped(kinds: &[i64], ends: &[i64], nodes: &[i64], count: usize) -> Result<Cells, Fault> {
    let mut cells = Cells::default();
    let mut start = 0;
    let mut own = Vec::new();
    for (at, (kind, end)) in kinds.iter().zip(ends).enumerate() {
        let end = usize::try_from(*end)
            .ok()
            .filter(|end| (start..=nodes.len()).contains(end));
        let Some(end) = end else {
            return Err(("offsets", format!("don't rise at cell {at}")));
        };
        own.clear();
        for node in &nodes[start..end] {
            match u32::try_from(*node) {
                Ok(node) if (node as usize) < count => own.push(node),
                _ => {
                    return Err((
                        "connectivity",
                        format!("cell {at} names point {node}, but there are {count} (from 0)"),
                    ));
                }
            }
        }
        start = end;
        // A cell without nodes is an empty one.
        if own.is_empty() {
            continue;
        }
        match cell_of(*kind) {
            Some((_, count, _)) if own.len() != count => {
                return Err((
                    "offsets",
                    format!(
                        "cell {at} of VTK type {kind} has {} points, expected {count}",
                        own.len()
                    ),
                ));
            }
            Some((name, count, Some(order))) => {
                let block = cells.block(name, count);
                cells.push(block, 0, order.iter().map(|at| own[*at]));
            }
            Some((name, count, None)) => {
                let block = cells.block(name, count);
                cells.push(block, 0, own.iter().copied());
            }
            None => {
                let block = cells.block(&format!("vtk_type_{kind}"), own.len());
                cells.push(block, 0, own.iter().copied());
            }
        }
    }
    Ok(cells)
}

/// Labels of the nodes, if a point array is called so and can be that.
fn labels(document: &Document, notes: &mut Vec<String>) -> Option<Vec<u32>> {
    let (name, array) = document.labels.as_ref()?;
    let taken = || -> Result<Vec<u32>, String> {
        let numbers = array.integers(document.point_count, document.layout)?;
        let labels: Vec<u32> = numbers
            .into_iter()
            .map(fields::as_label)
            .collect::<Result<_, _>>()?;
        match LabelIndex::of(&labels).repeated().first() {
            None => Ok(labels),
            Some((first, _)) => Err(format!("has {} twice", labels[*first as usize])),
        }
    };
    match taken() {
        Ok(labels) => {
            notes.push(format!(
                "labels of the nodes are those of the point array `{name}`"
            ));
            Some(labels)
        }
        Err(message) => {
            notes.push(format!(
                "the point array `{name}` isn't taken for labels of the nodes: it {message}"
            ));
            None
        }
    }
}
