//! What is added to K so that it has a factor: springs of a statically determinate support, or a small part of the mass.
//!
//! A free body on a statically determinate support moves under balanced forces as it does without: equilibrium leaves nothing for the
//! springs to carry, however stiff they are. So `(K + P)⁻¹` is an inverse of K for balanced forces, exactly, up to a rigid motion, which
//! is projected out (the flexibility of a free body with temporary constraints, Felippa et al. 1998). A shift `σ M` leaves `σ/ω²` of a
//! solution instead. It is for bodies with further motions that have no stiffness: `K + P` is singular then, `K + σ M` isn't.

use dcb_formats::SparseMatrix;
use dcb_formats::mesh::Direction;
use dcb_sparse::factorization::{PositiveFactor, SymmetricFactor, Unfactorized};
use faer::sparse::Triplet;
use rayon::prelude::*;

use crate::model::condensation::Model;
use crate::model::mass_sign::diagonal;
use crate::model::rigid_body::RigidBodyModes;
use crate::model::shift::SpectrumScale;

/// As many as a body has rigid motions in space.
const DIRECTIONS: usize = Direction::ALL.len();
/// A support is refused if a spring would stop less than this part of the motion that the first one does.
const LEAST_HOLD: f64 = 1e-3;
/// Springs are of no use where rounding in K reaches this part of the first elastic eigenvalue.
const LARGEST_ROUNDING: f64 = 1e-2;

/// K + P on springs, or K + σ M.
pub enum Regularization {
    /// P, diagonal, with a spring for each rigid motion.
    Supports(SparseMatrix),
    /// σ, ω² in 1/time².
    Shift(f64),
}

impl Regularization {
    /// Springs for the rigid motions of a body that has no other motion without stiffness; a shift where there is no place for them.
    pub fn by_supports(model: &Model, rigid: &RigidBodyModes, scale: &SpectrumScale) -> Self {
        let is_clear = scale.shift_floor <= LARGEST_ROUNDING * scale.first_elastic;
        let springs = match is_clear {
            true => springs(model, rigid, scale.first_elastic),
            false => None,
        };
        let n = model.len();
        match springs.and_then(|springs| SparseMatrix::try_new_from_triplets(n, n, &springs).ok()) {
            Some(supports) => Self::Supports(supports),
            None => Self::by_shift(scale),
        }
    }

    /// A shift.
    pub fn by_shift(scale: &SpectrumScale) -> Self {
        Self::Shift(scale.shift())
    }

    /// That with which stored moments were made, by their σ; a shift where there are none: nothing tells then that no further motion is
    /// without stiffness.
    pub fn of_moments(
        shift: Option<f64>,
        model: &Model,
        rigid: &RigidBodyModes,
        scale: &SpectrumScale,
    ) -> Self {
        match shift == Some(0.0) {
            true => Self::by_supports(model, rigid, scale),
            false => Self::by_shift(scale),
        }
    }

    /// Whether balanced forces are answered as by K alone.
    pub fn is_exact(&self) -> bool {
        matches!(self, Self::Supports(_))
    }

    /// σ; 0 on springs.
    pub fn shift(&self) -> f64 {
        match self {
            Self::Supports(_) => 0.0,
            Self::Shift(shift) => *shift,
        }
    }

    /// The factor of the regular matrix.
    ///
    /// # Errors
    /// [`Unfactorized`]: not positive definite, or no room.
    pub fn factorize<'a>(
        &'a self,
        model: &'a Model<'_>,
        factor: &'a mut SymmetricFactor,
    ) -> Result<PositiveFactor<'a>, Unfactorized> {
        let (added, times) = match self {
            Self::Supports(springs) => (springs, 1.0),
            Self::Shift(shift) => (&*model.mass, *shift),
        };
        factor.factorize(&model.stiffness, added, times)
    }
}

/// Springs at the dofs that hold the rigid motions best: the one that moves most in any of them, then the one that moves most in those that
/// are left, and so on. A body on them has rigid motions near the given ω². `None` if some motion isn't held.
fn springs(
    model: &Model,
    rigid: &RigidBodyModes,
    eigenvalue: f64,
) -> Option<Vec<Triplet<u32, u32, f64>>> {
    let amounts = model.unit_amounts(rigid.length);
    let places = stiff_dofs(model);
    // Parts of six rigid motions at most; a body that has fewer has zeros beyond.
    let row = |dof: &usize| -> [f64; DIRECTIONS] {
        std::array::from_fn(|motion| match motion < rigid.count() {
            true => rigid.shapes[(*dof, motion)] / amounts[*dof],
            false => 0.0,
        })
    };
    let mut rows: Vec<[f64; DIRECTIONS]> = places.par_iter().map(row).collect();
    let square = |row: &[f64; DIRECTIONS]| row.iter().map(|x| x * x).sum::<f64>();
    let mut springs = Vec::with_capacity(rigid.count());
    let mut first = 0.0;
    for _ in 0..rigid.count() {
        let sizes = rows.par_iter().map(square).enumerate();
        let (largest, size) = sizes.max_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))?;
        if springs.is_empty() {
            first = size;
        }
        if size.is_nan() || size <= LEAST_HOLD * LEAST_HOLD * first {
            return None;
        }
        let dof = places[largest];
        let stiffness = eigenvalue / size / (amounts[dof] * amounts[dof]);
        springs.push(Triplet::new(dof as u32, dof as u32, stiffness));
        let held = rows[largest].map(|x| x / size.sqrt());
        rows.par_iter_mut().for_each(|row| {
            let along: f64 = row.iter().zip(&held).map(|(x, h)| x * h).sum();
            for (x, h) in row.iter_mut().zip(&held) {
                *x -= along * h;
            }
        });
    }
    Some(springs)
}

/// The stiffer half of the dofs of each direction: a support on a soft one would hardly hold the rest.
fn stiff_dofs(model: &Model) -> Vec<usize> {
    let stiffness = diagonal(&model.stiffness);
    let mut directions: [Vec<usize>; DIRECTIONS] = Default::default();
    for (dof, of) in model.dofs.iter().enumerate() {
        if let Some(motion) = of.motion {
            directions[motion.direction.index()].push(dof);
        }
    }
    let stiffer_half = |mut places: Vec<usize>| {
        let stiffer = |a: &usize, b: &usize| stiffness[*b].total_cmp(&stiffness[*a]);
        places.par_sort_unstable_by(|a, b| stiffer(a, b).then(a.cmp(b)));
        places.truncate(places.len().div_ceil(2));
        places
    };
    directions.into_iter().flat_map(stiffer_half).collect()
}
