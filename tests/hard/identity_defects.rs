//! How far a reduction is from the identities of the method (Eq. 29–32, 39–40 and what follows from them), each without unit and with its
//! limit. Scaled by the whole response, with no mode kept, so that a residual that is all rounding stays small.

use dcb_formats::Component;
use dcb_reducer::Reduced;
use faer::Mat;

use dcb_tests::dense::{
    diagonal, diagonal_roots, eigen, identity, largest, scaled_difference, symmetric, times,
};

/// One identity.
#[derive(Clone, Copy, Debug)]
pub struct Defect {
    /// As `docs/theory.md` writes it.
    pub identity: &'static str,
    /// Largest deviation.
    pub value: f64,
    /// What it may be.
    pub limit: f64,
}

/// Largest |a_ij| / (r_i c_j); absolute where a scale is zero.
fn largest_scaled(a: &Mat<f64>, rows: &[f64], columns: &[f64]) -> f64 {
    let scale = |s: f64| if s > 0.0 { s } else { 1.0 };
    let scaled = Mat::from_fn(a.nrows(), a.ncols(), |i, j| {
        a[(i, j)] / (scale(rows[i]) * scale(columns[j]))
    });
    largest(scaled.as_ref())
}

/// How negative the smallest eigenvalue of A is, with rows and columns divided by `scale`.
fn negativity(a: &Mat<f64>, scale: &[f64]) -> f64 {
    let inverse = |s: f64| if s > 0.0 { 1.0 / s } else { 0.0 };
    let scaled = Mat::from_fn(a.nrows(), a.ncols(), |i, j| {
        a[(i, j)] * inverse(scale[i]) * inverse(scale[j])
    });
    let (values, _) = eigen(&symmetric(&scaled));
    -values.first().copied().unwrap_or(0.0).min(0.0)
}

/// Σ c cᵀ / ω^power over the kept modes, c their shapes at the interfaces.
pub fn modal_sum(reduced: &Reduced, power: i32) -> Mat<f64> {
    let modes = &reduced.superelement.modes;
    let weights: Vec<f64> = modes
        .eigenvalues
        .iter()
        .map(|squared| squared.powi(-power / 2))
        .collect();
    &modes.interface_shapes * diagonal(&weights) * modes.interface_shapes.transpose()
}

/// All of them; `none` is the same part with no mode kept.
pub fn identity_defects(component: &Component, reduced: &Reduced, none: &Reduced) -> Vec<Defect> {
    let mut defects = orthogonality(component, reduced, none);
    defects.extend(residuals(reduced, none));
    defects.extend(invariants(reduced, none));
    defects
}

/// Roots of the diagonals of F_res and M_res with no mode kept.
fn scales(none: &Reduced) -> (Vec<f64>, Vec<f64>) {
    let residual = &none.superelement.residual;
    (
        diagonal_roots(&residual.flexibility),
        diagonal_roots(&residual.mass),
    )
}

fn orthogonality(component: &Component, reduced: &Reduced, none: &Reduced) -> Vec<Defect> {
    let element = &reduced.superelement;
    let (phi, x) = (&reduced.recovery.modes, &reduced.recovery.residual);
    let (k_phi, m_phi) = (
        times(&component.stiffness, phi.as_ref()),
        times(&component.mass, phi.as_ref()),
    );
    let (k_x, m_x) = (
        times(&component.stiffness, x.as_ref()),
        times(&component.mass, x.as_ref()),
    );
    let (f0, m0) = scales(none);
    let n = element.mode_count();
    let (omega, ones) = (
        diagonal_roots(&diagonal(&element.modes.eigenvalues)),
        vec![1.0; n],
    );
    let defect = |identity, value, limit| Defect {
        identity,
        value,
        limit,
    };
    vec![
        defect(
            "ΦᵀMΦ = I",
            scaled_difference(&(phi.transpose() * &m_phi), &identity(n), &ones),
            1e-11,
        ),
        defect(
            "ΦᵀKΦ = Ω²",
            scaled_difference(
                &(phi.transpose() * &k_phi),
                &diagonal(&element.modes.eigenvalues),
                &omega,
            ),
            1e-8,
        ),
        defect(
            "ΦᵀK G_res L_bᵀ = 0",
            largest_scaled(&(phi.transpose() * &k_x), &omega, &f0),
            1e-8,
        ),
        defect(
            "ΦᵀM G_res L_bᵀ = 0",
            largest_scaled(&(phi.transpose() * &m_x), &ones, &m0),
            1e-8,
        ),
        defect(
            "G_resᵀ K G_res = G_res",
            scaled_difference(&(x.transpose() * &k_x), &element.residual.flexibility, &f0),
            1e-9,
        ),
        defect(
            "G_resᵀ M G_res = M_res",
            scaled_difference(&(x.transpose() * &m_x), &element.residual.mass, &m0),
            1e-11,
        ),
    ]
}

fn residuals(reduced: &Reduced, none: &Reduced) -> Vec<Defect> {
    let residual = &reduced.superelement.residual;
    let (f, m, t) = (&residual.flexibility, &residual.mass, &residual.transform);
    let whole = &none.superelement.residual;
    let (f0, m0) = scales(none);
    // What rounding in F_res and M_res may become in the coordinates of T_r.
    let amplified = |scale: &[f64]| {
        let of_column =
            |k: usize| -> f64 { (0..t.nrows()).map(|i| (t[(i, k)] * scale[i]).powi(2)).sum() };
        (0..t.ncols()).map(of_column).fold(1.0, f64::max)
    };
    let rank = t.ncols();
    let in_mass = t.transpose() * m * t - identity(rank);
    let in_flexibility = t.transpose() * f * t - diagonal(&residual.sigma_squared);
    let defect = |identity, value, limit| Defect {
        identity,
        value,
        limit,
    };
    vec![
        defect("F_res ⪰ 0", negativity(f, &f0), 1e-11),
        defect("M_res ⪰ 0", negativity(m, &m0), 1e-11),
        defect(
            "T_rᵀ M_res T_r = I",
            largest(in_mass.as_ref()) / amplified(&m0),
            1e-12,
        ),
        defect(
            "T_rᵀ F_res T_r = σ²",
            largest(in_flexibility.as_ref()) / amplified(&f0),
            1e-12,
        ),
        defect(
            "Σ c cᵀ/ω² + F_res, whatever is kept",
            scaled_difference(&(modal_sum(reduced, 2) + f), &whole.flexibility, &f0),
            1e-9,
        ),
        defect(
            "Σ c cᵀ/ω⁴ + M_res, whatever is kept",
            scaled_difference(&(modal_sum(reduced, 4) + m), &whole.mass, &m0),
            1e-9,
        ),
    ]
}

fn invariants(reduced: &Reduced, none: &Reduced) -> Vec<Defect> {
    let inertia = &reduced.superelement.inertia;
    let norms = column_norms(reduced, none);
    let moment = (0..3).map(|a| inertia.tensor[a][a]).fold(0.0, f64::max);
    let (momentum, spin) = (vec![inertia.mass.sqrt(); 3], vec![moment.sqrt(); 3]);
    let antisymmetry = inertia.l3.iter().map(|l3| {
        let zero = Mat::zeros(l3.nrows(), l3.ncols());
        scaled_difference(&(l3 + l3.transpose()), &zero, &norms)
    });
    let defect = |identity, value, limit| Defect {
        identity,
        value,
        limit,
    };
    vec![
        defect(
            "L1 Ψ = 0",
            largest_scaled(&inertia.l1, &momentum, &norms),
            1e-9,
        ),
        defect("I3 Ψ = 0", largest_scaled(&inertia.i3, &spin, &norms), 1e-9),
        defect("L3 + L3ᵀ = 0", antisymmetry.fold(0.0, f64::max), 1e-11),
    ]
}

/// M norm of each basis column: 1 of a mode, of an attachment that with no mode kept.
pub fn column_norms(reduced: &Reduced, none: &Reduced) -> Vec<f64> {
    let mut norms = vec![1.0; reduced.superelement.mode_count()];
    norms.extend(scales(none).1);
    norms
}
