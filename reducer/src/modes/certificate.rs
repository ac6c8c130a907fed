//! The certificate of the modes: how many eigenvalues of (K, M) lie below a limit, counted by the inertia of K - μ M (Sylvester, Sturm).

use dcb_sparse::factorization::SymmetricFactor;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::model::condensation::Model;
use crate::model::rigid_body::RigidBodyModes;
use crate::modes::free_modes::FreeModes;

/// An eigenvalue count by the inertia of K - μ M.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sturm {
    /// μ, (rad/time)²; absent for a part without elastic motion.
    pub limit: Option<f64>,
    /// Eigenvalues counted below μ, rigid motions included.
    pub counted: usize,
    /// Eigenvalues found below μ, rigid motions included.
    pub found: usize,
}

impl Sturm {
    /// Counts the eigenvalues below the first omitted one, beside those that were found.
    ///
    /// # Errors
    /// Those of counting.
    pub(crate) fn count(
        model: &Model,
        rigid: &RigidBodyModes,
        modes: &FreeModes,
        factor: &mut SymmetricFactor,
    ) -> Result<Self, Error> {
        let found = rigid.count() + modes.count();
        let Some((limit, room)) = modes.certificate_shift() else {
            return Ok(Self {
                limit: None,
                counted: found,
                found,
            });
        };
        // A zero pivot means that μ met an eigenvalue of some leading block; a slightly different μ in the same gap does not.
        let mut inertia = factor.inertia(&model.stiffness, &model.mass, limit)?;
        let mut used = limit;
        for fraction in [0.1, -0.1, 0.37] {
            if inertia.zero == 0 {
                break;
            }
            used = limit + fraction * room;
            inertia = factor.inertia(&model.stiffness, &model.mass, used)?;
        }
        Ok(Self {
            limit: Some(used),
            counted: inertia.negative,
            found,
        })
    }
}
