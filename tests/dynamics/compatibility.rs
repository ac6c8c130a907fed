//! The three choices of compatibility on the slider-crank of the literature: a steel rod of four beam elements, driven through two
//! revolutions, against the unreduced rod of an independent program.

use crate::support;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use dcb_formats::TimeFunction;
use dcb_formats::component::Units;
use dcb_formats::function::Function;
use dcb_formats::mesh::{Dimension, Direction};
use dcb_formats::scene::RedundantConstraints;
use dcb_formats::scene::Scheme;
use dcb_reducer::{Reduced, Reduction, reduce};
use dcb_runtime::body::{RigidBody, RigidPoint};
use dcb_runtime::integrator::{Formulation, Method, Tolerance};
use dcb_runtime::joint::{JointKind, Prismatic, Revolute};
use dcb_runtime::measure::Measure;
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, JointCoordinate, SystemBuilder, Turning};
use dcb_runtime::system::{Signal, State, System};
use dcb_runtime::watch::compatibility_window::WeakWindow;
use dcb_runtime::{Compatibility, Error, FlexibleBody};
use dcb_samples::{RodSection, planar_rod};
use faer::{Mat, Side};
use nalgebra::{Matrix3, Vector3};

const CRANK: f64 = 0.15;
const ROD: f64 = 0.3;
const SPEED: f64 = 150.0;
const SLIDER_MASS: f64 = 0.033378;

fn rod(modes: usize) -> Reduced {
    let component = planar_rod(4, &RodSection::default());
    reduce(&component, &Reduction::lowest(modes), &mut ()).unwrap()
}

fn rigid(name: &str, mass: f64, points: &[(&str, f64)]) -> Arc<FlexibleBody> {
    let points = points.iter().map(|(name, x)| RigidPoint {
        name: (*name).into(),
        position: Vector3::new(*x, 0.0, 0.0),
        axes: Matrix3::identity(),
    });
    let body = RigidBody {
        name: name.into(),
        units: Units {
            length: "m".into(),
            mass: "kg".into(),
            time: "s".into(),
        },
        dimension: Dimension::Planar,
        mass,
        tensor: Matrix3::identity() * 1e-4,
        center: Vector3::zeros(),
        points: points.collect(),
    };
    Arc::new(FlexibleBody::rigid(&body).unwrap())
}

fn pin() -> JointKind {
    JointKind::Revolute(Revolute {
        axis: Vector3::z(),
        axis_b: None,
    })
}

struct SliderCrank {
    reduced: Reduced,
    system: System,
    state: State,
    rod: usize,
    ends: [usize; 2],
}

impl SliderCrank {
    fn new(modes: usize, compatibility: Compatibility) -> Self {
        let reduced = rod(modes);
        let body = FlexibleBody::from_superelement(&reduced.superelement, compatibility).unwrap();
        let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::zeros());
        let spin = |rate: f64| Vector3::new(0.0, 0.0, rate);
        let tip_velocity = Vector3::new(0.0, SPEED * CRANK, 0.0);
        let crank = builder.body(
            "crank",
            rigid("crank", 1.0, &[("pivot", 0.0), ("tip", CRANK)]),
            &Drawn {
                angular_velocity: spin(SPEED),
                ..Drawn::default()
            },
        );
        let rod = builder.body(
            "rod",
            Arc::new(body),
            &Drawn {
                position: Vector3::new(CRANK, 0.0, 0.0),
                velocity: tip_velocity,
                angular_velocity: spin(-SPEED * CRANK / ROD),
                ..Drawn::default()
            },
        );
        let slider = builder.body(
            "slider",
            rigid("slider", SLIDER_MASS, &[("pin", 0.0)]),
            &Drawn {
                position: Vector3::new(CRANK + ROD, 0.0, 0.0),
                ..Drawn::default()
            },
        );
        let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
        let mut marker = |body, interface| builder.marker(body, interface, Turning::Body).unwrap();
        let (pivot, tip) = (marker(crank, 0), marker(crank, 1));
        let ends = [marker(rod, 0), marker(rod, 1)];
        let piston = marker(slider, 0);
        let main = builder.joint("main", ground, pivot, &pin()).unwrap();
        builder.joint("crank pin", tip, ends[0], &pin()).unwrap();
        builder
            .joint("piston pin", ends[1], piston, &pin())
            .unwrap();
        let guide = JointKind::Prismatic(Prismatic { axis: Vector3::x() });
        builder.joint("guide", ground, piston, &guide).unwrap();
        let turning = Function::Polynomial(vec![0.0, SPEED]);
        let signal = builder.signal(Signal {
            function: TimeFunction::new(&turning).unwrap(),
            input: None,
            offset: 0.0,
        });
        let angle: Measure = main.coordinate(JointCoordinate::Rotation).unwrap();
        builder.drive("motor", &main, angle, signal);
        let (system, state) = builder.finish();
        Self {
            reduced,
            system,
            state,
            rod,
            ends,
        }
    }

    fn start(&self, radius: f64) -> Simulation {
        let method = method(radius);
        let (system, state) = (self.system.clone(), self.state.clone());
        let (simulation, report) =
            Simulation::start(system, state, method, RedundantConstraints::MinimumNorm).unwrap();
        assert!(report.redundant.is_empty(), "{report:?}");
        simulation
    }

    /// d = (v_mid - (v_A + v_B)/2)/L in the rod's frame.
    fn deflection(&self, simulation: &mut Simulation) -> f64 {
        simulation.refresh();
        let rod = &self.system.bodies[self.rod];
        let y = &simulation.state().coordinates[rod.coordinates.clone()];
        let own = rod.flexible.displacement_count();
        let recovery = &self.reduced.recovery;
        let n_k = recovery.modes.ncols();
        let component = planar_rod(4, &RodSection::default());
        let middle = component.dofs.row(2, Direction::Uy).unwrap();
        let modal: f64 = (0..n_k).map(|k| recovery.modes[(middle, k)] * y[k]).sum();
        // Amplitudes of G_res L_bᵀ: T ζ, or the interface forces themselves.
        let attached = match rod.flexible.compatibility {
            Compatibility::Strong => {
                support::product(&rod.flexible.attachment_transform, &y[n_k..own])
            }
            Compatibility::Static => simulation.interface_forces(self.rod),
            Compatibility::Weak => y[own..].to_vec(),
        };
        let residual: f64 = attached
            .iter()
            .enumerate()
            .map(|(k, g)| recovery.residual[(middle, k)] * g)
            .sum();
        let evaluation = simulation.refresh();
        let ends = self.ends.map(|marker| evaluation.places[marker].arm.y);
        (modal + residual - 0.5 * (ends[0] + ends[1])) / ROD
    }

    /// Deflections over two revolutions, `samples` of them at equal crank angles, first the start.
    fn history(&self, radius: f64, steps: usize, samples: usize) -> Result<Vec<f64>, Error> {
        let mut simulation = self.start(radius);
        let step = TAU / SPEED / steps as f64;
        let every = 2 * steps / samples;
        let mut found = vec![self.deflection(&mut simulation)];
        for at in 1..=2 * steps {
            simulation.step(step)?;
            if at % every == 0 {
                found.push(self.deflection(&mut simulation));
            }
        }
        Ok(found)
    }
}

fn method(radius: f64) -> Method {
    Method {
        scheme: Scheme::generalized_alpha(radius),
        formulation: Formulation::Index3,
        tolerance: Tolerance {
            relative: 1e-7,
            max_iterations: 100,
        },
    }
}

fn reference() -> Vec<f64> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/data/reference/ref_planar.json"
    );
    let text = std::fs::read_to_string(path).unwrap();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let history = value["deflection"]["4"]["defl"].as_array().unwrap();
    history.iter().map(|d| d.as_f64().unwrap()).collect()
}

/// Largest difference over the largest value.
fn difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
    let pairs = found.iter().zip(expected);
    pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) / largest
}

#[test]
fn strong_and_static_follow_the_unreduced_rod() {
    let expected = reference();
    for (modes, compatibility, allowed) in [
        (5, Compatibility::Strong, 2e-3),
        (8, Compatibility::Strong, 2e-3),
        (5, Compatibility::Static, 2e-3),
        (8, Compatibility::Static, 2e-3),
    ] {
        let crank = SliderCrank::new(modes, compatibility);
        let error = difference(&crank.history(0.8, 3600, 72).unwrap(), &expected);
        println!("{compatibility:?}, {modes} modes: {error:.2e}");
        assert!(
            error < allowed,
            "{compatibility:?}, {modes} modes: {error:.2e}"
        );
    }
}

#[test]
fn all_modes_make_strong_and_static_the_same() {
    let of = |compatibility| {
        let crank = SliderCrank::new(12, compatibility);
        crank.history(0.8, 3600, 72).unwrap()
    };
    let (strong, static_) = (of(Compatibility::Strong), of(Compatibility::Static));
    let apart = difference(&static_, &strong);
    let error = difference(&strong, &reference());
    println!("all modes: apart {apart:.2e}, error {error:.2e}");
    assert!(apart < 1e-9, "{apart:.2e}");
    assert!(error < 2e-3, "{error:.2e}");
}

#[test]
fn weak_survives_long_steps_only() {
    // At such steps the unreduced rod's start rings in the integrator; the static twin starts as the weak form does.
    let of = |modes, compatibility, steps| {
        let crank = SliderCrank::new(modes, compatibility);
        crank.history(0.8, steps, 2 * steps).unwrap()
    };
    for (modes, steps, allowed) in [(5, 50, 2e-2), (8, 50, 6e-3), (5, 72, 1e-2)] {
        let found = of(modes, Compatibility::Weak, steps);
        let error = difference(&found, &of(12, Compatibility::Strong, steps));
        let apart = difference(&found, &of(modes, Compatibility::Static, steps));
        println!("weak, {modes} modes, {steps} steps: {error:.2e}, from static {apart:.2e}");
        assert!(error < allowed, "{modes} modes: {error:.2e}");
        assert!(apart < 1e-4, "{modes} modes: {apart:.2e}");
    }

    let weak = SliderCrank::new(5, Compatibility::Weak);
    for steps in [1000.0, 4000.0] {
        let mut simulation = weak.start(0.8);
        let fails = |_: &usize| match simulation.step(TAU / SPEED / steps) {
            Ok(_) => weak.deflection(&mut simulation).abs() > 1.0,
            Err(_) => true,
        };
        let diverged = (1..=100).find(fails);
        println!("weak, {steps} steps: {diverged:?}");
        assert!(diverged.is_some(), "{steps} steps");
    }
}

#[test]
fn window_of_weak_compatibility() {
    let weak = SliderCrank::new(5, Compatibility::Weak);
    let window = WeakWindow::of(&weak.system, &weak.state, &Scheme::generalized_alpha(0.8));
    assert_eq!(window.bodies.len(), 1);
    let body = &window.bodies[0];
    println!("{window:?}");
    assert_eq!(body.negative_eigenvalue_count, 4);
    assert_eq!(window.negative_eigenvalue_count, 4);
    assert!((body.sigma_min / 53638.0 - 1.0).abs() < 1e-4, "{body:?}");
    // z = 2 √3 (1 + ρ)/(1 - ρ)
    let limit = 2.0 * 3.0_f64.sqrt() * 1.8 / 0.2;
    assert!((body.smallest_step * body.sigma_min / limit - 1.0).abs() < 1e-12);
    window.check(TAU / SPEED / 50.0).unwrap();
    let refused = window.check(TAU / SPEED / 1000.0).unwrap_err();
    assert!(matches!(refused, Error::WeakUnstable { .. }), "{refused}");
    // Never damped without numerical damping; nothing grows with all modes.
    let undamped = WeakWindow::of(&weak.system, &weak.state, &Scheme::generalized_alpha(1.0));
    assert!(undamped.check(1e3).is_err());
    let all = SliderCrank::new(12, Compatibility::Weak);
    let window = WeakWindow::of(&all.system, &all.state, &Scheme::generalized_alpha(0.8));
    assert_eq!(window.negative_eigenvalue_count, 0);
    window.check(1e-9).unwrap();
}

/// The resultant of the forces on the rod's pins is what its momentum changes by, whatever the compatibility; a restored run goes on alike; and the
/// motor's work is in the energy.
#[test]
fn interface_forces_energy_and_restoring() {
    for (compatibility, formulation) in [
        (Compatibility::Strong, Formulation::Index3),
        (Compatibility::Static, Formulation::Index3),
        (Compatibility::Static, Formulation::StabilizedIndex2),
    ] {
        let crank = SliderCrank::new(5, compatibility);
        let mut method = method(0.8);
        method.formulation = formulation;
        let (system, state) = (crank.system.clone(), crank.state.clone());
        let (mut simulation, _) =
            Simulation::start(system, state, method, RedundantConstraints::MinimumNorm).unwrap();
        let step = TAU / SPEED / 3600.0;
        let mut peak: f64 = 0.0;
        for _ in 0..1800 {
            simulation.step(step).unwrap();
            simulation.refresh();
            let (energy, _, defect) = simulation.energy();
            peak = peak.max(defect.abs() / energy.kinetic);
        }
        println!("{compatibility:?} {formulation:?}: energy defect {peak:.2e}");
        assert!(peak < 1e-4, "{compatibility:?} {formulation:?}: {peak:.2e}");

        simulation.refresh();
        let g = simulation.interface_forces(crank.rod);
        let rod = &crank.system.bodies[crank.rod];
        let pose = simulation.state().pose(crank.rod);
        let first = rod.velocities.start;
        let acceleration =
            Vector3::from_column_slice(&simulation.state().accelerations[first..first + 3]);
        let force = pose.axes * Vector3::new(g[0] + g[2], g[1] + g[3], 0.0);
        let left = force - acceleration * rod.flexible.inertia.mass();
        assert!(left.norm() < 1e-6 * force.norm(), "{left} {force}");

        let snapshot = simulation.save();
        for _ in 0..10 {
            simulation.step(step).unwrap();
        }
        let end = simulation.state().clone();
        simulation.restore(&snapshot).unwrap();
        for _ in 0..10 {
            simulation.step(step).unwrap();
        }
        assert_eq!(&end, simulation.state());
        let flexibility = rod.flexible.residual_flexibility.as_ref();
        if let Some(flexibility) = flexibility {
            simulation.refresh();
            let g = simulation.interface_forces(crank.rod);
            let expected = support::product(flexibility, &g);
            let size = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for (x, expected) in end.residual_displacements.iter().zip(&expected) {
                assert!((x - expected).abs() < 1e-6 * size, "{x} {expected}");
            }
        }
    }
}

/// Two rods in line, pinned together: the pencil of the linear equations in modes, rigid ones among them, and joint forces.
#[test]
fn negative_eigenvalues_are_the_rank_of_the_flexibility() {
    for modes in [0, 2, 5] {
        let reduced = rod(modes);
        let part = &reduced.superelement;
        let inertia = &part.inertia;
        let (mass, moment) = (inertia.mass, inertia.tensor[2][2]);
        // Rows ux, uy of the end at the pin, relative to the centre of mass.
        let side = |end: usize, sign: f64| {
            let arm = part.rows[2 * end].position[0];
            Mat::from_fn(2, 3 + modes, |i, k| {
                sign * match (k, i) {
                    (0, 0) | (1, 1) => 1.0 / mass.sqrt(),
                    (2, 1) => arm / moment.sqrt(),
                    (0..3, _) => 0.0,
                    _ => part.modes.interface_shapes[(2 * end + i, k - 3)],
                }
            })
        };
        let sides = [side(1, 1.0), side(0, -1.0)];
        let residual = &part.residual;
        let at_pin =
            |matrix: &Mat<f64>| Mat::from_fn(2, 2, |i, j| matrix[(2 + i, 2 + j)] + matrix[(i, j)]);
        let (f, m) = (at_pin(&residual.flexibility), at_pin(&residual.mass));
        let own = 3 + modes;
        let square = |k: usize| match k % own {
            0..3 => 0.0,
            k => part.modes.eigenvalues[k - 3],
        };
        // The joint forces' mass is diagonal here: pulling and bending don't couple in a straight rod.
        assert!(m[(0, 1)].abs() < 1e-12 * m[(0, 0)]);
        let n = 2 * own + 2;
        let unit = |k: usize| {
            if k < 2 * own {
                1.0
            } else {
                m[(k - 2 * own, k - 2 * own)].sqrt()
            }
        };
        let pencil = Mat::from_fn(n, n, |i, j| {
            let entry = match (i < 2 * own, j < 2 * own) {
                (true, true) if i == j => square(i),
                (true, true) => 0.0,
                (true, false) => -sides[i / own][(j - 2 * own, i % own)],
                (false, true) => -sides[j / own][(i - 2 * own, j % own)],
                (false, false) => -f[(i - 2 * own, j - 2 * own)],
            };
            entry / (unit(i) * unit(j))
        });
        let eigen = pencil.self_adjoint_eigen(Side::Lower).unwrap();
        let values: Vec<f64> = eigen.S().column_vector().iter().copied().collect();
        let largest = values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let negative: Vec<f64> = values
            .into_iter()
            .filter(|v| *v < -1e-9 * largest)
            .collect();

        let body = FlexibleBody::from_superelement(part, Compatibility::Weak).unwrap();
        let body = Arc::new(body);
        let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::zeros());
        let mut add = |name: &str, x: f64, end: usize| {
            let position = Vector3::new(x, 0.0, 0.0);
            let drawn = Drawn {
                position,
                ..Drawn::default()
            };
            let rod = builder.body(name, body.clone(), &drawn);
            builder.marker(rod, end, Turning::Body).unwrap()
        };
        let (first, second) = (add("first", 0.0, 1), add("second", ROD, 0));
        builder.joint("pin", first, second, &pin()).unwrap();
        let (system, state) = builder.finish();
        let window = WeakWindow::of(&system, &state, &Scheme::generalized_alpha(0.8));
        println!("{modes} modes: {negative:?} {window:?}");
        assert_eq!(negative.len(), window.negative_eigenvalue_count);
        assert_eq!(negative.len(), 2);
        for body in &window.bodies {
            assert!(negative.iter().all(|v| (-v).sqrt() >= body.sigma_min));
        }
    }
}

/// A rod between two pins sags under its weight: no rigid motion can make room for the stretch that interface forces would make,
/// no constraint is redundant, and the pins carry the weight.
#[test]
fn rod_between_two_pins() {
    let reduced = rod(5);
    let body = FlexibleBody::from_superelement(&reduced.superelement, Compatibility::Static);
    let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::new(0.0, -9.81, 0.0));
    let rod = builder.body("rod", Arc::new(body.unwrap()), &Drawn::default());
    for (end, x) in [(0, 0.0), (1, ROD)] {
        let support = builder.ground(Vector3::new(x, 0.0, 0.0), Matrix3::identity());
        let marker = builder.marker(rod, end, Turning::Body).unwrap();
        let name = format!("pin {end}");
        builder.joint(&name, support, marker, &pin()).unwrap();
    }
    let (system, state) = builder.finish();
    let (mut simulation, report) =
        Simulation::start(system, state, method(0.8), RedundantConstraints::Refuse).unwrap();
    assert!(report.redundant.is_empty());
    let weight = 9.81 * reduced.superelement.inertia.mass;
    let period = TAU / (PI * PI / (ROD * ROD) * bending_speed());
    let steps = 400;
    let mut sum = 0.0;
    for _ in 0..10 * steps {
        simulation.step(period / f64::from(steps)).unwrap();
        simulation.refresh();
        let g = simulation.interface_forces(rod);
        sum += 0.5 * (g[1] + g[3]) / f64::from(10 * steps);
        // Pulling forces are equal and opposite, and gravity doesn't stretch the rod.
        assert!(
            g[0].abs() < 1e-6 * weight && g[2].abs() < 1e-6 * weight,
            "{g:?}"
        );
    }
    // The supports carry the weight over whole periods of the swinging; the rest is the higher modes'.
    assert!((sum / (0.5 * weight) - 1.0).abs() < 0.02, "{sum} {weight}");
}

/// √(E I / (ρ A)) of the rod.
fn bending_speed() -> f64 {
    let rod = RodSection::default();
    (rod.youngs_modulus * rod.second_moment / (rod.density * rod.area)).sqrt()
}
