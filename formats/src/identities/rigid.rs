//! Rigid motions at the rows, from mass, tensor and the rows' positions and directions.
//!
//! ```text
//! R Rᵀ = G diag(1/m, J⁻¹) Gᵀ      G: row of direction e at r:  (eᵀ, (r × e)ᵀ) for a displacement, (0, eᵀ) for a rotation
//! ```
//! whichever M-orthonormal rigid motions R was made of.

use faer::Mat;
use faer::linalg::solvers::{PartialPivLu, Solve};

use super::scaled::larger;
use super::{AGREEMENT, Identity};
use crate::mesh::Dimension;
use crate::superelement::{BoundaryRow, Superelement};

pub(super) fn in_full(of: &Superelement) -> Vec<Identity> {
    match &of.moments {
        Some(moments) if moments.rigid_shapes.ncols() > 0 => {
            vec![from_geometry(of, &moments.rigid_shapes)]
        }
        _ => Vec::new(),
    }
}

fn from_geometry(of: &Superelement, shapes: &Mat<f64>) -> Identity {
    let rows: Vec<usize> = (0..of.rows.len())
        .filter(|row| of.rows[*row].direction >= 0)
        .collect();
    let (d, axes) = match of.dimension {
        Dimension::Planar => (2, 1),
        Dimension::Spatial => (3, 3),
    };
    let motions = Mat::from_fn(rows.len(), d + axes, |i, j| {
        let row = &of.rows[rows[i]];
        match (j < d, of.dimension) {
            (true, _) => f64::from(u8::from(row.direction == j as i64)),
            (false, Dimension::Planar) => turned(row, 2),
            (false, Dimension::Spatial) => turned(row, j - d),
        }
    });
    let mass = Mat::from_fn(d + axes, d + axes, |i, j| match (i < d, j < d) {
        (true, true) if i == j => of.inertia.mass,
        (false, false) if axes == 1 => of.inertia.tensor[2][2],
        (false, false) => of.inertia.tensor[i - d][j - d],
        _ => 0.0,
    });
    // The mass of each motion is 1, so that no unit decides the pivots.
    let scale: Vec<f64> = (0..d + axes)
        .map(|i| mass[(i, i)].max(0.0).sqrt())
        .collect();
    let unit = Mat::from_fn(d + axes, d + axes, |i, j| {
        mass[(i, j)] / (scale[i] * scale[j])
    });
    let motions = Mat::from_fn(rows.len(), d + axes, |i, j| motions[(i, j)] / scale[j]);
    let solved = PartialPivLu::new(unit.as_ref()).solve(motions.transpose().to_owned());
    let expected = &motions * solved;
    let found = Mat::from_fn(rows.len(), rows.len(), |i, j| {
        let both = (0..shapes.ncols()).map(|k| shapes[(rows[i], k)] * shapes[(rows[j], k)]);
        both.sum::<f64>()
    });
    let mut defect = 0.0;
    for j in 0..rows.len() {
        for i in 0..=j {
            let size = (expected[(i, i)] * expected[(j, j)]).sqrt();
            defect = larger(defect, (found[(i, j)] - expected[(i, j)]).abs() / size);
        }
    }
    Identity {
        path: "/error/rigid_shapes",
        what: "they are the rigid motions that mass, tensor and the rows' places make",
        defect,
        limit: AGREEMENT,
    }
}

/// Displacement of a row in a unit rotation about an axis.
fn turned(row: &BoundaryRow, axis: usize) -> f64 {
    let direction = usize::try_from(row.direction).unwrap_or(0);
    if direction >= 3 {
        return f64::from(u8::from(direction - 3 == axis));
    }
    // (e_axis × r) · e_direction
    match (direction + 3 - axis) % 3 {
        1 => -row.position[(axis + 2) % 3],
        2 => row.position[(axis + 1) % 3],
        _ => 0.0,
    }
}
