//! F_res, M_res, the transform T_r with σ², and what of them the modes and the rows of output interfaces show.
//!
//! ```text
//! T_rᵀ M_res T_r = I      T_rᵀ F_res T_r = diag(σ²)      diag(M_res) + Σ_k s_k²/ω_k⁴ = mass_diagonal0,  s = L_b Φ
//! σ² ≥ first_omitted      F_res ≥ first_omitted · M_res ≥ 0
//! ```

use faer::Mat;

use super::scaled::{larger, negative_part};
use super::{AGREEMENT, Identity, LOAD_LIMIT};
use crate::component::Role;
use crate::superelement::Superelement;

/// T_r enlarges rounding by as much as the tolerance that it was cut at allows.
const TRANSFORM_LIMIT: f64 = 1e-4;
/// Negative eigenvalues of matrices that are Gram matrices.
const DEFINITENESS_LIMIT: f64 = 1e-8;
/// σ² below this fraction of the largest has no scale of its own.
const SMALLEST_SIGMA: f64 = 1e-12;
/// Masses of rows below this fraction of the largest of their kind are rounding.
const MASS_ROUNDING: f64 = 1e-18;

const FLEXIBILITY: &str = "/residual/flexibility";
const MASS: &str = "/residual/mass";

pub(super) fn at_load(of: &Superelement) -> Vec<Identity> {
    let residual = &of.residual;
    let transform = &residual.transform;
    let along = |matrix: &Mat<f64>, scale: &[f64], expected: &[f64]| {
        // T_rᵀ A T_r = E for one vector in place of all: two products of a matrix with a vector.
        let vector: Vec<f64> = scale
            .iter()
            .enumerate()
            .map(|(j, s)| s * irregular(j))
            .collect();
        let answer = transposed_times(transform, &times(matrix, &times(transform, &vector)));
        let defects =
            (0..vector.len()).map(|j| (answer[j] - expected[j] * vector[j]).abs() * scale[j]);
        defects.fold(0.0, larger)
    };
    let sigma = &residual.sigma_squared;
    let ones = vec![1.0; sigma.len()];
    let reciprocal = sigma_scales(sigma);
    vec![
        Identity {
            path: MASS,
            what: "T_rᵀ M_res T_r = I with /residual/transform",
            defect: along(&residual.mass, &ones, &ones),
            limit: LOAD_LIMIT,
        },
        Identity {
            path: FLEXIBILITY,
            what: "T_rᵀ F_res T_r = diag(σ²) with /residual/transform and /residual/sigma2",
            defect: along(&residual.flexibility, &reciprocal, sigma),
            limit: LOAD_LIMIT,
        },
        lowest_sigma(of),
        signs(of),
        masses_with_no_mode(of, LOAD_LIMIT),
        answers(of),
    ]
}

pub(super) fn in_full(of: &Superelement) -> Vec<Identity> {
    let residual = &of.residual;
    let transform = &residual.transform;
    let sigma = &residual.sigma_squared;
    let reciprocal = sigma_scales(sigma);
    let mass = transform.transpose() * &residual.mass * transform;
    let stiffness = transform.transpose() * &residual.flexibility * transform;
    let mut unit = 0.0;
    let mut diagonal = 0.0;
    for j in 0..sigma.len() {
        for i in 0..sigma.len() {
            let (one, square) = if i == j { (1.0, sigma[i]) } else { (0.0, 0.0) };
            unit = larger(unit, (mass[(i, j)] - one).abs());
            let defect = (stiffness[(i, j)] - square).abs() * reciprocal[i] * reciprocal[j];
            diagonal = larger(diagonal, defect);
        }
    }
    let rows = row_scales(of);
    let flexibilities: Vec<f64> = flexibilities(of)
        .into_iter()
        .zip(&rows)
        .map(|(size, row)| match *row > 0.0 && size > 0.0 {
            true => size.sqrt().recip(),
            false => 0.0,
        })
        .collect();
    let lowest = match of.modes.first_omitted_eigenvalue {
        finite if finite.is_finite() => finite,
        _ => 0.0,
    };
    let beyond = &residual.flexibility - &residual.mass * faer::Scale(lowest);
    vec![
        Identity {
            path: MASS,
            what: "T_rᵀ M_res T_r = I",
            defect: unit,
            limit: TRANSFORM_LIMIT,
        },
        Identity {
            path: FLEXIBILITY,
            what: "T_rᵀ F_res T_r = diag(σ²)",
            defect: diagonal,
            limit: TRANSFORM_LIMIT,
        },
        Identity {
            path: MASS,
            what: "M_res is positive semi-definite (negative part)",
            defect: negative_part(residual.mass.as_ref(), &rows),
            limit: DEFINITENESS_LIMIT,
        },
        Identity {
            path: FLEXIBILITY,
            what: "F_res is positive semi-definite (negative part)",
            defect: negative_part(residual.flexibility.as_ref(), &flexibilities),
            limit: DEFINITENESS_LIMIT,
        },
        Identity {
            path: FLEXIBILITY,
            what: "F_res ≥ first_omitted · M_res (negative part)",
            defect: negative_part(beyond.as_ref(), &flexibilities),
            limit: DEFINITENESS_LIMIT,
        },
        lowest_sigma(of),
        signs(of),
        masses_with_no_mode(of, AGREEMENT),
        answers(of),
    ]
}

/// 1/√diag(M_res) with no mode kept; zero for rows without, and for those of which a selection has left rounding beside the largest of
/// their kind, forces or moments. Explicit rows have each its own scale.
pub fn row_scales(of: &Superelement) -> Vec<f64> {
    let masses = &of.residual.mass_diagonal0;
    let kind = |row: usize| match of.rows[row].direction {
        0..3 => Some(0),
        direction if direction >= 3 => Some(1),
        _ => None,
    };
    let mut largest = [0.0_f64; 2];
    for (row, mass) in masses.iter().enumerate() {
        if let Some(kind) = kind(row) {
            largest[kind] = largest[kind].max(*mass);
        }
    }
    let scale = |(row, mass): (usize, &f64)| {
        let least = kind(row).map_or(0.0, |kind| MASS_ROUNDING * largest[kind]);
        match *mass > least {
            true => mass.sqrt().recip(),
            false => 0.0,
        }
    };
    masses.iter().enumerate().map(scale).collect()
}

/// diag(F_res) with no mode kept, and with what was left out of it where the file says.
pub fn flexibilities(of: &Superelement) -> Vec<f64> {
    let (modes, residual) = (&of.modes, &of.residual);
    let n_b = of.rows.len();
    let mut sums: Vec<f64> = (0..n_b)
        .map(|row| {
            let stored = residual.flexibility[(row, row)].max(0.0);
            let whole = of.moments.as_ref().map(|moments| moments.first[(row, row)]);
            stored.max(whole.unwrap_or(0.0))
        })
        .collect();
    for (k, eigenvalue) in modes.eigenvalues.iter().enumerate() {
        if *eigenvalue > 0.0 {
            let column = modes.interface_shapes.col_as_slice(k);
            for (sum, shape) in sums.iter_mut().zip(column) {
                *sum += shape * shape / eigenvalue;
            }
        }
    }
    sums
}

/// Whether some of the attachments may have been left out of `/residual`: on request, by a selection, or by a maker that doesn't say.
pub(super) fn may_be_cut(of: &Superelement) -> bool {
    let loaded = (of.moments.as_ref()).and_then(|moments| moments.loaded.as_ref());
    let by_maker = of.derivation.as_ref().is_none_or(|derivation| {
        derivation.interface_directions.is_some() || !derivation.selections.is_empty()
    });
    by_maker || loaded.is_some()
}

pub(super) fn is_attached(of: &Superelement, row: usize) -> bool {
    of.interfaces[of.rows[row].interface].role == Role::Attachment
}

/// σ⁻¹, from σ² not below rounding of the largest.
fn sigma_scales(sigma: &[f64]) -> Vec<f64> {
    let least = SMALLEST_SIGMA * sigma.last().copied().unwrap_or(0.0);
    let scale = |square: &f64| square.max(least).max(f64::MIN_POSITIVE).sqrt().recip();
    sigma.iter().map(scale).collect()
}

/// Numbers between 1/2 and 3/2 without a pattern.
fn irregular(j: usize) -> f64 {
    let golden = 0.618_033_988_749_894_9 * (j as f64 + 1.0);
    let size = 0.5 + golden.fract();
    if j.is_multiple_of(3) { -size } else { size }
}

fn times(matrix: &Mat<f64>, vector: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; matrix.nrows()];
    for (j, factor) in vector.iter().enumerate() {
        for (sum, entry) in product.iter_mut().zip(matrix.col_as_slice(j)) {
            *sum += factor * entry;
        }
    }
    product
}

fn transposed_times(matrix: &Mat<f64>, vector: &[f64]) -> Vec<f64> {
    let of_column = |j: usize| -> f64 {
        let pairs = matrix.col_as_slice(j).iter().zip(vector);
        pairs.map(|(a, b)| a * b).sum()
    };
    (0..matrix.ncols()).map(of_column).collect()
}

/// Attachments hold nothing but modes that were left out, so that no quotient of Rayleigh's is below the lowest of them.
fn lowest_sigma(of: &Superelement) -> Identity {
    let omitted = of.modes.first_omitted_eigenvalue;
    let defect = match of.residual.sigma_squared.first() {
        Some(lowest) if omitted.is_finite() && omitted > 0.0 => 1.0 - lowest / omitted,
        // Nothing was left out, but what has no mass of its own.
        _ => 0.0,
    };
    Identity {
        path: "/residual/sigma2",
        what: "no σ² is below first_omitted_eigenvalue",
        defect: defect.max(0.0),
        limit: LOAD_LIMIT,
    }
}

/// diag(F_res) ≥ first_omitted · diag(M_res) ≥ 0, relative to what the row has with no mode kept.
fn signs(of: &Superelement) -> Identity {
    let residual = &of.residual;
    let scales = row_scales(of);
    let mut defect = 0.0;
    for (row, scale) in scales.iter().enumerate().filter(|(_, scale)| **scale > 0.0) {
        let (flexibility, mass) = (residual.flexibility[(row, row)], residual.mass[(row, row)]);
        defect = larger(defect, -mass * scale * scale);
        if flexibility < 0.0 {
            defect = larger(defect, 1.0);
        }
    }
    Identity {
        path: MASS,
        what: "the diagonals of F_res and M_res are not negative",
        defect,
        limit: AGREEMENT,
    }
}

/// diag(M_res) and what the kept modes have of it.
fn masses_with_no_mode(of: &Superelement, limit: f64) -> Identity {
    let (modes, residual) = (&of.modes, &of.residual);
    let scales = row_scales(of);
    let mut sums: Vec<f64> = (0..scales.len())
        .map(|row| residual.mass[(row, row)])
        .collect();
    for (k, eigenvalue) in modes.eigenvalues.iter().enumerate() {
        if *eigenvalue > 0.0 {
            let column = modes.interface_shapes.col_as_slice(k);
            for (sum, shape) in sums.iter_mut().zip(column) {
                *sum += (shape / eigenvalue).powi(2);
            }
        }
    }
    let mut defect = 0.0;
    for (row, scale) in scales.iter().enumerate() {
        let stored = residual.mass_diagonal0[row];
        // A row without any is left out of the transform.
        if stored == 0.0
            && residual
                .transform
                .row(row)
                .iter()
                .any(|entry| *entry != 0.0)
        {
            defect = 1.0;
        }
        if is_attached(of, row) {
            defect = larger(defect, (sums[row] - stored).abs() * scale * scale);
        }
    }
    Identity {
        path: "/residual/mass_diagonal0",
        what: "diag(M_res) and the modes' share Σ (L_b φ)²/ω⁴ make diag(M_res) with no mode kept",
        defect,
        limit,
    }
}

/// Rows of attachments in `output_shapes` are those of F_res.
fn answers(of: &Superelement) -> Identity {
    let residual = &of.residual;
    let mut defect = 0.0;
    if let Some(shapes) = &residual.output_shapes {
        // What an interface reduction leaves of a row can be rounding beside the whole of it.
        let sizes: Vec<f64> = flexibilities(of).into_iter().map(f64::sqrt).collect();
        for column in (0..of.rows.len()).filter(|row| is_attached(of, *row)) {
            for row in (0..of.rows.len()).filter(|row| is_attached(of, *row)) {
                let found = (shapes[(row, column)] - residual.flexibility[(row, column)]).abs();
                if found > 0.0 {
                    defect = larger(defect, found / (sizes[row] * sizes[column]));
                }
            }
        }
    }
    Identity {
        path: "/residual/output_shapes",
        what: "rows of attachments are those of F_res",
        defect,
        limit: AGREEMENT,
    }
}
