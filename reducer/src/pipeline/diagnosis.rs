//! Defects of a component that can't be reduced as a free body, reported in the order in which an analyst would look:
//! dofs that nothing holds, a part that is still held, pieces and mechanisms, and last a mesh that doesn't belong to the
//! matrices.

use std::cmp::Ordering;

use dcb_formats::component::Component;
use dcb_sparse::block_algebra::{column_dots, symmetric_product};
use dcb_sparse::factorization::{SymmetricFactor, Unfactorized};
use faer::MatRef;

use crate::error::{BodyRefusal, Error, LISTED, Matrix, MatrixRefusal, Places, Softness};
use crate::model::condensation::Model;
use crate::model::mass_sign::{NegativeEigenvalues, diagonal};
use crate::model::piece_motions::Pieces;
use crate::model::rigid_body::{RigidBodyModes, StiffnessDefects};
use crate::model::shift::{AbsoluteForces, SpectrumScale};
use crate::modes::free_modes::ZERO_OVER_ROUNDING;
use crate::modes::lanczos::Lanczos;
use crate::pipeline::free_body::{FreeBody, Spectrum};

/// Largest max|K r| / (max row sum |K| · max|r|) of a rigid motion that is not worth a word. Double-precision exports give
/// 1e-16 to 1e-12.
pub const QUIET_TOLERANCE: f64 = 1e-10;
/// Up to here the defect may come from few printed digits or weak supports, if it is soft against the first elastic mode too.
const PRINTED_TOLERANCE: f64 = 1e-5;
/// A rigid motion's eigenvalue as a fraction of the first elastic one that is not worth a word.
const QUIET_SOFTNESS: f64 = 1e-7;
/// Share of the nodes beyond which a defect is everywhere, as digits are, rather than somewhere, as supports are.
const SPREAD: f64 = 0.5;
/// A rigid motion's eigenvalue from such a defect, as a fraction of the first elastic one, that is still harmless.
const SOFT_DEFECT: f64 = 1e-4;

/// Whether a part may be held by something outside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Grounding {
    /// Refuse: a superelement is a free body.
    #[default]
    Refuse,
    /// Reduce it as it is, without rigid motions; the file's frame is `given`.
    Allow,
}

/// Whether a part may have motions without stiffness other than the rigid ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum LoosePieces {
    /// Refuse.
    #[default]
    Refuse,
    /// Keep them as modes of eigenvalue zero.
    Allow,
}

/// How a part stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Free: every rigid motion costs nothing.
    Free,
    /// Held.
    Grounded,
}

/// Refuses what shows in single rows: dofs without stiffness, negative diagonals.
///
/// # Errors
/// [`Error::Matrix`] and [`Error::Body`] with the dofs listed.
pub fn check_rows(component: &Component) -> Result<(), Error> {
    let name = |row: usize| component.dofs.row_name(row);
    let (stiffness, mass) = (diagonal(&component.stiffness), diagonal(&component.mass));
    let tolerated = NegativeEigenvalues::of_diagonals(&stiffness, &mass);
    for (entries, which) in [(&stiffness, Matrix::Stiffness), (&mass, Matrix::Mass)] {
        let limit = |row: usize| match which {
            Matrix::Stiffness => 0.0,
            Matrix::Mass => tolerated.at(stiffness[row]),
        };
        let negative: Vec<usize> = (0..entries.len())
            .filter(|row| entries[*row] < 0.0 && entries[*row] < -limit(*row))
            .collect();
        if let Some(first) = negative.first() {
            return Err(MatrixRefusal::NegativeDiagonal {
                matrix: which,
                count: negative.len(),
                value: entries[*first],
                place: name(*first),
            }
            .into());
        }
    }
    let orphans: Vec<usize> = (0..component.dofs.len())
        .filter(|row| {
            component
                .stiffness
                .val_of_col(*row)
                .iter()
                .all(|value| *value == 0.0)
        })
        .collect();
    if !orphans.is_empty() {
        return Err(BodyRefusal::NoStiffness {
            count: orphans.len(),
            places: Places::of(orphans.iter().map(|row| name(*row))),
        }
        .into());
    }
    let multipliers: Vec<usize> = (0..component.dofs.len())
        .filter(|row| stiffness[*row] == 0.0)
        .collect();
    if !multipliers.is_empty() {
        return Err(MatrixRefusal::Multipliers {
            count: multipliers.len(),
            places: Places::of(multipliers.iter().map(|row| name(*row))),
        }
        .into());
    }
    Ok(())
}

/// Supports of a component, judged by K r for the geometric rigid motions, and what to say otherwise. Also returns a warning
/// where the defect is larger than rounding but harmless.
///
/// # Errors
/// [`Error::Body`]: held, in pieces, or the mesh does not belong to the matrices.
pub(crate) fn support(
    body: &FreeBody<'_>,
    spectrum: &Spectrum,
    factor: &mut SymmetricFactor,
    grounding: Grounding,
) -> Result<(Support, Option<String>), Error> {
    let FreeBody { model, rigid, .. } = body;
    if rigid.stiffness_precision <= f64::EPSILON {
        return Ok((Support::Free, None));
    }
    let resistance = Resistance::of(model, rigid, spectrum);
    if resistance.is_small() && resistance.softness.ratio <= SOFT_DEFECT {
        return Ok((Support::Free, resistance.warning()));
    }
    if resistance.is_small() && resistance.is_spread() {
        return Err(resistance.few_digits().into());
    }
    let free = nullity(model, rigid, &spectrum.scale, factor)?;
    match (free.cmp(&rigid.count()), grounding) {
        (Ordering::Greater, _) => {
            let extra = free - rigid.count();
            Err(loose(model, &spectrum.pieces, extra, None))
        }
        (Ordering::Less, Grounding::Allow) => Ok((Support::Grounded, None)),
        (Ordering::Less, Grounding::Refuse) => Err(resistance.held(free, rigid.count()).into()),
        (Ordering::Equal, _) if !resistance.is_small() => Err(resistance.foreign_mesh(free).into()),
        (Ordering::Equal, Grounding::Allow) => Ok((Support::Grounded, None)),
        (Ordering::Equal, Grounding::Refuse) => Err(resistance.held_weakly().into()),
    }
}

/// How rigid motions r are resisted.
struct Resistance {
    /// max|K r| / (max row sum |K| · max|r|).
    force: f64,
    softness: Softness,
    /// Where it is largest.
    places: Places,
    /// Dofs above a thousandth of the largest.
    dofs: usize,
    /// Nodes and frames of these dofs, and all that there are.
    points: usize,
    all_points: usize,
}

impl Resistance {
    fn of(model: &Model, rigid: &RigidBodyModes, spectrum: &Spectrum) -> Self {
        let forces = symmetric_product(&model.stiffness, rigid.shapes.as_ref());
        let stiffest = column_dots(rigid.shapes.as_ref(), forces.as_ref())
            .into_iter()
            .fold(0.0, |largest, energy| f64::max(largest, energy.abs()));
        let resisting = resisting_dofs(&spectrum.defects);
        let distinct = |dofs: &mut dyn Iterator<Item = usize>| {
            let of_nodes = dofs.filter(|dof| !model.is_internal(*dof));
            let mut points: Vec<u32> = of_nodes.map(|dof| model.dofs[dof].point).collect();
            points.sort_unstable();
            points.dedup();
            points.len()
        };
        let worst = resisting.iter().take(LISTED);
        Self {
            force: spectrum.defects.largest(),
            softness: Softness {
                ratio: stiffest / spectrum.scale.first_elastic,
                limit: SOFT_DEFECT,
            },
            places: Places::of(worst.map(|dof| model.dof_name(*dof))),
            dofs: resisting.len(),
            points: distinct(&mut resisting.iter().copied()),
            all_points: distinct(&mut (0..model.len())),
        }
    }

    /// Whether it may come from few printed digits or weak supports.
    fn is_small(&self) -> bool {
        self.force <= PRINTED_TOLERANCE
    }

    fn is_spread(&self) -> bool {
        self.points as f64 > SPREAD * self.all_points as f64
    }

    /// Message for a harmless one.
    fn warning(&self) -> Option<String> {
        let (largest, softness) = (self.force, self.softness.ratio);
        (largest > QUIET_TOLERANCE || softness > QUIET_SOFTNESS).then(|| match self.is_spread() {
            true => format!(
                "K times a rigid motion is {largest:.1e} of K's row sum (rounding would be below 1e-14): the matrices were probably printed with few digits, and frequencies are no better than that allows; export at least 15"
            ),
            false => format!(
                "rigid motions are resisted a little ({softness:.1e} of the first elastic eigenvalue) at {}: a weak support?",
                self.places
            ),
        })
    }

    fn few_digits(self) -> BodyRefusal {
        BodyRefusal::FewDigits {
            force: self.force,
            nodes: self.points,
            all_nodes: self.all_points,
            softness: self.softness,
        }
    }

    fn held(self, free: usize, expected: usize) -> BodyRefusal {
        BodyRefusal::Held {
            free,
            expected,
            places: self.places,
            dofs: self.dofs,
        }
    }

    fn held_weakly(self) -> BodyRefusal {
        BodyRefusal::HeldWeakly {
            places: self.places,
            force: self.force,
            softness: self.softness,
        }
    }

    fn foreign_mesh(self, motions: usize) -> BodyRefusal {
        BodyRefusal::ForeignMesh {
            motions,
            force: self.force,
            tolerance: QUIET_TOLERANCE,
            places: self.places,
        }
    }
}

/// Dofs at which rigid motions are resisted, strongest first, down to a thousandth of the strongest.
fn resisting_dofs(defects: &StiffnessDefects) -> Vec<usize> {
    let strength = |i: usize| {
        (0..defects.forces.ncols())
            .map(|j| defects.forces[(i, j)].abs())
            .fold(0.0, f64::max)
    };
    let mut dofs: Vec<(usize, f64)> = (0..defects.forces.nrows())
        .map(|i| (i, strength(i)))
        .collect();
    dofs.sort_by(|a, b| b.1.total_cmp(&a.1));
    let strongest = dofs.first().map_or(0.0, |(_, s)| *s);
    dofs.into_iter()
        .take_while(|(_, s)| *s > 1e-3 * strongest)
        .map(|(dof, _)| dof)
        .collect()
}

/// Number of motions without energy, found numerically and without the geometry's help.
fn nullity(
    model: &Model,
    rigid: &RigidBodyModes,
    scale: &SpectrumScale,
    factor: &mut SymmetricFactor,
) -> Result<usize, Error> {
    let shift = scale.shift();
    let free = rigid.none();
    let positive = match factor.factorize(&model.stiffness, &model.mass, shift) {
        Ok(positive) => positive,
        Err(why) => return Err(unfactorized(model, scale, factor, why)),
    };
    let block = 16.min(model.len());
    let mut lanczos = Lanczos::start(model, &free, &positive, shift, block, 6 * block, 0x5eed)?;
    for _ in 0..5 {
        if !lanczos.is_exhausted() && !lanczos.is_full() {
            lanczos.step()?;
        }
    }
    let pairs = lanczos.ritz_pairs()?;
    let candidates = pairs.eigenvalues.len().min(3 * block);
    let vectors = lanczos.polish(lanczos.ritz_vectors(&pairs, candidates).as_ref())?;
    let forces = symmetric_product(&model.stiffness, vectors.as_ref());
    let absolute = AbsoluteForces::of(&model.stiffness, vectors.as_ref()).energies;
    let energies = column_dots(vectors.as_ref(), forces.as_ref());
    let is_zero = |j: &usize| energies[*j] < ZERO_OVER_ROUNDING * f64::EPSILON * absolute[*j];
    Ok((0..candidates).filter(is_zero).count())
}

/// The refusal of motions without energy beyond the rigid ones; `shapes` are such motions where they are known.
pub(crate) fn loose(
    model: &Model,
    pieces: &Pieces,
    extra: usize,
    shapes: Option<MatRef<'_, f64>>,
) -> Error {
    if let Err(refusal) = pieces.refuse_several() {
        return refusal.into();
    }
    let moving = shapes.map(|shapes| {
        let strength = |i: usize| {
            (0..shapes.ncols())
                .map(|j| shapes[(i, j)].abs())
                .fold(0.0, f64::max)
        };
        let mut dofs: Vec<usize> = (0..shapes.nrows()).collect();
        dofs.sort_by(|a, b| strength(*b).total_cmp(&strength(*a)));
        let most = dofs.into_iter().take(LISTED);
        Places::of(most.map(|dof| model.dof_name(dof)))
    });
    BodyRefusal::Mechanism {
        motions: extra,
        moving,
    }
    .into()
}

/// Why K + σ M has no factor.
pub fn unfactorized(
    model: &Model,
    scale: &SpectrumScale,
    factor: &mut SymmetricFactor,
    why: Unfactorized,
) -> Error {
    match why {
        Unfactorized::NotPositive => indefinite(model, scale, factor),
        Unfactorized::Failed(error) => error.into(),
    }
}

/// The message for a stiffness matrix that K + σ M can't make positive.
pub fn indefinite(model: &Model, scale: &SpectrumScale, factor: &mut SymmetricFactor) -> Error {
    let shift = scale.shift();
    let inertia = match factor.inertia(&model.stiffness, &model.mass, -shift) {
        Ok(inertia) => inertia,
        Err(error) => return error.into(),
    };
    let places = inertia.negative_dofs.iter();
    MatrixRefusal::NegativePivots {
        shift,
        pivots: inertia.negative.max(1),
        places: Places::of(places.map(|dof| model.dof_name(*dof))),
        internal_rows: (0..model.len())
            .filter(|dof| model.is_internal(*dof))
            .count(),
    }
    .into()
}
