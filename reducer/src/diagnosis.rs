//! What is wrong with a component that can't be reduced as a free body, said in the order in which an analyst would look:
//! dofs that nothing holds, a part that is still held, pieces and mechanisms, and last a mesh that doesn't belong to the
//! matrices.

use dcb_formats::component::Component;
use dcb_sparse::block_algebra::{column_dots, symmetric_product};
use dcb_sparse::factorization::{SymmetricFactor, Unfactorized};
use faer::Mat;

use crate::condensation::Model;
use crate::error::{
    BodyRefusal, Error, LISTED, Matrix, MatrixRefusal, PieceSize, Places, Softness,
};
use crate::free_modes::ZERO_OVER_ROUNDING;
use crate::lanczos::Lanczos;
use crate::rigid_body::{RigidBodyModes, StiffnessDefects};
use crate::shift::{AbsoluteForces, SpectrumScale};

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
    let name = |row: usize| {
        let dof = component.dofs.dofs()[row];
        format!("node {} {}", dof.node, dof.direction.name())
    };
    for (matrix, which) in [
        (&component.stiffness, Matrix::Stiffness),
        (&component.mass, Matrix::Mass),
    ] {
        let negative: Vec<usize> = (0..matrix.ncols())
            .filter(|row| {
                matrix
                    .as_ref()
                    .get(*row, *row)
                    .is_some_and(|value| *value < 0.0)
            })
            .collect();
        if let Some(first) = negative.first() {
            let value = matrix.as_ref().get(*first, *first).copied().unwrap_or(0.0);
            return Err(MatrixRefusal::NegativeDiagonal {
                matrix: which,
                count: negative.len(),
                value,
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
    Ok(())
}

/// Sets of model points that the stiffness matrix connects, largest first.
pub fn pieces(model: &Model) -> Vec<Vec<u32>> {
    let points = model.points();
    let count = points
        .iter()
        .map(|point| *point as usize + 1)
        .max()
        .unwrap_or(0);
    let mut parent: Vec<u32> = (0..count as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    for column in 0..model.len() {
        let rows = model
            .stiffness
            .row_idx_of_col_raw(column)
            .iter()
            .zip(model.stiffness.val_of_col(column));
        for (row, _) in rows.filter(|(_, value)| **value != 0.0) {
            let (a, b) = (
                root(&mut parent, points[*row as usize]),
                root(&mut parent, points[column]),
            );
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut by_root: std::collections::BTreeMap<u32, Vec<u32>> = Default::default();
    let mut distinct = points;
    distinct.sort_unstable();
    distinct.dedup();
    for point in distinct {
        by_root
            .entry(root(&mut parent, point))
            .or_default()
            .push(point);
    }
    let mut pieces: Vec<Vec<u32>> = by_root.into_values().collect();
    pieces.sort_by_key(|piece| std::cmp::Reverse(piece.len()));
    pieces
}

/// What a part stands on, judged by K r for the geometric rigid motions, and what to say otherwise. Also returns a warning
/// where the defect is larger than rounding but harmless.
///
/// # Errors
/// [`Error::Body`]: held, in pieces, or the mesh does not belong to the matrices.
pub fn support(
    model: &Model,
    rigid: &RigidBodyModes,
    defects: &StiffnessDefects,
    scale: &SpectrumScale,
    factor: &mut SymmetricFactor,
    grounding: Grounding,
) -> Result<(Support, Option<String>), Error> {
    if rigid.stiffness_precision <= f64::EPSILON {
        return Ok((Support::Free, None));
    }
    let largest = defects.largest();
    let forces = symmetric_product(&model.stiffness, rigid.shapes.as_ref());
    let stiffest = column_dots(rigid.shapes.as_ref(), forces.as_ref())
        .into_iter()
        .fold(0.0, |largest, energy| f64::max(largest, energy.abs()));
    let softness = stiffest / scale.first_elastic;
    let resisting = resisting_dofs(defects);
    let mut resisting_points: Vec<u32> =
        resisting.iter().map(|dof| model.dofs[*dof].point).collect();
    resisting_points.sort_unstable();
    resisting_points.dedup();
    let mut points = model.points();
    points.sort_unstable();
    points.dedup();
    let is_spread = resisting_points.len() as f64 > SPREAD * points.len() as f64;
    let worst = resisting.iter().take(LISTED);
    let places = Places::of(worst.map(|dof| model.dof_name(*dof)));
    if largest <= PRINTED_TOLERANCE && softness <= SOFT_DEFECT {
        let warning = (largest > QUIET_TOLERANCE || softness > QUIET_SOFTNESS).then(|| match is_spread {
            true => format!(
                "K times a rigid motion is {largest:.1e} of K's row sum (rounding would be below 1e-14): the matrices were probably printed with few digits, and frequencies are no better than that allows; export at least 15"
            ),
            false => format!(
                "rigid motions are resisted a little ({softness:.1e} of the first elastic eigenvalue) at {places}: a weak support?"
            ),
        });
        return Ok((Support::Free, warning));
    }
    let softness = Softness {
        ratio: softness,
        limit: SOFT_DEFECT,
    };
    if is_spread && largest <= PRINTED_TOLERANCE {
        return Err(BodyRefusal::FewDigits {
            force: largest,
            nodes: resisting_points.len(),
            all_nodes: points.len(),
            softness,
        }
        .into());
    }
    let nullity = nullity(model, rigid, scale, factor)?;
    let expected = rigid.count();
    if nullity < expected {
        if grounding == Grounding::Allow {
            return Ok((Support::Grounded, None));
        }
        return Err(BodyRefusal::Held {
            free: nullity,
            expected,
            places,
            dofs: resisting.len(),
        }
        .into());
    }
    if nullity > expected {
        return Err(loose(model, nullity - expected, None));
    }
    if largest <= PRINTED_TOLERANCE && grounding == Grounding::Allow {
        return Ok((Support::Grounded, None));
    }
    if largest <= PRINTED_TOLERANCE {
        return Err(BodyRefusal::HeldWeakly {
            places,
            force: largest,
            softness,
        }
        .into());
    }
    Err(BodyRefusal::ForeignMesh {
        motions: nullity,
        force: largest,
        tolerance: QUIET_TOLERANCE,
        places,
    }
    .into())
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
    let vectors = lanczos.polish(lanczos.ritz_vectors(&pairs, candidates).as_ref());
    let forces = symmetric_product(&model.stiffness, vectors.as_ref());
    let absolute = AbsoluteForces::of(&model.stiffness, vectors.as_ref()).energies;
    let energies = column_dots(vectors.as_ref(), forces.as_ref());
    let is_zero = |j: &usize| energies[*j] < ZERO_OVER_ROUNDING * f64::EPSILON * absolute[*j];
    Ok((0..candidates).filter(is_zero).count())
}

/// The message for motions without energy beyond the rigid ones; `shapes` are such motions where they are known.
pub fn loose(model: &Model, extra: usize, shapes: Option<&Mat<f64>>) -> Error {
    let pieces = pieces(model);
    if pieces.len() > 1 {
        let pieces = pieces.iter().map(|piece| PieceSize {
            nodes: piece.len(),
            first_node: piece.first().copied().unwrap_or(0),
        });
        return BodyRefusal::InPieces {
            pieces: pieces.collect(),
        }
        .into();
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
        Unfactorized::NotPositive { .. } => indefinite(model, scale, factor),
        Unfactorized::NoRoom(error) => error.into(),
    }
}

/// The message for a stiffness matrix that K + σ M can't make positive.
pub fn indefinite(model: &Model, scale: &SpectrumScale, factor: &mut SymmetricFactor) -> Error {
    let shift = scale.shift();
    let inertia = factor.inertia(&model.stiffness, &model.mass, -shift);
    let places = inertia.negative_dofs.iter();
    MatrixRefusal::NegativePivots {
        shift,
        pivots: inertia.negative.max(1),
        places: Places::of(places.map(|dof| model.dof_name(*dof))),
    }
    .into()
}
