//! The Krylov basis over many steps.
#![allow(clippy::unwrap_used)]

use dcb_samples::{Material, SolidElement, box_block};
use dcb_sparse::block_algebra::{gram, largest_entry, symmetric_product};
use dcb_sparse::factorization::SymmetricFactor;
use faer::Mat;

use crate::model::condensation::Model;
use crate::model::piece_motions::Pieces;
use crate::model::rigid_body::{MassProperties, RigidBodyModes};
use crate::model::shift::SpectrumScale;
use crate::modes::lanczos::Lanczos;

/// Cleaned once a step, the basis keeps to M-orthonormal vectors without rigid motion, and the projected matrix to its eigenvalues, however many steps are made.
#[test]
fn a_basis_stays_orthonormal_over_many_steps() {
    let size = [0.4, 0.05, 0.05];
    let component = box_block(
        [12, 2, 2],
        size,
        SolidElement::Hexahedron20,
        &Material::STEEL,
    );
    let properties = MassProperties::of(&component).unwrap();
    let model = &Model::of(&component).unwrap();
    let rigid = RigidBodyModes::of(&component, model, &properties).unwrap();
    let pieces = Pieces::of(model, &rigid);
    let dimension = component.dimension();
    let shift = SpectrumScale::of(model, &rigid, &pieces, dimension, properties.centre).shift();
    let mut factor =
        SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points()).unwrap();
    let factor = factor
        .factorize(&model.stiffness, &model.mass, shift)
        .unwrap();
    let start =
        |capacity: usize| Lanczos::start(model, &rigid, &factor, shift, 8, capacity, 3).unwrap();
    let mut lanczos = start(400);
    let mut largest = 0.0_f64;
    for _ in 0..45 {
        lanczos.step().unwrap();
        let vectors = lanczos.vectors();
        let inertia = symmetric_product(&model.mass, vectors);
        let defect = gram(vectors, inertia.as_ref())
            - Mat::<f64>::identity(inertia.ncols(), inertia.ncols());
        largest = largest.max(largest_entry(defect.as_ref()));
    }
    println!(
        "{} columns of {} dofs: {largest:e}",
        lanczos.column_count(),
        model.len()
    );
    assert!(lanczos.column_count() >= 350 && model.len() > 800);
    assert!(largest < 1e-12, "{largest:e}");

    // A basis that was restarted on its way comes to the same eigenvalues.
    let mut restarted = start(96);
    for _ in 0..45 {
        if restarted.is_full() {
            let pairs = restarted.ritz_pairs().unwrap();
            restarted.restart(&pairs, 40);
        }
        restarted.step().unwrap();
    }
    let [whole, restarted] =
        [&lanczos, &restarted].map(|one| one.ritz_pairs().unwrap().eigenvalues);
    for (a, b) in whole.iter().zip(&restarted).take(24) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
}
