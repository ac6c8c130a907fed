//! Inertia forces with accelerations against a cloud of particles, and their derivatives against differences.

use crate::support;
use crate::support::cloud::Cloud;
use crate::support::numbers;
use dcb_formats::mesh::Dimension;
use dcb_runtime::frame::AttachmentMass;
use dcb_runtime::{
    BodyAcceleration, BodyState, FrameInertia, InertiaChange, InertiaForces, InertiaTangent,
    InertiaTerms,
};
use faer::Mat;
use nalgebra::Vector3;

const CHANGES: [InertiaChange; 3] = [
    InertiaChange::Constant,
    InertiaChange::FirstOrder,
    InertiaChange::SecondOrder,
];

/// Everything that the forces depend on.
#[derive(Clone)]
struct Motion {
    y: Vec<f64>,
    rates: Vec<f64>,
    second_rates: Vec<f64>,
    spin: Vector3<f64>,
    spin_rate: Vector3<f64>,
    origin: Vector3<f64>,
}

impl Motion {
    fn random(dimension: Dimension, n: usize) -> Self {
        let turn = |v: Vector3<f64>| match dimension {
            Dimension::Planar => Vector3::new(0.0, 0.0, v.z),
            Dimension::Spatial => v,
        };
        Self {
            y: numbers(n, 1),
            rates: numbers(n, 2),
            second_rates: numbers(n, 3),
            spin: turn(Vector3::new(0.7, -1.1, 0.5)),
            spin_rate: turn(Vector3::new(0.4, 0.9, -0.6)),
            origin: match dimension {
                Dimension::Planar => Vector3::new(1.3, -0.8, 0.0),
                Dimension::Spatial => Vector3::new(1.3, -0.8, 0.4),
            },
        }
    }

    fn state(&self) -> BodyState<'_> {
        BodyState {
            y: &self.y,
            rates: &self.rates,
            spin: self.spin,
        }
    }

    fn acceleration(&self) -> BodyAcceleration<'_> {
        BodyAcceleration {
            origin: self.origin,
            spin_rate: self.spin_rate,
            second_rates: &self.second_rates,
        }
    }

    /// Force, moment, forces on y in one vector.
    fn forces(&self, inertia: &FrameInertia) -> Vec<f64> {
        let n = self.y.len();
        let mut terms = InertiaTerms::for_coordinates(n);
        let mut forces = InertiaForces::for_coordinates(n);
        inertia.evaluate_forces(&self.state(), &self.acceleration(), &mut terms, &mut forces);
        let frame = forces.force_body.iter().chain(forces.moment.iter());
        frame.copied().chain(forces.elastic).collect()
    }
}

fn clouds(n: usize) -> Vec<(String, Cloud)> {
    [Dimension::Planar, Dimension::Spatial]
        .into_iter()
        .flat_map(|dimension| {
            [
                (
                    format!("{dimension:?}, given frame"),
                    Cloud::with_momentum(dimension, n),
                ),
                (
                    format!("{dimension:?}, mean axes"),
                    Cloud::on_mean_axes(dimension, n),
                ),
            ]
        })
        .collect()
}

fn close(name: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    let size = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (at, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!(
            (a - b).abs() <= tolerance * size.max(1e-30),
            "{name}, entry {at}: {a} against {b}"
        );
    }
}

#[test]
fn forces_are_dalemberts_of_the_particles() {
    for n in [0, 1, 3, 5, 8, 13] {
        for (name, cloud) in clouds(n) {
            let body = cloud.body();
            let motion = Motion::random(cloud.dimension, n);
            let (force, moment, elastic) =
                cloud.inertia_forces(&body, &motion.state(), &motion.acceleration());
            let expected: Vec<f64> = (force.iter().chain(moment.iter()))
                .copied()
                .chain(elastic)
                .collect();
            close(
                &format!("{name}, {n} coordinates"),
                &motion.forces(&body.inertia),
                &expected,
                1e-11,
            );
        }
    }
}

#[test]
fn energy_and_momenta_are_those_of_the_particles() {
    for (name, cloud) in clouds(5) {
        let body = cloud.body();
        let motion = Motion::random(cloud.dimension, 5);
        let velocity = motion.origin * 0.7;
        let (energy, linear, angular) = cloud.energy_and_momenta(&body, &velocity, &motion.state());
        let mut terms = InertiaTerms::for_coordinates(5);
        (body.inertia).evaluate(&motion.y, &motion.spin, &motion.rates, &mut terms);
        let mass = body.inertia.mass();
        let own = terms.kinetic_energy(mass, &velocity, &motion.spin, &motion.rates);
        close(&name, &[own], &[energy], 1e-12);
        let (p, h) = terms.momenta(mass, &velocity, &motion.spin);
        close(&name, p.as_slice(), linear.as_slice(), 1e-12);
        close(&name, h.as_slice(), angular.as_slice(), 1e-12);

        // Half of vᵀ M v is the same energy.
        let d = cloud.dimension.coordinate_count();
        let turns = if d == 2 {
            vec![motion.spin.z]
        } else {
            motion.spin.as_slice().to_vec()
        };
        let v: Vec<f64> = (velocity.iter().take(d).copied())
            .chain(turns)
            .chain(motion.rates.clone())
            .collect();
        let mut matrix = Mat::zeros(v.len(), v.len());
        body.inertia.write_mass_matrix(&terms, matrix.as_mut());
        let half: f64 = support::product(&matrix, &v)
            .iter()
            .zip(&v)
            .map(|(p, v)| 0.5 * p * v)
            .sum();
        close(&name, &[half], &[energy], 1e-12);
    }
}

/// Less of the change of inertia than all is still a Lagrangian: along a path with constant accelerations,
/// dT/dt = f_R · V + f_φ · ω + f_y · y' for the forces of every choice.
#[test]
fn every_inertia_change_conserves_energy() {
    for (name, cloud) in clouds(5) {
        for change in CHANGES {
            let inertia = cloud.body().inertia.with_change(change);
            let motion = Motion::random(cloud.dimension, 5);
            let velocity = Vector3::new(0.3, 0.9, 0.0);
            let mut terms = InertiaTerms::for_coordinates(5);
            let mut energy = |t: f64| {
                let along = |x: &[f64], dx: &[f64], ddx: &[f64]| -> Vec<f64> {
                    (0..x.len())
                        .map(|i| x[i] + t * dx[i] + 0.5 * t * t * ddx[i])
                        .collect()
                };
                let y = along(&motion.y, &motion.rates, &motion.second_rates);
                let rates = along(&motion.rates, &motion.second_rates, &[0.0; 5]);
                let spin = motion.spin + t * motion.spin_rate;
                // V in body axes: V' = A - ω × V.
                let moved = velocity + t * (motion.origin - motion.spin.cross(&velocity));
                inertia.evaluate(&y, &spin, &rates, &mut terms);
                terms.kinetic_energy(inertia.mass(), &moved, &spin, &rates)
            };
            let h = 1e-5;
            let power = (energy(h) - energy(-h)) / (2.0 * h);
            let forces = motion.forces(&inertia);
            let rates = velocity
                .iter()
                .chain(motion.spin.iter())
                .chain(&motion.rates);
            let expected: f64 = forces.iter().zip(rates).map(|(f, v)| f * v).sum();
            let size: f64 = forces.iter().map(|f| f.abs()).sum();
            assert!(
                (power - expected).abs() < 1e-8 * size,
                "{name}, {change:?}: {power} against {expected}"
            );
        }
    }
}

/// Central differences: the forces are of second degree in each argument alone, so they are exact but for rounding.
fn difference(
    motion: &Motion,
    inertia: &FrameInertia,
    change: impl Fn(&mut Motion, f64),
) -> Vec<f64> {
    let h = 0.25;
    let at = |step: f64| {
        let mut moved = motion.clone();
        change(&mut moved, step);
        moved.forces(inertia)
    };
    at(h)
        .iter()
        .zip(at(-h))
        .map(|(a, b)| (a - b) / (2.0 * h))
        .collect()
}

/// Column `j` of a block that the tangent stores, all rows.
fn stored(block: &dcb_runtime::frame::TangentBlock, n: usize, j: usize) -> Vec<f64> {
    let rigid = block.rigid.column(j);
    let elastic = &block.elastic_by_rigid[j * n..(j + 1) * n];
    rigid.iter().chain(elastic).copied().collect()
}

fn unit(axis: usize) -> Vector3<f64> {
    Vector3::from_fn(|i, _| f64::from(u8::from(i == axis)))
}

#[test]
fn tangents_are_the_derivatives_of_the_forces() {
    let n = 5;
    for (name, cloud) in clouds(n) {
        for change in CHANGES {
            for weighted in ["orthonormal", "weighted"] {
                let mut inertia = cloud.body().inertia.with_change(change);
                if weighted == "weighted" {
                    let mass = Mat::from_fn(2, 2, |i, j| [[2.0, 0.3], [0.3, 0.7]][i][j]);
                    inertia = inertia.with_attachment_mass(AttachmentMass::of(&mass));
                }
                check_tangent(&format!("{name}, {change:?}, {weighted}"), &inertia, n);
            }
        }
    }
}

fn check_tangent(name: &str, inertia: &FrameInertia, n: usize) {
    let motion = Motion::random(inertia.dimension(), n);
    let mut terms = InertiaTerms::for_coordinates(n);
    let mut tangent = InertiaTangent::for_coordinates(n);
    inertia.evaluate(&motion.y, &motion.spin, &motion.rates, &mut terms);
    inertia.evaluate_tangent(
        &motion.state(),
        &motion.acceleration(),
        &terms,
        &mut tangent,
    );
    let (mut damping, mut stiffness) = (Mat::zeros(n, n), Mat::zeros(n, n));
    inertia.write_elastic_tangent(
        &motion.spin,
        &motion.spin_rate,
        damping.as_mut(),
        stiffness.as_mut(),
    );
    let check = |what: &str, found: Vec<f64>, expected: Vec<f64>| {
        let size = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for (row, (a, b)) in found.iter().zip(&expected).enumerate() {
            assert!(
                (a - b).abs() < 1e-11 * size,
                "{name}, {what}, row {row}: {a} against {b}"
            );
        }
    };
    let (moves, turns) = match inertia.dimension() {
        Dimension::Planar => (0..2, 2..3),
        Dimension::Spatial => (0..3, 0..3),
    };
    for axis in moves {
        let expected = difference(&motion, inertia, |m, h| m.origin += h * unit(axis));
        check("mass by A", stored(&tangent.mass, n, axis), expected);
        check(
            "damping by V",
            stored(&tangent.damping, n, axis),
            vec![0.0; 6 + n],
        );
        check(
            "stiffness by R",
            stored(&tangent.stiffness, n, axis),
            vec![0.0; 6 + n],
        );
    }
    for axis in turns {
        let expected = difference(&motion, inertia, |m, h| m.spin_rate += h * unit(axis));
        check("mass by ω'", stored(&tangent.mass, n, 3 + axis), expected);
        let expected = difference(&motion, inertia, |m, h| m.spin += h * unit(axis));
        check(
            "damping by ω",
            stored(&tangent.damping, n, 3 + axis),
            expected,
        );
        // Turned frame, the same acceleration in world axes; a small angle because the rotation isn't polynomial.
        let angle = 1e-5;
        let turned = |h: f64| {
            let mut moved = motion.clone();
            moved.origin = nalgebra::Rotation3::new(h * unit(axis)).inverse() * motion.origin;
            moved.forces(inertia)
        };
        let slopes: Vec<f64> = (turned(angle).iter())
            .zip(turned(-angle))
            .map(|(a, b)| (a - b) / (2.0 * angle))
            .collect();
        for (row, (a, b)) in stored(&tangent.stiffness, n, 3 + axis)
            .iter()
            .zip(slopes)
            .enumerate()
        {
            assert!(
                (a - b).abs() < 1e-6,
                "{name}, stiffness by φ, row {row}: {a} against {b}"
            );
        }
    }
    for k in 0..n {
        let column = |block: &dcb_runtime::frame::TangentBlock, elastic: Vec<f64>| -> Vec<f64> {
            (0..6)
                .map(|row| block.rigid_by_elastic[row * n + k])
                .chain(elastic)
                .collect()
        };
        let expected = difference(&motion, inertia, |m, h| m.second_rates[k] += h);
        let constant = expected[6..].to_vec();
        check("mass by y''", column(&tangent.mass, constant), expected);
        let expected = difference(&motion, inertia, |m, h| m.rates[k] += h);
        check(
            "damping by y'",
            column(&tangent.damping, damping.col_as_slice(k).to_vec()),
            expected,
        );
        let expected = difference(&motion, inertia, |m, h| m.y[k] += h);
        check(
            "stiffness by y",
            column(&tangent.stiffness, stiffness.col_as_slice(k).to_vec()),
            expected,
        );
        assert!(
            (tangent.softening[k] - stiffness[(k, k)]).abs()
                < 1e-13 * stiffness[(k, k)].abs().max(1.0)
        );
        assert_eq!(damping[(k, k)], 0.0, "{name}");
    }
}
