//! The flyball governor of the IFToMM library (A05): stiff spring-dampers, and Lagrange's equations of its symmetric motion.

use std::f64::consts::{FRAC_PI_6, PI};

use dcb_formats::mesh::Dimension;
use dcb_runtime::force_law::{Characteristic, Law};
use dcb_runtime::integrator::Method;
use dcb_runtime::joint::{JointKind, Prismatic};
use dcb_runtime::measure::{Elongation, Measure};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::Drawn;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::mechanism::rigid_benchmarks::GRAVITY;
use crate::mechanism::{Scene, method, revolute, rigid, run, runge_kutta};

const ARM: f64 = 0.05;
const SHAFT_SPEED: f64 = 0.16 * 2.0 * PI;
const SPRING: f64 = 8e5;
const DAMPER: f64 = 4e4;
const BALL: f64 = 5.0;

fn cuboid(mass: f64, x: f64, y: f64, z: f64) -> Matrix3<f64> {
    let diagonal = Vector3::new(y * y + z * z, x * x + z * z, x * x + y * y);
    Matrix3::from_diagonal(&(diagonal * mass / 12.0))
}

/// A rod with the ball at its end: mass, centre from the hinge, moments about and across its axis.
fn rod_with_ball() -> (f64, f64, Matrix3<f64>) {
    let mass = 0.3 + BALL;
    let center = (0.3 * 0.5 + BALL) / mass;
    let mut tensor = cuboid(0.3, 1.0, 0.01, 0.01);
    let across = 0.3 * (center - 0.5_f64).powi(2) + BALL * (1.0 - center).powi(2);
    tensor[(1, 1)] += across;
    tensor[(2, 2)] += across;
    (mass, center, tensor)
}

/// Shaft, slider, two rods with balls, two stiff spring-dampers between rods and slider (A05): spring 8e5 N/m, damper 4e4 N s/m.
pub fn governor(method: Method) -> Simulation {
    let mut scene = Scene::new(Dimension::Spatial, Vector3::new(0.0, 0.0, -GRAVITY));
    let space = Dimension::Spatial;
    let shaft = rigid(
        space,
        0.3,
        cuboid(0.3, 0.01, 0.01, 1.0),
        &[
            [0.0, 0.0, -0.5],
            [ARM, 0.0, 0.5],
            [-ARM, 0.0, 0.5],
            [0.0; 3],
        ],
    );
    let slider = rigid(
        space,
        3.0,
        cuboid(3.0, 0.1, 0.1, 0.1),
        &[[0.0; 3], [ARM, 0.0, 0.0], [-ARM, 0.0, 0.0]],
    );
    let (mass, center, tensor) = rod_with_ball();
    let rod = rigid(
        space,
        mass,
        tensor,
        &[[-center, 0.0, 0.0], [0.5 - center, 0.0, 0.0]],
    );
    let spin = Vector3::new(0.0, 0.0, SHAFT_SPEED);
    let drawn = |position: Vector3<f64>, orientation| Drawn {
        position,
        orientation,
        velocity: spin.cross(&position),
        angular_velocity: spin,
    };
    let upright = UnitQuaternion::identity();
    let shaft = scene.body(&shaft, &drawn(Vector3::new(0.0, 0.0, 0.5), upright));
    let slider = scene.body(&slider, &drawn(Vector3::new(0.0, 0.0, 0.5), upright));
    let ground = scene.ground([0.0; 3]);
    let (foot, middle, block) = (scene.on(shaft, 0), scene.on(shaft, 3), scene.on(slider, 0));
    scene.join(&revolute(Vector3::z()), ground, foot);
    let along = Prismatic { axis: Vector3::z() };
    scene.join(&JointKind::Prismatic(along), middle, block);
    for (side, index) in [(1.0, 1), (-1.0, 2)] {
        let direction = Vector3::new(side * FRAC_PI_6.cos(), 0.0, -FRAC_PI_6.sin());
        // The y axis stays the hinge's axis.
        let x = direction;
        let axes = Matrix3::from_columns(&[x, Vector3::y(), x.cross(&Vector3::y())]);
        let turn = UnitQuaternion::from_matrix(&axes);
        let place = Vector3::new(side * ARM, 0.0, 1.0) + center * direction;
        let rod = scene.body(&rod, &drawn(place, turn));
        let (hinge, own) = (scene.on(shaft, index), scene.on(rod, 0));
        scene.join(&revolute(Vector3::y()), hinge, own);
        let (on_slider, on_rod) = (scene.on(slider, index), scene.on(rod, 1));
        let law = Law::new(
            0.5,
            Characteristic::Linear { slope: SPRING },
            Characteristic::Linear { slope: DAMPER },
        );
        let distance = Measure::Elongation(Elongation { length: 0.5 });
        let name = format!("spring {index}");
        scene
            .builder()
            .spring(&name, on_slider, on_rod, [(distance, law.unwrap())]);
    }
    scene.start(method).0
}

/// Angle of the rods below the horizontal, its rate, place of the slider, its rate, by Lagrange's equations of the symmetric motion.
pub fn least_governor(duration: f64, steps: usize) -> [f64; 5] {
    let (mass, center, tensor) = rod_with_ball();
    let (about, across) = (tensor[(0, 0)], tensor[(1, 1)]);
    let fixed = cuboid(0.3, 0.01, 0.01, 1.0)[(2, 2)] + cuboid(3.0, 0.1, 0.1, 0.1)[(2, 2)];
    let about_shaft = |angle: f64| {
        let (sine, cosine) = angle.sin_cos();
        let out = ARM + center * cosine;
        fixed + 2.0 * (mass * out * out + about * sine * sine + across * cosine * cosine)
    };
    let momentum = about_shaft(FRAC_PI_6) * SHAFT_SPEED;
    let end = runge_kutta(
        [FRAC_PI_6, 0.0, 0.5, 0.0],
        duration,
        steps,
        |[angle, rate, s, up]| {
            let (sine, cosine) = angle.sin_cos();
            let spin = momentum / about_shaft(*angle);
            let out = ARM + center * cosine;
            let half_slope = 2.0 * (-mass * out * center * sine + (about - across) * sine * cosine);
            let (wide, high) = (0.5 * cosine, 1.0 - 0.5 * sine - s);
            let length = wide.hypot(high);
            let by_angle = (-wide * 0.5 * sine - high * 0.5 * cosine) / length;
            let by_s = -high / length;
            let force = SPRING * (length - 0.5) + DAMPER * (by_angle * rate + by_s * up);
            [
                *rate,
                (half_slope * spin * spin
                    + 2.0 * (mass * GRAVITY * center * cosine - force * by_angle))
                    / (2.0 * (mass * center * center + across)),
                *up,
                -GRAVITY - 2.0 * force * by_s / 3.0,
            ]
        },
    );
    [
        end[0],
        end[1],
        end[2],
        end[3],
        momentum / about_shaft(end[0]),
    ]
}

/// Errors of the slider's place, m, and of the shaft's spin, rad/s, after `duration` at `rate` steps a second.
pub fn governor_errors(duration: f64, rate: f64) -> [f64; 2] {
    let expected = least_governor(duration, (duration * 2e5) as usize);
    let mut simulation = governor(method(0.8));
    run(
        &mut simulation,
        duration,
        (rate * duration) as usize,
        |_| {},
    );
    let state = simulation.state();
    [
        (state.origins[1].z - expected[2]).abs(),
        (state.velocities[5] - expected[4]).abs(),
    ]
}
