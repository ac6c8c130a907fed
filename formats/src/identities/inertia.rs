//! L1, I3, I1, L3 and I2 by Cauchy and Schwarz, and the trace of I2.
//!
//! With Ω_a ψ = e_a × ψ and the inner product of M, these are products of known columns: L1 of rigid translations with ψ, I3 of rigid
//! rotations with ψ, I1 of rigid rotations with Ω_a ψ, L3 of Ω_a ψ with ψ, I2 of Ω_a ψ with Ω_b ψ. No product exceeds that of the norms
//! √m, √J_aa, √I2_aa,kk and √M_kk, however M was lumped and whether nodes have rotations or not.

use super::scaled::{larger, norms, reciprocals};
use super::{AGREEMENT, Identity, LOAD_LIMIT};
use crate::mesh::Dimension;
use crate::superelement::{CouplingSource, FrameKind, Superelement};

/// How much more than its mass a column may have in I2 where the mass of nodal rotations was left out of it: 6 for elements with cubic
/// shapes, whose rotations can take back as much of the motion between nodes.
const NODAL_EXCESS: f64 = 8.0;

/// Largest rest of a trace: attachments hold up to 2e-9 of the kept modes.
const TRACE_LIMIT: f64 = 1e-6;

pub(super) fn at_load(of: &Superelement) -> Vec<Identity> {
    let mut all = vec![tensor(of)];
    if of.frame_kind == FrameKind::Given {
        all.extend(momentum(of));
    }
    match of.dimension {
        Dimension::Planar => all.extend(planar(of)),
        Dimension::Spatial => all.extend(spatial(of)),
    }
    all
}

pub(super) fn in_full(of: &Superelement) -> Vec<Identity> {
    let mut all = at_load(of);
    if of.frame_kind == FrameKind::MeanAxis {
        all.extend(mean_axes(of));
    }
    all
}

/// Norms of the columns that no rounding is measured by: attachments count with no mode kept.
pub(super) fn whole_norms(of: &Superelement) -> Vec<f64> {
    let n_k = of.mode_count();
    let mut sizes = norms(of);
    for (size, mass) in sizes[n_k..].iter_mut().zip(&of.residual.mass_diagonal0) {
        *size = mass.sqrt().max(*size);
    }
    sizes
}

/// Second moments ∫ρ r_a r_b are a Gram matrix: ½ tr(J) δ_ab − J_ab.
fn tensor(of: &Superelement) -> Identity {
    let j = &of.inertia.tensor;
    let half = match of.dimension {
        Dimension::Planar => return positive_moment(j[2][2]),
        Dimension::Spatial => 0.5 * (j[0][0] + j[1][1] + j[2][2]),
    };
    let p = |a: usize, b: usize| (if a == b { half } else { 0.0 }) - j[a][b];
    let mut defect = if half > 0.0 { 0.0 } else { f64::INFINITY };
    for a in 0..3 {
        let b = (a + 1) % 3;
        defect = larger(defect, -p(a, a) / half);
        defect = larger(
            defect,
            -(p(a, a) * p(b, b) - p(a, b) * p(b, a)) / (half * half),
        );
    }
    let minor = |a: usize, b: usize| p(1, a) * p(2, b) - p(1, b) * p(2, a);
    let determinant = p(0, 0) * minor(1, 2) - p(0, 1) * minor(0, 2) + p(0, 2) * minor(0, 1);
    Identity {
        path: "/inertia/tensor",
        what: "the inertia tensor is that of a body: no second moment is negative",
        defect: larger(defect, -determinant / half.powi(3)),
        limit: AGREEMENT,
    }
}

fn positive_moment(moment: f64) -> Identity {
    Identity {
        path: "/inertia/tensor",
        what: "it is not negative",
        defect: (-moment).max(0.0),
        limit: 0.0,
    }
}

/// |L1_ak|² ≤ m M_kk and |I3_ak|² ≤ J_aa M_kk.
fn momentum(of: &Superelement) -> [Identity; 2] {
    let (l1, i3) = cosines(of, &norms(of));
    [
        Identity {
            path: "/inertia/L1",
            what: "|L1_ak|² ≤ m M_kk (Cauchy and Schwarz)",
            defect: l1 - 1.0,
            limit: LOAD_LIMIT,
        },
        Identity {
            path: "/inertia/I3",
            what: "|I3_ak|² ≤ J_aa M_kk (Cauchy and Schwarz)",
            defect: i3 - 1.0,
            limit: LOAD_LIMIT,
        },
    ]
}

/// L1 = 0 and I3 = 0.
fn mean_axes(of: &Superelement) -> [Identity; 2] {
    let (l1, i3) = cosines(of, &whole_norms(of));
    [
        Identity {
            path: "/inertia/L1",
            what: "L1 Ψ = 0 (Eq. 39)",
            defect: l1,
            limit: AGREEMENT,
        },
        Identity {
            path: "/inertia/I3",
            what: "I3 Ψ = 0 (Eq. 40)",
            defect: i3,
            limit: AGREEMENT,
        },
    ]
}

/// Largest cosines between rigid translations and rotations and a column.
fn cosines(of: &Superelement, norms: &[f64]) -> (f64, f64) {
    let inertia = &of.inertia;
    let largest = (0..3).fold(0.0_f64, |most, a| most.max(inertia.tensor[a][a]));
    let of_rows = |rows: &faer::Mat<f64>, size: f64| {
        let mut most = 0.0;
        for (k, norm) in norms.iter().enumerate() {
            for entry in rows.col_as_slice(k) {
                if *entry != 0.0 {
                    most = larger(most, entry.abs() / (size.sqrt() * norm));
                }
            }
        }
        most
    };
    (
        of_rows(&inertia.l1, inertia.mass),
        of_rows(&inertia.i3, largest),
    )
}

/// Whether the modes have mass in rows that L3 and I2 know nothing of: what the nodes have of it may then be any multiple of the whole, and
/// the last bound, which compares the two, isn't one.
fn has_internal_rows(of: &Superelement) -> bool {
    let derivation = of.derivation.as_ref();
    let is_nodal = of.coupling_source() != CouplingSource::Integrals;
    is_nodal && derivation.is_some_and(|derivation| derivation.internal_rows > 0)
}

/// |I1_k|² ≤ I_z M_kk and |L3_kl|² ≤ M_kk M_ll.
fn planar(of: &Superelement) -> Vec<Identity> {
    let sizes = whole_norms(of);
    let reciprocal = reciprocals(&sizes);
    let allowed = match of.coupling_source() {
        CouplingSource::Integrals => 1.0,
        CouplingSource::Nodal | CouplingSource::Unknown => NODAL_EXCESS.sqrt(),
    };
    let moment = of.inertia.tensor[2][2].max(0.0).sqrt();
    let mut first = 0.0;
    for (block, reciprocal) in of.inertia.i1.iter().zip(&reciprocal) {
        let found = block[2][2].abs() * reciprocal;
        if found > 0.0 {
            first = larger(first, found / moment - 1.0);
        }
    }
    let mut coupling = 0.0_f64;
    for layer in &of.inertia.l3 {
        for (l, of_column) in reciprocal.iter().enumerate() {
            let pairs = layer.col_as_slice(l).iter().zip(&reciprocal);
            let most = pairs
                .map(|(entry, of_row)| entry.abs() * of_row)
                .fold(0.0, f64::max);
            coupling = coupling.max(most * of_column);
        }
    }
    let mut all = vec![
        Identity {
            path: "/inertia/I1",
            what: "|I1_k|² ≤ I_z M_kk (Cauchy and Schwarz)",
            defect: first,
            limit: LOAD_LIMIT,
        },
        Identity {
            path: "/inertia/L3",
            what: "|L3_kl|² ≤ M_kk M_ll (Cauchy and Schwarz)",
            defect: coupling / allowed - 1.0,
            limit: LOAD_LIMIT,
        },
    ];
    if has_internal_rows(of) {
        all.pop();
    }
    all
}

fn spatial(of: &Superelement) -> Vec<Identity> {
    let inertia = &of.inertia;
    let sizes = whole_norms(of);
    let reciprocal = reciprocals(&sizes);
    // √I2_aa,kk over the norm of the column.
    let mut negative = 0.0;
    let arms: [Vec<f64>; 3] = std::array::from_fn(|a| {
        let of_column = |(k, reciprocal): (usize, &f64)| {
            let square = inertia.i2[a][(k, k)] * reciprocal * reciprocal;
            negative = larger(negative, -square);
            square.max(0.0).sqrt()
        };
        reciprocal.iter().enumerate().map(of_column).collect()
    });
    let own: Vec<f64> = norms(of)
        .iter()
        .zip(&reciprocal)
        .map(|(own, whole)| own * whole)
        .collect();
    let mut second = 0.0_f64;
    for (pair, (a, b)) in PAIRS.iter().enumerate() {
        second = second.max(beyond(&inertia.i2[pair], &arms[*a], &arms[*b], &reciprocal));
    }
    let mut coupling = 0.0_f64;
    for (a, layer) in inertia.l3.iter().enumerate() {
        coupling = coupling.max(beyond(layer, &arms[a], &own, &reciprocal));
    }
    let moments: [f64; 3] = std::array::from_fn(|a| inertia.tensor[a][a].max(0.0).sqrt());
    let size = moments
        .iter()
        .fold(f64::MIN_POSITIVE, |most, moment| most.max(*moment));
    let mut first = 0.0;
    for (k, block) in inertia.i1.iter().enumerate() {
        for a in 0..3 {
            for b in 0..=a {
                let bound = moments[a] * arms[b][k] + moments[b] * arms[a][k];
                first = larger(first, (block[a][b].abs() * reciprocal[k] - bound) / size);
            }
        }
    }
    let allowed = match of.coupling_source() {
        CouplingSource::Integrals => TRACE_LIMIT,
        CouplingSource::Nodal | CouplingSource::Unknown => NODAL_EXCESS,
    };
    let mut all = vec![
        Identity {
            path: "/inertia/I2",
            what: "I2_aa,kk is not negative",
            defect: negative,
            limit: AGREEMENT,
        },
        Identity {
            path: "/inertia/I2",
            what: "|I2_ab,kl| ≤ ½ (√(I2_aa,kk I2_bb,ll) + √(I2_aa,ll I2_bb,kk)) (Cauchy and Schwarz)",
            defect: second,
            limit: LOAD_LIMIT,
        },
        Identity {
            path: "/inertia/L3",
            what: "|L3_a,kl| ≤ ½ (√(I2_aa,kk M_ll) + √(I2_aa,ll M_kk)) (Cauchy and Schwarz)",
            defect: coupling,
            limit: LOAD_LIMIT,
        },
        Identity {
            path: "/inertia/I1",
            what: "|I1_k,ab| ≤ √(J_aa I2_bb,kk) + √(J_bb I2_aa,kk) (Cauchy and Schwarz)",
            defect: first,
            limit: LOAD_LIMIT,
        },
        Identity {
            path: "/inertia/I2",
            what: "its trace is twice the reduced mass",
            defect: trace_defect(of),
            limit: allowed,
        },
    ];
    if has_internal_rows(of) {
        all.pop();
    }
    all
}

/// Order of the six matrices of I2.
pub(super) const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// Largest |x_kl| / (n_k n_l) − ½ (p_k q_l + p_l q_k).
fn beyond(matrix: &faer::Mat<f64>, p: &[f64], q: &[f64], reciprocal: &[f64]) -> f64 {
    let mut most = 0.0_f64;
    for l in 0..reciprocal.len() {
        let (half_p, half_q, of_column) = (0.5 * p[l], 0.5 * q[l], reciprocal[l]);
        let column = matrix.col_as_slice(l)[..=l].iter();
        let rows = column.zip(reciprocal).zip(p.iter().zip(q));
        let defect = |((entry, of_row), (p, q)): ((&f64, &f64), (&f64, &f64))| {
            entry.abs() * of_row * of_column - (p * half_q + half_p * q)
        };
        most = rows.map(defect).fold(most, f64::max);
    }
    most
}

/// Largest |½ tr I2_kl − M_kl| / (n_k n_l).
pub(super) fn trace_defect(of: &Superelement) -> f64 {
    let i2 = &of.inertia.i2;
    let reciprocal = reciprocals(&whole_norms(of));
    let mut most = 0.0_f64;
    for l in 0..reciprocal.len() {
        let [x, y, z] = [0, 1, 2].map(|a| i2[a].col_as_slice(l));
        for k in 0..=l {
            let half = 0.5 * (x[k] + y[k] + z[k]);
            let defect = (half - of.reduced_mass(k, l)).abs() * reciprocal[k] * reciprocal[l];
            most = larger(most, defect);
        }
    }
    most
}
