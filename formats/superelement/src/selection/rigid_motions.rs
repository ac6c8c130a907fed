//! Rigid motions at the rows, from mass, tensor and the rows' places.

use dcb_formats::mesh::{Dimension, Direction};
use dcb_formats::superelement::{BoundaryRow, FrameKind, Superelement};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

/// M-orthonormal rigid motions at the rows, (n_b, r). None in a frame that isn't on mean axes, whose component is held; none of explicit rows, which don't
/// say how the frame moves them.
pub(super) fn rigid_motions(whole: &Superelement) -> Mat<f64> {
    if whole.frame_kind == FrameKind::Given {
        return Mat::zeros(whole.rows.len(), 0);
    }
    let motions = unit_motions(whole);
    Mat::from_fn(whole.rows.len(), motions.len(), |row, k| {
        let (translation, rotation) = &motions[k];
        let BoundaryRow {
            direction,
            position,
            ..
        } = &whole.rows[row];
        let direction = usize::try_from(*direction).ok();
        match direction.and_then(Direction::from_index) {
            None => 0.0,
            Some(direction) if direction.is_rotation() => rotation[direction.axis()],
            Some(direction) => {
                let moved = translation + rotation.cross(&Vector3::from(*position));
                moved[direction.axis()]
            }
        }
    })
}

/// Translations and rotations of unit kinetic energy, twice over: uᵀ M u = 1.
fn unit_motions(whole: &Superelement) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let inertia = &whole.inertia;
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let zero = Vector3::zeros();
    let translations = axes[..whole.dimension.coordinate_count()].iter();
    let translations = translations.map(|axis| (axis / inertia.mass.sqrt(), zero));
    let rotations: Vec<Vector3<f64>> = match whole.dimension {
        Dimension::Planar => vec![axes[2] / inertia.tensor[2][2].sqrt()],
        Dimension::Spatial => {
            let tensor = Matrix3::from_fn(|a, b| inertia.tensor[a][b]);
            let principal = tensor.symmetric_eigen();
            let pairs = principal
                .eigenvalues
                .iter()
                .zip(principal.eigenvectors.column_iter());
            pairs.map(|(moment, axis)| axis / moment.sqrt()).collect()
        }
    };
    let rotations = rotations
        .into_iter()
        .filter(|axis| axis.iter().all(|entry| entry.is_finite()));
    translations
        .chain(rotations.map(|axis| (zero, axis)))
        .collect()
}
