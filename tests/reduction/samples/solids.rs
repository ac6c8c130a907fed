//! Solid elements and blocks against closed forms and the spatial reference values.

use std::f64::consts::PI;

use super::*;
use dcb_formats::mesh::Direction;
use dcb_samples::solid::{jacobian_determinants, solid_component};
use dcb_samples::{Material, SolidElement, box_block, reference_hexahedra, reference_tetrahedra};
use faer::Side;

#[test]
fn shape_functions_sum_to_one_and_have_their_gradients() {
    let step = 1e-5;
    for element in SolidElement::ALL {
        for point in element.quadrature() {
            let shapes = element.shape_functions(point.at);
            assert_eq!(shapes.len(), element.node_count());
            assert!((shapes.iter().map(|shape| shape.value).sum::<f64>() - 1.0).abs() < 1e-14);
            for axis in 0..3 {
                let (mut above, mut below) = (point.at, point.at);
                above[axis] += step;
                below[axis] -= step;
                let (above, below) = (
                    element.shape_functions(above),
                    element.shape_functions(below),
                );
                for (node, shape) in shapes.iter().enumerate() {
                    let slope = (above[node].value - below[node].value) / (2.0 * step);
                    assert!(
                        (slope - shape.gradient[axis]).abs() < 1e-8,
                        "{element:?} node {node} axis {axis}"
                    );
                }
            }
        }
    }
}

#[test]
fn blocks_are_symmetric_positive_and_free() {
    for element in SolidElement::ALL {
        let block = box_block([3, 2, 2], [0.3, 0.1, 0.12], element, &Material::STEEL);
        assert!(exactly_symmetric(&block.stiffness) && exactly_symmetric(&block.mass));
        assert!(
            rigid_defect(&block) < 1e-13,
            "{element:?}: {:e}",
            rigid_defect(&block)
        );
        assert!(
            dense(&block.mass).llt(Side::Lower).is_ok(),
            "{element:?}: mass is positive"
        );
        let omega = omegas(&block);
        assert!(
            omega[5] < 1e-4 * omega[6],
            "{element:?}: six rigid modes, {} and {}",
            omega[5],
            omega[6]
        );
    }
}

#[test]
fn blocks_have_the_mass_and_inertia_of_a_box() {
    let [a, b, c] = [0.3, 0.1, 0.12];
    let mass = 7850.0 * a * b * c;
    let inertia = [
        (b * b + c * c) / 3.0,
        (a * a + c * c) / 3.0,
        (a * a + b * b) / 3.0,
    ]
    .map(|x| x * mass);
    for element in SolidElement::ALL {
        let block = box_block([2, 1, 1], [a, b, c], element, &Material::STEEL);
        let motions = rigid_motions(&block);
        for axis in 0..3 {
            assert!(relative(form(&block.mass, &motions[axis], &motions[axis]), mass) < 1e-13);
            let spin = &motions[3 + axis];
            assert!(
                relative(form(&block.mass, spin, spin), inertia[axis]) < 1e-13,
                "{element:?} axis {axis}"
            );
        }
        // Product of inertia about the corner: -m a b / 4.
        let product = form(&block.mass, &motions[3], &motions[4]);
        assert!(
            relative(product, -mass * a * b / 4.0) < 1e-12,
            "{element:?}"
        );
    }
}

#[test]
fn distorted_meshes_pass_the_patch_test() {
    for element in SolidElement::ALL {
        let regular = box_block([2, 2, 2], [1.0, 1.0, 1.0], element, &Material::SOFT);
        let mut mesh = regular.mesh.clone();
        let boundary: Vec<u32> = ["x", "y", "z"]
            .iter()
            .flat_map(|axis| [format!("{axis}_min"), format!("{axis}_max")])
            .flat_map(|name| mesh.point_sets[&name].clone())
            .collect();
        // An affine map keeps straight edges; moving the centre bends the grid. Mid-side nodes stay in the middle.
        let bend = |x: [f64; 3]| {
            let hat = x
                .iter()
                .map(|t| 1.0 - (2.0 * t - 1.0).abs())
                .fold(1.0, f64::min);
            let x = [x[0] + 0.12 * hat, x[1] - 0.08 * hat, x[2] + 0.1 * hat];
            [x[0] + 0.2 * x[1], x[1] + 0.1 * x[2], x[2] - 0.1 * x[0]]
        };
        for point in mesh.coordinates.chunks_exact_mut(3) {
            let moved = bend([point[0], point[1], point[2]]);
            point.copy_from_slice(&moved);
        }
        straighten(&mut mesh);
        assert!(jacobian_determinants(&mesh).iter().all(|det| *det > 0.0));
        let patch = solid_component("patch", mesh, &Material::SOFT, Vec::new());
        let field = |x: [f64; 3]| {
            [
                1e-3 * x[0] + 2e-3 * x[1],
                3e-3 * x[1] - 1e-3 * x[2],
                0.5e-3 * x[0] + 1e-3 * x[2],
            ]
        };
        let displacement: Vec<f64> = (0..patch.mesh.node_count() as u32)
            .flat_map(|node| field(patch.mesh.position(node)))
            .collect();
        let forces = product(&patch.stiffness, &displacement);
        let largest = forces.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for node in (0..patch.mesh.node_count()).filter(|node| !boundary.contains(&(*node as u32)))
        {
            for axis in 0..3 {
                let force = forces[3 * node + axis];
                assert!(
                    force.abs() < 1e-12 * largest,
                    "{element:?}: {force:e} inside, {largest:e} outside"
                );
            }
        }
    }
}

/// Puts mid-side nodes halfway between their corners.
fn straighten(mesh: &mut dcb_formats::mesh::Mesh) {
    let edges: &[[usize; 2]] = match mesh.cells[0].nodes_per_cell {
        20 => &HEXAHEDRON_EDGES,
        10 => &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
        _ => return,
    };
    let corners = mesh.cells[0].nodes_per_cell - edges.len();
    for cell in mesh.cells[0]
        .cells()
        .map(<[u32]>::to_vec)
        .collect::<Vec<_>>()
    {
        for (at, [i, j]) in edges.iter().enumerate() {
            let (a, b) = (mesh.position(cell[*i]), mesh.position(cell[*j]));
            let middle = cell[corners + at] as usize;
            for axis in 0..3 {
                mesh.coordinates[3 * middle + axis] = 0.5 * (a[axis] + b[axis]);
            }
        }
    }
}

#[test]
fn axial_frequency_converges_with_the_order_of_the_element() {
    let material = Material {
        poisson_ratio: 0.0,
        ..Material::STEEL
    };
    let exact = PI * (material.youngs_modulus / material.density).sqrt();
    for (element, order) in [
        (SolidElement::Hexahedron, 2.0),
        (SolidElement::Hexahedron20, 4.0),
        (SolidElement::Tetra10, 4.0),
    ] {
        let errors = [2, 4].map(|cells| {
            let bar = box_block([cells, 1, 1], [1.0, 0.07, 0.05], element, &material);
            // Without motion across, the bar can only stretch; the first eigenvalue is the rigid motion along.
            let (k, m) = held(&bar, |_, direction| direction != Direction::Ux);
            relative(omega_squared(&k, &m)[1].sqrt(), exact)
        });
        let found = (errors[0] / errors[1]).log2();
        assert!(
            (found - order).abs() < 0.35,
            "{element:?}: order {found}, errors {errors:?}"
        );
    }
}

#[test]
fn reference_boxes_have_the_reference_frequencies() {
    let reference = reference("ref_spatial.json");
    for (kind, component) in [
        ("hex", reference_hexahedra()),
        ("tet", reference_tetrahedra()),
    ] {
        let expected = numbers(&reference[kind]["omega_first12"]);
        let computed = elastic_omegas(&component);
        assert_eq!(
            component.mesh.node_count() as u64,
            reference[kind]["nodes"].as_u64().unwrap()
        );
        for (a, b) in computed.iter().zip(&expected) {
            assert!(
                relative(*a, *b) < 1e-9,
                "{kind}: {computed:?} against {expected:?}"
            );
        }
    }
}
