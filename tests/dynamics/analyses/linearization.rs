//! The exact linearization against differences of the equations; the condensed solve against the exact one.

use dcb_formats::component::ComponentDraft;
use std::sync::Arc;

use crate::support::frames::Random;
use crate::support::mechanisms::{about_z, formula, linear, rigid, with_stiffness};
use crate::support::{Part, numbers};
use dcb_formats::Component;
use dcb_formats::mesh::Dimension;
use dcb_runtime::FlexibleBody;
use dcb_runtime::joint::{JointKind, Spherical};
use dcb_runtime::measure::{Displacement, Elongation, Measure, Rotation};
use dcb_runtime::system::body_factor::Elastic;
use dcb_runtime::system::builder::{Drawn, JointCoordinate, SystemBuilder, Turning};
use dcb_runtime::system::condensed::{Blend, Condensed, Interfaces};
use dcb_runtime::system::evaluation::Evaluation;
use dcb_runtime::system::linearization::Linearization;
use dcb_runtime::system::{Demand, LoadAxes, State, System};
use dcb_samples::spatial_beam::BeamSection;
use dcb_samples::{Material, RodSection, SpatialBeam, axial_prestress, planar_rod, spatial_beam};
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use nalgebra::{UnitQuaternion, Vector3};

/// Two flexible bodies and a rigid one with one of everything that couples bodies; loads are scaled by an input.
fn mechanism(dimension: Dimension) -> System {
    let [first, second] = flexible(dimension);
    let mut builder = SystemBuilder::new(dimension, Vector3::new(0.3, -9.81, 0.0));
    let a = builder.body("a", first, &Drawn::default());
    let b = builder.body("b", second, &Drawn::default());
    let c = builder.body(
        "c",
        rigid(
            dimension,
            0.7,
            Vector3::new(0.1, 0.2, 0.3),
            &[Vector3::new(0.2, 0.1, 0.0), Vector3::new(-0.3, 0.0, 0.1)],
        ),
        &Drawn::default(),
    );
    let axes = nalgebra::Matrix3::identity();
    let ground = builder.ground(Vector3::new(0.1, 0.2, 0.0), axes);
    let mut on = |body, interface, turning| builder.marker(body, interface, turning).unwrap();
    let (a0, a1) = (on(a, 0, Turning::Interface), on(a, 1, Turning::Interface));
    let (b0, b1) = (on(b, 0, Turning::Interface), on(b, 1, Turning::Body));
    let (c0, c1) = (on(c, 0, Turning::Interface), on(c, 1, Turning::Interface));
    let pin = builder.joint("pin", ground, a0, &about_z()).unwrap();
    let ball = JointKind::Spherical(Spherical);
    builder.joint("ball", a1, b0, &ball).unwrap();
    let hinge = builder.joint("hinge", b1, c0, &about_z()).unwrap();
    let motion = builder.signal(formula("0.3*t"));
    let angle = pin.coordinate(JointCoordinate::Rotation).unwrap();
    builder.drive("motor", &pin, angle, motion);
    let free = hinge.coordinate(JointCoordinate::Rotation).unwrap();
    builder.gear("gear", (&pin, angle), (&hinge, free), 1.5);
    let line = Measure::Elongation(Elongation { length: 1.0 });
    builder.spring("line", a1, c1, [(line, linear(0.4, 30.0, 2.0))]);
    let direction = Vector3::x_axis();
    let mut bushing = vec![
        (
            Measure::Displacement(Displacement { direction }),
            linear(0.1, 20.0, 1.0),
        ),
        (
            Measure::Displacement(Displacement {
                direction: Vector3::y_axis(),
            }),
            linear(0.1, 10.0, 1.5),
        ),
    ];
    for direction in match dimension {
        Dimension::Planar => vec![Vector3::z_axis()],
        Dimension::Spatial => vec![Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()],
    } {
        let rest = axes;
        let turn = Measure::Rotation(Rotation { direction, rest });
        bushing.push((turn, linear(0.2, 5.0, 0.4)));
    }
    builder.spring("bushing", b1, a1, bushing);
    let size = builder.input("size", 1.0);
    let signal = |value| dcb_runtime::system::Signal {
        function: dcb_formats::TimeFunction::new(&dcb_formats::Function::Input(
            dcb_formats::function::InputSignal { initial: value },
        ))
        .unwrap(),
        input: Some(size),
        offset: 0.0,
    };
    let pull = builder.signal(signal(1.0));
    let (plane, space) = match dimension {
        Dimension::Planar => ([Some(pull), Some(pull), None], [None, None, Some(pull)]),
        Dimension::Spatial => ([Some(pull); 3], [Some(pull), None, Some(pull)]),
    };
    builder.load("pull", b1, LoadAxes::World, plane, space);
    builder.load("push", a1, LoadAxes::Follower, plane, space);
    builder.finish().0
}

/// Beams with rotations at their interfaces, made soft so that every entry is of the size of the others.
fn flexible(dimension: Dimension) -> [Arc<FlexibleBody>; 2] {
    let parts = match dimension {
        Dimension::Planar => [0.3, -0.4].map(|angle| {
            let rod = RodSection {
                angle,
                ..RodSection::default()
            };
            Part::reduced(stiffened(planar_rod(4, &rod), 0.3), 3)
        }),
        Dimension::Spatial => [0.5, 0.8].map(|end| {
            let beam = SpatialBeam {
                elements: 3,
                start: [0.1, 0.2, -0.1],
                end: [end, 0.5, 0.3],
                roll: 0.4,
                section: BeamSection::rectangle(0.02, 0.05),
                material: Material::SOFT,
                ..SpatialBeam::default()
            };
            Part::reduced(stiffened(spatial_beam(&beam), 0.7), 3)
        }),
    };
    parts.map(|part| with_stiffness(&part.body, 20.0, 0.03))
}

/// With geometric stiffening by spins and by forces at both ends.
fn stiffened(component: Component, mass_per_length: f64) -> Component {
    Component::checked(ComponentDraft {
        geometric_stiffness: Some(axial_prestress(&component, mass_per_length)),
        ..component.into_draft()
    })
    .unwrap()
}

/// A state far from everything: large turns, motion, deflections that turn interfaces by tenths of a radian.
fn scattered(system: &System, seed: u64) -> State {
    let mut random = Random::new(seed);
    let flat = |v: Vector3<f64>, spin: bool| match (system.dimension, spin) {
        (Dimension::Spatial, _) => v,
        (Dimension::Planar, false) => Vector3::new(v.x, v.y, 0.0),
        (Dimension::Planar, true) => Vector3::new(0.0, 0.0, v.z),
    };
    let mut state = State::at_rest(system);
    state.time = 0.4;
    for index in 0..system.bodies.len() {
        state.origins[index] = flat(random.vector() * 0.5, false);
        state.orientations[index] = UnitQuaternion::new(flat(random.vector() * 1.2, true));
        let body = &system.bodies[index];
        let at = body.velocities.start;
        let most = largest_shape(system, index);
        for values in [&mut state.velocities, &mut state.accelerations] {
            let (v, w) = (random.vector() * 2.0, random.vector() * 3.0);
            values[at..at + 3].copy_from_slice(flat(v, false).as_slice());
            values[at + 3..at + 6].copy_from_slice(flat(w, true).as_slice());
            for rate in &mut values[at + 6..body.velocities.end] {
                *rate = 2.0 / most * random.number();
            }
        }
        for y in &mut state.coordinates[body.coordinates.clone()] {
            *y = 0.3 / most * random.number();
        }
    }
    for force in &mut state.forces {
        *force = 5.0 * random.number();
    }
    state
}

/// The largest displacement or turn of an interface for a coordinate of one.
fn largest_shape(system: &System, body: usize) -> f64 {
    let markers = &system.bodies[body].markers;
    let shapes = markers.iter().flat_map(|m| &system.markers[*m].shapes);
    shapes.fold(1e-3, |most, shape| most.max(shape.abs()))
}

/// A variation of a coordinate that is small for its interfaces.
fn small(system: &System, column: usize) -> f64 {
    let mut bodies = system.bodies.iter().enumerate();
    let (index, body) = bodies
        .rfind(|(_, body)| body.velocities.contains(&column))
        .unwrap();
    match column - body.velocities.start {
        0..6 => 1e-5,
        _ => 3e-5 / largest_shape(system, index),
    }
}

/// Equations of motion with forces in world axes and moments in body axes, then the constraints.
fn equations(system: &System, state: &State, evaluation: &mut Evaluation) -> Vec<f64> {
    let mut state = state.clone();
    evaluate(system, &mut state, evaluation);
    let mut residual = evaluation.residual.clone();
    for (index, body) in system.bodies.iter().enumerate() {
        let at = body.velocities.start;
        let force =
            evaluation.poses[index].axes * Vector3::from_column_slice(&residual[at..at + 3]);
        residual[at..at + 3].copy_from_slice(force.as_slice());
    }
    for (index, row) in system.rows.iter().enumerate() {
        if !matches!(row.demand, Demand::Answer(_)) {
            residual.push(evaluation.answers[index]);
        }
    }
    residual
}

/// Everything at a state; springs take their forces from their laws.
fn evaluate(system: &System, state: &mut State, evaluation: &mut Evaluation) {
    evaluation.place(system, state);
    evaluation.add_velocities(system, state);
    evaluation.measure(system, state);
    for (index, row) in system.rows.iter().enumerate() {
        if matches!(row.demand, Demand::Answer(_)) {
            state.forces[index] = evaluation.answers[index];
        }
    }
    evaluation.load(system, state);
    evaluation.resist(system, state);
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Level {
    Positions,
    Velocities,
    Accelerations,
}

/// The state with one coordinate of one level varied; translations along the axes of the body.
fn varied(system: &System, state: &State, level: Level, column: usize, by: f64) -> State {
    let mut varied = state.clone();
    let index = system
        .bodies
        .iter()
        .position(|body| body.velocities.contains(&column))
        .unwrap();
    let body = &system.bodies[index];
    let local = column - body.velocities.start;
    let along = state.pose(index).axes * Vector3::from_fn(|i, _| if i == local { by } else { 0.0 });
    let about = Vector3::from_fn(|i, _| if i + 3 == local { by } else { 0.0 });
    let values = match level {
        Level::Positions => {
            varied.origins[index] += along;
            varied.orientations[index] *= UnitQuaternion::new(about);
            if local >= 6 {
                varied.coordinates[body.coordinates.start + local - 6] += by;
            }
            return varied;
        }
        Level::Velocities => &mut varied.velocities,
        Level::Accelerations => &mut varied.accelerations,
    };
    if local < 3 {
        for i in 0..3 {
            values[body.velocities.start + i] += along[i];
        }
    } else {
        values[column] += by;
    }
    varied
}

/// Motions that the scene has: a planar one keeps its bodies in the plane.
fn moves(system: &System, column: usize) -> bool {
    system.bodies.iter().all(|body| {
        !body.velocities.contains(&column)
            || column - body.velocities.start >= 6
            || body.free[column - body.velocities.start]
    })
}

#[test]
fn linearization_is_the_derivative_of_the_equations() {
    for dimension in [Dimension::Planar, Dimension::Spatial] {
        let system = mechanism(dimension);
        let mut evaluation = Evaluation::of(&system);
        for seed in [3, 4] {
            let mut state = scattered(&system, seed);
            evaluate(&system, &mut state, &mut evaluation);
            let exact = Linearization::at(&system, &state, &evaluation).unwrap();
            let n = system.velocity_count();
            for (level, matrix) in [
                (Level::Positions, &exact.stiffness),
                (Level::Velocities, &exact.damping),
                (Level::Accelerations, &exact.mass),
            ] {
                let scale = matrix.norm_max();
                for column in (0..n).filter(|column| moves(&system, *column)) {
                    // The equations are of second degree in the velocities and of first in the accelerations.
                    let step = match level {
                        Level::Positions => small(&system, column),
                        Level::Velocities | Level::Accelerations => 0.1,
                    };
                    let mut at = |by: f64| {
                        let state = varied(&system, &state, level, column, by);
                        equations(&system, &state, &mut evaluation)
                    };
                    let (above, below) = (at(step), at(-step));
                    let mut difference: Vec<f64> = above
                        .iter()
                        .zip(&below)
                        .map(|(a, b)| (a - b) / (2.0 * step))
                        .collect();
                    for (index, body) in system.bodies.iter().enumerate() {
                        let at = body.velocities.start;
                        let force = Vector3::from_column_slice(&difference[at..at + 3]);
                        let turned = state.pose(index).axes.tr_mul(&force);
                        difference[at..at + 3].copy_from_slice(turned.as_slice());
                    }
                    for row in (0..n).filter(|row| moves(&system, *row)) {
                        let error = (difference[row] - matrix[(row, column)]).abs();
                        assert!(
                            error < 1e-7 * scale,
                            "{dimension:?} {level:?} row {row} column {column}: {} against {}",
                            matrix[(row, column)],
                            difference[row]
                        );
                    }
                    if level == Level::Positions {
                        for constraint in 0..exact.constraints.len() {
                            let found = exact.jacobian[(constraint, column)];
                            let error = (difference[n + constraint] - found).abs();
                            assert!(
                                error < 1e-7 * exact.jacobian.norm_max(),
                                "{dimension:?} constraint {constraint} column {column}: {found} against {}",
                                difference[n + constraint]
                            );
                        }
                    }
                }
            }
        }
    }
}

/// The state moved along itself for a time: positions to second order, velocities to first.
fn carried(system: &System, state: &State, time: f64) -> State {
    let mut moved = state.clone();
    for (index, body) in system.bodies.iter().enumerate() {
        let at = body.velocities.start;
        let increment = |i: usize| {
            time * state.velocities[at + i] + 0.5 * time * time * state.accelerations[at + i]
        };
        let three = |i: usize| Vector3::new(increment(i), increment(i + 1), increment(i + 2));
        moved.origins[index] += three(0);
        moved.orientations[index] *= UnitQuaternion::new(three(3));
        for (k, y) in moved.coordinates[body.coordinates.clone()]
            .iter_mut()
            .enumerate()
        {
            *y += increment(6 + k);
        }
    }
    for (velocity, acceleration) in moved.velocities.iter_mut().zip(&state.accelerations) {
        *velocity += time * acceleration;
    }
    moved
}

#[test]
fn markers_and_rows_move_with_their_bodies() {
    for dimension in [Dimension::Planar, Dimension::Spatial] {
        let system = mechanism(dimension);
        let state = scattered(&system, 7);
        let step = 1e-5;
        let at = |time: f64| {
            let state = carried(&system, &state, time);
            let mut evaluation = Evaluation::of(&system);
            evaluation.place(&system, &state);
            evaluation.add_velocities(&system, &state);
            evaluation.add_accelerations(&system, &state);
            evaluation.measure(&system, &state);
            evaluation
        };
        let (before, now, after) = (at(-step), at(0.0), at(step));
        let (long_before, long_after) = (at(-2.0 * step), at(2.0 * step));
        let slope = |a: Vector3<f64>, b: Vector3<f64>| (b - a) / (2.0 * step);
        // Differences over four points: those over two err by third derivatives, whose size depends on where the scattered state is.
        let rate_of = |value: &dyn Fn(&Evaluation) -> f64| {
            let near = value(&after) - value(&before);
            let far = value(&long_after) - value(&long_before);
            (8.0 * near - far) / (12.0 * step)
        };
        for marker in 0..system.markers.len() {
            let [a, m, b] = [&before, &now, &after].map(|e| &e.motions[marker]);
            let error = (slope(a.position, b.position) - m.velocity).norm();
            assert!(
                error < 1e-7,
                "{dimension:?} velocity of {marker}: {error:e}"
            );
            let turning = (b.axes - a.axes) / (2.0 * step) * m.axes.transpose();
            let error = (turning - m.spin.cross_matrix()).norm();
            assert!(error < 1e-7, "{dimension:?} spin of {marker}: {error:e}");
            let error = (slope(a.velocity, b.velocity) - m.acceleration).norm();
            assert!(
                error < 1e-6,
                "{dimension:?} acceleration of {marker}: {error:e}"
            );
            let error = (slope(a.spin, b.spin) - m.spin_rate).norm();
            assert!(
                error < 1e-6,
                "{dimension:?} spin rate of {marker}: {error:e}"
            );
        }
        for row in 0..system.rows.len() {
            let rate = rate_of(&|evaluation| evaluation.values[row]);
            let error = (rate - now.rate(&system, row)).abs();
            assert!(error < 1e-7, "{dimension:?} rate of row {row}: {error:e}");
            let second = rate_of(&|evaluation| evaluation.rate(&system, row));
            let error = (second - now.second_rate(&system, row)).abs();
            assert!(
                error < 1e-6,
                "{dimension:?} second rate of row {row}: {error:e}"
            );
        }
    }
}

/// δq and δλ of `[S -Bᵀ; B 0] = (-r, h)` as a dense system over the motions that the scene has.
fn dense_solve(
    system: &System,
    exact: &Linearization,
    blend: &Blend<c64>,
    residual: &[c64],
    constraint_changes: &[c64],
) -> (Vec<c64>, Vec<c64>) {
    let columns: Vec<usize> = (0..system.velocity_count())
        .filter(|column| moves(system, *column))
        .collect();
    let (n, m) = (columns.len(), exact.constraints.len());
    let real = |value: f64| c64::new(value, 0.0);
    let entry = |i: usize, j: usize| -> c64 {
        let at = |k: usize, l: usize| {
            blend.mass * exact.mass[(k, l)]
                + blend.damping * exact.damping[(k, l)]
                + blend.stiffness * exact.stiffness[(k, l)]
        };
        match (i < n, j < n) {
            (true, true) => at(columns[i], columns[j]),
            (true, false) => real(-exact.jacobian[(j - n, columns[i])]),
            (false, true) => real(exact.jacobian[(i - n, columns[j])]),
            (false, false) => real(0.0),
        }
    };
    let matrix = Mat::from_fn(n + m, n + m, entry);
    let right = Mat::from_fn(n + m, 1, |i, _| {
        if i < n {
            -residual[columns[i]]
        } else {
            constraint_changes[i - n]
        }
    });
    let solution = matrix.partial_piv_lu().solve(&right);
    let mut step = vec![real(0.0); system.velocity_count()];
    for (i, column) in columns.iter().enumerate() {
        step[*column] = solution[(i, 0)];
    }
    (step, (0..m).map(|i| solution[(n + i, 0)]).collect())
}

/// Real numbers as complex ones.
fn complex(values: &[f64]) -> Vec<c64> {
    values.iter().map(|value| c64::new(*value, 0.0)).collect()
}

/// The same of a complex solution.
fn apart(found: &[c64], expected: &[c64]) -> f64 {
    let scale = expected.iter().fold(0.0_f64, |most, x| most.max(x.norm()));
    let error = found.iter().zip(expected).map(|(a, b)| (a - b).norm());
    error.fold(0.0, f64::max) / scale
}

/// At rest and unloaded the iteration leaves nothing out.
fn unloaded(system: &System, seed: u64) -> (State, Evaluation) {
    let mut state = scattered(system, seed).without_motion();
    state.forces.fill(0.0);
    state.inputs.fill(0.0);
    let mut evaluation = Evaluation::of(system);
    evaluation.place(system, &state);
    evaluation.add_velocities(system, &state);
    evaluation.measure(system, &state);
    evaluation.load(system, &state);
    evaluation.resist(system, &state);
    (state, evaluation)
}

fn relative(found: &[f64], expected: &[f64]) -> f64 {
    let scale = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let error = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    error.fold(0.0, f64::max) / scale
}

#[test]
fn condensed_solve_is_the_dense_one_at_rest() {
    let blend = Blend {
        mass: 40.0,
        damping: 7.0,
        stiffness: 1.0,
        elastic: Elastic::Moving,
        interfaces: Interfaces::Following,
    };
    for dimension in [Dimension::Planar, Dimension::Spatial] {
        let system = mechanism(dimension);
        let (state, evaluation) = unloaded(&system, 5);
        let mut condensed = Condensed::of(&system).unwrap();
        condensed
            .factor(&system, &state, &evaluation, &blend, None)
            .unwrap();
        let exact = Linearization::at(&system, &state, &evaluation).unwrap();
        let mut residual = numbers(system.velocity_count(), 17);
        for (row, entry) in residual.iter_mut().enumerate() {
            *entry *= f64::from(u8::from(moves(&system, row)));
        }
        let mut changes = vec![0.0; system.rows.len()];
        let constraint_changes = numbers(exact.constraints.len(), 18);
        for (row, change) in exact.constraints.iter().zip(&constraint_changes) {
            changes[*row] = *change;
        }
        condensed.solve(&system, &state, &evaluation, &changes, &residual);
        let as_complex = Blend {
            mass: c64::new(blend.mass, 0.0),
            damping: c64::new(blend.damping, 0.0),
            stiffness: 1.0,
            elastic: Elastic::Moving,
            interfaces: Interfaces::Following,
        };
        let (given, wanted) = (complex(&residual), complex(&constraint_changes));
        let (step, forces) = dense_solve(&system, &exact, &as_complex, &given, &wanted);
        let error = apart(&complex(&condensed.step), &step);
        assert!(error < 1e-10, "{dimension:?} step: {error:e}");
        let found: Vec<f64> = exact
            .constraints
            .iter()
            .map(|row| condensed.force_step[*row])
            .collect();
        let error = apart(&complex(&found), &forces);
        assert!(error < 1e-10, "{dimension:?} forces: {error:e}");
    }
}

/// The same at a complex shift, beside a real factor.
#[test]
fn condensed_solve_at_a_complex_shift_is_the_dense_one_at_rest() {
    let shift = c64::new(5.0, 4.0);
    let beside = Blend {
        mass: shift * shift,
        damping: shift,
        stiffness: 1.0,
        elastic: Elastic::Moving,
        interfaces: Interfaces::Held,
    };
    let real = Blend {
        mass: 40.0,
        damping: 7.0,
        stiffness: 1.0,
        elastic: Elastic::Moving,
        interfaces: Interfaces::Held,
    };
    for dimension in [Dimension::Planar, Dimension::Spatial] {
        let system = mechanism(dimension);
        let (state, evaluation) = unloaded(&system, 5);
        let mut factor = Condensed::of(&system).unwrap();
        factor
            .factor_straight(&system, &state, &evaluation, &real)
            .unwrap();
        let mut condensed = Condensed::<c64>::of(&system).unwrap();
        condensed
            .factor_beside(&system, &state, &evaluation, &beside, &factor)
            .unwrap();
        let exact = Linearization::at(&system, &state, &evaluation).unwrap();
        let (re, im) = (
            numbers(system.velocity_count(), 17),
            numbers(system.velocity_count(), 19),
        );
        let residual: Vec<c64> = (0..system.velocity_count())
            .map(|row| c64::new(re[row], im[row]) * f64::from(u8::from(moves(&system, row))))
            .collect();
        let wanted = complex(&numbers(exact.constraints.len(), 18));
        let mut changes = vec![c64::new(0.0, 0.0); system.rows.len()];
        for (row, change) in exact.constraints.iter().zip(&wanted) {
            changes[*row] = *change;
        }
        condensed.solve_held(&system, &evaluation, &changes, &residual);
        let (step, forces) = dense_solve(&system, &exact, &beside, &residual, &wanted);
        let error = apart(&condensed.step, &step);
        assert!(error < 1e-10, "{dimension:?} step: {error:e}");
        let rows = exact.constraints.iter();
        let found: Vec<c64> = rows.map(|row| condensed.force_step[*row]).collect();
        let error = apart(&found, &forces);
        assert!(error < 1e-10, "{dimension:?} forces: {error:e}");
    }
}

/// A hinge that is there twice: the pair moves as the single one does and carries its force.
#[test]
fn repeated_constraints_share_the_force_and_leave_the_motion() {
    let build = |times: usize| {
        let inertia = Vector3::new(0.1, 0.2, 0.3);
        let body = rigid(
            Dimension::Spatial,
            1.3,
            inertia,
            &[Vector3::new(-1.0, 0.2, 0.1)],
        );
        let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::new(0.0, -9.81, 0.0));
        let bar = builder.body("bar", body, &Drawn::default());
        let end = builder.marker(bar, 0, Turning::Interface).unwrap();
        let place = builder.frame(end);
        let ground = builder.ground(place.position, place.axes);
        for _ in 0..times {
            builder.joint("hinge", ground, end, &about_z()).unwrap();
        }
        builder.finish()
    };
    let blend = Blend {
        mass: 40.0,
        damping: 7.0,
        stiffness: 1.0,
        elastic: Elastic::Moving,
        interfaces: Interfaces::Following,
    };
    let solve = |times: usize, regularization: f64| {
        let (system, state) = build(times);
        let mut evaluation = Evaluation::of(&system);
        evaluation.place(&system, &state);
        evaluation.measure(&system, &state);
        evaluation.load(&system, &state);
        evaluation.resist(&system, &state);
        let mut condensed = Condensed::of(&system).unwrap();
        condensed.regularization = regularization;
        condensed
            .factor(&system, &state, &evaluation, &blend, None)
            .unwrap();
        let changes = vec![0.0; system.rows.len()];
        let residual = evaluation.residual.clone();
        condensed.solve(&system, &state, &evaluation, &changes, &residual);
        (condensed.step.clone(), condensed.force_step.clone())
    };
    let (step, forces) = solve(1, 0.0);
    let (step_of_pair, forces_of_pair) = solve(2, dcb_runtime::initial::REGULARIZATION);
    // Of the order of the regularization; the iterations of a step take away the rest.
    assert!(relative(&step_of_pair, &step) < 1e-6);
    let together: Vec<f64> = (0..5)
        .map(|i| forces_of_pair[i] + forces_of_pair[i + 5])
        .collect();
    assert!(relative(&together, &forces) < 1e-6);
    let half: Vec<f64> = forces.iter().map(|force| 0.5 * force).collect();
    assert!(
        relative(&forces_of_pair[..5], &half) < 1e-5,
        "{forces_of_pair:?}"
    );
}
