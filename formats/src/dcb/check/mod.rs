//! Checks of the numbers, whoever made them: the writer refuses to write anything else, the reader to
//! hand it on.

pub(super) mod derivation;
pub(super) mod fields;
mod interfaces;
pub(super) mod rules;

use crate::component::Role;
use crate::mesh::Dimension;
use crate::superelement::{BoundaryRow, LoadedForces, Superelement};
use interfaces::{interfaces, rows};
use rules::{
    Checked, ascending, finite, layers, length, matrix, mirrored, name, not_negative, symmetric,
    symmetric_tensor, trace, wrong,
};

/// Checks a superelement.
pub(super) fn superelement(of: &Superelement) -> Checked {
    let d = of.dimension.coordinate_count();
    let (n_b, n_k) = (of.boundary_row_count(), of.mode_count());
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
    inertia(of)?;
    stiffening(of)?;
    loads(of)?;
    stresses(of)?;
    moments(of)?;
    enrichment(of)
}

fn inertia(of: &Superelement) -> Checked {
    let (d, n) = (of.dimension.coordinate_count(), of.basis_count());
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
    let axes = match of.dimension {
        Dimension::Planar => 1,
        Dimension::Spatial => 3,
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
        .try_for_each(|layer| mirrored("/inertia/I2", layer.as_ref(), 1.0, scale))
}

fn enrichment(of: &Superelement) -> Checked {
    let (n_b, n_k, n) = (of.boundary_row_count(), of.mode_count(), of.basis_count());
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

fn stresses(of: &Superelement) -> Checked {
    let mut names = std::collections::HashSet::new();
    for (index, field) in of.stresses.iter().enumerate() {
        let named = "/stress/names";
        name(named, &format!("name {index}"), &field.name)?;
        if !names.insert(field.name.as_str()) {
            return wrong(named, format!("{:?} stands there twice", field.name));
        }
        if field.points.is_empty() || field.components.is_empty() {
            return wrong(
                "/stress/rows",
                format!("{:?} has no row; each field needs one", field.name),
            );
        }
        let mut seen = std::collections::HashSet::new();
        if !field
            .components
            .iter()
            .all(|component| seen.insert(component))
        {
            return wrong(
                "/stress/rows",
                format!("{:?} has a component twice", field.name),
            );
        }
        for point in &field.points {
            finite("/stress/points", &point.position)?;
        }
        let rows = field.points.len() * field.components.len();
        matrix("/stress/shapes", &field.shapes, rows, of.basis_count())?;
        if let Some(omitted) = &field.omitted {
            length("/stress/omitted", omitted.len(), rows)?;
            not_negative("/stress/omitted", omitted)?;
        }
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
