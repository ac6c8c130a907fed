//! A body in dynamic coordinates, and what is refused.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{Part, dense, parts, product};
use dcb_formats::component::Role;
use dcb_formats::superelement::FrameKind;
use dcb_runtime::FlexibleBody;
use dcb_samples::{RodSection, planar_rod};
use faer::Mat;

fn largest(matrix: &Mat<f64>) -> f64 {
    matrix
        .col_iter()
        .flat_map(|column| column.iter())
        .fold(0.0, |most, x| f64::max(most, x.abs()))
}

#[test]
fn dynamic_coordinates_are_orthonormal_and_uncoupled() {
    for (name, part) in parts() {
        let basis = part.basis();
        let n = part.body.coordinate_count();
        assert_eq!(
            n,
            part.body.mode_count + part.reduced.superelement.residual.sigma_squared.len()
        );
        let mass = basis.transpose() * dense(&part.component.mass) * &basis;
        let identity = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == j)));
        assert!(
            largest(&(&mass - &identity)) < 1e-8,
            "{name}: {:e}",
            largest(&(&mass - &identity))
        );
        let stiffness = basis.transpose() * dense(&part.component.stiffness) * &basis;
        let expected = Mat::from_fn(
            n,
            n,
            |i, j| if i == j { part.body.stiffness[i] } else { 0.0 },
        );
        assert!(
            largest(&(&stiffness - &expected)) < 1e-7 * largest(&expected),
            "{name}"
        );
    }
}

#[test]
fn interface_shapes_are_the_field_at_the_interface_nodes() {
    let mut component = planar_rod(4, &RodSection::default());
    component.interfaces[1].role = Role::Output;
    for (name, part) in [
        ("output", Part::reduced(component, 3)),
        (
            "both",
            Part::reduced(planar_rod(4, &RodSection::default()), 3),
        ),
    ] {
        let basis = part.basis();
        let y = common::deflection(&basis, 1e-3, 5);
        let u = product(&basis, &y);
        let at_rows = product(&part.body.interface_shapes, &y);
        for (row, seen) in part.body.rows.iter().zip(at_rows) {
            let direction =
                dcb_formats::mesh::Direction::from_index(row.direction as usize).unwrap();
            let dof = part.component.dofs.row(row.node as u32, direction).unwrap();
            assert!(
                (u[dof] - seen).abs() < 1e-14,
                "{name}: {} against {seen}",
                u[dof]
            );
        }
    }
}

#[test]
fn internal_forces_are_the_gradient_of_the_strain_energy() {
    let part = Part::reduced(planar_rod(4, &RodSection::default()), 3);
    let n = part.body.coordinate_count();
    let y = common::numbers(n, 9);
    let mut forces = vec![0.0; n];
    part.body.internal_forces(&y, &vec![0.0; n], &mut forces);
    for (i, force) in forces.iter().enumerate() {
        let (mut more, mut less) = (y.clone(), y.clone());
        more[i] += 0.5;
        less[i] -= 0.5;
        let slope = part.body.strain_energy(&more) - part.body.strain_energy(&less);
        assert!(
            (slope - force).abs() < 1e-9 * part.body.stiffness[n - 1],
            "{i}: {slope} against {force}"
        );
    }
}

#[test]
fn damping_follows_the_ratios() {
    let mut component = planar_rod(4, &RodSection::default());
    component.damping = dcb_formats::component::Damping::Uniform(0.02);
    let part = Part::reduced(component, 3);
    let n = part.body.coordinate_count();
    let mut forces = vec![0.0; n];
    part.body
        .internal_forces(&vec![0.0; n], &vec![1.0; n], &mut forces);
    for (force, stiffness) in forces.iter().zip(&part.body.stiffness) {
        assert!((force - 2.0 * 0.02 * stiffness.sqrt()).abs() < 1e-12 * force);
    }
}

#[test]
fn frames_that_are_not_on_mean_axes_are_refused_by_name() {
    let part = Part::reduced(planar_rod(2, &RodSection::default()), 2);
    let mut given = part.reduced.superelement.clone();
    given.frame_kind = FrameKind::Given;
    let message = FlexibleBody::from_superelement(&given)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("planar-rod") && message.contains("`given`"),
        "{message}"
    );

    let mut crooked = part.reduced.superelement.clone();
    crooked.inertia.l1[(0, 0)] = 1e-3;
    let message = FlexibleBody::from_superelement(&crooked)
        .unwrap_err()
        .to_string();
    assert!(message.contains("L1"), "{message}");

    let mut stiffened = part.reduced.superelement;
    stiffened.stiffening.centrifugal = vec![Mat::zeros(6, 6)];
    let message = FlexibleBody::from_superelement(&stiffened)
        .unwrap_err()
        .to_string();
    assert!(message.contains("stiffening"), "{message}");
}

#[test]
fn a_missing_file_is_reported_with_its_path() {
    let message = FlexibleBody::load("nowhere.dcb.h5".as_ref())
        .unwrap_err()
        .to_string();
    assert!(message.contains("nowhere.dcb.h5"), "{message}");
}
