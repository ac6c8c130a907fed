//! L_b over the component's own dofs, by an orthogonal factorization of the interface's kinematics.

use dcb_formats::Component;
use dcb_formats::component::{Interface, InterfaceKind, Weights};
use dcb_formats::mesh::Direction;
use faer::Mat;
use nalgebra::{DMatrix, Vector3};

use crate::dense::dense;

/// Rows of node, averaged (uniform or given weights) and explicit interfaces.
pub fn localization(component: &Component) -> Mat<f64> {
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for interface in &component.interfaces {
        match interface.kind {
            InterfaceKind::Nodes => rows.extend(node_rows(component, interface)),
            InterfaceKind::Average => rows.extend(average_rows(
                component,
                interface,
                &given_weights(interface),
            )),
            other => panic!("no dense rows for kind {}", other.name()),
        }
    }
    if let Some(matrix) = &component.explicit_boundary {
        let matrix = dense(matrix);
        rows.extend((0..matrix.nrows()).map(|i| {
            (0..matrix.ncols())
                .map(|j| matrix[(i, j)])
                .collect::<Vec<_>>()
        }));
    }
    Mat::from_fn(rows.len(), component.dofs.len(), |i, j| rows[i][j])
}

fn given_weights(interface: &Interface) -> Vec<f64> {
    match &interface.weights {
        Weights::Uniform => vec![1.0; interface.nodes.len()],
        Weights::Given(weights) => weights.clone(),
        other => panic!("weights {other:?} have to be given to average_rows"),
    }
}

fn node_rows(component: &Component, interface: &Interface) -> Vec<Vec<f64>> {
    let mut rows = Vec::new();
    for node in &interface.nodes {
        for direction in Direction::ALL {
            let wanted = interface
                .directions
                .as_ref()
                .is_none_or(|list| list.contains(&direction));
            if let Some(at) = component.dofs.row(*node, direction).filter(|_| wanted) {
                let mut row = vec![0.0; component.dofs.len()];
                row[at] = 1.0;
                rows.push(row);
            }
        }
    }
    rows
}

/// The frame motion that fits the nodes' translations best, weighted: `R⁻¹ Qᵀ √w` with `Q R = √w A`.
pub fn average_rows(
    component: &Component,
    interface: &Interface,
    weights: &[f64],
) -> Vec<Vec<f64>> {
    let planar = component.dimension().coordinate_count() == 2;
    let d = component.dimension().coordinate_count();
    let total: f64 = weights.iter().sum();
    let centroid = Vector3::from_fn(|axis, _| {
        let sum = interface
            .nodes
            .iter()
            .zip(weights)
            .map(|(node, w)| w * component.mesh.position(*node)[axis]);
        sum.sum::<f64>() / total
    });
    let reference = interface.position.map_or(centroid, Vector3::from);
    let axes: Vec<usize> = if planar { vec![2] } else { vec![0, 1, 2] };
    let (mut lines, mut roots, mut dofs): (Vec<Vec<f64>>, Vec<f64>, Vec<usize>) =
        Default::default();
    for (node, weight) in interface.nodes.iter().zip(weights) {
        let arm = Vector3::from(component.mesh.position(*node)) - reference;
        for direction in &Direction::ALL[..d] {
            let mut line = vec![0.0; d + axes.len()];
            line[direction.axis()] = 1.0;
            for (column, axis) in axes.iter().enumerate() {
                line[d + column] = Vector3::ith(*axis, 1.0).cross(&arm)[direction.axis()];
            }
            lines.push(line);
            roots.push(weight.sqrt());
            dofs.push(
                component
                    .dofs
                    .row(*node, *direction)
                    .expect("a translation"),
            );
        }
    }
    let scaled = DMatrix::from_fn(lines.len(), d + axes.len(), |i, j| roots[i] * lines[i][j]);
    let (q, r) = scaled.qr().unpack();
    let inverse = r
        .solve_upper_triangular(&q.transpose())
        .expect("nodes that determine the frame");
    let frame: Vec<Direction> = component.dimension().frame_directions().to_vec();
    let mut rows = Vec::new();
    for (i, direction) in frame.iter().enumerate() {
        if interface
            .directions
            .as_ref()
            .is_none_or(|list| list.contains(direction))
        {
            let mut row = vec![0.0; component.dofs.len()];
            for (k, dof) in dofs.iter().enumerate() {
                row[*dof] = inverse[(i, k)] * roots[k];
            }
            rows.push(row);
        }
    }
    rows
}
