//! Forces whose static responses are wanted: at the rows of L_b, or given as columns.

use std::ops::Range;

use dcb_sparse::block_algebra::gram;
use faer::{Mat, MatRef};

use crate::model::localization::Localization;

/// Forces whose static responses are wanted.
#[derive(Clone, Copy)]
pub enum Loads<'a> {
    /// Unit forces at the rows of L_b; none at those of output interfaces.
    Interfaces(&'a Localization),
    /// Given ones.
    Columns {
        /// Over the model's dofs, (n_c, n).
        forces: MatRef<'a, f64>,
        /// Names, (n).
        names: &'a [String],
    },
}

impl Loads<'_> {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Interfaces(localization) => localization.len(),
            Self::Columns { forces, .. } => forces.ncols(),
        }
    }

    /// Name of one for messages.
    pub fn name(&self, load: usize) -> String {
        match self {
            Self::Interfaces(localization) => localization.row_name(load),
            Self::Columns { names, .. } => names[load].clone(),
        }
    }

    /// Some of them over the model's dofs, (n_c, count).
    pub fn columns(&self, model_dofs: usize, which: Range<usize>) -> Mat<f64> {
        match self {
            Self::Interfaces(localization) => localization.attachment_columns(model_dofs, which),
            Self::Columns { forces, .. } => forces.subcols(which.start, which.len()).to_owned(),
        }
    }

    /// Work of some of them along motions x, (n_c, k): `xᵀ f`, (k, count).
    pub fn work(&self, x: MatRef<'_, f64>, which: Range<usize>) -> Mat<f64> {
        match self {
            Self::Interfaces(localization) => localization.work(x, which),
            Self::Columns { forces, .. } => gram(x, forces.subcols(which.start, which.len())),
        }
    }
}
