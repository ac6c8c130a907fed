//! Hard cases of events: drives that jump, pulses between steps, a spin through the first frequency, a mechanism that runs for hours.

use std::f64::consts::PI;

use dcb_formats::function::{Function, Interpolation, Table, TimeFunction};
use dcb_formats::mesh::Dimension;
use dcb_runtime::integrator::Rule;
use dcb_runtime::integrator::adaptive::{AdaptiveStep, StepSize};
use dcb_runtime::integrator::radau::Accuracy;
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, JointCoordinate};
use dcb_runtime::system::{LoadAxes, Signal};
use dcb_runtime::watch::validity::Validity;
use nalgebra::{Matrix3, Vector3};

use crate::assert_says;
use crate::hard::case::{Bounded, HardCase};
use crate::mechanism::closed_form_motions::beam;
use crate::mechanism::{Scene, method, radau, revolute, rigid, run};
use crate::rod::reduced::{Benchmark, ReducedRod};

fn signal(function: TimeFunction) -> Signal {
    Signal {
        function,
        input: None,
        offset: 0.0,
    }
}

/// A rotor of 2 kg m² whose angle is drawn along straight lines: 1 rad/s from 0.5 s on. Its torque 0.7 s later, by that which makes the jump in
/// one step; the step at which it stops, if it does.
fn torque_after_a_jump(rule: impl Into<Rule>) -> Result<f64, usize> {
    let (inertia, step) = (2.0, 1e-2);
    let mut scene = Scene::new(Dimension::Planar, Vector3::zeros());
    let rotor = rigid(
        Dimension::Planar,
        1.0,
        Matrix3::identity() * inertia,
        &[[0.0; 3]],
    );
    let rotor = scene.body(&rotor, &Drawn::default());
    let (ground, hub) = (scene.ground([0.0; 3]), scene.on(rotor, 0));
    let bearing = scene.join(&revolute(Vector3::z()), ground, hub);
    let lines = Function::Table(Table {
        times: vec![0.0, 0.5, 1.5],
        values: vec![0.0, 0.0, 1.0],
        interpolation: Interpolation::Linear,
    });
    let lines = TimeFunction::new(&lines).expect("a table");
    let lines = scene.builder().signal(signal(lines));
    let angle = bearing
        .coordinate(JointCoordinate::Rotation)
        .expect("an angle");
    let motor = scene.builder().drive("motor", &bearing, angle, lines);
    let (mut simulation, _) = scene.start(rule);
    for index in 0..120 {
        if simulation.step(step).is_err() {
            return Err(index + 1);
        }
    }
    let rows = simulation.system().connections[motor].rows.clone();
    Ok(simulation.state().forces[rows.start].abs() * step / inertia)
}

/// A drive of an angle whose speed jumps.
pub fn jump_of_a_drive() -> HardCase {
    let naive = match torque_after_a_jump(method(1.0)) {
        Err(step) => format!("stops at step {step}: the torque's ringing grows"),
        Ok(torque) => {
            assert!(torque > 0.5, "the torque is {torque} of the jump's");
            format!("0.7 s later the torque still is {torque:.1} of that of the jump")
        }
    };
    let torque = torque_after_a_jump(method(0.8)).expect("a run");
    HardCase {
        group: "dynamics",
        name: "jump_of_a_drive",
        naive_method: "the trapezoidal rule (ρ 1) on positions",
        naive,
        ours: "ρ 0.8: the torque 70 steps after the jump, by that of the jump".into(),
        error: Some(Bounded {
            found: torque,
            bound: 2e-2,
        }),
    }
}

/// The same by accuracy: steps end at the jump, and the speed jumps with the drive.
pub fn jump_of_a_drive_by_radau() -> HardCase {
    let mut case = jump_of_a_drive();
    let torque = torque_after_a_jump(radau(1e-6)).expect("a run");
    case.name = "jump_of_a_drive_by_radau";
    case.ours = "radau: the torque 0.7 s after the jump, by that which makes the jump in a hundredth of a second".into();
    case.error = Some(Bounded {
        found: torque,
        bound: 1e-9,
    });
    case
}

/// A free block of 1 kg with a pulse on it at 0.5 s, a bell of half a millisecond.
fn pushed_block(rule: impl Into<Rule>) -> Simulation {
    let mut scene = Scene::new(Dimension::Planar, Vector3::zeros());
    let block = rigid(Dimension::Planar, 1.0, Matrix3::identity(), &[[0.0; 3]]);
    let block = scene.body(&block, &Drawn::default());
    let at = scene.on(block, 0);
    let bell = Function::Formula("400*exp(-((t-0.5)/0.0005)^2)".into());
    let bell = TimeFunction::new(&bell).expect("a formula");
    let bell = scene.builder().signal(signal(bell));
    scene.builder().load(
        "kick",
        at,
        LoadAxes::World,
        [Some(bell), None, None],
        [None; 3],
    );
    scene.start(rule).0
}

/// A velocity by that which the pulse gives, less one.
fn error_of_push(simulation: &Simulation) -> f64 {
    let impulse = 400.0 * 0.0005 * PI.sqrt();
    (simulation.state().velocities[0] / impulse - 1.0).abs()
}

/// What steps over the pulse come to.
fn missed_pulse() -> String {
    let mut coarse = pushed_block(method(0.8));
    run(&mut coarse, 1.0, 501, |_| {});
    let naive = error_of_push(&coarse);
    assert!(naive > 0.2, "{naive}");
    format!("a velocity wrong by {:.0} %", 100.0 * naive)
}

/// A pulse that is shorter than the step.
pub fn impulsive_load() -> HardCase {
    let mut fine = pushed_block(method(0.8));
    let mut size = StepSize::new(AdaptiveStep {
        tolerance: 1e-9,
        first: 1e-4,
        smallest: 1e-9,
        largest: 5e-4,
    });
    fine.advance_to(1.0, &mut size, &mut |_| {})
        .expect("adaptive steps");
    HardCase {
        group: "dynamics",
        name: "impulsive_load",
        naive_method: "equal steps of 2 ms over a pulse of 0.5 ms",
        naive: missed_pulse(),
        ours: "adaptive steps no longer than the pulse; velocity from the impulse, relative".into(),
        error: Some(Bounded {
            found: error_of_push(&fine),
            bound: 1e-3,
        }),
    }
}

/// The same by accuracy, with no step longer than the pulse: the pulse is a formula, whose places nobody tells.
pub fn impulsive_load_by_radau() -> HardCase {
    let mut fine = pushed_block(Accuracy {
        longest: 5e-4,
        ..radau(1e-8)
    });
    run(&mut fine, 1.0, 1, |_| {});
    HardCase {
        group: "dynamics",
        name: "impulsive_load_by_radau",
        naive_method: "equal steps of 2 ms over a pulse of 0.5 ms",
        naive: missed_pulse(),
        ours: "steps no longer than the pulse; velocity from the impulse, relative".into(),
        error: Some(Bounded {
            found: error_of_push(&fine),
            bound: 1e-7,
        }),
    }
}

/// A steel beam that is spun up through its first frequency.
pub fn spin_through_the_first_frequency() -> HardCase {
    let (_, body) = beam(8, 12, 0.0);
    let first = body.stiffness[0].sqrt();
    let mut scene = Scene::new(Dimension::Spatial, Vector3::zeros());
    let bar = scene.body(&body, &Drawn::default());
    let (ground, end) = (scene.ground([0.0; 3]), scene.on(bar, 0));
    let bearing = scene.join(&revolute(Vector3::z()), ground, end);
    // 1.5 of the first frequency after four seconds: slow enough that the spinning up itself bends it little.
    let rising = Function::Polynomial(vec![0.0, 0.0, 0.75 * first / 4.0]);
    let rising = TimeFunction::new(&rising).expect("a polynomial");
    let rising = scene.builder().signal(signal(rising));
    let angle = bearing
        .coordinate(JointCoordinate::Rotation)
        .expect("an angle");
    scene.builder().drive("motor", &bearing, angle, rising);
    let (mut simulation, _) = scene.start(method(0.8));
    let mut validity = Validity::of(simulation.system(), simulation.state());
    let mut told: Vec<(f64, String)> = Vec::new();
    let mut largest: f64 = 0.0;
    let mut stopped = None;
    for _ in 0..20_000 {
        if let Err(error) = simulation.step(2e-4) {
            stopped = Some(error.to_string());
            break;
        }
        let state = simulation.state();
        let checked = validity.check(simulation.system(), state, |message| {
            told.push((state.time, message));
        });
        checked.expect("one drive doesn't contradict another");
        let size = state.coordinates.iter().map(|y| y * y).sum::<f64>();
        largest = largest.max((size / body.inertia.mass()).sqrt());
    }
    println!("{told:?}, {stopped:?}, {largest:e}");
    assert!(largest > 0.1, "the deflection stays at {largest} m");
    let when = |part: &str| {
        let found = told.iter().find(|(_, message)| message.contains(part));
        found.map(|(time, message)| (*time, message.clone()))
    };
    let (softened, message) = when("without geometric stiffening").expect("a warning");
    assert_says(&message, &["0.30 of its first frequency"]);
    assert!((softened - 0.8).abs() < 1e-3, "{softened}");
    let (deflected, _) = when("the theory is linear").expect("a warning");
    assert!(softened < deflected);
    HardCase {
        group: "dynamics",
        name: "spin_through_the_first_frequency",
        naive_method: "the linear floating frame, taken at its word",
        naive: format!("the beam of 1 m deflects by {largest:.1e} m"),
        ours: format!(
            "told at 0.30 of the first frequency, {:.2} s before the deflection leaves the linear theory, which is told too",
            deflected - softened
        ),
        error: None,
    }
}

/// The slider-crank with a flexible rod over many turns: defect of the energy balance by the largest stored energy, the largest deflection
/// of the first two turns and of the last two.
fn turned_for(revolutions: usize, steps: usize) -> (f64, [f64; 2]) {
    let rod = ReducedRod::new(Benchmark::first(), 4, 5);
    let mechanism = rod.mechanism();
    let mut simulation = mechanism.start(&mechanism.rigid_start(), method(0.8));
    let (mut defect, mut stored): (f64, f64) = (0.0, 0.0);
    let mut deflections = [0.0_f64; 2];
    for turn in 0..revolutions {
        run(&mut simulation, rod.revolution(), steps, |simulation| {
            if turn < 2 || turn + 2 >= revolutions {
                let found = rod.deflection_in(simulation).abs();
                let which = usize::from(turn >= 2);
                deflections[which] = deflections[which].max(found);
            }
        });
        simulation.refresh();
        let (energy, _, off) = simulation.energy();
        defect = defect.max(off.abs());
        stored = stored.max(energy.kinetic + energy.strain);
    }
    (defect / stored, deflections)
}

/// Ten thousand turns of the flexible slider-crank, 360 steps each.
pub fn slider_crank_ten_thousand_turns() -> HardCase {
    let (defect, deflections) = turned_for(10_000, 360);
    assert!(deflections[1] < 1.1 * deflections[0], "{deflections:?}");
    let naive = crate::hard::dynamics::naive_constraints::twice_differentiated(
        nalgebra::Vector2::new(0.0, 20.0),
        PI / 3600.0,
        3_600_000,
    );
    assert!(naive.abs() > 1e-6 || naive.is_nan(), "{naive:e}");
    HardCase {
        group: "dynamics",
        name: "slider_crank_ten_thousand_turns",
        naive_method: "constraint differentiated twice, Runge-Kutta of order four, a bob on a rod of 1 m, as many steps",
        naive: format!("the rod is off by {naive:.1e} m"),
        ours: format!(
            "3.6 million steps; largest deflection of the first two turns {:.4}, of the last two {:.4}; defect of the energy balance, relative",
            deflections[0], deflections[1]
        ),
        error: Some(Bounded {
            found: defect,
            bound: 0.5,
        }),
    }
}
