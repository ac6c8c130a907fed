//! Nodal displacements of a body whose component has rows that belong to no node, against the full model.

use std::sync::Arc;

use dcb_formats::Function;
use dcb_formats::TimeFunction;
use dcb_formats::mesh::Dimension;
use dcb_runtime::analysis::equilibrium::{EquilibriumSettings, find_equilibrium};
use dcb_runtime::export::nodal_field::NodalField;
use dcb_runtime::joint::{Fixed, JointKind};
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use dcb_runtime::system::{LoadAxes, Signal};
use dcb_tests::dense::{dense, solve};
use dcb_tests::localization::localization;
use dcb_tests::parts::with_internal_rows;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use crate::support::Part;

/// N at the right frame; displacements stay so small that the linear model is exact to seven digits.
const FORCE: [f64; 3] = [0.02, -0.005, 0.01];

/// Displacement of every row of the component: left frame held, force at the right one.
fn of_the_full_model(part: &Part) -> Mat<f64> {
    let component = &part.component;
    let (n, rows) = (component.dofs.len(), localization(component));
    let (stiffness, held) = (dense(&component.stiffness), 6);
    let size = rows.as_ref().subrows(0, held).norm_max();
    let scale = stiffness.norm_max() / size;
    let bordered = Mat::from_fn(n + held, n + held, |i, j| match (i < n, j < n) {
        (true, true) => stiffness[(i, j)],
        (true, false) => scale * rows[(j - n, i)],
        (false, true) => scale * rows[(i - n, j)],
        (false, false) => 0.0,
    });
    let forces = Mat::from_fn(n + held, 1, |i, _| match i < n {
        true => (0..3)
            .map(|axis| FORCE[axis] * rows[(held + axis, i)])
            .sum(),
        false => 0.0,
    });
    solve(&bordered, &forces)
}

#[test]
fn nodes_of_a_held_plate_move_as_in_the_full_model() {
    let part = Part::reduced(with_internal_rows("plate"), 4);
    let mesh = &part.component.mesh;
    let field = NodalField::new(&part.body, &part.reduced.recovery, mesh).unwrap();
    assert_eq!(field.recovered(), vec![1; 30]);

    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    let origin = Vector3::from(part.body.origin);
    let drawn = Drawn {
        position: origin,
        ..Drawn::default()
    };
    let body = builder.body("plate", Arc::new(part.body.clone()), &drawn);
    let left = builder.marker(body, 0, Turning::Interface).unwrap();
    let right = builder.marker(body, 1, Turning::Interface).unwrap();
    let place = Vector3::from(part.body.interfaces[0].position) + origin;
    let ground = builder.ground(place, Matrix3::identity());
    builder
        .joint("clamp", ground, left, &JointKind::Fixed(Fixed))
        .unwrap();
    let force = FORCE.map(|value| {
        Some(builder.signal(Signal {
            function: TimeFunction::new(&Function::Polynomial(vec![value])).unwrap(),
            input: None,
            offset: 0.0,
        }))
    });
    builder.load("pull", right, LoadAxes::World, force, [None; 3]);
    let (system, mut state) = builder.finish();
    find_equilibrium(&system, &mut state, &EquilibriumSettings::default()).unwrap();

    let y = &state.coordinates[system.bodies[0].coordinates.clone()];
    let axes = state.orientations[0].to_rotation_matrix().into_inner();
    let rigid = field.rigid_positions(&state.origins[0], &axes);
    let expected = of_the_full_model(&part);
    let largest = (part.component.dofs.nodal())
        .map(|(row, _)| expected[(row, 0)].abs())
        .fold(0.0, f64::max);
    assert!(largest > 1e-6, "{largest:e}");
    let elastic = field.displacement(y);
    for (row, dof) in part.component.dofs.nodal() {
        let node = dof.node as usize;
        let moved = rigid[node] + axes * elastic[node] - Vector3::from(mesh.position(dof.node));
        let off = (moved[dof.direction.axis()] - expected[(row, 0)]).abs();
        assert!(off < 1e-6 * largest, "{dof:?}: {off:e} of {largest:e}");
    }
}
