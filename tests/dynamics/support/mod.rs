//! Small superelements through their files, and their energy summed over the nodes.

pub mod cloud;
pub mod frames;
pub mod free;
pub mod mechanisms;

use dcb_formats::Component;
use dcb_formats::mesh::Dimension;
use dcb_reducer::{Reduced, Reduction, reduce};
use dcb_runtime::{FlexibleBody, InertiaTerms};
use dcb_samples::spatial_beam::BeamSection;
use dcb_samples::{
    Material, PseudoRandom, RodSection, SolidElement, SpatialBeam, box_block, planar_rod,
    spatial_beam,
};
use dcb_tests::dense::dense;
use faer::{Mat, MatRef};
use nalgebra::{Matrix3, Vector3};

/// A component, its reduction, and the body that a reader of the file gets.
pub struct Part {
    pub component: Component,
    pub reduced: Reduced,
    pub body: FlexibleBody,
}

impl Part {
    pub fn reduced(component: Component, modes: usize) -> Self {
        Self::with(component, &Reduction::lowest(modes))
    }

    pub fn with(component: Component, options: &Reduction) -> Self {
        let reduced = reduce(&component, options, &mut ()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.dcb.h5");
        dcb_tests::write_bare(&path, &reduced.superelement);
        let body = FlexibleBody::load(&path).unwrap();
        Self {
            component,
            reduced,
            body,
        }
    }

    /// Ψ_r over all dofs, (n_e, n).
    pub fn basis(&self) -> Mat<f64> {
        let recovery = &self.reduced.recovery;
        let mut attachments = &recovery.residual * &self.body.attachment_transform;
        if let Some(further) = &recovery.enrichment {
            attachments += further * &self.body.further_transform;
        }
        let n_k = recovery.modes.ncols();
        Mat::from_fn(
            recovery.modes.nrows(),
            n_k + attachments.ncols(),
            |i, j| match j < n_k {
                true => recovery.modes[(i, j)],
                false => attachments[(i, j - n_k)],
            },
        )
    }

    pub fn terms(&self) -> InertiaTerms {
        InertiaTerms::for_coordinates(self.body.coordinate_count())
    }

    /// Axis-aligned spin that the part can have.
    pub fn spin(&self, spin: Vector3<f64>) -> Vector3<f64> {
        match self.component.dimension() {
            Dimension::Planar => Vector3::new(0.0, 0.0, spin.z),
            Dimension::Spatial => spin,
        }
    }

    pub fn velocity(&self, velocity: Vector3<f64>) -> Vector3<f64> {
        match self.component.dimension() {
            Dimension::Planar => Vector3::new(velocity.x, velocity.y, 0.0),
            Dimension::Spatial => velocity,
        }
    }
}

/// The parts that every identity is tried on: a beam with exact component masses in the plane and in space, and a solid.
pub fn parts() -> Vec<(&'static str, Part)> {
    let beam = SpatialBeam {
        start: [0.1, 0.2, -0.1],
        end: [0.7, 0.5, 0.3],
        roll: 0.4,
        section: BeamSection::rectangle(0.02, 0.05),
        ..SpatialBeam::default()
    };
    vec![
        (
            "planar rod",
            Part::reduced(
                planar_rod(
                    4,
                    &RodSection {
                        angle: 0.3,
                        ..RodSection::default()
                    },
                ),
                4,
            ),
        ),
        ("spatial beam", Part::reduced(spatial_beam(&beam), 5)),
        (
            "box",
            Part::reduced(
                box_block(
                    [3, 2, 2],
                    [0.4, 0.2, 0.1],
                    SolidElement::Hexahedron,
                    &Material::SOFT,
                ),
                6,
            ),
        ),
    ]
}

/// Repeatable numbers in (-1, 1).
pub fn numbers(count: usize, seed: u64) -> Vec<f64> {
    PseudoRandom::new(seed).numbers(count)
}

/// Coordinates whose largest nodal translation is `size`.
pub fn deflection(basis: &Mat<f64>, size: f64, seed: u64) -> Vec<f64> {
    let y = numbers(basis.ncols(), seed);
    let u = product(basis, &y);
    let largest = u.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    y.iter().map(|y| y * size / largest).collect()
}

pub fn product(matrix: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    (0..matrix.nrows())
        .map(|i| (0..x.len()).map(|j| matrix[(i, j)] * x[j]).sum())
        .collect()
}

fn bilinear(x: &[f64], matrix: MatRef<'_, f64>, y: &[f64]) -> f64 {
    (0..x.len())
        .map(|i| x[i] * (0..y.len()).map(|j| matrix[(i, j)] * y[j]).sum::<f64>())
        .sum()
}

/// Kinetic energy of the finite element model itself: no invariants, only nodal velocities (body axes) and the mass matrix;
/// nodes with rotations through the element-integrated component masses.
pub fn nodal_energy(
    part: &Part,
    velocity: &Vector3<f64>,
    spin: &Vector3<f64>,
    y: &[f64],
    rates: &[f64],
) -> f64 {
    let component = &part.component;
    let origin = Vector3::from(part.body.origin);
    let basis = part.basis();
    let (u, du) = (product(&basis, y), product(&basis, rates));
    let dofs = component.dofs.nodal_dofs();
    let position = |row: usize| Vector3::from(component.mesh.position(dofs[row].node)) - origin;
    // A nodal vector field's value at the node of a row, all three components.
    let at_node = |field: &[f64], row: usize| {
        Vector3::from_fn(|axis, _| {
            let direction = dcb_formats::mesh::Direction::ALL[axis];
            component
                .dofs
                .row(dofs[row].node, direction)
                .map_or(0.0, |at| field[at])
        })
    };
    // Rigid motion and rate of deflection at every dof.
    let rigid: Vec<f64> = (0..dofs.len())
        .map(|row| {
            let axis = dofs[row].direction.axis();
            match dofs[row].direction.is_rotation() {
                true => spin[axis] + du[row],
                false => (velocity + spin.cross(&position(row)))[axis] + du[row],
            }
        })
        .collect();
    let mass = dense(&component.mass);
    let Some(masses) = &component.component_masses else {
        let nodal: Vec<f64> = (0..dofs.len())
            .map(|row| rigid[row] + spin.cross(&at_node(&u, row))[dofs[row].direction.axis()])
            .collect();
        return 0.5 * bilinear(&nodal, mass.as_ref(), &nodal);
    };
    // ω × u has components whose shape functions are those of other components: field[c][b] is interpolated by N_b and
    // counts in direction c.
    let d = component.dimension().coordinate_count();
    let order: &[(usize, usize)] = match d {
        2 => &[(0, 0), (1, 1), (0, 1)],
        _ => &[(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)],
    };
    let matrices: Vec<Mat<f64>> = masses.matrices.iter().map(dense).collect();
    let pair =
        |b: usize, e: usize, x: &[f64], z: &[f64]| match order.iter().position(|p| *p == (b, e)) {
            Some(at) => bilinear(x, matrices[at].as_ref(), z),
            None => bilinear(
                z,
                matrices[order.iter().position(|p| *p == (e, b)).unwrap()].as_ref(),
                x,
            ),
        };
    type Fields = Vec<Vec<Vec<f64>>>;
    let inner = |f: &Fields, g: &Fields| -> f64 {
        let mut sum = 0.0;
        for (f, g) in f.iter().zip(g) {
            for (b, of_b) in f.iter().enumerate() {
                for (e, of_e) in g.iter().enumerate() {
                    sum += pair(b, e, of_b, of_e);
                }
            }
        }
        sum
    };
    let skew = Matrix3::new(
        0.0, -spin.z, spin.y, spin.z, 0.0, -spin.x, -spin.y, spin.x, 0.0,
    );
    let fields = |along: &dyn Fn(usize) -> f64, crossed: &dyn Fn(usize) -> f64| -> Fields {
        let entry = |c: usize, b: usize, row: usize| {
            skew[(c, b)] * crossed(row) + if c == b { along(row) } else { 0.0 }
        };
        (0..d)
            .map(|c| {
                (0..d)
                    .map(|b| (0..dofs.len()).map(|row| entry(c, b, row)).collect())
                    .collect()
            })
            .collect()
    };
    let translation = |row: usize| {
        if dofs[row].direction.is_rotation() {
            0.0
        } else {
            1.0
        }
    };
    let axis = |row: usize| dofs[row].direction.axis();
    let rigid_part = fields(
        &|row| velocity[axis(row)] * translation(row) + du[row],
        &|row| position(row)[axis(row)] * translation(row),
    );
    let turned = fields(&|_| 0.0, &|row| u[row]);
    0.5 * bilinear(&rigid, mass.as_ref(), &rigid)
        + inner(&rigid_part, &turned)
        + 0.5 * inner(&turned, &turned)
}
