//! All bodies as one: motions that the joints allow, their stiffness, damping and rigid motions.
//!
//! ```text
//! x = Z z,   H Z = 0,   Zᵀ Z = 1 = M           Z = [rigid, loose, elastic]: K is zero over the first two
//! K = RᵀR over the elastic ones                R by QR of the roots of all stiffnesses, so that its rounding is not squared
//! ```

use dcb_dense::symmetric_eigen;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Mat, Par};
use nalgebra::Vector3;

use crate::Error;
use crate::closing::Closing;
use crate::measure::{starts, stiffness};
use crate::part::Part;

/// Pivots of the constraints below this are dependent: the joint holds what others hold already.
const DEPENDENT: f64 = 1e-10;
/// Pivots below this are nearly dependent.
const NEARLY: f64 = 1e-6;
/// Eigenvalues below this fraction of the parts' first elastic one are motions without stiffness.
const LOOSE: f64 = 1e-9;
/// A rigid motion that is held less than this, unit-free, is free.
const FREE: f64 = 1e-16;

/// Whether the whole is free or held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Support {
    Free,
    Held,
}

/// Treatment of motions without stiffness beside the rigid ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LooseMotions {
    /// The assembly is refused.
    #[default]
    Refuse,
    /// They become modes of frequency zero.
    Allow,
}

/// All bodies as one. Motions are over all coordinates, orthonormal.
pub(crate) struct Whole {
    /// (all coordinates, r).
    pub rigid: Mat<f64>,
    /// Motions without stiffness beside the rigid ones, (all coordinates, l).
    pub loose: Mat<f64>,
    /// (all coordinates, e).
    pub elastic: Mat<f64>,
    /// R, (e, e), upper triangular.
    root: Mat<f64>,
    /// ω² of the elastic modes, all of them, ascending, (e).
    pub eigenvalues: Vec<f64>,
    /// Their orthonormal shapes over the elastic motions, (e, e).
    pub shapes: Mat<f64>,
    pub support: Support,
    /// Joint rows that hold what others hold already.
    pub redundant: Vec<String>,
    /// Joint rows that nearly do.
    pub nearly_redundant: Vec<String>,
    /// Centre of mass.
    pub centre: Vector3<f64>,
}

impl Whole {
    /// # Errors
    /// [`Error::Whole`] if the assembly is held in part, or loose.
    pub fn of(
        parts: &[Part],
        closing: &Closing,
        centre: Vector3<f64>,
        loose: LooseMotions,
    ) -> Result<Self, Error> {
        let (allowed, redundant, nearly_redundant) = allowed(closing);
        let stiffness = stiffness(parts);
        let lowest = stiffness
            .iter()
            .copied()
            .filter(|square| *square > 0.0)
            .fold(f64::INFINITY, f64::min);
        let (support, rigid) = supported(parts, closing, rigid_motions(parts, centre), lowest)?;
        let elastic = &allowed * complement(&(allowed.transpose() * &rigid));
        // Motions without stiffness are told with a little stiffness for all, beside which the lowest elastic ones still stand out.
        let sprung = &closing.stiffness_root * &elastic;
        let softest = (0..sprung.ncols())
            .map(|k| sprung.col(k).squared_norm_l2())
            .fold(0.0, f64::max);
        let reference = if lowest.is_finite() { lowest } else { softest };
        let lifted = 1e-2 * LOOSE * reference;
        let root = stiffness_root(&elastic, &stiffness, closing, lifted)?;
        let (values, shapes) = modes(&root)?;
        let mut whole = Self {
            loose: Mat::zeros(elastic.nrows(), 0),
            rigid,
            elastic,
            root,
            eigenvalues: Vec::new(),
            shapes: Mat::zeros(0, 0),
            support,
            redundant,
            nearly_redundant,
            centre,
        };
        let count = values
            .iter()
            .filter(|value| **value < LOOSE * reference)
            .count();
        if count > 0 {
            let shapes = shapes.subcols(0, count).to_owned();
            if loose == LooseMotions::Refuse {
                return Err(Error::Whole(whole.loose_message(parts, &shapes)));
            }
            whole.loose = &whole.elastic * &shapes;
            whole.elastic = &whole.elastic * complement(&shapes);
        }
        whole.root = stiffness_root(&whole.elastic, &stiffness, closing, 0.0)?;
        (whole.eigenvalues, whole.shapes) = modes(&whole.root)?;
        Ok(whole)
    }

    /// K⁻¹ times columns over the elastic motions.
    pub fn solved(&self, mut columns: Mat<f64>) -> Mat<f64> {
        solve_lower_triangular_in_place(self.root.transpose(), columns.as_mut(), Par::Seq);
        solve_upper_triangular_in_place(self.root.as_ref(), columns.as_mut(), Par::Seq);
        columns
    }

    fn loose_message(&self, parts: &[Part], shapes: &Mat<f64>) -> String {
        let over = &self.elastic * shapes;
        let starts = starts(parts);
        let energy = |i: usize| -> f64 {
            (starts[i]..starts[i + 1])
                .map(|k| over[(k, 0)].powi(2))
                .sum()
        };
        let most = (0..parts.len()).max_by(|a, b| energy(*a).total_cmp(&energy(*b)));
        let name = most.map_or("?", |i| parts[i].name.as_str());
        let count = shapes.ncols();
        format!(
            "the assembly isn't one body: {count} motion(s) beside the rigid ones meet no stiffness, most of the first in {name:?}; join it, keep the mechanism apart in a scene, or allow it with --allow-loose (such motions become modes of frequency zero)"
        )
    }
}

/// ω², ascending, and orthonormal shapes of the stiffness RᵀR. They are those of the inverse, whose lowest are right to rounding whatever the highest are.
///
/// # Errors
/// [`Error::NotFinite`].
fn modes(root: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let e = root.nrows();
    let mut inverse = Mat::<f64>::identity(e, e);
    solve_lower_triangular_in_place(root.transpose(), inverse.as_mut(), Par::Seq);
    let compliance = inverse.transpose() * &inverse;
    let failed = Error::NotFinite {
        what: "the modes of the assembly",
    };
    let (values, vectors) = symmetric_eigen(compliance.as_ref()).ok_or(failed)?;
    let highest = values.last().copied().unwrap_or(1.0);
    let value = |k: usize| 1.0 / values[k].max(f64::EPSILON.powi(2) * highest);
    Ok((
        (0..e).rev().map(value).collect(),
        Mat::from_fn(e, e, |i, k| vectors[(i, e - 1 - k)]),
    ))
}

/// Orthonormal columns that complete orthonormal ones, (n, n − k).
fn complement(columns: &Mat<f64>) -> Mat<f64> {
    let (n, k) = (columns.nrows(), columns.ncols());
    if k == 0 {
        return Mat::identity(n, n);
    }
    columns.qr().compute_Q().subcols(k, n - k).to_owned()
}

/// R of K + `lifted` over some motions.
fn stiffness_root(
    motions: &Mat<f64>,
    stiffness: &[f64],
    closing: &Closing,
    lifted: f64,
) -> Result<Mat<f64>, Error> {
    let (n, e, c) = (
        motions.nrows(),
        motions.ncols(),
        closing.stiffness_root.nrows(),
    );
    let closed = &closing.stiffness_root * motions;
    // At least as many rows as columns, so that R is square.
    let stacked = Mat::from_fn(n + c + e, e, |i, j| {
        if i < n {
            stiffness[i].max(0.0).sqrt() * motions[(i, j)]
        } else if i < n + c {
            closed[(i - n, j)]
        } else if i - n - c == j {
            lifted.sqrt()
        } else {
            0.0
        }
    });
    let root = stacked.qr().thin_R().to_owned();
    match root.is_all_finite() {
        true => Ok(root),
        false => Err(Error::NotFinite {
            what: "the stiffness of the assembly",
        }),
    }
}

/// Z, and the joint rows that hold nothing more, or nearly nothing.
fn allowed(closing: &Closing) -> (Mat<f64>, Vec<String>, Vec<String>) {
    let rows = &closing.constraints;
    let n = rows.ncols();
    if rows.nrows() == 0 {
        return (Mat::identity(n, n), Vec::new(), Vec::new());
    }
    let factors = rows.transpose().col_piv_qr();
    let pivots = factors.thin_R();
    let sizes: Vec<f64> = (0..pivots.nrows().min(pivots.ncols()))
        .map(|i| pivots[(i, i)].abs())
        .collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let rank = sizes
        .iter()
        .filter(|size| **size > DEPENDENT * largest)
        .count();
    let order = factors.P().arrays().0;
    let names = |range: std::ops::Range<usize>| {
        range
            .map(|k| closing.constraint_names[order[k]].clone())
            .collect::<Vec<_>>()
    };
    let nearly = (0..rank)
        .filter(|k| sizes[*k] <= NEARLY * largest)
        .min()
        .unwrap_or(rank);
    let basis = factors.compute_Q().subcols(rank, n - rank).to_owned();
    (basis, names(rank..rows.nrows()), names(nearly..rank))
}

/// Rigid motions of unit kinetic energy about the centre, over the coordinates of all bodies, (all coordinates, r).
fn rigid_motions(parts: &[Part], centre: Vector3<f64>) -> Mat<f64> {
    let starts = starts(parts);
    let count = starts.last().copied().unwrap_or(0);
    let Some(dimension) = parts.first().map(|part| part.dimension) else {
        return Mat::zeros(0, 0);
    };
    let planar = dimension.coordinate_count() == 2;
    let motions: Vec<[f64; 6]> = (0..6)
        .filter(|k| !planar || [0, 1, 5].contains(k))
        .map(|k| std::array::from_fn(|i| f64::from(u8::from(i == k))))
        .collect();
    let mut all = Mat::zeros(count, motions.len());
    for (part, start) in parts.iter().zip(&starts) {
        for (j, motion) in motions.iter().enumerate() {
            let (shift, turn) = (
                Vector3::from_column_slice(&motion[..3]),
                Vector3::from_column_slice(&motion[3..]),
            );
            let own = shift + turn.cross(&(part.centre - centre));
            let own: [f64; 6] = [own[0], own[1], own[2], turn[0], turn[1], turn[2]];
            // R has M-orthonormal columns: amplitudes are momenta.
            for k in 0..part.rigid_count() {
                let column = part.rigid.col(k);
                let translation: f64 = (0..3).map(|a| column[a] * part.mass * own[a]).sum();
                let rotation: f64 = (0..3)
                    .map(|a| {
                        (0..3)
                            .map(|b| column[3 + a] * part.tensor[(a, b)] * own[3 + b])
                            .sum::<f64>()
                    })
                    .sum();
                all[(start + k, j)] = translation + rotation;
            }
        }
    }
    orthonormal(&all)
}

fn orthonormal(columns: &Mat<f64>) -> Mat<f64> {
    let factors = columns.qr();
    let size = |k: usize| factors.thin_R()[(k, k)].abs();
    let largest = (0..columns.ncols().min(columns.nrows()))
        .map(size)
        .fold(0.0, f64::max);
    let q = factors.compute_thin_Q();
    let kept: Vec<usize> = (0..q.ncols())
        .filter(|k| size(*k) > 1e-13 * largest)
        .collect();
    Mat::from_fn(q.nrows(), kept.len(), |i, k| q[(i, kept[k])])
}

/// Whether joints and springs hold the rigid motions: all of them, or none.
fn supported(
    parts: &[Part],
    closing: &Closing,
    rigid: Mat<f64>,
    lowest: f64,
) -> Result<(Support, Mat<f64>), Error> {
    let held = &closing.constraints * &rigid;
    let scale = if lowest.is_finite() { lowest } else { 1.0 };
    let sprung = &closing.stiffness_root * &rigid;
    let resisted =
        held.transpose() * &held + sprung.transpose() * &sprung * faer::Scale(1.0 / scale);
    let failed = Error::NotFinite {
        what: "what holds the assembly",
    };
    let (values, _) = symmetric_eigen(resisted.as_ref()).ok_or(failed)?;
    let free = values
        .iter()
        .filter(|value| **value <= FREE * parts.len() as f64)
        .count();
    if free == rigid.ncols() {
        return Ok((Support::Free, rigid));
    }
    if free == 0 {
        return Ok((Support::Held, Mat::zeros(rigid.nrows(), 0)));
    }
    Err(Error::Whole(format!(
        "the assembly is held in part: {free} of {} rigid motions are left; hold it wholly, or leave it free and hold it in a scene",
        rigid.ncols()
    )))
}
