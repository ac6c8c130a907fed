//! A mode in axes that turn along as circular motions about the axis.

use std::collections::BTreeMap;

use nalgebra::{Complex, Vector3};

use crate::analysis::eigenmodes::Eigenmode;
use crate::system::{State, System};

/// Motions across the axis below this part of those along and about it are rounding.
const ACROSS: f64 = 1e-8;

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
        let arm = axes.tr_mul(&n) * body.length;
        let shapes = [&mode.shape, &mode.shape_behind].map(|all| &all[body.velocities.clone()]);
        for point in points(body, arm, shapes) {
            // U = in phase − i behind.
            let of = |e: &Vector3<f64>| -> Complex<f64> {
                let e = axes.tr_mul(e);
                Complex::new(point[0].dot(&e), -point[1].dot(&e))
            };
            let (a, b) = (of(&e1), of(&e2));
            let i = Complex::new(0.0, 1.0);
            forward += (a + i * b).norm_sqr();
            backward += (a - i * b).norm_sqr();
            along += of(&n).norm_sqr();
        }
        let turn = |shape: &[f64]| {
            let turn = Vector3::new(shape[3], shape[4], shape[5]);
            turn.dot(&axes.tr_mul(&n)) * body.length
        };
        along += turn(shapes[0]).powi(2) + turn(shapes[1]).powi(2);
    }
    let omega = mode.angular_frequency;
    if forward + backward <= ACROSS * along {
        return (Whirl::Along, omega);
    }
    match forward >= backward {
        true => (Whirl::Across, speed + omega),
        false => (Whirl::Across, speed - omega),
    }
}

/// Displacements in body axes of points that show every motion of a body: two on the axis, and those of its interfaces.
fn points(body: &crate::system::Body, arm: Vector3<f64>, shapes: [&[f64]; 2]) -> Vec<Amplitude> {
    let rigid = |at: Vector3<f64>| {
        shapes.map(|shape| {
            let turn = Vector3::new(shape[3], shape[4], shape[5]);
            Vector3::new(shape[0], shape[1], shape[2]) + turn.cross(&at)
        })
    };
    let mut all = vec![rigid(arm), rigid(-arm)];
    let flexible = &body.flexible;
    let mut places: BTreeMap<(usize, i64), Amplitude> = BTreeMap::new();
    for (row, of) in flexible.rows.iter().enumerate() {
        let Some(axis) = usize::try_from(of.direction).ok().filter(|axis| *axis < 3) else {
            continue;
        };
        let place = places
            .entry((of.interface, of.node))
            .or_insert_with(|| rigid(Vector3::from(of.position)));
        for (amplitude, shape) in place.iter_mut().zip(shapes) {
            let own = (shape[6..].iter().enumerate())
                .map(|(k, y)| flexible.interface_shapes[(row, k)] * y);
            amplitude[axis] += own.sum::<f64>();
        }
    }
    all.extend(places.into_values());
    all
}

/// The coordinate axis that is the least along a direction.
fn least_along(n: Vector3<f64>) -> Vector3<f64> {
    let sizes = n.map(f64::abs);
    let mut unit = Vector3::zeros();
    unit[sizes.imin()] = 1.0;
    unit
}
