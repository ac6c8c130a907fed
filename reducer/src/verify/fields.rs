//! `reduce verify --component`: every identity on the stored nodal shapes, with K and M of the component.

use dcb_formats::superelement::{FrameKind, Inertia};
use dcb_formats::{RecoveryBasis, Superelement};
use dcb_sparse::block_algebra::{largest_entry, symmetric_product};
use dcb_sparse::factorization::SymmetricFactor;
use faer::Mat;

use super::findings::{AGREEMENT, Findings};
use super::further::{check_further, check_loads, check_stiffening, check_stresses};
use super::interfaces::{check_interface_reduction, reported_reduction};
use super::moments::check_moments;
use crate::attachments::interface_reduction::InterfaceReduction;
use crate::attachments::residual::ResidualFlexibility;
use crate::error::Error;
use crate::inertia::invariants::inertia_invariants;
use crate::model::regularization::Regularization;
use crate::model::shift::AbsoluteForces;
use crate::modes::certificate::ModeCount;
use crate::modes::free_modes::{FreeModes, residuals};
use crate::moments::PowerMoments;
use crate::pipeline::diagnosis::{Support, unfactorized};
use crate::pipeline::free_body::{FreeBody, Spectrum};
use crate::quality::Quality;
use crate::quality::lines::quality_lines;

/// Every identity on the stored shapes.
///
/// # Errors
/// If the component can't be reduced.
pub(crate) fn check_fields(
    element: &Superelement,
    basis: &RecoveryBasis,
    mut body: FreeBody<'_>,
    findings: &mut Findings,
) -> Result<(), Error> {
    let same_dofs = basis.dofs == body.component.dofs.nodal_dofs();
    findings.require(
        "dofs of the fields are those of the component",
        same_dofs,
        if same_dofs { "yes" } else { "no" },
    );
    if !same_dofs {
        return Ok(());
    }
    let spectrum = body.spectrum();
    body.stand(match element.frame_kind {
        FrameKind::MeanAxis => Support::Free,
        FrameKind::Given => Support::Grounded,
    });
    let model = &body.model;
    let stored = Stored {
        element,
        basis,
        body: &body,
        spectrum: &spectrum,
        modes: stored_modes(element, basis, &body),
        attachments: model.contract(basis.residual.as_ref()),
    };
    stored.check_rigid_interfaces(findings);
    let mut factor = SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points())?;
    let (residual, moments) = stored.residual(&mut factor, findings)?;
    let mode_count = ModeCount::by_inertia(model, &body.rigid, &stored.modes, &mut factor)?;
    stored.check_projections(&residual, mode_count, moments, findings)
}

/// Nodal shapes of a file over the model of the component.
struct Stored<'a> {
    element: &'a Superelement,
    basis: &'a RecoveryBasis,
    body: &'a FreeBody<'a>,
    spectrum: &'a Spectrum,
    modes: FreeModes,
    /// G_res L_bᵀ over the model's dofs.
    attachments: Mat<f64>,
}

/// The stored modes with their residuals and roundings.
fn stored_modes(element: &Superelement, basis: &RecoveryBasis, body: &FreeBody<'_>) -> FreeModes {
    let FreeBody { model, rigid, .. } = body;
    let shapes = model.contract(basis.modes.as_ref());
    let eigenvalues = element.modes.eigenvalues.clone();
    let zero_count = eigenvalues
        .iter()
        .take_while(|value| **value == 0.0)
        .count();
    let mass_shapes = symmetric_product(&model.mass, shapes.as_ref());
    let absolute = AbsoluteForces::of(&model.stiffness, shapes.as_ref());
    let (residuals, residual_roundings) = residuals(
        &model.stiffness,
        shapes.as_ref(),
        mass_shapes.as_ref(),
        &eigenvalues,
        zero_count,
        &absolute.norms,
        rigid.stiffness_precision,
    );
    let rounding = |(energy, value): (&f64, &f64)| match *value > 0.0 {
        true => rigid.stiffness_precision * energy / value,
        false => 0.0,
    };
    FreeModes {
        eigenvalue_roundings: (absolute.energies.iter().zip(&eigenvalues))
            .map(rounding)
            .collect(),
        shapes,
        mass_shapes,
        eigenvalues,
        residuals,
        residual_roundings,
        zero_count,
        first_omitted: element.modes.first_omitted_eigenvalue,
        iterations: 0,
        added_for_cluster: 0,
        complete_below: None,
    }
}

impl Stored<'_> {
    fn check_rigid_interfaces(&self, findings: &mut Findings) {
        let rigidity = |full: &Mat<f64>, model_columns: &Mat<f64>| {
            let expanded = self.body.model.expand(model_columns.as_ref());
            largest_entry((expanded.as_ref() - full).as_ref())
                / largest_entry(full.as_ref()).max(f64::MIN_POSITIVE)
        };
        let of_modes = rigidity(&self.basis.modes, &self.modes.shapes);
        let of_attachments = rigidity(&self.basis.residual, &self.attachments);
        findings.check(
            "rigid interfaces move rigidly in the fields",
            of_modes.max(of_attachments),
            AGREEMENT,
        );
    }

    /// The residual flexibility of the stored attachments, and the moments of what is left out where the file has such. An interface
    /// reduction is made anew, as the moments are: both need a factor.
    fn residual(
        &self,
        factor: &mut SymmetricFactor,
        findings: &mut Findings,
    ) -> Result<(ResidualFlexibility, Option<PowerMoments>), Error> {
        let FreeBody {
            model,
            localization,
            rigid,
            ..
        } = self.body;
        let modes = &self.modes;
        let given = || {
            let attachments = self.attachments.clone();
            ResidualFlexibility::from_shapes(model, localization, rigid, modes, attachments)
        };
        let reduction = reported_reduction(self.element).filter(InterfaceReduction::leaves_out);
        if reduction.is_none() && self.element.moments.is_none() {
            return Ok((given()?, None));
        }
        let scale = &self.spectrum.scale;
        let stored = self.element.moments.as_ref().map(|moments| moments.shift);
        let regularization = Regularization::of_moments(stored, model, rigid, scale);
        let positive = match regularization.factorize(model, factor) {
            Ok(positive) => positive,
            Err(why) => return Err(unfactorized(model, scale, factor, why)),
        };
        let whole = match &reduction {
            Some(_) => {
                ResidualFlexibility::compute(model, localization, rigid, modes, &positive, &mut ())?
            }
            None => given()?,
        };
        let mut moments = None;
        if self.element.moments.is_some() {
            let of = self.body.with(modes, &whole);
            let further = self.basis.enrichment.as_ref();
            let further = further.map(|shapes| model.contract(shapes.as_ref()));
            let further = further.as_ref().map(|shapes| shapes.as_ref());
            let shift = regularization.shift();
            match PowerMoments::compute(&of, further, &positive, shift, &mut ()) {
                Ok(computed) => moments = Some(computed),
                Err(why) => {
                    findings.require("error estimate recomputed", false, &why.to_string());
                }
            }
        }
        let Some(report) = &reduction else {
            return Ok((whole, moments));
        };
        let expected = whole.keeping(report.wanted, model, localization, modes)?;
        check_interface_reduction(report, &expected, &self.attachments, findings);
        let attachments = self.attachments.clone();
        let residual = expected.with_shapes(model, localization, modes, attachments)?;
        Ok((residual, moments))
    }

    /// Matrices of the file over Ψ = [Φ, G_res L_bᵀ, X].
    fn check_projections(
        &self,
        residual: &ResidualFlexibility,
        mode_count: ModeCount,
        moments: Option<PowerMoments>,
        findings: &mut Findings,
    ) -> Result<(), Error> {
        let (element, model, modes) = (self.element, &self.body.model, &self.modes);
        let (phi, x) = (
            model.expand(modes.shapes.as_ref()),
            model.expand(residual.shapes.as_ref()),
        );
        let further = self.basis.enrichment.as_ref();
        let shapes = [phi.as_ref(), x.as_ref()];
        let psi: Vec<_> = shapes
            .into_iter()
            .chain(further.map(|further| further.as_ref()))
            .collect();
        let (inertia, _) = inertia_invariants(self.body.component, &self.body.properties, &psi);
        let of = self.body.with(modes, residual);
        check_further(element, further, &of, findings)?;
        check_stiffening(element, &psi, &of, findings);
        check_loads(element, &psi, &of, findings);
        check_stresses(element, &psi, &of, findings);
        if let (Some(stored), Some(computed)) = (&element.moments, moments) {
            let certified = mode_count.counted == mode_count.found;
            check_moments(
                element,
                stored,
                &computed.certified(modes, mode_count),
                certified,
                findings,
            );
        }
        let defects = &self.spectrum.defects.per_column;
        let quality = Quality::of(&of, defects, None, &inertia, mode_count);
        findings.text += &quality_lines(&quality, &self.body.component.units.time);
        let broken = quality.broken_limits();
        findings.require(
            "identities recomputed with K and M",
            broken.is_empty(),
            &format!("{} broken", broken.len()),
        );
        let broken = broken.iter().map(ToString::to_string);
        findings.broken.extend(broken);
        self.check_interface_matrices(residual, findings);
        check_invariants(
            &element.inertia,
            &inertia,
            element.mode_count(),
            &residual.mass_diagonal0,
            findings,
        );
        Ok(())
    }

    fn check_interface_matrices(&self, residual: &ResidualFlexibility, findings: &mut Findings) {
        let (element, shapes) = (self.element, self.modes.shapes.as_ref());
        let seen = self.body.localization.apply(shapes);
        let seen_defect = (&seen - &element.modes.interface_shapes).norm_max()
            / largest_entry(shapes).max(f64::MIN_POSITIVE);
        findings.check("L_b Φ", seen_defect, AGREEMENT);
        let flexibility0 = |i: usize| {
            let entry = residual.flexibility0[(i, i)].abs();
            entry.max(f64::MIN_POSITIVE).sqrt()
        };
        let mass0 = |i: usize| residual.mass_diagonal0[i].sqrt();
        let stored = &element.residual;
        let scales: [&dyn Fn(usize) -> f64; 2] = [&flexibility0, &mass0];
        for ((what, stored, computed), scale) in [
            ("F_res", &stored.flexibility, &residual.flexibility),
            ("M_res", &stored.mass, &residual.mass),
        ]
        .into_iter()
        .zip(scales)
        {
            let scaled = Mat::from_fn(stored.nrows(), stored.ncols(), |i, j| {
                let difference = stored[(i, j)] - computed[(i, j)];
                match scale(i) * scale(j) {
                    unit if unit > 0.0 => difference / unit,
                    _ => difference,
                }
            });
            findings.check(what, largest_entry(scaled.as_ref()), AGREEMENT);
        }
    }
}

/// I1, L3 and I2 against their recomputation, each column divided by the size of its basis vector.
fn check_invariants(
    stored: &Inertia,
    computed: &Inertia,
    n_k: usize,
    mass_diagonal0: &[f64],
    findings: &mut Findings,
) {
    let norm = |k: usize| {
        // Further columns have unit norm with no mode kept.
        let attachment = k.checked_sub(n_k).and_then(|k| mass_diagonal0.get(k));
        attachment.map_or(1.0, |mass| mass.sqrt())
    };
    let n = computed.i1.len();
    let largest_moment = (0..3)
        .map(|a| computed.tensor[a][a])
        .fold(0.0, f64::max)
        .sqrt();
    let mut first = 0.0_f64;
    for k in (0..n).filter(|k| norm(*k) > 0.0) {
        for a in 0..3 {
            for b in 0..3 {
                first = first.max(
                    (stored.i1[k][a][b] - computed.i1[k][a][b]).abs() / (norm(k) * largest_moment),
                );
            }
        }
    }
    findings.check("I1", first, AGREEMENT);
    for (what, x, y) in [
        ("L3", &stored.l3, &computed.l3),
        ("I2", &stored.i2, &computed.i2),
    ] {
        let mut worst = 0.0_f64;
        for (x, y) in x.iter().zip(y) {
            let scaled = Mat::from_fn(n, n, |k, l| {
                let unit = norm(k) * norm(l);
                if unit > 0.0 {
                    (x[(k, l)] - y[(k, l)]) / unit
                } else {
                    0.0
                }
            });
            worst = worst.max(largest_entry(scaled.as_ref()));
        }
        findings.check(what, worst, AGREEMENT);
    }
}
