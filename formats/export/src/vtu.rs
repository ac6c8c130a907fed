//! VTK's unstructured grid: the whole mesh, one field of displacements a free mode and one an attachment.
//!
//! Numbers are those of the superelement, in its units: modes are normalized by mass, attachments are displacements by a unit force or moment.

use dcb_formats::vtk::{Cells, Grid};
use dcb_formats::{Error, Superelement};
use faer::Mat;
use nalgebra::Vector3;

use crate::files::product::{Content, Product};
use crate::mesh::mode_names;
use crate::mesh::node_shapes::NodeShapes;
use crate::part::Source;
use crate::{Axes, Request};

/// Fields at the nodes of the mesh.
pub(crate) fn product(source: &Source, request: &Request<'_>) -> Result<Product, Error> {
    let Some((fields, mesh)) = source.fields()? else {
        return Err(source.refused("has no nodal fields, or no mesh, and a grid shows both; reduce it without --without-fields".to_owned()));
    };
    let element = source.superelement();
    let cells = Cells::of(&mesh).map_err(|message| source.refused(message))?;
    let (n, n_k) = (element.basis_count(), element.mode_count());
    let count = n_k + fields.residual.ncols();
    let columns = Mat::from_fn(n, count, |i, j| f64::from(u8::from(i == j)));
    let shapes = NodeShapes::of(&fields, &mesh, &columns);
    let nodes = 0..mesh.node_count() as u32;
    let offset = match request.axes {
        Axes::Body => Vector3::from(element.origin),
        Axes::Component => Vector3::zeros(),
    };
    let points: Vec<_> = nodes
        .clone()
        .map(|node| Vector3::from(mesh.position(node)) - offset)
        .collect();
    let fields: Vec<Vec<Vector3<f64>>> = (0..count)
        .map(|column| {
            let of = |node: u32| match shapes.nodes.binary_search(&node) {
                Ok(place) => Vector3::from_fn(|a, _| shapes.shapes[(3 * place + a, column)]),
                Err(_) => Vector3::zeros(),
            };
            nodes.clone().map(of).collect()
        })
        .collect();
    let mut names = mode_names(element);
    names.extend((1..=count - n_k).map(|number| format!("attachment {number}")));
    let vectors = names.iter().zip(&fields);
    let vectors: Vec<_> = vectors
        .map(|(name, values)| (name.as_str(), values.as_slice()))
        .collect();
    let grid = Grid {
        cells: &cells,
        points: &points,
        vectors: &vectors,
        numbers: &[],
        marks: &[],
    };
    let mut bytes = Vec::new();
    let written = grid.write(&mut bytes);
    written.map_err(|error| source.refused(format!("can't be written as a grid: {error}")))?;
    let summary = format!(
        "{} nodes, {} cells, {n_k} modes and {} attachments as fields of displacements",
        points.len(),
        mesh.cells
            .iter()
            .map(|block| block.cells().count())
            .sum::<usize>(),
        count - n_k
    );
    let mut product = Product::new(Content::Bytes(bytes), summary);
    product.notes = notes(element, &shapes, points.len());
    product
        .left_out
        .push("everything but shapes and frequencies; rotations of nodes too".to_owned());
    Ok(product)
}

fn notes(element: &Superelement, shapes: &NodeShapes, nodes: usize) -> Vec<String> {
    let units = &element.units;
    let mut notes = vec![format!(
        "places in {}; modes are normalized by mass; in ParaView `Warp By Vector` with one field moves the mesh",
        units.length
    )];
    let still = nodes - shapes.nodes.len();
    if still > 0 {
        notes.push(format!(
            "{still} of {nodes} nodes have no displacements in the file and stay at rest"
        ));
    }
    notes
}
