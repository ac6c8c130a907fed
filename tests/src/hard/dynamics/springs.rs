//! Hard cases of springs: stiffnesses that are ten decades apart in one mechanism.

use dcb_formats::SparseMatrix;
use dcb_formats::mesh::Dimension;
use dcb_runtime::force_law::{Characteristic, Law};
use dcb_runtime::integrator::Rule;
use dcb_runtime::measure::{Displacement, Measure};
use dcb_runtime::system::builder::Drawn;
use dcb_samples::{RodSection, planar_rod};
use nalgebra::{DMatrix, DVector, Matrix3, Unit, Vector3};

use crate::dense::dense;
use crate::hard::case::{Bounded, HardCase};
use crate::hard::dynamics::naive_constraints::explicit_springs;
use crate::mechanism::rigid_benchmarks::GRAVITY;
use crate::mechanism::{Scene, method, radau, rigid, run};
use crate::rod::reduced::{Benchmark, ReducedRod};

/// A block on 100 N/m one way and 1e12 N/m the other.
pub fn stiffness_ratio_1e10() -> HardCase {
    block_on_springs("stiffness_ratio_1e10", method(0.8).into(), 1e-3)
}

/// The same by accuracy.
pub fn stiffness_ratio_1e10_by_radau() -> HardCase {
    block_on_springs("stiffness_ratio_1e10_by_radau", radau(1e-8).into(), 1e-6)
}

fn block_on_springs(name: &'static str, rule: Rule, bound: f64) -> HardCase {
    let (soft, stiff) = (100.0, 1e12);
    let failed = explicit_springs([soft, stiff], 1e-3, 1000).expect("leapfrog fails");
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    let block = rigid(
        Dimension::Planar,
        1.0,
        Matrix3::identity() * 0.01,
        &[[0.0; 3]],
    );
    let drawn = Drawn {
        position: Vector3::new(0.01, 0.0, 0.0),
        ..Drawn::default()
    };
    let block = scene.body(&block, &drawn);
    let (ground, center) = (scene.ground([0.0; 3]), scene.on(block, 0));
    let laws = [
        linear(Vector3::x_axis(), soft),
        linear(Vector3::y_axis(), stiff),
    ];
    scene.builder().spring("bushing", ground, center, laws);
    let (mut simulation, _) = scene.start(rule);
    let mut error: f64 = 0.0;
    run(&mut simulation, 1.0, 1000, |simulation| {
        let state = simulation.state();
        let expected = 0.01 * (10.0 * state.time).cos();
        error = error.max((state.origins[0].x - expected).abs() / 0.01);
    });
    // The stiff direction has rung out.
    error = error.max((simulation.state().forces[1].abs() / GRAVITY - 1.0).abs());
    HardCase {
        group: "dynamics",
        name,
        naive_method: "leapfrog at the same step of 1 ms",
        naive: format!("the block is a metre away after {failed} steps"),
        ours: "place over 1 s from the cosine, and the force of the stiff direction from the weight, relative".into(),
        error: Some(Bounded {
            found: error,
            bound,
        }),
    }
}

/// A steel rod on a bushing of 100 N/m at one end and 1e12 N/m at the other, let go under its weight.
pub fn bushing_on_steel() -> HardCase {
    rod_on_bushings("bushing_on_steel", method(0.8).into(), 3e-3)
}

/// The same by accuracy: what is left is that the modes' theory is linear, the rod turns by a hundredth.
pub fn bushing_on_steel_by_radau() -> HardCase {
    rod_on_bushings("bushing_on_steel_by_radau", radau(1e-6).into(), 3e-4)
}

fn rod_on_bushings(name: &'static str, rule: Rule, bound: f64) -> HardCase {
    let (stiffness, step) = ([100.0, 1e12], 1e-4);
    let component = planar_rod(4, &RodSection::default());
    let square = |matrix: &SparseMatrix| {
        let full = dense(matrix);
        DMatrix::from_fn(full.nrows(), full.ncols(), |i, j| full[(i, j)])
    };
    let (mut k, m) = (square(&component.stiffness), square(&component.mass));
    let n = m.nrows();
    // ux uy rz at five nodes; the ends are the first and the last.
    for (stiffness, first) in stiffness.into_iter().zip([0, n - 3]) {
        k[(first, first)] += stiffness;
        k[(first + 1, first + 1)] += stiffness;
    }
    let upward = DVector::from_fn(n, |i, _| if i % 3 == 1 { 1.0 } else { 0.0 });
    let weight = -GRAVITY * (&m * upward);
    let factor = m.clone().cholesky().expect("a mass matrix");

    let (mut u, mut v) = (DVector::zeros(n), DVector::zeros(n));
    let failed = (1..=1000).find(|_| {
        v += step * factor.solve(&(&weight - &k * &u));
        u += step * &v;
        u.amax() > 1.0
    });
    let failed = failed.expect("leapfrog fails");

    // u = Σ φ (φᵀ f / ω²) (1 - cos ω t)
    let inverse = factor.l().try_inverse().expect("an inverse");
    let modes = (&inverse * &k * inverse.transpose()).symmetric_eigen();
    let shapes = inverse.transpose() * &modes.eigenvectors;
    let loads = shapes.transpose() * &weight;
    let soft_end = |time: f64| -> f64 {
        let terms = modes.eigenvalues.iter().enumerate();
        let term = |(j, square): (usize, &f64)| {
            shapes[(1, j)] * loads[j] / square * (1.0 - (square.sqrt() * time).cos())
        };
        terms.map(term).sum()
    };

    let rod = ReducedRod::new(Benchmark::first(), 4, 12);
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    let body = scene.body(&rod.body, &Drawn::default());
    for (end, slope) in stiffness.into_iter().enumerate() {
        let x = RodSection::default().length * end as f64;
        let (ground, at) = (scene.ground([x, 0.0, 0.0]), scene.on(body, end));
        let laws = [Vector3::x_axis(), Vector3::y_axis()].map(|along| linear(along, slope));
        scene
            .builder()
            .spring(&format!("bushing {end}"), ground, at, laws);
    }
    let soft = scene.on(body, 0);
    let (mut simulation, _) = scene.start(rule);
    let (mut error, mut largest): (f64, f64) = (0.0, 0.0);
    run(
        &mut simulation,
        0.1,
        (0.1 / step).round() as usize,
        |simulation| {
            let expected = soft_end(simulation.state().time);
            let found = simulation.refresh().motions[soft].position.y;
            error = error.max((found - expected).abs());
            largest = largest.max(expected.abs());
        },
    );
    HardCase {
        group: "dynamics",
        name,
        naive_method: "leapfrog on the finite elements at the same step of 0.1 ms",
        naive: format!("an end is a metre away after {failed} steps"),
        ours: "the soft end over a period of the swing, from the modes of the linear finite elements with their springs, by its largest".into(),
        error: Some(Bounded {
            found: error / largest,
            bound,
        }),
    }
}

fn linear(direction: Unit<Vector3<f64>>, slope: f64) -> (Measure, Law) {
    let law = Law::new(
        0.0,
        Characteristic::Linear { slope },
        Characteristic::Linear { slope: 0.0 },
    );
    let measure = Measure::Displacement(Displacement { direction });
    (measure, law.expect("a law"))
}
