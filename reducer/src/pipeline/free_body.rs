//! A component as a free body: K and M without what rigid interfaces take away, L_b, mass and centre, and the rigid motions.

use std::sync::atomic::{AtomicBool, Ordering};

use dcb_formats::component::Component;
use dcb_sparse::factorization::SymmetricFactor;

use crate::attachments::enrichment::Reducing;
use crate::attachments::residual::ResidualFlexibility;
use crate::error::{BodyRefusal, Error};
use crate::model::condensation::Model;
use crate::model::localization::Localization;
use crate::model::mass_sign::refuse_indefinite_mass;
use crate::model::piece_motions::Pieces;
use crate::model::rigid_body::{MassProperties, RigidBodyModes, StiffnessDefects};
use crate::model::shift::SpectrumScale;
use crate::model::stresses::refuse_rigid_stress;
use crate::modes::free_modes::FreeModes;
use crate::pipeline::diagnosis::{LoosePieces, Support, check_rows, support};
use crate::pipeline::reduction::Reduction;
use crate::resources::huge_pages::touch_ahead;

/// Start of a reduction.
pub(crate) struct FreeBody<'a> {
    pub component: &'a Component,
    pub properties: MassProperties,
    pub model: Model<'a>,
    pub localization: Localization,
    /// Rigid motions; none of a body that is held.
    pub rigid: RigidBodyModes,
    pub support: Support,
    /// Part of uᵀ diag(M) u that at least is mass of every motion u, where that is known.
    pub mass_part: Option<f64>,
}

/// Properties of a body from K before it is factorized.
pub(crate) struct Spectrum {
    /// K times the rigid motions.
    pub defects: StiffnessDefects,
    pub pieces: Pieces,
    pub scale: SpectrumScale,
}

impl<'a> FreeBody<'a> {
    /// # Errors
    /// Refusals of single rows, of interfaces, of the mass, and of a part without elastic motion.
    pub fn of(component: &'a Component) -> Result<Self, Error> {
        check_rows(component)?;
        let properties = MassProperties::of(component)?;
        refuse_rigid_stress(component, properties.centre)?;
        let model = Model::of(component)?;
        let localization = Localization::of(component, &model)?;
        let rigid = RigidBodyModes::of(component, &model, &properties)?;
        let (dofs, motions) = (model.len(), rigid.count());
        if dofs <= motions {
            return Err(BodyRefusal::NothingElastic { dofs, motions }.into());
        }
        Ok(Self {
            component,
            properties,
            model,
            localization,
            rigid,
            support: Support::Free,
            mass_part: None,
        })
    }

    /// The order of the factor of K + σ M, found by one thread; what K says of the spectrum comes from the others meanwhile. If they
    /// are done first, room for the factor is touched.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn analysed(&self) -> Result<(SymmetricFactor, Spectrum), Error> {
        let model = &self.model;
        let is_ordered = AtomicBool::new(rayon::current_num_threads() == 1);
        let ordered = || {
            let factor = SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points());
            is_ordered.store(true, Ordering::Relaxed);
            factor
        };
        let meanwhile = || {
            let spectrum = self.spectrum();
            // A factor of a solid has at least twice as many entries as K.
            touch_ahead(2 * size_of_val(model.stiffness.val()), &is_ordered);
            spectrum
        };
        let (factor, spectrum) = rayon::join(ordered, meanwhile);
        Ok((factor?, spectrum))
    }

    /// Properties from K before it is factorized.
    pub fn spectrum(&self) -> Spectrum {
        let (model, rigid) = (&self.model, &self.rigid);
        let defects = rigid.stiffness_defects(model);
        let pieces = Pieces::of(model, rigid);
        let dimension = self.component.dimension();
        let scale = SpectrumScale::of(model, rigid, &pieces, dimension, self.properties.centre);
        Spectrum {
            defects,
            pieces,
            scale,
        }
    }

    /// Finds out how it is supported; returns what to say of a stiffness that is hardly one of a free body.
    ///
    /// # Errors
    /// An indefinite mass; a support and loose pieces where they are refused; a mesh that doesn't belong to the matrices.
    pub fn settle(
        &mut self,
        spectrum: &Spectrum,
        factor: &mut SymmetricFactor,
        options: &Reduction,
    ) -> Result<Option<String>, Error> {
        self.mass_part = refuse_indefinite_mass(self.component, &self.model, factor)?;
        let (support, warning) = support(self, spectrum, factor, options.grounding)?;
        self.stand(support);
        match options.loose_pieces {
            LoosePieces::Allow => {}
            LoosePieces::Refuse => spectrum.pieces.refuse_several()?,
        }
        Ok(warning)
    }

    /// Supports it.
    pub fn stand(&mut self, support: Support) {
        if support == Support::Grounded {
            self.rigid = self.rigid.none();
        }
        self.support = support;
    }

    /// With the first columns of the basis.
    pub fn with<'b>(
        &'b self,
        modes: &'b FreeModes,
        residual: &'b ResidualFlexibility,
    ) -> Reducing<'b> {
        Reducing {
            component: self.component,
            properties: &self.properties,
            model: &self.model,
            localization: &self.localization,
            rigid: &self.rigid,
            modes,
            residual,
        }
    }
}
