//! Mass, geometric stiffness, loads and stresses of the body over the basis Ψ = [Φ, G_res L_bᵀ, X], and Ψ over all degrees of freedom of the
//! component.

use dcb_formats::superelement::CouplingSource;
use dcb_formats::superelement::{Enrichment, Inertia, PartLoad, Stiffening, StressField};
use faer::Mat;

use crate::attachments::enrichment::FurtherColumns;
use crate::inertia::invariants::inertia_invariants;
use crate::inertia::part_loads::part_loads;
use crate::inertia::stiffening::stiffening;
use crate::model::condensation::CowMat;
use crate::model::rigid_body::StiffnessDefects;
use crate::model::stresses::stress_fields;
use crate::pipeline::basis::Basis;
use crate::pipeline::free_body::FreeBody;
use crate::quality::Quality;

/// Projections on a basis.
pub(crate) struct Projection {
    pub inertia: Inertia,
    pub couplings: CouplingSource,
    pub stiffening: Stiffening,
    pub loads: Vec<PartLoad>,
    pub stresses: Vec<StressField>,
    /// Further columns as the interfaces see them.
    pub enrichment: Option<Enrichment>,
    /// Φ over all dofs of the component, (n_e, n_k), where these are not the model's.
    pub modes: Option<Mat<f64>>,
    /// G_res L_bᵀ, (n_e, n_b), likewise.
    pub residual: Option<Mat<f64>>,
    /// X, (n_e, n_x).
    pub further: Option<Mat<f64>>,
}

impl Projection {
    /// On the basis of a body.
    pub fn of(body: &FreeBody<'_>, basis: &Basis) -> Self {
        let Basis {
            modes,
            residual,
            further,
            ..
        } = basis;
        let FreeBody {
            component,
            properties,
            model,
            localization,
            ..
        } = body;
        let phi = model.expand(modes.shapes.as_ref());
        let x = model.expand(residual.shapes.as_ref());
        let further_shapes =
            (further.as_ref()).map(|further| model.expand(further.shapes.as_ref()));
        let mut psi = vec![phi.as_ref(), x.as_ref()];
        psi.extend(further_shapes.iter().map(CowMat::as_ref));
        let (inertia, couplings) = inertia_invariants(component, properties, &psi);
        let stored = |of: &FurtherColumns| of.stored(model, localization, modes, residual);
        Self {
            inertia,
            couplings,
            stiffening: stiffening(component, localization, &psi),
            loads: part_loads(component, properties.centre, &psi),
            stresses: stress_fields(
                component,
                properties.centre,
                &psi,
                basis.omitted_stress.clone(),
            ),
            enrichment: further.as_ref().map(stored),
            modes: phi.computed(),
            residual: x.computed(),
            further: match (further_shapes.map(CowMat::computed), further) {
                (Some(None), Some(further)) => Some(further.shapes.clone()),
                (Some(computed), _) => computed,
                (None, _) => None,
            },
        }
    }

    /// How good the reduction is.
    pub fn quality(
        &self,
        body: &FreeBody<'_>,
        basis: &Basis,
        defects: &StiffnessDefects,
    ) -> Quality {
        let of = body.with(&basis.modes, &basis.residual);
        let (further, mode_count) = (basis.further.as_ref(), basis.mode_count);
        Quality {
            couplings: Some(self.couplings),
            ..Quality::of(&of, &defects.per_column, further, &self.inertia, mode_count)
        }
    }
}
