//! Checks of the interfaces and of the rows of the boundary localization.

use super::rules::{Checked, finite, name, wrong};
use crate::component::InterfaceKind;
use crate::mesh::{Dimension, Direction};
use crate::superelement::{InterfaceFrame, Superelement};

/// Rotation matrices may differ from orthonormal by this much.
const ROTATION_TOLERANCE: f64 = 1e-9;

/// Names, places and axes of the interfaces.
pub(super) fn interfaces(of: &Superelement) -> Checked {
    let mut names = std::collections::HashSet::new();
    for (index, interface) in of.interfaces.iter().enumerate() {
        name(
            "/interfaces/names",
            &format!("name {index}"),
            &interface.name,
        )?;
        if !names.insert(interface.name.as_str()) {
            return wrong(
                "/interfaces/names",
                format!("{:?} stands there twice", interface.name),
            );
        }
        finite("/interfaces/positions", &interface.position)?;
        rotation(of.dimension, interface)?;
    }
    Ok(())
}

fn rotation(dimension: Dimension, interface: &InterfaceFrame) -> Checked {
    let axes = &interface.orientation;
    let path = "/interfaces/orientations";
    let dot = |a: usize, b: usize| -> f64 { (0..3).map(|k| axes[k][a] * axes[k][b]).sum() };
    let minor = |a: usize, b: usize| axes[1][a] * axes[2][b] - axes[1][b] * axes[2][a];
    let determinant =
        axes[0][0] * minor(1, 2) - axes[0][1] * minor(0, 2) + axes[0][2] * minor(0, 1);
    let mut defect = (determinant - 1.0).abs();
    for a in 0..3 {
        for b in 0..3 {
            let unit = if a == b { 1.0 } else { 0.0 };
            defect = nan_max(defect, (dot(a, b) - unit).abs());
        }
    }
    if defect.is_nan() || defect > ROTATION_TOLERANCE {
        return wrong(
            path,
            format!(
                "the axes of {:?} aren't a rotation matrix: defect {defect:.1e}",
                interface.name
            ),
        );
    }
    if dimension == Dimension::Planar && (axes[2][2] - 1.0).abs() > ROTATION_TOLERANCE {
        return wrong(
            path,
            format!("the axes of {:?} turn out of the plane", interface.name),
        );
    }
    Ok(())
}

fn nan_max(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Rows go by interface, and fit its kind.
pub(super) fn rows(of: &Superelement) -> Checked {
    let mut previous = 0;
    let mut seen = std::collections::HashSet::new();
    for (index, row) in of.rows.iter().enumerate() {
        let path = "/interfaces/dofs";
        let Some(interface) = of.interfaces.get(row.interface) else {
            return wrong(
                path,
                format!(
                    "row {index} names interface {} of {}",
                    row.interface,
                    of.interfaces.len()
                ),
            );
        };
        if row.interface < previous {
            return wrong(
                path,
                format!(
                    "row {index} goes back to interface {}; rows go interface by interface",
                    row.interface
                ),
            );
        }
        previous = row.interface;
        let explicit = interface.kind == InterfaceKind::Boundary;
        let direction = usize::try_from(row.direction)
            .ok()
            .and_then(Direction::from_index);
        let fits = match direction {
            None => explicit && row.direction == -1,
            Some(direction) => !explicit && has_direction(of.dimension, direction),
        };
        if !fits {
            return wrong(
                path,
                format!(
                    "row {index} has dof index {}, which {:?} interfaces of this dimension don't have",
                    row.direction,
                    interface.kind.name()
                ),
            );
        }
        if direction.is_some() && !seen.insert((row.interface, row.node, row.direction)) {
            return wrong(path, format!("row {index} repeats an earlier row"));
        }
        let of_node = interface.kind == InterfaceKind::Nodes;
        if of_node != (0..=i64::from(u32::MAX)).contains(&row.node) || (!of_node && row.node != -1)
        {
            return wrong(
                "/interfaces/row_nodes",
                format!(
                    "row {index} has node {}, of a {:?} interface",
                    row.node,
                    interface.kind.name()
                ),
            );
        }
        finite("/interfaces/row_positions", &row.position)?;
    }
    Ok(())
}

pub(super) fn has_direction(dimension: Dimension, direction: Direction) -> bool {
    dimension.frame_directions().contains(&direction)
}
