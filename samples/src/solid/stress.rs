//! Stress at nodes of a solid mesh as rows over its degrees of freedom: σ = D B u in every cell at a node, averaged over the cells.

use std::collections::BTreeMap;

use dcb_formats::SparseMatrix;
use dcb_formats::component::{NamedStress, StressComponent, StressPoint, StressQuantity};
use dcb_formats::mesh::Mesh;
use faer::sparse::Triplet;
use nalgebra::{Matrix3, Vector3};

use super::assemble::{jacobian, solid_blocks};
use crate::material::Material;

/// All six components at these nodes, each of a solid cell.
pub fn nodal_stress(name: &str, mesh: &Mesh, material: &Material, nodes: &[u32]) -> NamedStress {
    let place: BTreeMap<u32, usize> = (nodes.iter().enumerate())
        .map(|(place, node)| (*node, place))
        .collect();
    // Gradients of the neighbours' shape functions at each place, summed over its cells.
    let mut gradients = vec![BTreeMap::<u32, Vector3<f64>>::new(); nodes.len()];
    let mut cells = vec![0.0; nodes.len()];
    for (element, block) in solid_blocks(mesh) {
        let corners = element.node_positions();
        for cell in block.cells() {
            for (local, node) in cell.iter().enumerate() {
                let Some(&place) = place.get(node) else {
                    continue;
                };
                let shapes = element.shape_functions(corners[local]);
                let inverse = jacobian(mesh, cell, &shapes)
                    .try_inverse()
                    .unwrap_or_else(Matrix3::zeros);
                cells[place] += 1.0;
                for (other, shape) in cell.iter().zip(&shapes) {
                    *gradients[place].entry(*other).or_default() +=
                        inverse * Vector3::from(shape.gradient);
                }
            }
        }
    }
    let mut triplets = Vec::new();
    for (place, neighbours) in gradients.iter().enumerate() {
        for (node, sum) in neighbours {
            let gradient = sum / cells[place];
            for axis in 0..3 {
                let stress = of_displacement(material, &gradient, axis);
                for (component, value) in stress.into_iter().enumerate() {
                    if value != 0.0 {
                        let row = (6 * place + component) as u32;
                        triplets.push(Triplet::new(row, 3 * node + axis as u32, value));
                    }
                }
            }
        }
    }
    let columns = 3 * mesh.node_count();
    NamedStress {
        name: name.to_owned(),
        quantity: StressQuantity::Stress,
        components: StressComponent::ALL.to_vec(),
        points: (nodes.iter())
            .map(|node| StressPoint {
                position: mesh.position(*node),
                node: Some(*node),
            })
            .collect(),
        matrix: match SparseMatrix::try_new_from_triplets(6 * nodes.len(), columns, &triplets) {
            Ok(matrix) => matrix,
            Err(error) => unreachable!("rows and columns are those of the mesh: {error}"),
        },
    }
}

/// σ of a unit displacement of a node along an axis: λ tr(ε) 1 + 2 μ ε with ε the symmetric part of ∇N ⊗ e.
fn of_displacement(material: &Material, gradient: &Vector3<f64>, axis: usize) -> [f64; 6] {
    let (lambda, mu) = material.lame();
    StressComponent::ALL.map(|component| {
        let (a, b) = component.axes();
        let strain = 0.5
            * (f64::from(u8::from(b == axis)) * gradient[a]
                + f64::from(u8::from(a == axis)) * gradient[b]);
        let trace = if a == b { gradient[axis] } else { 0.0 };
        lambda * trace + 2.0 * mu * strain
    })
}
