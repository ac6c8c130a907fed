//! Nodal fields and the mesh of the whole, from those that the parts' files have.

use std::collections::BTreeMap;

use dcb_formats::mesh::{CellBlock, Dimension, Direction, Dof, Mesh};
use dcb_formats::superelement::RecoveryBasis;
use faer::{Mat, MatRef};
use nalgebra::{Matrix3, Vector3};

use crate::inertia::PartColumns;
use crate::part::Part;
use crate::spot::ALONG;

/// What a part's file has of its inside.
#[derive(Clone, Debug, Default)]
pub struct Inside {
    /// Nodal shapes.
    pub recovery: Option<RecoveryBasis>,
    /// Geometry.
    pub mesh: Option<Mesh>,
}

/// The meshes in their places, one after the other; `None` where no part has one.
pub(crate) fn joined_mesh(
    parts: &[Part],
    insides: &[Inside],
    dimension: Dimension,
) -> Option<Mesh> {
    let d = dimension.coordinate_count();
    let mut coordinates = Vec::new();
    let mut cells: Vec<CellBlock> = Vec::new();
    let mut point_sets = BTreeMap::new();
    let mut is_any = false;
    for (part, inside) in parts.iter().zip(insides) {
        let Some(mesh) = &inside.mesh else { continue };
        is_any = true;
        let first = (coordinates.len() / d) as u32;
        let origin = part
            .flexible()
            .map_or_else(Vector3::zeros, |of| Vector3::from(of.element.origin));
        for node in 0..mesh.node_count() as u32 {
            let position = part.centre + part.axes * (Vector3::from(mesh.position(node)) - origin);
            coordinates.extend_from_slice(&position.as_slice()[..d]);
        }
        let is_mirrored = part.axes.determinant() < 0.0;
        for block in &mesh.cells {
            let order = is_mirrored.then(|| turned_over(&block.cell_type)).flatten();
            let nodes = block.cells().flat_map(|cell| {
                let node = |i: usize| match order {
                    Some(order) if order.len() == cell.len() => cell[order[i]],
                    _ => cell[i],
                };
                (0..cell.len())
                    .map(|i| first + node(i))
                    .collect::<Vec<u32>>()
            });
            let nodes: Vec<u32> = nodes.collect();
            match cells.iter_mut().find(|of| {
                of.cell_type == block.cell_type && of.nodes_per_cell == block.nodes_per_cell
            }) {
                Some(whole) => whole.nodes.extend(nodes),
                None => cells.push(CellBlock {
                    cell_type: block.cell_type.clone(),
                    nodes_per_cell: block.nodes_per_cell,
                    nodes,
                }),
            }
        }
        let all = (first..first + mesh.node_count() as u32).collect();
        point_sets.insert(part.name.clone(), all);
        for (name, nodes) in &mesh.point_sets {
            let nodes = nodes.iter().map(|node| first + node).collect();
            point_sets.insert(format!("{}: {name}", part.name), nodes);
        }
    }
    is_any.then_some(Mesh {
        dimension,
        coordinates,
        cells,
        point_sets,
    })
}

/// The number of each part's first node in the joined mesh.
pub(crate) fn first_nodes(insides: &[Inside]) -> Vec<Option<u32>> {
    let mut next = 0;
    let first = |inside: &Inside| {
        let mesh = inside.mesh.as_ref()?;
        let first = next;
        next += mesh.node_count() as u32;
        Some(first)
    };
    insides.iter().map(first).collect()
}

/// Nodes of the mirror image of a cell in meshio's order.
fn turned_over(cell_type: &str) -> Option<&'static [usize]> {
    Some(match cell_type {
        "triangle" => &[0, 2, 1],
        "triangle6" => &[0, 2, 1, 5, 4, 3],
        "quad" => &[0, 3, 2, 1],
        "quad8" => &[0, 3, 2, 1, 7, 6, 5, 4],
        "tetra" => &[0, 2, 1, 3],
        "tetra10" => &[0, 2, 1, 3, 6, 5, 4, 7, 9, 8],
        "pyramid" => &[0, 3, 2, 1, 4],
        "wedge" => &[0, 2, 1, 3, 5, 4],
        "hexahedron" => &[0, 3, 2, 1, 4, 7, 6, 5],
        "hexahedron20" => &[
            0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17,
        ],
        _ => return None,
    })
}

/// Nodal fields of the columns of the whole, the first `mode_count` of them modes; `None` where no part has fields.
pub(crate) fn recovered(
    parts: &[Part],
    insides: &[Inside],
    columns: &[PartColumns],
    mode_count: usize,
) -> Option<RecoveryBasis> {
    let starts = first_nodes(insides);
    let mut dofs = Vec::new();
    let mut fields: Vec<Mat<f64>> = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        let (Some(recovery), Some(mesh), Some(first)) =
            (&insides[i].recovery, &insides[i].mesh, starts[i])
        else {
            continue;
        };
        let (own_dofs, field) = of_part(part, recovery, mesh, &columns[i]);
        dofs.extend(own_dofs.into_iter().map(|dof| Dof {
            node: first + dof.node,
            ..dof
        }));
        fields.push(field);
    }
    if dofs.is_empty() {
        return None;
    }
    let count = fields.first().map_or(0, Mat::ncols);
    let mut whole = Mat::zeros(dofs.len(), count);
    let mut at = 0;
    for field in &fields {
        whole
            .as_mut()
            .subrows_mut(at, field.nrows())
            .copy_from(field);
        at += field.nrows();
    }
    Some(RecoveryBasis {
        dofs,
        modes: whole.as_ref().subcols(0, mode_count).to_owned(),
        residual: whole
            .as_ref()
            .subcols(mode_count, count - mode_count)
            .to_owned(),
        enrichment: None,
    })
}

/// Fields of one part in axes of the assembly.
fn of_part(
    part: &Part,
    recovery: &RecoveryBasis,
    mesh: &Mesh,
    columns: &PartColumns,
) -> (Vec<Dof>, Mat<f64>) {
    let own = deformation(recovery, columns.deformation.as_ref());
    let origin = part
        .flexible()
        .map_or_else(Vector3::zeros, |of| Vector3::from(of.element.origin));
    let axial = part.axial();
    let mut dofs = Vec::new();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut start = 0;
    while start < recovery.dofs.len() {
        let node = recovery.dofs[start].node;
        let end = start
            + recovery.dofs[start..]
                .iter()
                .take_while(|dof| dof.node == node)
                .count();
        let arm = part.axes * (Vector3::from(mesh.position(node)) - origin);
        for (is_rotation, axes) in [(false, &part.axes), (true, &axial)] {
            let places: Vec<usize> = (start..end)
                .filter(|place| recovery.dofs[*place].direction.is_rotation() == is_rotation)
                .collect();
            for axis in touched(axes, &places, recovery) {
                let direction = if is_rotation { 3 + axis } else { axis };
                let Some(direction) = Direction::from_index(direction) else {
                    continue;
                };
                dofs.push(Dof { node, direction });
                let rigid = rigid_weights(is_rotation, axis, arm);
                rows.push(
                    (0..columns.rigid.ncols())
                        .map(|k| {
                            let of_frame: f64 =
                                (0..6).map(|i| rigid[i] * columns.rigid[(i, k)]).sum();
                            let elastic: f64 = (places.iter())
                                .map(|place| {
                                    axes[(axis, recovery.dofs[*place].direction.axis())]
                                        * own[(*place, k)]
                                })
                                .sum();
                            of_frame + elastic
                        })
                        .collect(),
                );
            }
        }
        start = end;
    }
    let field = Mat::from_fn(rows.len(), columns.rigid.ncols(), |i, k| rows[i][k]);
    (dofs, field)
}

/// Axes of the assembly that some directions of a node have a part in.
fn touched(axes: &Matrix3<f64>, places: &[usize], recovery: &RecoveryBasis) -> Vec<usize> {
    let has = |axis: &usize| {
        places
            .iter()
            .any(|place| axes[(*axis, recovery.dofs[*place].direction.axis())].abs() > ALONG)
    };
    (0..3).filter(has).collect()
}

fn rigid_weights(is_rotation: bool, axis: usize, arm: Vector3<f64>) -> [f64; 6] {
    let mut weights = [0.0; 6];
    if is_rotation {
        weights[3 + axis] = 1.0;
    } else {
        weights[axis] = 1.0;
        let lever = arm.cross(&Vector3::ith(axis, 1.0));
        weights[3..].copy_from_slice(lever.as_slice());
    }
    weights
}

/// [Φ, G_res L_bᵀ, X] times amplitudes, body axes.
fn deformation(recovery: &RecoveryBasis, amplitudes: MatRef<'_, f64>) -> Mat<f64> {
    let (n_k, n_b) = (recovery.modes.ncols(), recovery.residual.ncols());
    let mut field = &recovery.modes * amplitudes.subrows(0, n_k)
        + &recovery.residual * amplitudes.subrows(n_k, n_b);
    if let Some(further) = &recovery.enrichment {
        field += further * amplitudes.subrows(n_k + n_b, further.ncols());
    }
    field
}
