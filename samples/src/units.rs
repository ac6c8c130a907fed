//! The same component in another unit system.

use dcb_formats::component::{Damping, RowStiffness, StressQuantity, Units};
use dcb_formats::{Component, SparseMatrix};

use crate::component::checked;
use crate::sparse::map_entries;

/// A unit system and how many of its units make one of the old ones.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitScale {
    /// Names of the new units.
    pub units: Units,
    /// New length units in one old one.
    pub length: f64,
    /// New mass units in one old one.
    pub mass: f64,
    /// New time units in one old one.
    pub time: f64,
}

impl UnitScale {
    /// From SI to millimetre, tonne, second (force in newton, stress in megapascal).
    pub fn mm_t_s() -> Self {
        let units = Units {
            length: "mm".into(),
            mass: "t".into(),
            time: "s".into(),
        };
        Self {
            units,
            length: 1e3,
            mass: 1e-3,
            time: 1.0,
        }
    }
}

/// Scales coordinates, stiffness, mass, component masses and damping; rows and columns of rotations gain one length
/// each. Rows given as `explicit_boundary`, and internal rows, are taken to be translations.
pub fn in_units(component: &Component, scale: &UnitScale) -> Component {
    let rotation: Vec<i32> = component
        .dofs
        .rows()
        .iter()
        .map(|owner| i32::from(owner.dof().is_some_and(|dof| dof.direction.is_rotation())))
        .collect();
    let scaled = |matrix: &SparseMatrix, factor: f64| {
        map_entries(matrix, |row, column, value| {
            value * (factor * scale.length.powi(rotation[row] + rotation[column]))
        })
    };
    let mut result = component.clone().into_draft();
    result.units = scale.units.clone();
    result.stiffness = scaled(&component.stiffness, scale.mass / (scale.time * scale.time));
    result.mass = scaled(&component.mass, scale.mass);
    for matrix in result
        .component_masses
        .iter_mut()
        .flat_map(|masses| &mut masses.matrices)
    {
        *matrix = scaled(matrix, scale.mass);
    }
    let force = scale.mass * scale.length / (scale.time * scale.time);
    for load in &mut result.loads {
        for (value, power) in load.forces.iter_mut().zip(&rotation) {
            *value *= force * scale.length.powi(*power);
        }
    }
    for stress in &mut result.stresses {
        let unit = match stress.quantity {
            StressQuantity::Stress => scale.mass / (scale.length * scale.time * scale.time),
            StressQuantity::Strain => 1.0,
        };
        for point in &mut stress.points {
            point.position = point.position.map(|coordinate| coordinate * scale.length);
        }
        let starts = stress.matrix.col_ptr().to_vec();
        let values = stress.matrix.val_mut();
        for (column, rotation) in rotation.iter().enumerate() {
            let factor = unit * scale.length.powi(rotation - 1);
            for value in &mut values[starts[column] as usize..starts[column + 1] as usize] {
                *value *= factor;
            }
        }
    }
    if let Some(geometric) = &mut result.geometric_stiffness {
        for matrix in geometric.spins.iter_mut().flatten() {
            *matrix = scaled(matrix, scale.mass);
        }
        for RowStiffness { row, matrix } in &mut geometric.rows {
            let moment = i32::from(row.1.is_rotation());
            let per_force = 1.0 / (force * scale.length.powi(moment));
            *matrix = scaled(matrix, scale.mass / (scale.time * scale.time) * per_force);
        }
    }
    if let Some(boundary) = &mut result.explicit_boundary {
        let factors: Vec<f64> = rotation
            .iter()
            .map(|&power| scale.length.powi(power))
            .collect();
        let starts = boundary.col_ptr().to_vec();
        let values = boundary.val_mut();
        for (column, factor) in factors.iter().enumerate() {
            for value in &mut values[starts[column] as usize..starts[column + 1] as usize] {
                *value *= factor;
            }
        }
    }
    for coordinate in &mut result.mesh.coordinates {
        *coordinate *= scale.length;
    }
    for position in result
        .interfaces
        .iter_mut()
        .filter_map(|interface| interface.position.as_mut())
    {
        *position = position.map(|coordinate| coordinate * scale.length);
    }
    if let Damping::Rayleigh { alpha, beta } = &mut result.damping {
        *alpha /= scale.time;
        *beta *= scale.time;
    }
    checked(result)
}
