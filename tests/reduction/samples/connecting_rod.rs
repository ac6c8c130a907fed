//! The connecting rod's mesh is a valid one of the right shape.

use std::collections::{BTreeSet, HashSet};

use super::*;
use dcb_samples::connecting_rod;
use dcb_samples::connecting_rod::RodShape;
use dcb_samples::solid::jacobian_determinants;

const FACES: [[usize; 4]; 6] = [
    [0, 1, 2, 3],
    [4, 5, 6, 7],
    [0, 1, 5, 4],
    [1, 2, 6, 5],
    [2, 3, 7, 6],
    [3, 0, 4, 7],
];
#[test]
fn default_rod_is_large_enough_and_refinement_quadruples_it() {
    let sizes = [0, 1, 2].map(|refinement| connecting_rod(refinement).dofs.len() as f64);
    assert!(sizes[1] >= 20_000.0 && sizes[1] < 32_000.0, "{sizes:?}");
    assert!(
        sizes[2] / sizes[1] > 3.0 && sizes[1] / sizes[0] > 2.5,
        "{sizes:?}"
    );
}

#[test]
fn no_element_is_inverted() {
    for refinement in 0..3 {
        let determinants = jacobian_determinants(&connecting_rod(refinement).mesh);
        let smallest = determinants.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(smallest > 0.0, "refinement {refinement}: {smallest:e}");
    }
}

#[test]
fn mesh_is_one_piece_with_two_holes_and_no_doubled_nodes() {
    let mesh = connecting_rod(0).into_draft().mesh;
    let cells: Vec<&[u32]> = mesh.cells[0].cells().collect();
    let sorted = |nodes: &mut dyn Iterator<Item = u32>| {
        let mut nodes: Vec<u32> = nodes.collect();
        nodes.sort_unstable();
        nodes
    };
    let corners: HashSet<u32> = cells.iter().flat_map(|cell| cell[..8].to_vec()).collect();
    let edges: HashSet<Vec<u32>> = cells
        .iter()
        .flat_map(|cell| HEXAHEDRON_EDGES.map(|edge| sorted(&mut edge.iter().map(|&i| cell[i]))))
        .collect();
    let faces: HashSet<Vec<u32>> = cells
        .iter()
        .flat_map(|cell| FACES.map(|face| sorted(&mut face.iter().map(|&i| cell[i]))))
        .collect();
    // A solid with two through holes: V - E + F - C = 1 - 2.
    let euler = corners.len() as i64 - edges.len() as i64 + faces.len() as i64 - cells.len() as i64;
    assert_eq!(euler, -1);
    assert_eq!(
        corners.len() + edges.len(),
        mesh.node_count(),
        "one mid-side node to an edge"
    );

    let mut reached = BTreeSet::from([0_u32]);
    loop {
        let before = reached.len();
        for cell in &cells {
            if cell.iter().any(|node| reached.contains(node)) {
                reached.extend(cell.iter());
            }
        }
        if reached.len() == before {
            break;
        }
    }
    assert_eq!(reached.len(), mesh.node_count());

    let places: HashSet<[i64; 3]> = (0..mesh.node_count() as u32)
        .map(|node| mesh.position(node).map(|x| (x * 1e7).round() as i64))
        .collect();
    assert_eq!(places.len(), mesh.node_count(), "no two nodes at one place");
}

#[test]
fn volume_and_mass_are_those_of_the_shape() {
    let exact = 7850.0 * RodShape::default().volume();
    let errors = [0, 1].map(|refinement| {
        let rod = connecting_rod(refinement);
        let along = &rigid_motions(&rod)[0];
        relative(form(&rod.mass, along, along), exact)
    });
    // Quadratic edges leave a fourth-order error of the arcs.
    assert!(
        errors[0] < 2e-4 && errors[1] < errors[0] / 2.0,
        "{errors:?}"
    );
}

#[test]
fn bore_nodes_lie_on_their_circles_and_the_frames_in_the_middle() {
    let rod = connecting_rod(1);
    let shape = RodShape::default();
    for (interface, radius, center) in [
        (&rod.interfaces[0], shape.big_end[0], 0.0),
        (&rod.interfaces[1], shape.small_end[0], shape.length),
    ] {
        assert_eq!(interface.position, Some([center, 0.0, 0.0]));
        assert!(interface.nodes.len() > 50);
        for &node in &interface.nodes {
            let [x, y, z] = rod.mesh.position(node);
            assert!(((x - center).hypot(y) - radius).abs() < 1e-15 + 1e-14 * shape.length);
            assert!(z.abs() <= shape.thickness / 2.0);
        }
    }
    // Nothing else comes as close to the axes.
    let on_big = (0..rod.mesh.node_count() as u32).filter(|&node| {
        let [x, y, _] = rod.mesh.position(node);
        x.hypot(y) < shape.big_end[0] + 1e-9
    });
    assert_eq!(on_big.count(), rod.interfaces[0].nodes.len());
}

#[test]
fn matrices_are_symmetric_and_free() {
    let rod = connecting_rod(0);
    assert!(exactly_symmetric(&rod.stiffness) && exactly_symmetric(&rod.mass));
    assert!(rigid_defect(&rod) < 1e-13, "{:e}", rigid_defect(&rod));
}
