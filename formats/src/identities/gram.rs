//! L1, I1, I3, L3, I2, the mass and the tensor as one Gram matrix.
//!
//! In space the functions 1, r_a and ψ_k,a (a = x, y, z) have the inner products ∫ρ f g
//!
//! ```text
//! <1, 1> = m            <1, r_a> = 0             <r_a, r_b> = ½ tr(J) δ_ab − J_ab
//! <1, ψ_k,a> = L1_ak    <r_a, ψ_k,b> = X_k,ab    <ψ_k,a, ψ_l,b> = S_ab,kl
//!
//! X_k = ¼ tr(I1_k) 1 − ½ I1_k + ½ skew(I3_k)       S_ab = ½ tr(I2) δ_ab − I2_ab + ½ Σ_c ε_abc L3_c
//! ```
//! A matrix of inner products is positive semi-definite, which bounds each of them by all others. In the plane the complex
//! functions 1, r = x + iy and ψ_x + iψ_y have <r, r> = I_z, <1, ψ> = L1_x + i L1_y, <r, ψ> = I1 + i I3 and
//! <ψ_k, ψ_l> = M_kl + i L3_kl. Where L3 and I2 come from nodes alone they are products of Ω_a ψ and ψ in M, and only
//! ½ (I2_aa + M) ± i L3_a and I2_aa are sure to be semi-definite.

use faer::Mat;

use super::inertia::{PAIRS, trace_defect, whole_norms};
use super::scaled::{negative_part, reciprocal};
use super::{AGREEMENT, Identity};
use crate::mesh::Dimension;
use crate::superelement::{CouplingSource, Superelement};

/// Rounding of attachments beside their size with no mode kept.
const GRAM_LIMIT: f64 = 1e-8;
/// Mass and tensor come from the mass matrix; beams that leave the rotary inertia of sections out of it, but not out of the component
/// masses, are that far from one field.
const SECTION_LIMIT: f64 = 1e-2;

pub(super) fn in_full(of: &Superelement) -> Vec<Identity> {
    let source = of.coupling_source();
    match of.dimension {
        Dimension::Planar if source == CouplingSource::Integrals => planar(of).into(),
        Dimension::Planar => Vec::new(),
        Dimension::Spatial => {
            let is_whole = source == CouplingSource::Integrals
                || source == CouplingSource::Unknown && trace_defect(of) <= AGREEMENT;
            match is_whole {
                true => spatial(of).into(),
                false => nodal(of),
            }
        }
    }
}

fn spatial(of: &Superelement) -> [Identity; 2] {
    let inertia = &of.inertia;
    let n = of.basis_count();
    let j = &inertia.tensor;
    let half = 0.5 * (j[0][0] + j[1][1] + j[2][2]);
    let delta = |a: usize, b: usize| f64::from(u8::from(a == b));
    let position = |a: usize, b: usize| half * delta(a, b) - j[a][b];
    // Sign of (a, b, c) and c.
    let third = |a: usize, b: usize| match (b + 3 - a) % 3 {
        1 => (1.0, (b + 1) % 3),
        2 => (-1.0, (a + 1) % 3),
        _ => (0.0, a),
    };
    let moment = |k: usize, a: usize, b: usize| {
        let block = &inertia.i1[k];
        let trace = 0.25 * (block[0][0] + block[1][1] + block[2][2]);
        let (sign, c) = third(a, b);
        trace * delta(a, b) - 0.25 * (block[a][b] + block[b][a]) + 0.5 * sign * inertia.i3[(c, k)]
    };
    let pair = |a: usize, b: usize| {
        let place = PAIRS
            .iter()
            .position(|pair| *pair == (a, b) || *pair == (b, a));
        &inertia.i2[place.unwrap_or(0)]
    };
    let product = |k: usize, a: usize, l: usize, b: usize| {
        let trace = 0.5 * (0..3).map(|c| inertia.i2[c][(k, l)]).sum::<f64>();
        let (sign, c) = third(a, b);
        trace * delta(a, b) - pair(a, b)[(k, l)] + 0.5 * sign * inertia.l3[c][(k, l)]
    };
    let entry = |i: usize, j: usize| match (i, j) {
        (0, 0) => inertia.mass,
        (0, 1..4) => 0.0,
        (0, _) => inertia.l1[((j - 4) % 3, (j - 4) / 3)],
        (1..4, 1..4) => position(i - 1, j - 1),
        (1..4, _) => moment((j - 4) / 3, i - 1, (j - 4) % 3),
        _ => product((i - 4) / 3, (i - 4) % 3, (j - 4) / 3, (j - 4) % 3),
    };
    let gram = Mat::from_fn(4 + 3 * n, 4 + 3 * n, |i, j| entry(i.min(j), i.max(j)));
    let mut scale = vec![reciprocal(inertia.mass.sqrt())];
    scale.extend((0..3).map(|_| reciprocal(half.max(0.0).sqrt())));
    for norm in whole_norms(of) {
        scale.extend([reciprocal(norm); 3]);
    }
    let deformations = gram.as_ref().submatrix(4, 4, 3 * n, 3 * n);
    [
        Identity {
            path: "/inertia/L3",
            what: "L3 and I2 are one Gram matrix (negative part)",
            defect: negative_part(deformations, &scale[4..]),
            limit: GRAM_LIMIT,
        },
        Identity {
            path: "/inertia/I1",
            what: "L1, I1, I3, L3, I2, mass and tensor are one Gram matrix (negative part)",
            defect: negative_part(gram.as_ref(), &scale),
            limit: SECTION_LIMIT,
        },
    ]
}

fn planar(of: &Superelement) -> [Identity; 2] {
    let inertia = &of.inertia;
    let n = 2 + of.basis_count();
    let entry = |i: usize, j: usize| match (i, j) {
        (0, 0) => (inertia.mass, 0.0),
        (0, 1) => (0.0, 0.0),
        (0, _) => (inertia.l1[(0, j - 2)], inertia.l1[(1, j - 2)]),
        (1, 1) => (inertia.tensor[2][2], 0.0),
        (1, _) => (inertia.i1[j - 2][2][2], inertia.i3[(0, j - 2)]),
        _ => (of.reduced_mass(i - 2, j - 2), inertia.l3[0][(i - 2, j - 2)]),
    };
    let gram = hermitian(n, entry);
    let mut scale = vec![
        reciprocal(inertia.mass.sqrt()),
        reciprocal(inertia.tensor[2][2].max(0.0).sqrt()),
    ];
    scale.extend(whole_norms(of).into_iter().map(reciprocal));
    let of_deformations = [vec![0.0; 2], scale[2..].to_vec()].concat();
    [
        Identity {
            path: "/inertia/L3",
            what: "L3 and the reduced mass are one Gram matrix (negative part)",
            defect: negative_part(
                gram.as_ref(),
                &[of_deformations.clone(), of_deformations].concat(),
            ),
            limit: GRAM_LIMIT,
        },
        Identity {
            path: "/inertia/I1",
            what: "L1, I1, I3, L3, the reduced mass, mass and I_z are one Gram matrix (negative part)",
            defect: negative_part(gram.as_ref(), &[scale.clone(), scale].concat()),
            limit: SECTION_LIMIT,
        },
    ]
}

/// [A −B; B A] for A + iB, of which the upper triangle is given.
fn hermitian(n: usize, entry: impl Fn(usize, usize) -> (f64, f64)) -> Mat<f64> {
    Mat::from_fn(2 * n, 2 * n, |row, column| {
        let (i, j) = (row % n, column % n);
        let (real, imaginary) = match i <= j {
            true => entry(i, j),
            false => {
                let (real, imaginary) = entry(j, i);
                (real, -imaginary)
            }
        };
        match (row < n, column < n) {
            (true, true) | (false, false) => real,
            (true, false) => -imaginary,
            (false, true) => imaginary,
        }
    })
}

fn nodal(of: &Superelement) -> Vec<Identity> {
    let inertia = &of.inertia;
    let n = of.basis_count();
    let scale: Vec<f64> = whole_norms(of).into_iter().map(reciprocal).collect();
    let mut own = 0.0_f64;
    let mut both = 0.0_f64;
    for a in 0..3 {
        own = own.max(negative_part(inertia.i2[a].as_ref(), &scale));
        let matrix = hermitian(n, |k, l| {
            let mean = 0.5 * (inertia.i2[a][(k, l)] + of.reduced_mass(k, l));
            (mean, inertia.l3[a][(k, l)])
        });
        both = both.max(negative_part(
            matrix.as_ref(),
            &[scale.clone(), scale.clone()].concat(),
        ));
    }
    vec![
        Identity {
            path: "/inertia/I2",
            what: "I2_aa is positive semi-definite (negative part)",
            defect: own,
            limit: GRAM_LIMIT,
        },
        Identity {
            path: "/inertia/L3",
            what: "½ (I2_aa + M) ± i L3_a is positive semi-definite (negative part)",
            defect: both,
            limit: GRAM_LIMIT,
        },
    ]
}
