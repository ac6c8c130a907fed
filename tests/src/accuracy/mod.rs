//! A reduction measured against the dense oracle: one line per quantity, with the bound that the tests hold it to.

pub mod cases;
pub mod references;
pub mod sections;

use dcb_formats::Component;
use dcb_formats::mesh::Dimension;
use dcb_reducer::Reduced;
use faer::Mat;
use serde_json::{Value, json};

use crate::dense::{
    dense, diagonal, diagonal_roots, difference, eigen, identity, largest, relative,
    scaled_difference, symmetric,
};
use crate::nodal::{self, Invariants};
use crate::oracle::{Oracle, centre_of_mass, rigid_motions};

/// Bound of relative errors where nothing amplifies rounding.
pub const BOUND: f64 = 1e-9;
/// Where rounding in K amplifies: this many times ε|φ|ᵀ|K||φ|/ω² of the first mode.
const OVER_ROUNDING: f64 = 30.0;
/// Scaled directions of M_res below this carry no usable mass.
const FILTER: f64 = 1e-10;

/// One measured error.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// What was measured.
    pub quantity: &'static str,
    /// Of which part.
    pub part: String,
    /// Its size.
    pub n_e: usize,
    /// Modes kept.
    pub modes: usize,
    /// Relative error.
    pub error: f64,
    /// What it may be.
    pub bound: f64,
    /// What it was compared with.
    pub oracle: &'static str,
}

impl Measurement {
    /// As one line of `docs/data/accuracy.jsonl`.
    pub fn line(&self) -> Value {
        json!({
            "kind": "dense", "quantity": self.quantity, "part": self.part, "n_e": self.n_e, "n_k": self.modes,
            "relative_error": self.error, "bound": self.bound, "oracle": self.oracle,
        })
    }
}

/// Exact invariants of a basis about a point.
pub type Exact = dyn Fn([f64; 3], &Mat<f64>) -> Invariants;

/// Collects measurements of one part.
struct Sheet<'a> {
    component: &'a Component,
    part: &'a str,
    modes: usize,
    lines: Vec<Measurement>,
}

impl Sheet<'_> {
    fn add(&mut self, quantity: &'static str, error: f64, bound: f64, oracle: &'static str) {
        let (part, n_e, modes) = (self.part.to_owned(), self.component.dofs.len(), self.modes);
        self.lines.push(Measurement {
            quantity,
            part,
            n_e,
            modes,
            error,
            bound,
            oracle,
        });
    }
}

/// The whole basis [Φ, G_res L_bᵀ].
pub fn basis(reduced: &Reduced) -> Mat<f64> {
    let (phi, x) = (&reduced.recovery.modes, &reduced.recovery.residual);
    Mat::from_fn(phi.nrows(), phi.ncols() + x.ncols(), |i, j| {
        match j < phi.ncols() {
            true => phi[(i, j)],
            false => x[(i, j - phi.ncols())],
        }
    })
}

/// Measures a reduction to `count` modes; `exact` gives the invariants of a basis where M alone does not.
pub fn measure(
    component: &Component,
    part: &str,
    count: usize,
    oracle: &Oracle,
    exact: Option<&Exact>,
) -> Vec<Measurement> {
    let reduced = crate::lowest(component, count);
    let kept = reduced.superelement.mode_count();
    let mut sheet = Sheet {
        component,
        part,
        modes: kept,
        lines: Vec::new(),
    };
    let rounding = oracle.eigenvalue_rounding(0);
    let bound = BOUND.max(OVER_ROUNDING * rounding);
    mass_properties(&mut sheet, &reduced);
    modes(&mut sheet, &reduced, oracle, bound);
    residuals(&mut sheet, &reduced, oracle, bound);
    invariants(&mut sheet, &reduced, bound, exact);
    sheet.lines
}

fn mass_properties(sheet: &mut Sheet, reduced: &Reduced) {
    let element = &reduced.superelement;
    let (mass, centre) = centre_of_mass(sheet.component);
    let x = rigid_motions(sheet.component, centre);
    let rigid = x.transpose() * dense(&sheet.component.mass) * &x;
    let size = (0..3).map(|i| centre[i].abs()).fold(0.05, f64::max);
    let offset = (0..3)
        .map(|i| (centre[i] - element.origin[i]).abs())
        .fold(0.0, f64::max)
        / size;
    sheet.add(
        "mass",
        (element.inertia.mass / mass - 1.0).abs(),
        1e-12,
        "TᵀMT",
    );
    sheet.add("centre of mass", offset, 1e-12, "TᵀM(x - mean)");
    let planar = sheet.component.dimension() == Dimension::Planar;
    let tensor = Mat::from_fn(3, 3, |i, j| element.inertia.tensor[i][j]);
    let expected = Mat::from_fn(3, 3, |i, j| match planar {
        true => {
            if i == 2 && j == 2 {
                rigid[(2, 2)]
            } else {
                0.0
            }
        }
        false => rigid[(3 + i, 3 + j)],
    });
    sheet.add(
        "inertia tensor",
        difference(&tensor, &expected),
        1e-12,
        "dense XᵀMX",
    );
}

fn modes(sheet: &mut Sheet, reduced: &Reduced, oracle: &Oracle, bound: f64) {
    let element = &reduced.superelement;
    let kept = element.mode_count();
    let frequencies = |values: &[f64]| values.iter().map(|v| v.sqrt()).collect::<Vec<_>>();
    let expected = frequencies(&oracle.eigenvalues[..kept]);
    sheet.add(
        "frequencies",
        relative(&frequencies(&element.modes.eigenvalues), &expected),
        bound,
        "dense eigenproblem",
    );
    let phi = &reduced.recovery.modes;
    let orthonormality = phi.transpose() * &oracle.mass * phi;
    sheet.add(
        "ΦᵀMΦ - I",
        largest((&orthonormality - identity(kept)).as_ref()),
        1e-11,
        "dense product",
    );
    // The kept space, whatever the basis in it.
    let cosines = oracle.kept(kept).transpose() * &oracle.mass * phi;
    let defect = cosines.transpose() * &cosines - identity(kept);
    sheet.add(
        "kept space",
        largest(defect.as_ref()),
        bound,
        "dense eigenproblem",
    );
    let seen = &oracle.localization * phi;
    sheet.add(
        "L_b Φ",
        difference(&element.modes.interface_shapes, &seen),
        1e-11,
        "dense product",
    );
    let omitted = oracle.eigenvalues.get(kept).map_or(0.0, |next| {
        (element.modes.first_omitted_eigenvalue.sqrt() / next.sqrt() - 1.0).abs()
    });
    sheet.add(
        "first omitted frequency",
        omitted,
        1e-6,
        "dense eigenproblem",
    );
    if kept == oracle.eigenvalues.len() {
        assert!(element.modes.first_omitted_eigenvalue.is_infinite());
    }
}

fn residuals(sheet: &mut Sheet, reduced: &Reduced, oracle: &Oracle, bound: f64) {
    let residual = &reduced.superelement.residual;
    let kept = reduced.superelement.mode_count();
    let (f0, m0) = (oracle.residual_flexibility(0), oracle.residual_mass(0));
    let (f, m) = (
        oracle.residual_flexibility(kept),
        oracle.residual_mass(kept),
    );
    // Relative to the residual itself, and to all of the flexibility where the residual is rounding.
    let floor = |own: &Mat<f64>, whole: &Mat<f64>| -> Vec<f64> {
        let (own, whole) = (diagonal_roots(own), diagonal_roots(whole));
        own.iter()
            .zip(&whole)
            .map(|(own, whole)| own.max(1e-4 * whole))
            .collect()
    };
    let scale = floor(&f, &f0);
    sheet.add(
        "F_res",
        scaled_difference(&residual.flexibility, &f, &scale),
        bound,
        "bordered system",
    );
    let scale_m = floor(&m, &m0);
    sheet.add(
        "M_res",
        scaled_difference(&residual.mass, &m, &scale_m),
        bound,
        "bordered system",
    );
    let diagonal0: Vec<f64> = (0..m0.nrows()).map(|i| m0[(i, i)]).collect();
    sheet.add(
        "diag M_res, no mode",
        relative(&residual.mass_diagonal0, &diagonal0),
        bound,
        "bordered system",
    );
    // Filter and transform from the oracle's own matrices.
    let inverse_root: Vec<f64> = diagonal0
        .iter()
        .map(|d| if *d > 0.0 { 1.0 / d.sqrt() } else { 0.0 })
        .collect();
    let scaled = |a: &Mat<f64>| {
        Mat::from_fn(a.nrows(), a.ncols(), |i, j| {
            inverse_root[i] * a[(i, j)] * inverse_root[j]
        })
    };
    let top = eigen(&symmetric(&scaled(&m0)))
        .0
        .last()
        .copied()
        .unwrap_or(0.0);
    let (values, vectors) = eigen(&symmetric(&scaled(&m)));
    let chosen: Vec<usize> = (0..values.len())
        .filter(|i| values[*i] > FILTER * top)
        .collect();
    let rank = residual.sigma_squared.len();
    assert_eq!(
        rank,
        chosen.len(),
        "{}: rank with {kept} modes, scaled M_res {values:?}",
        sheet.part
    );
    let t = &residual.transform;
    let in_mass = t.transpose() * &m * t - identity(rank);
    // T is as long as the filter's weakest direction is short.
    let weakest = chosen.first().map_or(1.0, |i| values[*i] / top);
    let amplified = bound.max(1e-14 / weakest).min(1e-3);
    sheet.add(
        "TᵀM_resT - I",
        largest(in_mass.as_ref()),
        amplified,
        "bordered system",
    );
    let sigma_max = residual.sigma_squared.last().copied().unwrap_or(1.0);
    let in_flexibility =
        (t.transpose() * &f * t - diagonal(&residual.sigma_squared)) * faer::Scale(1.0 / sigma_max);
    sheet.add(
        "TᵀF_resT - σ²",
        largest(in_flexibility.as_ref()),
        amplified,
        "bordered system",
    );
    let normal = Mat::from_fn(f.nrows(), chosen.len(), |i, j| {
        inverse_root[i] * vectors[(i, chosen[j])] / values[chosen[j]].sqrt()
    });
    let (sigma, _) = eigen(&symmetric(&(normal.transpose() * &f * &normal)));
    let roots = |v: &[f64]| v.iter().map(|s| s.max(0.0).sqrt()).collect::<Vec<_>>();
    sheet.add(
        "σ",
        relative(&roots(&residual.sigma_squared), &roots(&sigma)),
        amplified,
        "dense eigenproblem",
    );
}

fn invariants(sheet: &mut Sheet, reduced: &Reduced, bound: f64, exact: Option<&Exact>) {
    let element = &reduced.superelement;
    let psi = basis(reduced);
    let (mass, centre) = centre_of_mass(sheet.component);
    let expected = match exact {
        Some(exact) => exact(centre, &psi),
        None => nodal::invariants(sheet.component, centre, psi.as_ref()),
    };
    let (oracle, n) = (
        if exact.is_some() {
            "quadrature"
        } else {
            "loops over nodes"
        },
        psi.ncols(),
    );
    let matrix = dense(&sheet.component.mass);
    let norms: Vec<f64> = diagonal_roots(&(psi.transpose() * &matrix * &psi));
    let planar = element.dimension == Dimension::Planar;
    let inertia = &element.inertia;
    let length = (0..3)
        .map(|a| inertia.tensor[a][a] / mass)
        .fold(0.0, f64::max)
        .sqrt();
    let worst = |value: &dyn Fn(usize) -> f64, scale: f64| {
        (0..n)
            .filter(|k| norms[*k] > 0.0)
            .map(|k| value(k).abs() / (scale * norms[k]))
            .fold(0.0, f64::max)
    };
    let rows = if planar { 2 } else { 3 };
    let l1 = |k: usize| {
        (0..rows)
            .map(|a| {
                (inertia.l1[(a, k)] - expected.l1[(a, k)])
                    .abs()
                    .max(inertia.l1[(a, k)].abs())
            })
            .fold(0.0, f64::max)
    };
    sheet.add("L1 (zero)", worst(&l1, mass.sqrt()), bound, oracle);
    let i3 = |k: usize| match planar {
        true => inertia.i3[(0, k)].abs().max(expected.i3[(2, k)].abs()),
        false => (0..3)
            .map(|a| inertia.i3[(a, k)].abs().max(expected.i3[(a, k)].abs()))
            .fold(0.0, f64::max),
    };
    sheet.add("I3 (zero)", worst(&i3, mass.sqrt() * length), bound, oracle);
    let i1 = |k: usize| match planar {
        true => (inertia.i1[k][2][2] - expected.stretch[k]).abs(),
        false => {
            let entry = |a: usize, b: usize| (inertia.i1[k][a][b] - expected.j1[k][a][b]).abs();
            (0..9).map(|at| entry(at / 3, at % 3)).fold(0.0, f64::max)
        }
    };
    sheet.add(
        if planar { "I1" } else { "J1" },
        worst(&i1, mass.sqrt() * length),
        bound,
        oracle,
    );
    let l3 = |a: usize, of: usize| scaled_difference(&inertia.l3[a], &expected.l3[of], &norms);
    let l3 = if planar {
        l3(0, 2)
    } else {
        (0..3).map(|a| l3(a, a)).fold(0.0, f64::max)
    };
    sheet.add("L3", l3, bound, oracle);
    if !planar {
        let j2 = (0..6)
            .map(|p| scaled_difference(&inertia.i2[p], &expected.j2[p], &norms))
            .fold(0.0, f64::max);
        sheet.add("J2", j2, bound, oracle);
    }
}
