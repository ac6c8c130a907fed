//! Shapes of a basis over every row of the component's matrices: what the fields of the nodes leave out where rows are internal.

use dcb_formats::RecoveryBasis;
use dcb_formats::mesh::DofMap;
use faer::{Mat, MatRef};

use crate::error::Error;
use crate::pipeline::Reduced;

/// A reduction together with its shapes over all rows.
#[derive(Clone, Debug)]
pub struct WholeReduction {
    /// Its results.
    pub reduced: Reduced,
    /// Shapes over all rows; `None` where the fields of the nodes are all there are.
    rows: Option<RowShapes>,
}

/// Blocks of Ψ over all rows.
#[derive(Clone, Debug)]
pub(super) struct RowShapes {
    pub modes: Mat<f64>,
    pub residual: Mat<f64>,
    pub enrichment: Option<Mat<f64>>,
}

/// Blocks of Ψ over all rows, internal ones too, to be read.
#[derive(Clone, Copy, Debug)]
pub struct RowShapesRef<'a> {
    /// Φ, (n_e, n_k).
    pub modes: MatRef<'a, f64>,
    /// G_res L_bᵀ, (n_e, n_b).
    pub residual: MatRef<'a, f64>,
    /// X, (n_e, n_x).
    pub enrichment: Option<MatRef<'a, f64>>,
}

impl WholeReduction {
    pub(super) fn new(reduced: Reduced, rows: Option<RowShapes>) -> Self {
        Self { reduced, rows }
    }

    /// The same where it is good enough.
    ///
    /// # Errors
    /// As [`Reduced::accepted`].
    pub fn accepted(self) -> Result<Self, Error> {
        Ok(Self {
            reduced: self.reduced.accepted()?,
            ..self
        })
    }

    /// Shapes over all rows.
    pub fn shapes(&self) -> RowShapesRef<'_> {
        let fields = &self.reduced.recovery;
        match &self.rows {
            Some(rows) => RowShapesRef {
                modes: rows.modes.as_ref(),
                residual: rows.residual.as_ref(),
                enrichment: rows.enrichment.as_ref().map(Mat::as_ref),
            },
            None => RowShapesRef {
                modes: fields.modes.as_ref(),
                residual: fields.residual.as_ref(),
                enrichment: fields.enrichment.as_ref().map(Mat::as_ref),
            },
        }
    }
}

impl RowShapes {
    /// The fields of the nodes, and these shapes where they have more.
    pub(super) fn fields(self, dofs: &DofMap) -> (RecoveryBasis, Option<Self>) {
        if dofs.internal_count() == 0 {
            let fields = RecoveryBasis {
                dofs: dofs.nodal_dofs(),
                modes: self.modes,
                residual: self.residual,
                enrichment: self.enrichment,
            };
            return (fields, None);
        }
        let rows: Vec<usize> = dofs.nodal().map(|(row, _)| row).collect();
        let of_nodes =
            |all: &Mat<f64>| Mat::from_fn(rows.len(), all.ncols(), |i, j| all[(rows[i], j)]);
        let fields = RecoveryBasis {
            dofs: dofs.nodal_dofs(),
            modes: of_nodes(&self.modes),
            residual: of_nodes(&self.residual),
            enrichment: self.enrichment.as_ref().map(of_nodes),
        };
        (fields, Some(self))
    }
}
