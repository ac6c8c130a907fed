//! Newton's and Euler's laws for every body by itself, from what is recorded and nothing else.

use std::collections::BTreeMap;

use dcb_formats::TimeFunction;
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::{AtPlace, Attachment, BodyKind, Joint, Load, Output, Scene};
use dcb_runtime::Mechanism;
use dcb_runtime::momentum::Momentum;
use nalgebra::Vector3;

/// Force, and moment about the world's origin.
#[derive(Clone, Copy, Default)]
struct Wrench {
    force: Vector3<f64>,
    moment: Vector3<f64>,
}

impl Wrench {
    fn at(point: Vector3<f64>, force: Vector3<f64>, moment: Vector3<f64>) -> Self {
        Self {
            force,
            moment: moment + point.cross(&force),
        }
    }

    fn add(&mut self, other: &Self, factor: f64) {
        self.force += other.force * factor;
        self.moment += other.moment * factor;
    }
}

/// Records where every joint and load acts, as `at NAME`.
pub fn watch_places(scene: &mut Scene) {
    let joints = scene
        .joints
        .iter()
        .filter_map(|(name, joint)| Some((name.clone(), joint.attachments()?[0].to_owned())));
    let loads = scene.loads.iter().map(|(name, load)| {
        let Load::Force(load) = load else {
            panic!("only forces here")
        };
        (name.clone(), load.at.clone())
    });
    let places: Vec<_> = joints.chain(loads).collect();
    for (name, at) in places {
        let output = Output::Position(AtPlace { at });
        scene.outputs.insert(format!("at {name}"), output);
    }
}

fn in_space(values: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|i, _| values.get(i).copied().unwrap_or(0.0))
}

fn wrench_in_space(values: &[f64], dimension: Dimension) -> (Vector3<f64>, Vector3<f64>) {
    match dimension {
        Dimension::Planar => (in_space(&values[..2]), Vector3::new(0.0, 0.0, values[2])),
        Dimension::Spatial => (in_space(&values[..3]), in_space(&values[3..])),
    }
}

/// What the joints and loads do to each body, by its name; `ground` is one of them.
fn wrenches(scene: &Scene, mechanism: &mut Mechanism) -> BTreeMap<String, Wrench> {
    let mut all: BTreeMap<String, Wrench> = BTreeMap::new();
    let mut add = |place: &str, wrench: &Wrench, factor: f64| {
        let body = Attachment::parse(place).unwrap().body().unwrap_or("ground");
        all.entry(body.to_owned()).or_default().add(wrench, factor);
    };
    for (name, joint) in &scene.joints {
        let reaction = mechanism.output(&format!("reactions/{name}")).unwrap();
        let (force, moment) = wrench_in_space(reaction, scene.dimension);
        let pair = |joint: &str| scene.joints[joint].attachments().unwrap();
        match joint {
            Joint::Gear(gear) => {
                // The first joint turns about the world's z, the second about nearly the same. The power of the whole is zero.
                let turning = Wrench::at(Vector3::zeros(), force, moment);
                let [a, b] = pair(&gear.second);
                add(a, &turning, 1.0);
                add(b, &turning, -1.0);
                let moment = Vector3::z() * (gear.ratio * moment.norm().copysign(moment.z));
                let turning = Wrench::at(Vector3::zeros(), Vector3::zeros(), moment);
                let [a, b] = pair(&gear.first);
                add(a, &turning, -1.0);
                add(b, &turning, 1.0);
            }
            Joint::Rack(rack) => {
                let point = in_space(
                    mechanism
                        .output(&format!("at {}", rack.translation))
                        .unwrap(),
                );
                let pushing = Wrench::at(point, force, moment);
                let [a, b] = pair(&rack.translation);
                add(a, &pushing, 1.0);
                add(b, &pushing, -1.0);
                // The rack runs nearly along the world's x and the wheel turns about z in these scenes.
                let moment = Vector3::z() * (rack.radius * force.norm().copysign(force.x));
                let turning = Wrench::at(Vector3::zeros(), Vector3::zeros(), moment);
                let [a, b] = pair(&rack.rotation);
                add(a, &turning, -1.0);
                add(b, &turning, 1.0);
            }
            _ => {
                let point = in_space(mechanism.output(&format!("at {name}")).unwrap());
                let wrench = Wrench::at(point, force, moment);
                let [a, b] = joint.attachments().unwrap();
                add(a, &wrench, 1.0);
                add(b, &wrench, -1.0);
            }
        }
    }
    let time = mechanism.time();
    for (name, load) in &scene.loads {
        let Load::Force(load) = load else {
            panic!("only forces here")
        };
        let point = in_space(mechanism.output(&format!("at {name}")).unwrap());
        let value = |function| {
            TimeFunction::new(function)
                .unwrap()
                .evaluate(time, 0.0)
                .value
        };
        let force: Vec<f64> = load.components.iter().map(value).collect();
        let wrench = Wrench::at(point, in_space(&force), Vector3::zeros());
        add(&load.at, &wrench, 1.0);
    }
    all
}

/// Asserts `m a = Σ F` for every body and Euler's equation for every rigid one, to the accuracy of the iteration.
pub fn assert_newton(scene: &Scene, mechanism: &mut Mechanism, what: &str) {
    let acting = wrenches(scene, mechanism);
    let (system, state) = (
        mechanism.simulation().system(),
        mechanism.simulation().state(),
    );
    let mut largest = 1.0_f64;
    for wrench in acting.values() {
        largest = largest.max(wrench.force.norm());
    }
    for (index, body) in system.bodies.iter().enumerate() {
        let acceleration = in_space(&state.accelerations[body.velocities.clone()][..3]);
        let mass = body.flexible.inertia.mass();
        let own = acting.get(&body.name).copied().unwrap_or_default();
        let missing = own.force + (scene.gravity_in_space() - acceleration) * mass;
        assert!(
            missing.norm() < 1e-7 * largest,
            "{what}: forces on {:?} don't add up, {missing:?} of {largest:.1e} is missing",
            body.name
        );
        let BodyKind::Rigid(rigid) = &scene.bodies[&body.name].kind else {
            continue;
        };
        let turn = state.orientations[index];
        let spin = in_space(&state.velocities[body.velocities.clone()][3..6]);
        let spin_rate = in_space(&state.accelerations[body.velocities.clone()][3..6]);
        let tensor = rigid.inertia.matrix();
        let rate = turn * (tensor * spin_rate + spin.cross(&(tensor * spin)));
        let about_center = own.moment - state.origins[index].cross(&own.force);
        let mut missing = about_center - rate;
        if scene.dimension == Dimension::Planar {
            missing = Vector3::new(0.0, 0.0, missing.z);
        }
        assert!(
            missing.norm() < 1e-7 * largest,
            "{what}: moments on {:?} don't add up, {missing:?} is missing",
            body.name
        );
    }
}

/// Asserts the balance of moments of the whole scene, flexible bodies included, about the world's origin over one more step: the
/// change of the angular momentum is the impulse of gravity, of the loads and of the ground, by the trapezoidal rule.
pub fn assert_angular_impulse(scene: &Scene, mechanism: &mut Mechanism, step: f64, what: &str) {
    let outside = |mechanism: &mut Mechanism| {
        let mut sum = Wrench::default();
        for wrench in wrenches(scene, mechanism).values() {
            sum.add(wrench, 1.0);
        }
        // Action is reaction: all but the ground's share of the joints has cancelled, so take that away.
        let ground = wrenches(scene, mechanism)
            .get("ground")
            .copied()
            .unwrap_or_default();
        sum.add(&ground, -1.0);
        let simulation = mechanism.simulation();
        let (system, state) = (simulation.system(), simulation.state());
        for (index, body) in system.bodies.iter().enumerate() {
            let weight = scene.gravity_in_space() * body.flexible.inertia.mass();
            sum.moment += state.origins[index].cross(&weight);
        }
        let mut evaluation = dcb_runtime::system::evaluation::Evaluation::of(system);
        evaluation.refresh(system, state);
        (
            sum.moment,
            Momentum::of_all(system, state, &evaluation).angular,
        )
    };
    let (before, first) = outside(mechanism);
    mechanism.step(step).unwrap();
    let (after, second) = outside(mechanism);
    let impulse = (before + after) * (0.5 * step);
    let mut missing = second - first - impulse;
    if scene.dimension == Dimension::Planar {
        missing = Vector3::new(0.0, 0.0, missing.z);
    }
    assert!(
        missing.norm() < 2e-3 * impulse.norm().max(1e-3 * step),
        "{what}: {missing:?} of the angular impulse {impulse:?} is missing"
    );
}
