//! The flexible slider-crank of the Test Set for IVP Solvers: its data, its published solution, and the same motion by the
//! classical equations and by the runtime.
//!
//! Source: Simeon, "Modelling a flexible slider crank mechanism by a mixed system of DAEs and PDEs", Math. Modelling of Systems
//! 2 (1996) 1-18; test set (Mazzia, Magherini), problem "Slider crank", its file `crank.f`.
// The constants have the digits that the set prints, its π among them.
#![allow(clippy::approx_constant, clippy::excessive_precision)]

use std::sync::Arc;

use dcb_formats::component::{InterfaceKind, Role};
use dcb_formats::mesh::Dimension;
use dcb_formats::superelement::{BoundaryRow, Inertia, InterfaceFrame};
use dcb_runtime::integrator::Rule;
use dcb_runtime::integrator::radau::Accuracy;
use dcb_runtime::simulation::Simulation;
use dcb_runtime::{FlexibleBody, GeneralizedBody};
use dcb_samples::RodSection;
use faer::Mat;
use nalgebra::{DMatrix, RowDVector, Vector2};

use crate::mechanism::slider_crank::{
    RodStart, SliderCrank, rod_angle, rod_coordinates, slider_position,
};
use crate::mechanism::{method, run, si};
use crate::rod::corotated::{CorotatedRod, CorotatedSliderCrank, RodEnd};
use crate::rod::reduced::{Benchmark, ReducedRod};

/// The set's π.
const PI: f64 = 3.1415927;
const CRANK: f64 = 0.15;
/// Length of the rod.
pub const LENGTH: f64 = 0.30;
const SIDE: f64 = 0.008;
const MODULUS: f64 = 0.2e12;
const DENSITY: f64 = 7870.0;
const SLIDER: f64 = 0.075552;
const SPEED: f64 = 150.0;
/// The rod's mass and moment of inertia about the crank pin, as the set gives them; the moment includes that of the section.
const MASS: f64 = 0.151104;
const MOMENT: f64 = 0.0045339259;
/// Coordinates at the start.
pub const START: [f64; 4] = [0.0, 0.0, 1.033398630000000e-5, 1.693279690000000e-5];
/// Rates of the coordinates at the start.
pub const RATES: [f64; 4] = [
    4.448961125815990e-1,
    4.634339319238670e-3,
    -1.785910760000550e-6,
    -2.689386719979040e-6,
];
/// Spin of the rod at the start.
pub const SPIN: f64 = -7.499576703969453e1;
/// The published solution at t = 0.1: φ2, x3, q1..q4.
pub const PUBLISHED: [f64; 6] = [
    -0.331_173_498_825_626_0,
    0.169_737_332_842_786_0,
    1.893_192_899_613_509e-4,
    2.375_751_249_879_174e-5,
    -5.323_896_770_569_702e-6,
    -8.363_313_279_112_129e-6,
];
/// The published multipliers: guide, slider, drive.
pub const PUBLISHED_FORCES: [f64; 3] = [
    -62.329_358_332_879_16,
    -163.792_099_336_730_6,
    25.298_579_470_668_78,
];

/// The reduced matrices of the rod over two sines for v and a quadratic with two nodes for u, in a frame at the crank pin along
/// the rod. `axial` is the factor of [[8, 1], [1, 2]] in the mass: 1 in the set's code, 1/15 in a consistent mass.
fn rod(axial: f64) -> (CorotatedRod, GeneralizedBody) {
    let m = DENSITY * SIDE * SIDE * LENGTH;
    let k = MODULUS * SIDE * SIDE / LENGTH;
    let slender = (SIDE / LENGTH).powi(2);
    let mut mass = DMatrix::zeros(4, 4);
    mass[(0, 0)] = 0.5 * m;
    mass[(1, 1)] = 0.5 * m;
    for (i, j, entry) in [(2, 2, 8.0), (2, 3, 1.0), (3, 2, 1.0), (3, 3, 2.0)] {
        mass[(i, j)] = axial * m * entry;
    }
    let mut stiffness = DMatrix::zeros(4, 4);
    stiffness[(0, 0)] = k * PI.powi(4) / 24.0 * slender;
    stiffness[(1, 1)] = k * PI.powi(4) * 2.0 / 3.0 * slender;
    for (i, j, entry) in [(2, 2, 16.0), (2, 3, -8.0), (3, 2, -8.0), (3, 3, 7.0)] {
        stiffness[(i, j)] = k * entry / 3.0;
    }
    // ∫ρ (ψ_k × ψ_l): axial shapes with the sines.
    let mut l3 = DMatrix::zeros(4, 4);
    for (i, j, entry) in [
        (2, 0, 16.0 / PI.powi(3)),
        (3, 0, 1.0 / PI - 8.0 / PI.powi(3)),
        (3, 1, -0.5 / PI),
    ] {
        l3[(i, j)] = m * entry;
        l3[(j, i)] = -m * entry;
    }
    let l1 = DMatrix::from_row_slice(
        2,
        4,
        &[
            0.0,
            0.0,
            2.0 / 3.0 * m,
            m / 6.0, //
            2.0 / PI * m,
            0.0,
            0.0,
            0.0,
        ],
    );
    // About the crank pin, then about the centre.
    let to_centre = 0.5 * LENGTH;
    let about_pin = RowDVector::from_row_slice(&[0.0, 0.0, m * LENGTH / 3.0, m * LENGTH / 6.0]);
    let i1 = about_pin - to_centre * l1.row(0);
    let about_pin =
        RowDVector::from_row_slice(&[m * LENGTH / PI, -0.5 * m * LENGTH / PI, 0.0, 0.0]);
    let i3 = about_pin - to_centre * l1.row(1);
    let inertia = MOMENT - MASS * to_centre * to_centre;
    let end = |x: f64, stretch: f64| {
        let mut shapes = DMatrix::zeros(2, 4);
        shapes[(0, 3)] = stretch;
        RodEnd {
            position: Vector2::new(x, 0.0),
            shapes,
        }
    };
    let classical = CorotatedRod {
        mass: MASS,
        inertia,
        l1,
        i1,
        i3,
        l3,
        reduced_mass: mass,
        stiffness,
        ends: [end(-to_centre, 0.0), end(to_centre, 1.0)],
    };
    let body = generalized(&classical);
    (classical, body)
}

/// The same numbers as the runtime takes them.
fn generalized(rod: &CorotatedRod) -> GeneralizedBody {
    let n = rod.i1.len();
    let dense =
        |matrix: &DMatrix<f64>| Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)]);
    let about_z = |value: f64| {
        let mut block = [[0.0; 3]; 3];
        block[2][2] = value;
        block
    };
    let position = |end: usize| {
        let position = rod.ends[end].position;
        [position.x, position.y, 0.0]
    };
    GeneralizedBody {
        name: "rod".into(),
        units: si(),
        dimension: Dimension::Planar,
        origin: [0.5 * LENGTH, 0.0, 0.0],
        mass: dense(&rod.reduced_mass),
        stiffness: dense(&rod.stiffness),
        damping: Vec::new(),
        inertia: Inertia {
            mass: rod.mass,
            tensor: about_z(rod.inertia),
            l1: dense(&rod.l1),
            i1: rod.i1.iter().map(|value| about_z(*value)).collect(),
            i3: Mat::from_fn(1, n, |_, k| rod.i3[k]),
            l3: vec![dense(&rod.l3)],
            i2: Vec::new(),
        },
        interfaces: (0..2)
            .map(|end| InterfaceFrame {
                name: ["a", "b"][end].into(),
                kind: InterfaceKind::Rigid,
                role: Role::Attachment,
                position: position(end),
                orientation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            })
            .collect(),
        rows: (0..4)
            .map(|row| BoundaryRow {
                interface: row / 2,
                direction: (row % 2) as i64,
                node: -1,
                position: position(row / 2),
            })
            .collect(),
        interface_shapes: Mat::from_fn(4, n, |row, k| rod.ends[row / 2].shapes[(row % 2, k)]),
    }
}

/// What the set publishes: φ2, x3, q1..q4, and the multipliers of guide, slider and drive.
pub struct Answer {
    /// φ2, x3, q1..q4.
    pub positions: [f64; 6],
    /// Guide, slider, drive.
    pub forces: [f64; 3],
}

/// The mechanism in the classical equations.
pub fn classical_mechanism(axial: f64) -> CorotatedSliderCrank {
    CorotatedSliderCrank {
        rod: rod(axial).0,
        crank: CRANK,
        speed: SPEED,
        slider: SLIDER,
    }
}

/// At t = 0.1 by the classical equations.
pub fn classical(axial: f64) -> Answer {
    let mechanism = classical_mechanism(axial);
    let mut motion = mechanism.start(&START, &RATES, SPIN);
    mechanism.advance(&mut motion, 2e-5, 5000);
    let (_, reactions) = mechanism.accelerations(&motion);
    let q = motion.position.rows(3, 4);
    let x3 = mechanism.slider_position(&motion);
    let (sine, cosine) = (SPEED * motion.time).sin_cos();
    Answer {
        positions: [motion.position[2], x3, q[0], q[1], q[2], q[3]],
        // The guide pushes by -λ1, the slider is pulled by -λ2, and the drive turns the crank by -λ3 against the pin's force.
        forces: [
            -reactions[2],
            -SLIDER * mechanism.slider_acceleration(&motion),
            CRANK * (reactions[0] * sine - reactions[1] * cosine),
        ],
    }
}

/// The runtime's simulation from the set's start, and what turns its coordinates into q.
pub fn simulation(axial: f64, rule: impl Into<Rule>) -> (Simulation, Arc<FlexibleBody>) {
    let body = rod(axial).1;
    let flexible = Arc::new(FlexibleBody::from_generalized(&body).unwrap());
    // q = V y and Vᵀ M V = 1, so y = Vᵀ M q.
    let to_dynamic = |q: &[f64; 4]| -> Vec<f64> {
        (0..4)
            .map(|k| {
                let (mut unit, mut column) = ([0.0; 4], [0.0; 4]);
                unit[k] = 1.0;
                flexible.original_coordinates(&unit, &mut column);
                let weighted = |i: usize| -> f64 { (0..4).map(|j| body.mass[(i, j)] * q[j]).sum() };
                (0..4).map(|i| column[i] * weighted(i)).sum()
            })
            .collect()
    };
    let mechanism = SliderCrank {
        crank: CRANK,
        speed: SPEED,
        slider: SLIDER,
        rod: flexible.clone(),
        dimension: Dimension::Planar,
        rod_axes: 0.0,
    };
    let start = RodStart {
        y: to_dynamic(&START),
        rates: to_dynamic(&RATES),
        spin: SPIN,
    };
    (mechanism.start(&start, rule), flexible)
}

/// What the set publishes, now.
pub fn answer(simulation: &Simulation, rod: &FlexibleBody) -> Answer {
    let mut q = [0.0; 4];
    rod.original_coordinates(rod_coordinates(simulation), &mut q);
    let forces = &simulation.state().forces;
    // Rows: bearing 2, pin a 2, pin b 2 (on the slider), guide 2, motor.
    Answer {
        positions: [
            rod_angle(simulation),
            slider_position(simulation),
            q[0],
            q[1],
            q[2],
            q[3],
        ],
        forces: [forces[5], -forces[4], -forces[8]],
    }
}

/// At t = 0.1 by the runtime.
pub fn simulated(axial: f64, rule: impl Into<Rule>, steps: usize) -> Answer {
    let (mut simulation, rod) = simulation(axial, rule);
    run(&mut simulation, 0.1, steps, |_| {});
    answer(&simulation, &rod)
}

/// The same by accuracy, and how many steps that took.
pub fn simulated_in_steps(axial: f64, accuracy: Accuracy) -> (Answer, usize) {
    let (mut simulation, rod) = simulation(axial, accuracy);
    run(&mut simulation, 0.1, 1, |_| {});
    (answer(&simulation, &rod), simulation.effort().0)
}

/// Relative errors, entry by entry.
pub fn relative(found: &[f64], expected: &[f64]) -> Vec<f64> {
    let pairs = found.iter().zip(expected);
    pairs.map(|(a, b)| (a / b - 1.0).abs()).collect()
}

/// Deflection of the middle by the length, and place of the slider, every millisecond up to 0.1 s from an undeformed start, by the
/// set's shapes with the consistent mass.
pub fn sine_samples() -> Vec<[f64; 2]> {
    let mechanism = classical_mechanism(1.0 / 15.0);
    let mut motion = mechanism.start(&[0.0; 4], &[0.0; 4], -0.5 * SPEED);
    let sample = |_| {
        mechanism.advance(&mut motion, 2e-5, 50);
        let place = mechanism.slider_position(&motion);
        [motion.position[3] / LENGTH, place]
    };
    (0..100).map(sample).collect()
}

/// The set's rod in finite elements against these samples: largest difference of the deflection by its largest value, of the
/// slider's place by the length.
pub fn element_errors(expected: &[[f64; 2]], elements: usize, modes: usize) -> [f64; 2] {
    let benchmark = Benchmark {
        crank: CRANK,
        speed: SPEED,
        section: RodSection {
            length: LENGTH,
            area: SIDE * SIDE,
            second_moment: SIDE.powi(4) / 12.0,
            youngs_modulus: MODULUS,
            density: DENSITY,
            angle: 0.0,
        },
    };
    let peak = expected.iter().map(|x| x[0].abs()).fold(0.0, f64::max);
    let rod = ReducedRod::new(benchmark, elements, modes);
    let started = rod.mechanism();
    let mut simulation = started.start(&started.rigid_start(), method(0.9));
    let mut worst = [0.0_f64; 2];
    for [deflection, slider] in expected {
        run(&mut simulation, 0.1 / expected.len() as f64, 100, |_| {});
        let found = rod.deflection(rod_coordinates(&simulation));
        worst[0] = worst[0].max((found - deflection).abs() / peak);
        worst[1] = worst[1].max((slider_position(&simulation) - slider).abs() / LENGTH);
    }
    worst
}
