//! The plain methods that the hard cases of the dynamics are measured against, each in the few lines that it takes: particles under
//! gravity, held by constraints that are met in the ways of textbooks and game engines.

use nalgebra::{DMatrix, DVector, Vector2};

/// Gravity, m/s².
const GRAVITY: f64 = 9.81;

/// Particles on a string from the origin, horizontal at first, one metre in all. Sequential impulses (Gauss-Seidel on the velocities, with
/// a fifth of the misfit put back in a step), symplectic Euler: the string's largest stretch in the run, by its length.
pub fn sequential_impulses(masses: &[f64], sweeps: usize, step: f64, steps: usize) -> f64 {
    let n = masses.len();
    let link = 1.0 / n as f64;
    let mut x: Vec<Vector2<f64>> = (1..=n)
        .map(|k| Vector2::new(link * k as f64, 0.0))
        .collect();
    let mut v = vec![Vector2::zeros(); n];
    let mut stretch: f64 = 0.0;
    for _ in 0..steps {
        v.iter_mut()
            .for_each(|v: &mut Vector2<f64>| v.y -= step * GRAVITY);
        for _ in 0..sweeps {
            for k in 0..n {
                let (from, moving, light) = match k {
                    0 => (Vector2::zeros(), Vector2::zeros(), 0.0),
                    _ => (x[k - 1], v[k - 1], 1.0 / masses[k - 1]),
                };
                let along = x[k] - from;
                let length = along.norm();
                let along = along / length;
                let wrong = along.dot(&(v[k] - moving)) + 0.2 * (length - link) / step;
                let impulse = wrong / (light + 1.0 / masses[k]);
                v[k] -= along * (impulse / masses[k]);
                if k > 0 {
                    v[k - 1] += along * (impulse * light);
                }
            }
        }
        let mut length = 0.0;
        let mut from = Vector2::zeros();
        for (x, v) in x.iter_mut().zip(&v) {
            *x += step * v;
            length += (*x - from).norm();
            from = *x;
        }
        stretch = stretch.max((length - 1.0).abs());
    }
    stretch
}

/// A particle on a rod of 1 m whose constraint is differentiated twice and left alone, Runge-Kutta of order four: how much the rod's length
/// has changed at the end. It starts at the horizontal with this velocity.
pub fn twice_differentiated(velocity: Vector2<f64>, step: f64, steps: usize) -> f64 {
    let slope = |(x, v): &(Vector2<f64>, Vector2<f64>)| {
        let gravity = Vector2::new(0.0, -GRAVITY);
        let force = (v.norm_squared() + gravity.dot(x)) / x.norm_squared();
        (*v, gravity - force * x)
    };
    let mut now = (Vector2::new(1.0, 0.0), velocity);
    let moved = |now: &(Vector2<f64>, Vector2<f64>), by: f64, k: &(Vector2<f64>, Vector2<f64>)| {
        (now.0 + by * k.0, now.1 + by * k.1)
    };
    for _ in 0..steps {
        let k1 = slope(&now);
        let k2 = slope(&moved(&now, 0.5 * step, &k1));
        let k3 = slope(&moved(&now, 0.5 * step, &k2));
        let k4 = slope(&moved(&now, step, &k3));
        for (weight, k) in [(1.0, k1), (2.0, k2), (2.0, k3), (1.0, k4)] {
            now = moved(&now, weight * step / 6.0, &k);
        }
    }
    now.0.norm() - 1.0
}

/// A particle of 1 kg that whirls about a pin at 1 m with this speed, the rod a penalty spring, leapfrog: the spring's largest and
/// smallest force.
pub fn penalty_rod(stiffness: f64, speed: f64, step: f64, steps: usize) -> [f64; 2] {
    let force = |x: &Vector2<f64>| -stiffness * (x.norm() - 1.0) * x.normalize();
    let mut x = Vector2::new(1.0, 0.0);
    let mut v = Vector2::new(0.0, speed) + 0.5 * step * force(&x);
    let mut range = [f64::INFINITY, 0.0_f64];
    for _ in 0..steps {
        x += step * v;
        let pull = force(&x);
        v += step * pull;
        range = [range[0].min(pull.norm()), range[1].max(pull.norm())];
    }
    range
}

/// A particle on a rod, index 3 by the trapezoidal rule and Newton's iteration, which ends where forces (N) and misfit (m) are below an
/// absolute tolerance. Let go from the horizontal: the largest change of the rod's length by what it was.
pub fn absolute_tolerance(
    mass: f64,
    length: f64,
    tolerance: f64,
    step: f64,
    steps: usize,
) -> Option<f64> {
    let gravity = Vector2::new(0.0, -GRAVITY);
    let (mut x, mut v, mut a) = (Vector2::new(length, 0.0), Vector2::zeros(), gravity);
    let (mut pull, mut worst) = (0.0, 0.0_f64);
    for _ in 0..steps {
        let guess = x + step * v + 0.25 * step * step * a;
        let mut after = a;
        for _ in 0..20 {
            let at = guess + 0.25 * step * step * after;
            let forces = mass * (after - gravity) + pull * at;
            let misfit = 0.5 * (at.norm_squared() - length * length) / length;
            if forces.norm() < tolerance && misfit.abs() < tolerance {
                break;
            }
            let by_place = 0.25 * step * step;
            let matrix = DMatrix::from_row_slice(
                3,
                3,
                &[
                    mass + pull * by_place,
                    0.0,
                    at.x,
                    0.0,
                    mass + pull * by_place,
                    at.y,
                    at.x * by_place / length,
                    at.y * by_place / length,
                    0.0,
                ],
            );
            let right = DVector::from_vec(vec![-forces.x, -forces.y, -misfit]);
            let change = matrix.lu().solve(&right)?;
            after += Vector2::new(change[0], change[1]);
            pull += change[2];
        }
        x = guess + 0.25 * step * step * after;
        v += 0.5 * step * (a + after);
        a = after;
        worst = worst.max((x.norm() / length - 1.0).abs());
    }
    Some(worst)
}

/// A particle of 1 kg on a rod of 1 m that passes its lowest point at 1 m/s, index 3 by the trapezoidal rule; Newton's equations as they
/// stand, solved in the sense of least squares without what is below rounding of the largest singular value. The rod's pull at the end, N.
pub fn unscaled_least_squares(step: f64, steps: usize) -> f64 {
    let gravity = Vector2::new(0.0, -GRAVITY);
    let (mut x, mut v) = (Vector2::new(0.0, -1.0), Vector2::new(1.0, 0.0));
    let mut a = Vector2::new(0.0, 1.0);
    let mut pull = 0.0;
    let slope = 4.0 / (step * step);
    for _ in 0..steps {
        let guess = x + step * v + 0.25 * step * step * a;
        let mut at = x + step * v + 0.5 * step * step * a;
        for _ in 0..5 {
            let forces = slope * (at - guess) - gravity + pull * at;
            let misfit = 0.5 * (at.norm_squared() - 1.0);
            let own = slope + pull;
            let entries = [own, 0.0, at.x, 0.0, own, at.y, at.x, at.y, 0.0];
            let decomposed = DMatrix::from_row_slice(3, 3, &entries).svd(true, true);
            let small = f64::EPSILON * decomposed.singular_values.max();
            let right = DVector::from_vec(vec![-forces.x, -forces.y, -misfit]);
            let change = decomposed.solve(&right, small).expect("both bases");
            at += Vector2::new(change[0], change[1]);
            pull += change[2];
        }
        let after = slope * (at - guess);
        v += 0.5 * step * (a + after);
        (x, a) = (at, after);
    }
    // What moves it is not gravity alone.
    (a - gravity).norm()
}

/// A block of 1 kg on two springs, leapfrog: the step at which it is further away than a metre, if ever.
pub fn explicit_springs(stiffness: [f64; 2], step: f64, steps: usize) -> Option<usize> {
    let (mut x, mut v) = (Vector2::new(0.01, 0.0), Vector2::new(0.0, 0.0));
    (1..=steps).find(|_| {
        let force = Vector2::new(-stiffness[0] * x.x, -stiffness[1] * x.y - GRAVITY);
        v += step * force;
        x += step * v;
        x.norm() > 1.0
    })
}

/// Crank and rod of 1 m: the rod's angle and the slider's place by Newton's iteration from the last position, with the Jacobian as it is;
/// the place at the end, `None` where an iteration has no solution.
pub fn kinematic_newton(angles: impl Iterator<Item = f64>) -> Option<f64> {
    // Crank (cos φ, sin φ), rod from there (cos θ, sin θ) to the slider (s, 0).
    let (mut theta, mut s) = (0.0_f64, 2.0_f64);
    for phi in angles {
        let mut last = f64::INFINITY;
        for _ in 0..20 {
            let misfit = [phi.cos() + theta.cos() - s, phi.sin() + theta.sin()];
            let matrix = DMatrix::from_row_slice(2, 2, &[-theta.sin(), -1.0, theta.cos(), 0.0]);
            let change = matrix
                .lu()
                .solve(&DVector::from_vec(vec![-misfit[0], -misfit[1]]))?;
            theta += change[0];
            s += change[1];
            last = change.norm();
            if last < 1e-12 {
                break;
            }
        }
        if last.is_nan() || last > 1e-9 {
            return None;
        }
    }
    Some(s)
}

/// λ of `B M⁻¹ Bᵀ λ = -B M⁻¹ f - c`, by Gaussian elimination of the whole system with row pivoting; the largest size, infinite where there
/// is none.
pub fn plain_elimination(
    mass: &DMatrix<f64>,
    jacobian: &DMatrix<f64>,
    forces: &DVector<f64>,
    curvature: &DVector<f64>,
) -> f64 {
    let (n, m) = (mass.nrows(), jacobian.nrows());
    let mut matrix = DMatrix::zeros(n + m, n + m);
    matrix.view_mut((0, 0), (n, n)).copy_from(mass);
    matrix.view_mut((n, 0), (m, n)).copy_from(jacobian);
    matrix
        .view_mut((0, n), (n, m))
        .copy_from(&-jacobian.transpose());
    let mut right = DVector::zeros(n + m);
    right.rows_mut(0, n).copy_from(forces);
    right.rows_mut(n, m).copy_from(&-curvature);
    match matrix.lu().solve(&right) {
        Some(solution) => solution.rows(n, m).amax(),
        None => f64::INFINITY,
    }
}
