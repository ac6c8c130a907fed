//! `/reduced/mass` and `/reduced/stiffness`, over modes, attachments and further columns X.
//!
//! ```text
//!            Φ    G_res L_bᵀ          X                       Φ     G_res L_bᵀ            X
//! mass       I    0                   0          stiffness    Ω²    0                     0
//!            0    M_res               M_bx                    0     F_res                 K_bx,  K_bx = L_b X
//!            0    M_bxᵀ               M_xx                    0     K_bxᵀ                 K_xx
//! ```
//! Both are positive semi-definite, and no quotient of Rayleigh's over attachments and further columns is below the lowest ω² left out.

use faer::{Mat, MatRef};

use super::residual::{flexibilities, is_attached, may_be_cut};
use super::scaled::{larger, negative_part, reciprocal};
use super::{AGREEMENT, Identity, LOAD_LIMIT};
use crate::superelement::{Enrichment, Superelement};

/// Largest rest of a zero or of an equal entry.
const BLOCK_LIMIT: f64 = 1e-6;

const MASS: &str = "/reduced/mass";
const STIFFNESS: &str = "/reduced/stiffness";

pub(super) fn at_load(of: &Superelement) -> Vec<Identity> {
    let Some(enrichment) = &of.enrichment else {
        return Vec::new();
    };
    let sizes = Sizes::of(of, enrichment);
    let (mass, stiffness) = blocks(of, enrichment, &sizes);
    let mut all = vec![
        Identity {
            path: MASS,
            what: "its blocks are I, zero and M_res",
            defect: mass,
            limit: BLOCK_LIMIT,
        },
        Identity {
            path: STIFFNESS,
            what: "its blocks are diag(ω²), zero and F_res",
            defect: stiffness,
            limit: BLOCK_LIMIT,
        },
        Identity {
            path: MASS,
            what: "|M_kl|² ≤ M_kk M_ll (Cauchy and Schwarz)",
            defect: excess(
                enrichment.reduced_mass.as_ref(),
                &sizes.mass,
                of.mode_count(),
            ),
            limit: BLOCK_LIMIT,
        },
        Identity {
            path: STIFFNESS,
            what: "|K_kl|² ≤ K_kk K_ll (Cauchy and Schwarz)",
            defect: excess(
                enrichment.reduced_stiffness.as_ref(),
                &sizes.stiffness,
                of.mode_count(),
            ),
            limit: BLOCK_LIMIT,
        },
        quotients(of, enrichment),
    ];
    all.extend(work_at_rows(of, enrichment, &sizes));
    all
}

pub(super) fn in_full(of: &Superelement) -> Vec<Identity> {
    let Some(enrichment) = &of.enrichment else {
        return Vec::new();
    };
    let mut all = at_load(of);
    let sizes = Sizes::of(of, enrichment);
    let [masses, stiffnesses] = [&sizes.mass, &sizes.stiffness]
        .map(|sizes| -> Vec<f64> { sizes.iter().copied().map(reciprocal).collect() });
    all.push(Identity {
        path: MASS,
        what: "it is positive semi-definite (negative part)",
        defect: negative_part(enrichment.reduced_mass.as_ref(), &masses),
        limit: AGREEMENT,
    });
    all.push(Identity {
        path: STIFFNESS,
        what: "it is positive semi-definite (negative part)",
        defect: negative_part(enrichment.reduced_stiffness.as_ref(), &stiffnesses),
        limit: AGREEMENT,
    });
    let omitted = of.modes.first_omitted_eigenvalue;
    if omitted.is_finite() {
        let n_k = of.mode_count();
        let beyond = Mat::from_fn(masses.len() - n_k, masses.len() - n_k, |i, j| {
            let at = (n_k + i, n_k + j);
            enrichment.reduced_stiffness[at] - omitted * enrichment.reduced_mass[at]
        });
        all.push(Identity {
            path: STIFFNESS,
            what: "beyond the modes it is ≥ first_omitted · mass (negative part)",
            defect: negative_part(beyond.as_ref(), &stiffnesses[n_k..]),
            limit: BLOCK_LIMIT,
        });
    }
    all
}

/// How large columns are in M and in K, those of attachments with no mode kept.
struct Sizes {
    mass: Vec<f64>,
    stiffness: Vec<f64>,
}

impl Sizes {
    fn of(of: &Superelement, enrichment: &Enrichment) -> Self {
        let (n_k, n_b) = (of.mode_count(), of.rows.len());
        let own = |matrix: &Mat<f64>, k: usize| matrix[(k, k)].max(0.0);
        let flexibilities = flexibilities(of);
        let n = of.basis_count();
        let attachment = |k: usize| (n_k..n_k + n_b).contains(&k);
        Self {
            mass: (0..n)
                .map(|k| match attachment(k) {
                    true => of.residual.mass_diagonal0[k - n_k].sqrt(),
                    false => own(&enrichment.reduced_mass, k).sqrt(),
                })
                .collect(),
            stiffness: (0..n)
                .map(|k| match attachment(k) && is_attached(of, k - n_k) {
                    true => flexibilities[k - n_k].sqrt(),
                    false => own(&enrichment.reduced_stiffness, k).sqrt(),
                })
                .collect(),
        }
    }
}

/// Largest difference of the blocks of modes and attachments from what they must be.
fn blocks(of: &Superelement, enrichment: &Enrichment, sizes: &Sizes) -> (f64, f64) {
    let (n_k, n_b) = (of.mode_count(), of.rows.len());
    let highest = of.modes.eigenvalues.last().copied().unwrap_or(0.0);
    let least = f64::EPSILON * highest;
    let defect =
        |matrix: &Mat<f64>, of_modes: &dyn Fn(usize) -> f64, of_rows: &Mat<f64>, sizes: &[f64]| {
            let mut most = 0.0;
            for l in 0..sizes.len() {
                let column = matrix.col_as_slice(l);
                for (k, entry) in column.iter().enumerate() {
                    let expected = match (k < n_k, l < n_k) {
                        (true, true) if k == l => of_modes(k),
                        (true, _) | (_, true) => 0.0,
                        _ if k < n_k + n_b && l < n_k + n_b => of_rows[(k - n_k, l - n_k)],
                        _ => continue,
                    };
                    let found = (entry - expected).abs();
                    if found > 0.0 {
                        most = larger(most, found / (sizes[k] * sizes[l]));
                    }
                }
            }
            most
        };
    let mass = defect(
        &enrichment.reduced_mass,
        &|_| 1.0,
        &of.residual.mass,
        &sizes.mass,
    );
    let floored: Vec<f64> = sizes
        .stiffness
        .iter()
        .enumerate()
        .map(|(k, size)| match k < n_k {
            true => of.modes.eigenvalues[k].max(least).sqrt(),
            false => *size,
        })
        .collect();
    let stiffness = defect(
        &enrichment.reduced_stiffness,
        &|k| of.modes.eigenvalues[k],
        &of.residual.flexibility,
        &floored,
    );
    (mass, stiffness)
}

/// Largest |a_kl| − √(a_kk a_ll) beyond the modes, and of −a_kk, relative to the columns' sizes.
fn excess(matrix: MatRef<'_, f64>, sizes: &[f64], first: usize) -> f64 {
    let own: Vec<f64> = (0..sizes.len())
        .map(|k| matrix[(k, k)].max(0.0).sqrt())
        .collect();
    let mut most = 0.0;
    for l in first..sizes.len() {
        if matrix[(l, l)] < 0.0 {
            most = larger(most, -matrix[(l, l)] / sizes[l].powi(2));
        }
        for k in first..l {
            let beyond = matrix[(k, l)].abs() - own[k] * own[l];
            if beyond > 0.0 {
                most = larger(most, beyond / (sizes[k] * sizes[l]));
            }
        }
    }
    most
}

/// K_kk ≥ first_omitted · M_kk beyond the modes.
fn quotients(of: &Superelement, enrichment: &Enrichment) -> Identity {
    let omitted = of.modes.first_omitted_eigenvalue;
    let mut defect = 0.0;
    if omitted.is_finite() {
        for k in of.mode_count()..of.basis_count() {
            let least = omitted * enrichment.reduced_mass[(k, k)];
            if least > 0.0 {
                defect = larger(defect, 1.0 - enrichment.reduced_stiffness[(k, k)] / least);
            }
        }
    }
    Identity {
        path: STIFFNESS,
        what: "beyond the modes no K_kk / M_kk is below first_omitted_eigenvalue",
        defect,
        limit: LOAD_LIMIT,
    }
}

/// Connection of attachments and further columns in K: further columns at the rows, K G_res L_bᵀ = P' L_bᵀ,
/// and further columns have no share of the motions that P' takes out.
fn work_at_rows(of: &Superelement, enrichment: &Enrichment, sizes: &Sizes) -> Option<Identity> {
    if may_be_cut(of) {
        return None;
    }
    let (n_k, n_b) = (of.mode_count(), of.rows.len());
    let mut defect = 0.0;
    for (x, size) in sizes.stiffness[n_k + n_b..].iter().enumerate() {
        for row in (0..n_b).filter(|row| is_attached(of, *row)) {
            let stored = enrichment.reduced_stiffness[(n_k + row, n_k + n_b + x)];
            let found = (stored - enrichment.interface_shapes[(row, x)]).abs();
            if found > 0.0 {
                defect = larger(defect, found / (sizes.stiffness[n_k + row] * size));
            }
        }
    }
    Some(Identity {
        path: "/enrichment/interface_shapes",
        what: "L_b X is K_bx of /reduced/stiffness",
        defect,
        limit: BLOCK_LIMIT,
    })
}
