//! Whether component masses have the moments that `M_cd = ∫ ρ N_cᵀ N_d dV` must have.
//!
//! With T_b the unit translation along b and X_a the unit rotation about a through the mean node position, N_c T_b = δ_bc
//! and N_c X_a = (e_a × r)_c at every material point, whatever the elements. M = Σ_c M_cc then predicts, for every pair,
//! ```text
//! T_bᵀ M_cd T_e = m δ_bc δ_ed        m from M
//! T_bᵀ M_cd X_a = δ_bc T_dᵀ M X_a    = δ_bc ∫ ρ (e_a × r)_d
//! X_aᵀ M_cd T_b = δ_bd T_cᵀ M X_a
//! ```
//! A matrix that is zero, transposed or in another's place has other moments. Fields that the dofs can't represent (those of
//! a held component, recognized by K x ≠ 0) are left out; second moments too, because lumped masses don't keep them.

use super::fault::{ComponentFault, Place};
use super::{ComponentDraft, ComponentMasses};
use crate::SparseMatrix;
use crate::mesh::{Direction, DofMap, Mesh};

/// Moments may differ by this, relative to the mass times the component's size.
const MOMENT_TOLERANCE: f64 = 1e-6;
/// A row of K x this small, relative to its terms, is zero.
const FREE_TOLERANCE: f64 = 1e-6;

/// A rigid motion over all dofs.
struct RigidField {
    direction: Direction,
    values: Vec<f64>,
}

impl RigidField {
    fn is_translation_along(&self, axis: usize) -> bool {
        !self.direction.is_rotation() && self.direction.axis() == axis
    }
}

/// Checks every component mass.
///
/// # Errors
/// The first one with a wrong moment, with the one found and the one expected.
pub(super) fn check_moments(
    masses: &ComponentMasses,
    of: &ComponentDraft,
) -> Result<(), ComponentFault> {
    let ComponentDraft {
        mesh,
        dofs,
        stiffness,
        mass,
        ..
    } = of;
    let centre = mean_position(mesh);
    let size = (0..mesh.node_count())
        .map(|node| {
            let arm = arm(mesh, node as u32, centre);
            arm.iter().map(|x| x * x).sum::<f64>().sqrt()
        })
        .fold(0.0, f64::max);
    let fields: Vec<RigidField> = mesh
        .dimension
        .frame_directions()
        .iter()
        .map(|direction| rigid_field(*direction, mesh, dofs, centre))
        .filter(|field| is_free(stiffness, field, dofs, size))
        .collect();
    let translation = |axis| fields.iter().find(|field| field.is_translation_along(axis));
    let names = ComponentMasses::names(mesh.dimension);
    for (index, (name, matrix)) in names.iter().zip(&masses.matrices).enumerate() {
        let Some((c, d)) = axes_of(name) else {
            continue;
        };
        let (Some(along_c), Some(along_d)) = (translation(c), translation(d)) else {
            continue;
        };
        let total = product(&along_c.values, mass, &along_c.values);
        for left in &fields {
            for right in &fields {
                let (unit, expected) =
                    match (left.direction.is_rotation(), right.direction.is_rotation()) {
                        (true, true) => continue,
                        (false, false) => {
                            let kept =
                                left.is_translation_along(c) && right.is_translation_along(d);
                            (total, if kept { total } else { 0.0 })
                        }
                        (false, true) if left.is_translation_along(c) => {
                            (total * size, product(&along_d.values, mass, &right.values))
                        }
                        (true, false) if right.is_translation_along(d) => {
                            (total * size, product(&along_c.values, mass, &left.values))
                        }
                        _ => (total * size, 0.0),
                    };
                let found = product(&left.values, matrix, &right.values);
                if (found - expected).abs() > MOMENT_TOLERANCE * unit.abs().max(expected.abs()) {
                    return Err(ComponentFault::at(
                        Place::ComponentMass(index),
                        format!(
                            "is not the component mass {name} of this component: between its rigid motions {} and {} it gives {found:.6e}, but the mass matrix {expected:.6e} (missing entries, transposed, or another component's file?)",
                            left.direction.name(),
                            right.direction.name()
                        ),
                    ));
                }
            }
        }
    }
    Ok(())
}

/// (0, 1) for `xy`.
fn axes_of(name: &str) -> Option<(usize, usize)> {
    let mut axes = name.chars().map(|letter| "xyz".find(letter));
    Some((axes.next()??, axes.next()??))
}

fn mean_position(mesh: &Mesh) -> [f64; 3] {
    let count = mesh.node_count().max(1) as f64;
    let mut mean = [0.0; 3];
    for node in 0..mesh.node_count() {
        for (sum, x) in mean.iter_mut().zip(mesh.position(node as u32)) {
            *sum += x / count;
        }
    }
    mean
}

fn arm(mesh: &Mesh, node: u32, centre: [f64; 3]) -> [f64; 3] {
    let position = mesh.position(node);
    [0, 1, 2].map(|axis| position[axis] - centre[axis])
}

fn rigid_field(direction: Direction, mesh: &Mesh, dofs: &DofMap, centre: [f64; 3]) -> RigidField {
    let a = direction.axis();
    let value = |node: u32, of: Direction| {
        if of == direction {
            return 1.0;
        }
        if !direction.is_rotation() || of.is_rotation() {
            return 0.0;
        }
        // e_a × arm
        let arm = arm(mesh, node, centre);
        match (of.axis() + 3 - a) % 3 {
            1 => -arm[(a + 2) % 3],
            2 => arm[(a + 1) % 3],
            _ => 0.0,
        }
    };
    RigidField {
        direction,
        values: (dofs.rows().iter())
            .map(|owner| (owner.dof()).map_or(0.0, |dof| value(dof.node, dof.direction)))
            .collect(),
    }
}

/// `K x = 0`, row by row: relative to the row's terms, or to its diagonal times what the field moves at most.
fn is_free(stiffness: &SparseMatrix, field: &RigidField, dofs: &DofMap, size: f64) -> bool {
    let mut force = vec![0.0; stiffness.nrows()];
    let mut scale = vec![0.0; stiffness.nrows()];
    for (column, x) in field.values.iter().enumerate() {
        for (row, value) in entries(stiffness, column) {
            force[row] += value * x;
            scale[row] += (value * x).abs();
            if row == column {
                scale[row] += value.abs()
                    * match (
                        field.direction.is_rotation(),
                        (dofs.dof(row)).is_some_and(|dof| dof.direction.is_rotation()),
                    ) {
                        (true, false) => size,
                        (false, true) if size > 0.0 => 1.0 / size,
                        _ => 1.0,
                    };
            }
        }
    }
    force
        .iter()
        .zip(&scale)
        .all(|(force, scale)| force.abs() <= FREE_TOLERANCE * scale)
}

fn entries(matrix: &SparseMatrix, column: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
    matrix
        .row_idx_of_col_raw(column)
        .iter()
        .zip(matrix.val_of_col(column))
        .map(|(row, value)| (*row as usize, *value))
}

/// `xᵀ A y`.
fn product(x: &[f64], matrix: &SparseMatrix, y: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (column, y) in y.iter().enumerate().filter(|(_, y)| **y != 0.0) {
        let along: f64 = entries(matrix, column)
            .map(|(row, value)| x[row] * value)
            .sum();
        sum += along * y;
    }
    sum
}
