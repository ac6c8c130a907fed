//! Free motion of one body: its state, its equations, and an explicit integrator for them.

use dcb_runtime::{FlexibleBody, InertiaTerms};
use nalgebra::{Quaternion, Vector3};

/// Attitude, spin, coordinates and rates of a body that nothing acts on.
#[derive(Clone)]
pub struct FreeState {
    pub orientation: Quaternion<f64>,
    pub spin: Vector3<f64>,
    pub y: Vec<f64>,
    pub rates: Vec<f64>,
}

impl FreeState {
    pub fn spinning(body: &FlexibleBody, spin: Vector3<f64>) -> Self {
        let zeros = vec![0.0; body.coordinate_count()];
        Self {
            orientation: Quaternion::identity(),
            spin,
            y: zeros.clone(),
            rates: zeros,
        }
    }

    pub fn pack(&self) -> Vec<f64> {
        let q = &self.orientation;
        [q.w, q.i, q.j, q.k]
            .into_iter()
            .chain(self.spin.iter().copied())
            .chain(self.y.clone())
            .chain(self.rates.clone())
            .collect()
    }

    pub fn unpack(x: &[f64]) -> Self {
        let n = (x.len() - 7) / 2;
        Self {
            orientation: Quaternion::new(x[0], x[1], x[2], x[3]),
            spin: Vector3::new(x[4], x[5], x[6]),
            y: x[7..7 + n].to_vec(),
            rates: x[7 + n..].to_vec(),
        }
    }

    /// Energy about the centre of mass, and angular momentum in world axes.
    pub fn invariants(&self, body: &FlexibleBody, terms: &mut InertiaTerms) -> (f64, Vector3<f64>) {
        body.inertia
            .evaluate(&self.y, &self.spin, &self.rates, terms);
        let kinetic = terms.kinetic_energy(
            body.inertia.mass(),
            &Vector3::zeros(),
            &self.spin,
            &self.rates,
        );
        let momentum = terms.angular_momentum(&self.spin, &self.rates);
        let unit = nalgebra::UnitQuaternion::from_quaternion(self.orientation);
        (kinetic + body.strain_energy(&self.y), unit * momentum)
    }
}

/// d/dt of a packed free state.
pub fn free_motion(body: &FlexibleBody, terms: &mut InertiaTerms, x: &[f64], dx: &mut [f64]) {
    let n = body.coordinate_count();
    let spin = Vector3::new(x[4], x[5], x[6]);
    let (y, rates) = x[7..].split_at(n);
    let turning = Quaternion::new(x[0], x[1], x[2], x[3]) * Quaternion::from_imag(spin) * 0.5;
    dx[..4].copy_from_slice(&[turning.w, turning.i, turning.j, turning.k]);
    body.inertia.evaluate(y, &spin, rates, terms);
    let (dy, forces) = dx[7..].split_at_mut(n);
    dy.copy_from_slice(rates);
    body.internal_forces(y, rates, forces);
    forces.iter_mut().for_each(|force| *force = -*force);
    let spin_rate = terms
        .accelerations(body.inertia.dimension(), &Vector3::zeros(), forces)
        .unwrap();
    dx[4..7].copy_from_slice(spin_rate.as_slice());
}

/// Dormand and Prince's pair of orders 5 and 4 with step control, from 0 to `end`; `scale` is each entry's absolute tolerance.
pub fn integrate(mut f: impl FnMut(&[f64], &mut [f64]), x: &mut [f64], end: f64, scale: &[f64]) {
    const A: [[f64; 6]; 6] = [
        [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
        [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
        [
            19372.0 / 6561.0,
            -25360.0 / 2187.0,
            64448.0 / 6561.0,
            -212.0 / 729.0,
            0.0,
            0.0,
        ],
        [
            9017.0 / 3168.0,
            -355.0 / 33.0,
            46732.0 / 5247.0,
            49.0 / 176.0,
            -5103.0 / 18656.0,
            0.0,
        ],
        [
            35.0 / 384.0,
            0.0,
            500.0 / 1113.0,
            125.0 / 192.0,
            -2187.0 / 6784.0,
            11.0 / 84.0,
        ],
    ];
    const E: [f64; 7] = [
        71.0 / 57600.0,
        0.0,
        -71.0 / 16695.0,
        71.0 / 1920.0,
        -17253.0 / 339200.0,
        22.0 / 525.0,
        -1.0 / 40.0,
    ];
    let n = x.len();
    let mut k = vec![vec![0.0; n]; 7];
    let (mut t, mut h) = (0.0, 1e-3 * end);
    let mut trial = vec![0.0; n];
    f(x, &mut k[0]);
    while t < end {
        h = f64::min(h, end - t);
        for stage in 0..6 {
            for i in 0..n {
                trial[i] = x[i] + h * (0..=stage).map(|j| A[stage][j] * k[j][i]).sum::<f64>();
            }
            f(&trial, &mut k[stage + 1]);
        }
        let error = (0..n)
            .map(|i| (h * (0..7).map(|j| E[j] * k[j][i]).sum::<f64>() / scale[i]).abs())
            .fold(0.0, f64::max);
        if error <= 1.0 {
            t += h;
            x.copy_from_slice(&trial);
            k.swap(0, 6);
        }
        h *= (0.9 * error.max(1e-8).powf(-0.2)).clamp(0.2, 4.0);
    }
}
