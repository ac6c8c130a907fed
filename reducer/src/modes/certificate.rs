//! The certificate of the modes: how many eigenvalues of (K, M) lie below a limit, by the search itself (`crate::modes::completeness`) or counted by
//! the inertia of K - μ M (Sylvester, Sturm).

use dcb_sparse::factorization::SymmetricFactor;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::model::condensation::Model;
use crate::model::rigid_body::RigidBodyModes;
use crate::modes::free_modes::FreeModes;
use crate::modes::lanczos::{Lanczos, RitzPairs};

/// Steps that a search goes on for its proof. Each damps what it hasn't found several times more, and costs much less than a count.
const FURTHER_STEPS: usize = 2;

/// How it is known that no mode is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Proof {
    /// By the inertia of K - μ M, a factorization of its own.
    #[default]
    Inertia,
    /// By the random start of the search, which would have shown any other but for a chance of 10⁻¹².
    RandomStart,
}

/// Which proofs will do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProofChoice {
    /// The search's own, and a count where it has none.
    Any,
    /// A count.
    Count,
}

/// How many eigenvalues there are below a limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModeCount {
    /// μ, (rad/time)²; absent for a part without elastic motion.
    pub limit: Option<f64>,
    /// Eigenvalues below μ, rigid motions included.
    pub counted: usize,
    /// Eigenvalues found below μ, rigid motions included.
    pub found: usize,
    /// How the first number is known; always by the inertia in files of older versions.
    #[serde(default)]
    pub proof: Proof,
}

/// Notes below which eigenvalue the search, whose first `kept` pairs became these modes, has missed none, if it can tell. `rounding` and `mass_part` as in
/// [`Lanczos::has_all_below`].
///
/// # Errors
/// Those of a step.
pub(crate) fn prove_by_search(
    modes: &mut FreeModes,
    search: &mut Lanczos<'_>,
    mut pairs: RitzPairs,
    kept: usize,
    rounding: f64,
    mass_part: f64,
) -> Result<(), Error> {
    let Some((limit, _)) = modes.certificate_shift() else {
        return Ok(());
    };
    if !(modes.first_omitted.is_finite() && rounding > 0.0) {
        return Ok(());
    }
    for further in 0..=FURTHER_STEPS {
        if search.has_all_below(&pairs, kept, limit, rounding, mass_part) {
            modes.complete_below = Some(limit);
            break;
        }
        let is_over = !search.is_of_one_start() || search.is_exhausted() || search.is_full();
        if is_over || further == FURTHER_STEPS {
            break;
        }
        search.step()?;
        modes.iterations += 1;
        pairs = search.ritz_pairs()?;
    }
    Ok(())
}

impl ModeCount {
    /// Eigenvalues below the first omitted one, beside those that were found: as the search says, or counted.
    ///
    /// # Errors
    /// Those of counting.
    pub(crate) fn of(
        model: &Model,
        rigid: &RigidBodyModes,
        modes: &FreeModes,
        factor: &mut SymmetricFactor,
        choice: ProofChoice,
    ) -> Result<Self, Error> {
        match (choice, modes.complete_below) {
            (ProofChoice::Any, Some(limit)) => {
                let found = rigid.count() + modes.count();
                Ok(Self {
                    limit: Some(limit),
                    counted: found,
                    found,
                    proof: Proof::RandomStart,
                })
            }
            _ => Self::by_inertia(model, rigid, modes, factor),
        }
    }

    /// Counts the eigenvalues below the first omitted one, beside those that were found.
    ///
    /// # Errors
    /// Those of counting.
    pub(crate) fn by_inertia(
        model: &Model,
        rigid: &RigidBodyModes,
        modes: &FreeModes,
        factor: &mut SymmetricFactor,
    ) -> Result<Self, Error> {
        let found = rigid.count() + modes.count();
        let proof = Proof::Inertia;
        let Some((limit, room)) = modes.certificate_shift() else {
            return Ok(Self {
                limit: None,
                counted: found,
                found,
                proof,
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
            proof,
        })
    }
}
