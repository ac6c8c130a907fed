//! The awkward samples have the defects they are named for.

use super::*;
use dcb_formats::Component;
use dcb_samples::hard::*;
use faer::Side;

/// Zero eigenvalues of the stiffness, relative to the largest.
fn zero_count(component: &Component) -> usize {
    let values = dense(&component.stiffness)
        .self_adjoint_eigenvalues(Side::Lower)
        .unwrap();
    let largest = values.last().unwrap();
    values
        .iter()
        .filter(|value| value.abs() < 1e-11 * largest)
        .count()
}

#[test]
fn loose_and_hinged_blocks_have_their_zero_frequencies() {
    assert_eq!(zero_count(&two_loose_blocks()), 12);
    assert_eq!(zero_count(&hinged_blocks(Hinge::Edge)), 7);
    assert_eq!(zero_count(&hinged_blocks(Hinge::Node)), 9);
}

#[test]
fn grounded_block_has_no_zero_frequency_and_a_dof_table() {
    let block = grounded_block();
    assert_eq!(zero_count(&block), 0);
    assert_eq!(block.dofs.len(), block.stiffness.ncols());
    assert!(block.dofs.len() < 3 * block.mesh.node_count());
    assert_eq!(block.interfaces.len(), 1);
    assert!(dense(&block.mass).llt(Side::Lower).is_ok());
}

#[test]
fn orphan_dof_is_an_empty_row_of_both_matrices() {
    let block = orphan_dof_block();
    let last = block.dofs.len() - 1;
    for matrix in [&block.stiffness, &block.mass] {
        assert_eq!(matrix.ncols(), last + 1);
        assert_eq!(matrix.col_ptr()[last], matrix.col_ptr()[last + 1]);
    }
    assert_eq!(
        block.dofs.dof(last).unwrap().node as usize,
        block.mesh.node_count() - 1
    );
    assert_eq!(zero_count(&block), 7);
}

#[test]
fn square_block_bends_in_exact_pairs() {
    let omega = elastic_omegas(&square_block());
    assert!(relative(omega[0], omega[1]) < 1e-9, "{:?}", &omega[..4]);
    assert!(relative(omega[2], omega[1]) > 1e-2);
}

#[test]
fn symmetric_ring_has_double_roots() {
    for fold in [4, 8] {
        let ring = symmetric_ring(fold);
        let omega = elastic_omegas(&ring);
        let pairs = omega[..12]
            .windows(2)
            .filter(|pair| relative(pair[0], pair[1]) < 1e-8)
            .count();
        assert!(pairs >= 3, "{fold}: {:?}", &omega[..12]);
        assert!(rigid_defect(&ring) < 1e-13);
    }
}

#[test]
fn thin_and_slender_parts_are_free_and_symmetric() {
    for component in [thin_plate(), slender_block()] {
        assert!(exactly_symmetric(&component.stiffness) && exactly_symmetric(&component.mass));
        assert!(
            rigid_defect(&component) < 1e-12,
            "{}: {:e}",
            component.name,
            rigid_defect(&component)
        );
    }
}
