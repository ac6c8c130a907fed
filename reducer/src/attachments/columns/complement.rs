//! The complement of some motions, for motions and for forces.

use dcb_sparse::block_algebra::{add_combination, gram};
use faer::{Mat, MatRef};

use crate::model::rigid_body::RigidBodyModes;
use crate::modes::free_modes::FreeModes;

/// Projectors onto the complement of some motions.
pub struct Complement<'a> {
    pub(super) shapes: MatRef<'a, f64>,
    pub(super) mass_shapes: MatRef<'a, f64>,
}

impl<'a> Complement<'a> {
    /// Without rigid motions.
    pub fn of_rigid(rigid: &'a RigidBodyModes) -> Self {
        Self {
            shapes: rigid.shapes.as_ref(),
            mass_shapes: rigid.mass_shapes.as_ref(),
        }
    }

    /// Without kept modes.
    pub fn of_modes(modes: &'a FreeModes) -> Self {
        Self {
            shapes: modes.shapes.as_ref(),
            mass_shapes: modes.mass_shapes.as_ref(),
        }
    }

    /// Without the kept modes that have no stiffness.
    pub(super) fn of_loose_modes(modes: &'a FreeModes) -> Self {
        Self {
            shapes: modes.shapes.as_ref().subcols(0, modes.zero_count),
            mass_shapes: modes.mass_shapes.as_ref().subcols(0, modes.zero_count),
        }
    }

    /// x -= Φₐ (M Φₐ)ᵀ x
    pub fn project_motion(&self, x: &mut Mat<f64>) {
        if self.shapes.ncols() == 0 {
            return;
        }
        let amounts = gram(self.mass_shapes, x.as_ref());
        add_combination(x.as_mut(), self.shapes, amounts.as_ref(), -1.0);
    }

    /// f -= M Φₐ Φₐᵀ f
    pub(super) fn project_force(&self, f: &mut Mat<f64>) {
        if self.shapes.ncols() == 0 {
            return;
        }
        let amounts = gram(self.shapes, f.as_ref());
        add_combination(f.as_mut(), self.mass_shapes, amounts.as_ref(), -1.0);
    }
}
