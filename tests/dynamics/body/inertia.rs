//! The mass matrix and the velocity-dependent forces against what they stand for.

use crate::support;
use crate::support::{Part, deflection, nodal_energy, numbers, parts};
use dcb_runtime::InertiaTerms;
use faer::{Mat, Side};
use nalgebra::Vector3;

/// A motion with a deflection of some hundredths of the parts' size: the second-order terms show.
fn motion(part: &Part) -> (Vector3<f64>, Vector3<f64>, Vec<f64>, Vec<f64>) {
    let basis = part.basis();
    let velocity = part.velocity(Vector3::new(3.0, -1.0, 2.0));
    let spin = part.spin(Vector3::new(70.0, -110.0, 50.0));
    (
        velocity,
        spin,
        deflection(&basis, 0.02, 1),
        deflection(&basis, 0.5, 2),
    )
}

fn kinetic_energy(
    part: &Part,
    terms: &mut InertiaTerms,
    spin: &Vector3<f64>,
    y: &[f64],
    rates: &[f64],
) -> f64 {
    part.body.inertia.evaluate(y, spin, rates, terms);
    terms.kinetic_energy(0.0, &Vector3::zeros(), spin, rates)
}

#[test]
fn kinetic_energy_is_that_of_the_nodes() {
    for (name, part) in parts() {
        let (velocity, spin, y, rates) = motion(&part);
        let mut terms = part.terms();
        part.body.inertia.evaluate(&y, &spin, &rates, &mut terms);
        let reduced = terms.kinetic_energy(part.body.inertia.mass(), &velocity, &spin, &rates);
        let nodal = nodal_energy(&part, &velocity, &spin, &y, &rates);
        let defect = (reduced - nodal).abs() / nodal;
        assert!(
            defect < 1e-11,
            "{name}: {reduced} against {nodal}, {defect:e}"
        );
        // The deflection matters in this comparison.
        let rigid = nodal_energy(&part, &velocity, &spin, &vec![0.0; y.len()], &rates);
        assert!(
            (rigid - nodal).abs() > 1e-4 * nodal,
            "{name}: {rigid} against {nodal}"
        );
    }
}

#[test]
fn mass_matrix_is_positive_definite_and_gives_the_kinetic_energy() {
    for (name, part) in parts() {
        let (velocity, spin, y, rates) = motion(&part);
        let mut terms = part.terms();
        part.body.inertia.evaluate(&y, &spin, &rates, &mut terms);
        let d = part.component.dimension().coordinate_count();
        let axes = part.component.dimension().rigid_mode_count() - d;
        let size = d + axes + y.len();
        let mut mass = Mat::zeros(size, size);
        part.body.inertia.write_mass_matrix(&terms, mass.as_mut());
        assert_eq!(mass, mass.transpose().to_owned(), "{name}");
        assert!(mass.llt(Side::Lower).is_ok(), "{name}");
        let spins = spin.iter().skip(3 - axes);
        let v: Vec<f64> = velocity
            .iter()
            .take(d)
            .chain(spins)
            .chain(&rates)
            .copied()
            .collect();
        let momentum = support::product(&mass, &v);
        let half: f64 = 0.5 * momentum.iter().zip(&v).map(|(p, v)| p * v).sum::<f64>();
        let energy = terms.kinetic_energy(part.body.inertia.mass(), &velocity, &spin, &rates);
        assert!(
            (half - energy).abs() < 1e-13 * energy,
            "{name}: {half} against {energy}"
        );
    }
}

/// d/dt(∂T/∂ω) + ω × ∂T/∂ω and d/dt(∂T/∂y') - ∂T/∂y from values of T alone, along a path with constant accelerations;
/// central differences of step `h` in time. T is quadratic in velocities and in y, so its own differences are exact.
fn lagrange_forces(
    part: &Part,
    start: &(Vector3<f64>, Vec<f64>, Vec<f64>),
    accelerations: &(Vector3<f64>, Vec<f64>),
    h: f64,
) -> (Vector3<f64>, Vec<f64>) {
    let (spin0, y0, rates0) = start;
    let n = y0.len();
    let at = |t: f64| -> (Vector3<f64>, Vec<f64>, Vec<f64>) {
        (
            spin0 + accelerations.0 * t,
            (0..n)
                .map(|i| y0[i] + rates0[i] * t + 0.5 * accelerations.1[i] * t * t)
                .collect(),
            (0..n).map(|i| rates0[i] + accelerations.1[i] * t).collect(),
        )
    };
    let mut terms = part.terms();
    let difference = |t: &mut dyn FnMut(f64) -> f64, step: f64| (t(step) - t(-step)) / (2.0 * step);
    let mut momenta = |t: f64| -> (Vector3<f64>, Vec<f64>) {
        let (spin, y, rates) = at(t);
        let of_spin = part.spin(Vector3::from_fn(|axis, _| {
            let mut energy = |step: f64| {
                let mut moved = spin;
                moved[axis] += step;
                kinetic_energy(part, &mut terms, &part.spin(moved), &y, &rates)
            };
            difference(&mut energy, 10.0)
        }));
        let of_rates = (0..n)
            .map(|i| {
                let mut energy = |step: f64| {
                    let mut moved = rates.clone();
                    moved[i] += step;
                    kinetic_energy(part, &mut terms, &spin, &y, &moved)
                };
                difference(&mut energy, 1.0)
            })
            .collect();
        (of_spin, of_rates)
    };
    let (after, before, now) = (momenta(h), momenta(-h), momenta(0.0));
    let moment = (after.0 - before.0) / (2.0 * h) + spin0.cross(&now.0);
    let forces = (0..n)
        .map(|i| {
            let mut energy = |step: f64| {
                let mut moved = y0.clone();
                moved[i] += step;
                kinetic_energy(part, &mut terms, spin0, &moved, rates0)
            };
            (after.1[i] - before.1[i]) / (2.0 * h) - difference(&mut energy, 0.1)
        })
        .collect();
    (moment, forces)
}

#[test]
fn forces_are_those_of_the_energy() {
    for (name, part) in parts() {
        let (_, spin, y, rates) = motion(&part);
        let start = (spin, y.clone(), rates.clone());
        let of_rates: Vec<f64> = numbers(y.len(), 3).iter().map(|a| 30.0 * a).collect();
        let accelerations = (part.spin(Vector3::new(40.0, 90.0, -60.0)), of_rates);
        // M v' - f of the body.
        let mut terms = part.terms();
        part.body.inertia.evaluate(&y, &spin, &rates, &mut terms);
        let moment = terms.angular_momentum(&accelerations.0, &accelerations.1) - terms.moment;
        let forces: Vec<f64> = (0..y.len())
            .map(|l| {
                let coupled: f64 = (0..3)
                    .map(|a| terms.coupling(a)[l] * accelerations.0[a])
                    .sum();
                accelerations.1[l] + coupled - terms.force[l]
            })
            .collect();
        let size = moment.norm() + forces.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
        let error = |h: f64| {
            let (m, f) = lagrange_forces(&part, &start, &accelerations, h);
            let of_forces = f
                .iter()
                .zip(&forces)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            ((m - moment).norm() + of_forces) / size
        };
        let (coarse, fine) = (error(2e-3), error(1e-3));
        let order = (coarse / fine).log2();
        assert!(
            (order - 2.0).abs() < 0.05,
            "{name}: order {order}, errors {coarse:e} {fine:e}"
        );
        let finest = error(1e-5);
        assert!(finest < 1e-7, "{name}: {finest:e}");
    }
}

#[test]
fn antisymmetric_coupling_carries_no_energy() {
    for (name, part) in parts() {
        let (_, spin, y, rates) = motion(&part);
        let mut terms = part.terms();
        // A deflection that grows along itself has no momentum about the centre of mass: L(y) y = 0.
        part.body.inertia.evaluate(&y, &spin, &y, &mut terms);
        let along = terms.relative_momentum(&y).norm();
        let across = terms.relative_momentum(&rates).norm()
            * (y.iter().map(|y| y * y).sum::<f64>() / rates.iter().map(|r| r * r).sum::<f64>())
                .sqrt();
        assert!(
            along < 1e-12 * across,
            "{name}: {along:e} against {across:e}"
        );
        // Without stiffness and loads nothing changes the kinetic energy: dT/dt = ∂T/∂v v' + ∂T/∂y y' = 0.
        let mut rates_rate = vec![0.0; y.len()];
        part.body.inertia.evaluate(&y, &spin, &rates, &mut terms);
        let dimension = part.component.dimension();
        let spin_rate = terms
            .accelerations(dimension, &Vector3::zeros(), &mut rates_rate)
            .unwrap();
        let mut energy = |t: f64| {
            let moved: Vec<f64> = (0..y.len()).map(|i| y[i] + t * rates[i]).collect();
            let faster: Vec<f64> = (0..y.len()).map(|i| rates[i] + t * rates_rate[i]).collect();
            kinetic_energy(&part, &mut terms, &(spin + spin_rate * t), &moved, &faster)
        };
        let power = (energy(1e-5) - energy(-1e-5)) / 2e-5;
        let scale = energy(0.0) * spin.norm();
        assert!(power.abs() < 1e-8 * scale, "{name}: {power:e} of {scale:e}");
    }
}
