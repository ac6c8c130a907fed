//! Rigid interfaces as constraints: their nodes are replaced by one frame each *before* anything else is computed.
//!
//! With u_e = T u_c the reduced model has K_c = Tᵀ K_ee T and M_c = Tᵀ M_ee T; modes and attachments of the model are
//! expanded to all n_e dofs by T, so the interior of a rigid interface is recovered exactly. Without rigid interfaces
//! the model *is* the component and T is the identity.

use std::borrow::Cow;

use dcb_formats::SparseMatrix;
use dcb_formats::component::{Component, Interface, InterfaceKind};
use dcb_formats::mesh::{Direction, MatrixRow};
use faer::sparse::Triplet;
use faer::{Mat, MatRef};
use rayon::prelude::*;

use crate::error::Error;
use crate::model::frame::{merge_entries, offset, rigid_motion};
use crate::model::rigid_frame::{ModelDof, PointMotion, RigidFrame};

/// The matrices that are factorized: the component with its rigid interfaces condensed.
pub struct Model<'a> {
    /// K_c, (n_c, n_c), full symmetric storage.
    pub stiffness: Cow<'a, SparseMatrix>,
    /// M_c, (n_c, n_c), full symmetric storage.
    pub mass: Cow<'a, SparseMatrix>,
    /// Dofs in model order.
    pub dofs: Vec<ModelDof>,
    /// Frames of rigid interfaces.
    pub frames: Vec<RigidFrame>,
    /// Nodes of the mesh; points from here on are frames.
    node_count: usize,
    /// T by rows, (n_e) rows of (model dof, coefficient); `None` where it is the identity.
    expansion: Option<Vec<Vec<(u32, f64)>>>,
}

impl<'a> Model<'a> {
    /// Condenses the component's rigid interfaces.
    ///
    /// # Errors
    /// [`Error::Interface`] naming the interface that can't carry a moment asked for.
    pub fn of(component: &'a Component) -> Result<Self, Error> {
        let mut owner: Vec<Option<usize>> = vec![None; component.mesh.node_count()];
        let rigid: Vec<(usize, &Interface)> = component
            .interfaces
            .iter()
            .enumerate()
            .filter(|(_, i)| i.kind == InterfaceKind::Rigid)
            .collect();
        for (index, interface) in &rigid {
            for node in &interface.nodes {
                owner[*node as usize] = Some(*index);
            }
        }
        let mut model = Self {
            stiffness: Cow::Borrowed(&component.stiffness),
            mass: Cow::Borrowed(&component.mass),
            dofs: Vec::new(),
            frames: Vec::new(),
            node_count: component.mesh.node_count(),
            expansion: None,
        };
        let mut expansion = Vec::with_capacity(component.dofs.len());
        let mut next_internal = (component.mesh.node_count() + rigid.len()) as u32;
        for row in component.dofs.rows() {
            let kept = match row {
                MatrixRow::Nodal(dof) if owner[dof.node as usize].is_some() => None,
                MatrixRow::Nodal(dof) => {
                    let position = component.mesh.position(dof.node);
                    Some(ModelDof::of_point(dof.node, dof.direction, position))
                }
                MatrixRow::Internal => {
                    let point = next_internal;
                    next_internal += 1;
                    Some(ModelDof {
                        point,
                        motion: None,
                    })
                }
            };
            expansion.push(match kept {
                Some(_) => vec![(model.dofs.len() as u32, 1.0)],
                None => Vec::new(),
            });
            model.dofs.extend(kept);
        }
        if rigid.is_empty() {
            return Ok(model);
        }
        for (index, interface) in rigid {
            let frame = RigidFrame::of(
                component,
                index,
                interface,
                model.frames.len(),
                &mut model.dofs,
            )?;
            for node in &interface.nodes {
                let arm = offset(component.mesh.position(*node), frame.position);
                for nodal in Direction::ALL {
                    if let Some(row) = component.dofs.row(*node, nodal) {
                        let entries = frame
                            .dofs
                            .iter()
                            .map(|(d, dof)| (*dof, rigid_motion(*d, arm)[nodal.index()]));
                        expansion[row] = merge_entries(entries.collect());
                    }
                }
            }
            model.frames.push(frame);
        }
        model.stiffness = Cow::Owned(congruence(
            &component.stiffness,
            &expansion,
            model.dofs.len(),
        )?);
        model.mass = Cow::Owned(congruence(&component.mass, &expansion, model.dofs.len())?);
        model.expansion = Some(expansion);
        Ok(model)
    }

    /// n_c.
    pub fn len(&self) -> usize {
        self.dofs.len()
    }

    /// Whether the model has no dof.
    pub fn is_empty(&self) -> bool {
        self.dofs.is_empty()
    }

    /// The frame of a component's interface, if it is rigid.
    pub fn frame_of(&self, interface: usize) -> Option<&RigidFrame> {
        self.frames
            .iter()
            .find(|frame| frame.interface == interface)
    }

    /// A row over the component's dofs as a row over the model's: `row T`.
    pub fn condensed_row(&self, row: &[(u32, f64)]) -> Vec<(u32, f64)> {
        match &self.expansion {
            None => merge_entries(row.to_vec()),
            Some(expansion) => merge_entries(
                row.iter()
                    .flat_map(|(dof, value)| {
                        expansion[*dof as usize]
                            .iter()
                            .map(move |(to, c)| (*to, value * c))
                    })
                    .collect(),
            ),
        }
    }

    /// `T x`, (n_e, k): model columns expanded to all dofs of the component.
    pub fn expand<'x>(&self, x: MatRef<'x, f64>) -> CowMat<'x> {
        match &self.expansion {
            None => CowMat::Borrowed(x),
            Some(expansion) => {
                CowMat::Owned(Mat::from_fn(expansion.len(), x.ncols(), |row, column| {
                    expansion[row]
                        .iter()
                        .map(|(dof, c)| c * x[(*dof as usize, column)])
                        .sum()
                }))
            }
        }
    }

    /// `T⁺ x`, (n_c, k): columns over all dofs of the component seen by the model, rigid interfaces by their frames.
    pub fn contract(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let Some(expansion) = &self.expansion else {
            return x.to_owned();
        };
        let mut contracted = Mat::zeros(self.len(), x.ncols());
        let frame_start = self
            .frames
            .iter()
            .flat_map(|frame| &frame.dofs)
            .map(|(_, dof)| *dof)
            .min()
            .unwrap_or(u32::MAX);
        for (row, entries) in expansion.iter().enumerate() {
            if let [(dof, _)] = entries[..]
                && dof < frame_start
            {
                contracted
                    .as_mut()
                    .row_mut(dof as usize)
                    .copy_from(x.row(row));
            }
        }
        for frame in &self.frames {
            for ((_, dof), row) in frame.dofs.iter().zip(&frame.from_nodes) {
                for column in 0..x.ncols() {
                    contracted[(*dof as usize, column)] =
                        row.iter().map(|(i, c)| c * x[(*i as usize, column)]).sum();
                }
            }
        }
        contracted
    }

    /// `Tᵀ f`, (n_c, k): forces on all dofs of the component as the model feels them.
    pub fn condensed_forces(&self, f: Mat<f64>) -> Mat<f64> {
        let Some(expansion) = &self.expansion else {
            return f;
        };
        let mut condensed = Mat::zeros(self.len(), f.ncols());
        for (row, entries) in expansion.iter().enumerate() {
            for (dof, c) in entries {
                for column in 0..f.ncols() {
                    condensed[(*dof as usize, column)] += c * f[(row, column)];
                }
            }
        }
        condensed
    }

    /// The point that each dof belongs to, for orderings and graphs.
    pub fn points(&self) -> Vec<u32> {
        self.dofs.iter().map(|dof| dof.point).collect()
    }

    /// Whether a dof is an internal row of the component.
    pub fn is_internal(&self, dof: usize) -> bool {
        self.dofs[dof].motion.is_none()
    }

    /// Amounts of each dof that are alike: 1 of a translation, 1 / `length` of a rotation, and of an internal row, whose unit nobody
    /// knows, what is as stiff as the stiffest translation.
    pub fn unit_amounts(&self, length: f64) -> Vec<f64> {
        let stiffness = |dof: usize| -> f64 {
            let entry = self.stiffness.as_ref().get(dof, dof);
            entry.copied().unwrap_or(0.0).max(0.0)
        };
        let translations =
            (0..self.len()).filter(|dof| !self.is_internal(*dof) && !self.dofs[*dof].is_rotation());
        let stiffest = match self.dofs.iter().any(|dof| dof.motion.is_none()) {
            true => translations.map(stiffness).fold(0.0, f64::max),
            false => 0.0,
        };
        let amount = |dof: usize| match self.dofs[dof].motion {
            Some(motion) if motion.direction.is_rotation() => 1.0 / length,
            Some(_) => 1.0,
            None if stiffest > 0.0 && stiffness(dof) > 0.0 => (stiffest / stiffness(dof)).sqrt(),
            None => 1.0,
        };
        (0..self.len()).map(amount).collect()
    }

    /// Name of a dof for messages: `node 17 uy`, `interface "hub" rx`, or `internal row 17`.
    pub fn dof_name(&self, dof: usize) -> String {
        let ModelDof { point, motion } = self.dofs[dof];
        let Some(PointMotion { direction, .. }) = motion else {
            return format!("internal row {}", self.row_of(dof as u32));
        };
        match (point as usize).checked_sub(self.node_count) {
            None => format!("node {point} {}", direction.name()),
            Some(frame) => format!(
                "interface {:?} {}",
                self.frames[frame].name,
                direction.name()
            ),
        }
    }

    /// Row of the component that a dof is.
    fn row_of(&self, dof: u32) -> usize {
        let is_this = |entries: &Vec<(u32, f64)>| entries.first() == Some(&(dof, 1.0));
        match &self.expansion {
            Some(expansion) => expansion.iter().position(is_this).unwrap_or(dof as usize),
            None => dof as usize,
        }
    }
}

/// A matrix that is borrowed where nothing had to be computed.
pub enum CowMat<'a> {
    /// As it was.
    Borrowed(MatRef<'a, f64>),
    /// Computed.
    Owned(Mat<f64>),
}

impl CowMat<'_> {
    /// The matrix.
    pub fn as_ref(&self) -> MatRef<'_, f64> {
        match self {
            Self::Borrowed(matrix) => *matrix,
            Self::Owned(matrix) => matrix.as_ref(),
        }
    }

    /// The matrix if it was computed.
    pub fn computed(self) -> Option<Mat<f64>> {
        match self {
            Self::Borrowed(_) => None,
            Self::Owned(matrix) => Some(matrix),
        }
    }
}

/// `Tᵀ A T` for symmetric A, exactly symmetric.
fn congruence(
    matrix: &SparseMatrix,
    expansion: &[Vec<(u32, f64)>],
    size: usize,
) -> Result<SparseMatrix, Error> {
    // Entries on or above the diagonal of the result; the rest is their mirror image.
    let entries: Vec<Triplet<u32, u32, f64>> = (0..matrix.ncols())
        .into_par_iter()
        .flat_map_iter(|column| {
            let to_column = &expansion[column];
            matrix
                .row_idx_of_col_raw(column)
                .iter()
                .zip(matrix.val_of_col(column))
                .flat_map(move |(row, value)| {
                    expansion[*row as usize].iter().flat_map(move |(i, ci)| {
                        to_column
                            .iter()
                            .filter(move |(j, _)| i <= j)
                            .map(move |(j, cj)| Triplet::new(*i, *j, ci * value * cj))
                    })
                })
        })
        .collect();
    let out_of_memory = |_| Error::OutOfMemory {
        what: "the condensed matrices",
    };
    let upper = SparseMatrix::try_new_from_triplets(size, size, &entries).map_err(out_of_memory)?;
    drop(entries);
    let mut mirrored = Vec::with_capacity(2 * upper.compute_nnz());
    for column in 0..size {
        for (row, value) in upper
            .row_idx_of_col_raw(column)
            .iter()
            .zip(upper.val_of_col(column))
        {
            let (i, j) = (*row, column as u32);
            mirrored.push(Triplet::new(i, j, *value));
            if i != j {
                mirrored.push(Triplet::new(j, i, *value));
            }
        }
    }
    SparseMatrix::try_new_from_triplets(size, size, &mirrored).map_err(out_of_memory)
}
