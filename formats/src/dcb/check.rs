//! What must hold of the numbers, whoever made them: the writer refuses to write anything else, the reader to
//! hand it on.

use super::rules::{
    Checked, ascending, finite, layers, length, matrix, mirrored, name, not_negative, symmetric,
    symmetric_tensor, trace, wrong,
};
use crate::component::{InterfaceKind, Role};
use crate::mesh::{Dimension, Direction};
use crate::superelement::{BoundaryRow, InterfaceFrame, LoadedForces, Superelement};

/// Rotation matrices may differ from orthonormal by this much.
const ROTATION_TOLERANCE: f64 = 1e-9;

/// Checks a superelement.
pub(super) fn superelement(of: &Superelement) -> Checked {
    let d = of.dimension.coordinate_count();
    let (n_b, n_k, n) = (of.boundary_row_count(), of.mode_count(), of.basis_count());
    name("/", "name", &of.name)?;
    for (attribute, text) in [
        ("length", &of.units.length),
        ("mass", &of.units.mass),
        ("time", &of.units.time),
    ] {
        name("/", attribute, text)?;
    }
    finite("/frame/origin", &of.origin[..d])?;
    interfaces(of)?;
    rows(of)?;

    let modes = &of.modes;
    ascending("/modes/eigenvalues", &modes.eigenvalues)?;
    length("/modes/damping", modes.damping.len(), n_k)?;
    not_negative("/modes/damping", &modes.damping)?;
    not_negative("/modes/damping", &[modes.residual_damping])?;
    matrix("/modes/interface_shapes", &modes.interface_shapes, n_b, n_k)?;
    let first_omitted = modes.first_omitted_eigenvalue;
    if first_omitted.is_nan() || first_omitted < 0.0 {
        return wrong(
            "/modes",
            format!("first_omitted_eigenvalue is {first_omitted}; it must be positive or infinite"),
        );
    }

    residual(of)?;

    let inertia = &of.inertia;
    if !(inertia.mass.is_finite() && inertia.mass > 0.0) {
        return wrong(
            "/inertia/mass",
            format!("is {}; it must be positive", inertia.mass),
        );
    }
    match of.dimension {
        Dimension::Planar => not_negative("/inertia/tensor", &[inertia.tensor[2][2]])?,
        Dimension::Spatial => {
            symmetric_tensor("/inertia/tensor", &inertia.tensor, trace(&inertia.tensor))?
        }
    }
    matrix("/inertia/L1", &inertia.l1, d, n)?;
    length("/inertia/I1", inertia.i1.len(), n)?;
    let axes = if of.dimension == Dimension::Planar {
        1
    } else {
        3
    };
    matrix("/inertia/I3", &inertia.i3, axes, n)?;
    layers("/inertia/L3", &inertia.l3, axes, n)?;
    layers("/inertia/I2", &inertia.i2, if axes == 1 { 0 } else { 6 }, n)?;
    // By Cauchy and Schwarz the entries of these are bounded by the mass norms of their columns.
    let norms = mass_norms(of);
    for (block, norm) in inertia.i1.iter().zip(&norms) {
        match of.dimension {
            Dimension::Planar => finite("/inertia/I1", &[block[2][2]])?,
            Dimension::Spatial => symmetric_tensor(
                "/inertia/I1",
                block,
                norm * trace(&inertia.tensor).max(0.0).sqrt(),
            )?,
        }
    }
    let scale = |i: usize, j: usize| norms[i] * norms[j];
    inertia
        .l3
        .iter()
        .try_for_each(|layer| mirrored("/inertia/L3", layer.as_ref(), -1.0, scale))?;
    inertia
        .i2
        .iter()
        .try_for_each(|layer| mirrored("/inertia/I2", layer.as_ref(), 1.0, scale))?;

    stiffening(of)?;
    loads(of)?;
    moments(of)?;
    if let Some(enrichment) = &of.enrichment {
        if !enrichment.names.is_empty() {
            length("/enrichment/names", enrichment.names.len(), n - n_k - n_b)?;
        }
        for (index, text) in enrichment.names.iter().enumerate() {
            name("/enrichment/names", &format!("name {index}"), text)?;
        }
        matrix(
            "/enrichment/interface_shapes",
            &enrichment.interface_shapes,
            n_b,
            n - n_k - n_b,
        )?;
        matrix("/reduced/mass", &enrichment.reduced_mass, n, n)?;
        matrix("/reduced/stiffness", &enrichment.reduced_stiffness, n, n)?;
        symmetric("/reduced/mass", enrichment.reduced_mass.as_ref())?;
        symmetric("/reduced/stiffness", enrichment.reduced_stiffness.as_ref())?;
    }
    Ok(())
}

fn interfaces(of: &Superelement) -> Checked {
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

fn rows(of: &Superelement) -> Checked {
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

fn residual(of: &Superelement) -> Checked {
    let residual = &of.residual;
    let (n_b, rank) = (of.boundary_row_count(), residual.sigma_squared.len());
    matrix("/residual/flexibility", &residual.flexibility, n_b, n_b)?;
    matrix("/residual/mass", &residual.mass, n_b, n_b)?;
    matrix("/residual/transform", &residual.transform, n_b, rank)?;
    symmetric("/residual/flexibility", residual.flexibility.as_ref())?;
    symmetric("/residual/mass", residual.mass.as_ref())?;
    length(
        "/residual/mass_diagonal0",
        residual.mass_diagonal0.len(),
        n_b,
    )?;
    not_negative("/residual/mass_diagonal0", &residual.mass_diagonal0)?;
    ascending("/residual/sigma2", &residual.sigma_squared)?;
    if rank > n_b {
        return wrong(
            "/residual/transform",
            format!("has rank {rank} over {n_b} rows"),
        );
    }
    if !(residual.tolerance.is_finite() && residual.tolerance >= 0.0) {
        return wrong(
            "/residual/transform",
            format!(
                "tolerance is {}; it must not be negative",
                residual.tolerance
            ),
        );
    }
    if let Some(shapes) = &residual.output_shapes {
        matrix("/residual/output_shapes", shapes, n_b, n_b)?;
    }
    for (b, row) in of
        .rows
        .iter()
        .enumerate()
        .filter(|(_, row)| is_output(of, row))
    {
        let zero = |path: &str, mut values: Box<dyn Iterator<Item = f64> + '_>| match values
            .all(|value| value == 0.0)
        {
            true => Ok(()),
            false => wrong(
                path,
                format!(
                    "row {b} belongs to the output interface {:?} and must be zero",
                    of.interfaces[row.interface].name
                ),
            ),
        };
        zero(
            "/residual/flexibility",
            Box::new((0..n_b).map(|c| residual.flexibility[(b, c)])),
        )?;
        zero(
            "/residual/mass",
            Box::new((0..n_b).map(|c| residual.mass[(b, c)])),
        )?;
        zero(
            "/residual/transform",
            Box::new((0..rank).map(|c| residual.transform[(b, c)])),
        )?;
        zero(
            "/residual/mass_diagonal0",
            Box::new(std::iter::once(residual.mass_diagonal0[b])),
        )?;
        if let Some(shapes) = &residual.output_shapes {
            zero(
                "/residual/output_shapes",
                Box::new((0..n_b).map(|c| shapes[(c, b)])),
            )?;
        }
    }
    Ok(())
}

fn is_output(of: &Superelement, row: &BoundaryRow) -> bool {
    of.interfaces
        .get(row.interface)
        .is_some_and(|interface| interface.role == Role::Output)
}

fn stiffening(of: &Superelement) -> Checked {
    let n = of.basis_count();
    let parts = [
        (
            "/stiffening/centrifugal",
            &of.stiffening.centrifugal,
            if of.dimension == Dimension::Planar {
                1
            } else {
                6
            },
        ),
        (
            "/stiffening/interface",
            &of.stiffening.interface,
            of.boundary_row_count(),
        ),
    ];
    for (path, matrices, count) in parts {
        if matrices.is_empty() {
            continue;
        }
        layers(path, matrices, count, n)?;
        for layer in matrices {
            let largest: Vec<f64> = (0..n)
                .map(|i| (0..n).fold(0.0, |most: f64, j| most.max(layer[(i, j)].abs())))
                .collect();
            mirrored(path, layer.as_ref(), 1.0, |i, j| largest[i].min(largest[j]))?;
        }
    }
    Ok(())
}

fn loads(of: &Superelement) -> Checked {
    let mut names = std::collections::HashSet::new();
    for (index, load) in of.loads.iter().enumerate() {
        name("/loads/names", &format!("name {index}"), &load.name)?;
        if !names.insert(load.name.as_str()) {
            return wrong(
                "/loads/names",
                format!("{:?} stands there twice", load.name),
            );
        }
        finite("/loads/forces", &load.force)?;
        finite("/loads/moments", &load.moment)?;
        length("/loads/work", load.work.len(), of.basis_count())?;
        finite("/loads/work", &load.work)?;
    }
    Ok(())
}

fn moments(of: &Superelement) -> Checked {
    let Some(moments) = &of.moments else {
        return Ok(());
    };
    let (n_k, n_b) = (of.mode_count(), of.boundary_row_count());
    let n = of.basis_count() - n_k;
    let bound = moments.eigenvalue_bound;
    if bound.is_nan() || bound <= 0.0 {
        return wrong(
            "/error",
            format!("eigenvalue_bound is {bound}; it must be positive"),
        );
    }
    let shift = moments.shift;
    if !shift.is_finite() || shift < 0.0 {
        return wrong(
            "/error",
            format!("shift is {shift}; it must be finite and not negative"),
        );
    }
    for (path, values, count) in [
        ("/error/eigenvalue_errors", &moments.eigenvalue_errors, n_k),
        ("/error/rounding", &moments.rounding, n),
    ] {
        length(path, values.len(), count)?;
        not_negative(path, values)?;
    }
    let rigid = moments.rigid_shapes.ncols();
    matrix("/error/rigid_shapes", &moments.rigid_shapes, n_b, rigid)?;
    for (path, moment) in [
        ("/error/moment_1", &moments.first),
        ("/error/moment_2", &moments.second),
        ("/error/moment_3", &moments.third),
        ("/error/moment_4", &moments.fourth),
    ] {
        matrix(path, moment, n, n)?;
        symmetric(path, moment.as_ref())?;
    }
    match &moments.loaded {
        Some(loaded) => forces(of, loaded, bound),
        None => Ok(()),
    }
}

fn forces(of: &Superelement, loaded: &LoadedForces, least: f64) -> Checked {
    let LoadedForces {
        forces,
        eigenvalue_bound: bound,
    } = loaded;
    if bound.is_nan() || *bound < least {
        return wrong(
            "/error",
            format!(
                "forces_eigenvalue_bound is {bound}; it must not be below eigenvalue_bound, {least}"
            ),
        );
    }
    let path = "/error/forces";
    matrix(path, forces, of.boundary_row_count(), forces.ncols())?;
    for (index, row) in of.rows.iter().enumerate() {
        let is_output = of.interfaces[row.interface].role == Role::Output;
        if is_output && forces.row(index).iter().any(|force| *force != 0.0) {
            return wrong(
                path,
                format!("row {index} is that of an output interface; it must be zero"),
            );
        }
    }
    Ok(())
}

/// √ of the reduced mass's diagonal: 1 for modes.
fn mass_norms(of: &Superelement) -> Vec<f64> {
    match &of.enrichment {
        Some(enrichment) => (0..of.basis_count())
            .map(|j| enrichment.reduced_mass[(j, j)].max(0.0).sqrt())
            .collect(),
        None => {
            let residual =
                (0..of.boundary_row_count()).map(|b| of.residual.mass[(b, b)].max(0.0).sqrt());
            std::iter::repeat_n(1.0, of.mode_count())
                .chain(residual)
                .collect()
        }
    }
}
