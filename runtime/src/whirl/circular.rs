//! A mode in axes that turn along as circular motions about the axis.

use nalgebra::{Complex, Vector3};

use crate::analysis::eigenmodes::Eigenmode;
use crate::system::{Body, State, System};
use dcb_formats::superelement::BoundaryRow;

/// Where a mode moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whirl {
    /// Across the axis: bending and tilting.
    Across,
    /// Along and about the axis: it has the same frequency in all axes.
    Along,
}

/// Axis of the spin.
pub(super) struct Axis {
    /// A point on it.
    pub point: Vector3<f64>,
    /// Unit vector of the spin, world axes.
    pub direction: Vector3<f64>,
}

/// Amplitudes of the displacement of a point: in phase, and a quarter period behind.
type Amplitude = [Vector3<f64>; 2];

/// What a mode is, and its angular frequency in fixed axes: with the spin positive.
pub(super) fn whirl(
    system: &System,
    state: &State,
    axis: &Axis,
    speed: f64,
    mode: &Eigenmode,
) -> (Whirl, f64) {
    let n = axis.direction;
    let e1 = n.cross(&least_along(n)).normalize();
    let e2 = n.cross(&e1);
    let [mut forward, mut backward, mut along] = [0.0; 3];
    for (index, body) in system.bodies.iter().enumerate() {
        let axes = state.pose(index).axes;
        let axis = axes.tr_mul(&n);
        let shapes = [&mode.shape, &mode.shape_behind].map(|all| &all[body.velocities.clone()]);
        for motion in motions(body, axis, shapes) {
            // U = in phase − i behind.
            let of = |e: &Vector3<f64>| -> Complex<f64> {
                let e = axes.tr_mul(e);
                Complex::new(motion.shift[0].dot(&e), -motion.shift[1].dot(&e))
            };
            let (a, b) = (of(&e1), of(&e2));
            let i = Complex::new(0.0, 1.0);
            forward += (a + i * b).norm_sqr();
            backward += (a - i * b).norm_sqr();
            along += of(&n).norm_sqr();
            let turns = motion.twist.map(|twist| (twist * body.length).powi(2));
            along += turns[0] + turns[1];
        }
    }
    let omega = mode.angular_frequency;
    if forward.max(backward) <= along {
        return (Whirl::Along, omega);
    }
    match forward >= backward {
        true => (Whirl::Across, speed + omega),
        false => (Whirl::Across, speed - omega),
    }
}

/// How a part of a body moves, in phase and a quarter period behind, body axes.
struct Motion {
    /// Displacement of its middle.
    shift: Amplitude,
    /// Turn about the axis.
    twist: [f64; 2],
}

/// Motions that tell every motion of a body: of two points on the axis, and of its interfaces, each as a whole.
fn motions(body: &Body, axis: Vector3<f64>, shapes: [&[f64]; 2]) -> Vec<Motion> {
    let turns = shapes.map(|shape| Vector3::new(shape[3], shape[4], shape[5]));
    let rigid = |at: Vector3<f64>| Motion {
        shift: [0, 1].map(|k| {
            let shape = shapes[k];
            Vector3::new(shape[0], shape[1], shape[2]) + turns[k].cross(&at)
        }),
        twist: turns.map(|turn| turn.dot(&axis)),
    };
    let arm = axis * body.length;
    let mut all = vec![rigid(arm), rigid(-arm)];
    let flexible = &body.flexible;
    let elastic = |row: usize, k: usize| -> f64 {
        let y = shapes[k][6..].iter().enumerate();
        y.map(|(j, y)| flexible.interface_shapes[(row, j)] * y)
            .sum()
    };
    for interface in 0..flexible.interfaces.len() {
        let rows = flexible.rows.iter().enumerate();
        let own = rows.filter(|(_, of)| of.interface == interface);
        let own: Vec<(usize, &BoundaryRow)> = own.collect();
        let of_axis = |direction: usize| {
            let along = own.iter();
            along
                .filter(|(_, of)| usize::try_from(of.direction) == Ok(direction))
                .collect::<Vec<_>>()
        };
        let translations = [0, 1, 2].map(of_axis);
        let rotations = [3, 4, 5].map(of_axis);
        let places: Vec<Vector3<f64>> = translations
            .iter()
            .flatten()
            .map(|(_, of)| Vector3::from(of.position))
            .collect();
        if places.is_empty() {
            continue;
        }
        let middle = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
        let mut motion = rigid(middle);
        for k in [0, 1] {
            for (direction, rows) in translations.iter().enumerate() {
                let sum: f64 = rows.iter().map(|(row, _)| elastic(*row, k)).sum();
                motion.shift[k][direction] += sum / rows.len().max(1) as f64;
            }
            motion.twist[k] += match rotations.iter().any(|rows| !rows.is_empty()) {
                true => (rotations.iter().enumerate())
                    .map(|(direction, rows)| {
                        let sum: f64 = rows.iter().map(|(row, _)| elastic(*row, k)).sum();
                        axis[direction] * sum / rows.len().max(1) as f64
                    })
                    .sum(),
                // The turn that is nearest to what the nodes do about the middle.
                false => {
                    let (mut moment, mut inertia) = (0.0, 0.0);
                    for (direction, rows) in translations.iter().enumerate() {
                        for (row, of) in rows {
                            let lever = axis.cross(&(Vector3::from(of.position) - middle));
                            moment += lever[direction] * elastic(*row, k);
                            inertia += lever[direction].powi(2);
                        }
                    }
                    if inertia > 0.0 { moment / inertia } else { 0.0 }
                }
            };
        }
        all.push(motion);
    }
    all
}

/// The coordinate axis that is the least along a direction.
fn least_along(n: Vector3<f64>) -> Vector3<f64> {
    let sizes = n.map(f64::abs);
    let mut unit = Vector3::zeros();
    unit[sizes.imin()] = 1.0;
    unit
}
