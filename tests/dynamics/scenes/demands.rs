//! What scenes ask of their parts, by their text alone, against what their runs show.

use std::f64::consts::TAU;
use std::path::Path;

use dcb_demand::demand::{
    Band, Deflection, Demand, Involvement, NodeDemand, PartInterface, Parts, PlanesOfMotion,
};
use dcb_runtime::{Mechanism, Scene};
use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};

use super::parts::{Folder, number, rigid_scene, scene_text, started};

/// Interfaces `a` and `b` of the rod (planar) or the beam (spatial), 0.3 apart along x.
fn interfaces(dimension: u32) -> Vec<PartInterface> {
    let directions = match dimension {
        2 => [true, true, false, false, false, true],
        _ => [true; 6],
    };
    [("a", 0.0), ("b", 0.3)]
        .map(|(name, x)| PartInterface {
            name: name.into(),
            position: Vector3::new(x, 0.0, 0.0),
            orientation: Matrix3::identity(),
            directions,
        })
        .into()
}

fn parts(dimension: u32, bodies: &[&str]) -> Parts {
    let one = |name: &&str| ((*name).to_owned(), interfaces(dimension));
    bodies.iter().map(one).collect()
}

fn demand(text: &Value, body: &str) -> Demand {
    let dimension = text["dimension"].as_u64().unwrap() as u32;
    Demand::of(&rigid_scene(text), body, &parts(dimension, &[body])).unwrap()
}

fn slider_crank() -> Scene {
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/slider-crank/scene.json");
    Scene::read(&sample).unwrap()
}

#[test]
fn the_rod_of_a_slider_crank() {
    let scene = slider_crank();
    let demand = Demand::of(&scene, "rod", &parts(2, &["rod"])).unwrap();
    let forces = [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
    ];
    for (interface, joint) in demand.interfaces.iter().zip(["wrist", "pin"]) {
        assert_eq!(interface.wrenches, forces);
        assert_eq!(interface.loaded_by, [format!("joints.{joint}")]);
        assert_eq!(interface.observed_by, ["outputs.midpoint_deflection"]);
    }
    let names: Vec<&str> = demand
        .interfaces
        .iter()
        .map(|one| one.name.as_str())
        .collect();
    assert_eq!(names, ["a", "b"]);
    let nodes = [(2, vec!["outputs.midpoint_deflection".to_owned()])];
    assert_eq!(demand.nodes, NodeDemand::Some(nodes.into()));
    assert_eq!(demand.involvement, Involvement::Involved);
    assert_eq!(demand.deflection, Deflection::Dynamic);
    assert!(!demand.gravity && demand.part_loads.is_empty());
    // No drive determines how the rod turns, and the crank's 150 is the largest rate around.
    assert_eq!((demand.spin.rate, demand.spin.known), (150.0, false));
    let step = scene.integrator.unwrap().step;
    let steps = 1.0 / (demand.band.frequency.unwrap() * step);
    assert!((steps - 18.635).abs() < 1e-3, "{steps}");
    assert!(
        demand
            .band
            .reasons
            .iter()
            .any(|reason| reason.contains("joints.pin"))
    );

    let told = demand.to_string();
    assert!(
        told.contains("\"a\" takes fx fy from joints.wrist"),
        "{told}"
    );
    assert!(
        told.contains("node         2 for outputs.midpoint_deflection"),
        "{told}"
    );
    let as_json = serde_json::to_value(&demand).unwrap();
    assert_eq!(as_json["interfaces"][1]["name"], json!("b"));
    assert_eq!(
        as_json["nodes"]["some"]["2"],
        json!(["outputs.midpoint_deflection"])
    );
}

#[test]
fn what_is_not_in_the_scene_is_refused_by_name() {
    let scene = slider_crank();
    let told = |body: &str, parts: &Parts| Demand::of(&scene, body, parts).unwrap_err().to_string();
    assert!(told("crank", &parts(2, &["rod"])).contains("bodies.crank: is rigid"));
    assert!(told("rods", &parts(2, &["rod"])).contains("did you mean `rod`"));
    assert!(told("rod", &Parts::new()).contains("has no interfaces that are known"));
    let mut short = parts(2, &["rod"]);
    short["rod"].pop();
    let found = told("rod", &short);
    assert!(
        found.contains("joints.pin.revolute.a") && found.contains("\"b\""),
        "{found}"
    );
}

/// A spatial scene with the beam clamped at `a`.
fn clamped(rest: Value) -> Value {
    let mut text = scene_text(
        3,
        json!({
            "bodies": {"beam": {"superelement": "beam.dcb.h5"}},
            "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
        }),
    );
    for (key, value) in rest.as_object().unwrap() {
        text[key] = value.clone();
    }
    text
}

#[test]
fn a_part_that_is_fixed_everywhere_is_locked_until_somebody_looks() {
    let involvement = |rest: Value| demand(&clamped(rest), "beam").involvement;
    assert_eq!(involvement(json!({})), Involvement::Locked);
    assert_eq!(involvement(json!({"joints": {}})), Involvement::Unused);
    let looking = [
        json!({"outputs": {"tip": {"position": {"at": "beam/b"}}}}),
        json!({"outputs": {"modes": {"modal": {"body": "beam"}}}}),
        json!({"outputs": {"node": {"node_position": {"body": "beam", "node": 1}}}}),
        json!({"outputs": {"turn": {"body_orientation": {"body": "beam"}}}}),
        json!({"outputs": {"all": {"momentum": {}}}}),
        json!({"fields": [{"body": "beam", "times": [1], "directory": "fields"}]}),
        json!({"loads": {"push": {"force": {"at": "beam/b", "components": [1, 0, 0]}}}}),
        json!({"loads": {"hum": {"part_load": {"body": "beam", "load": "hum", "factor": 1}}}}),
        json!({"joints": {"hinge": {"revolute": {"a": "ground", "b": "beam/a", "axis": [0, 0, 1]}}}}),
    ];
    for rest in looking {
        assert_eq!(involvement(rest.clone()), Involvement::Involved, "{rest}");
    }
}

#[test]
fn what_looks_at_a_part_is_listed() {
    let text = clamped(json!({
        "gravity": [0, 0, -9.81],
        "outputs": {
            "tip": {"displacement": {"at": "beam/b"}},
            "turn": {"joint_coordinate": {"joint": "hinge"}},
            "side": {"reaction": {"joint": "ball", "axes": "second"}},
            "modes": {"modal": {"body": "beam"}},
            "frame": {"body_position": {"body": "beam"}},
            "block": {"angular_momentum": {"body": "block"}},
            "all": {"center_of_mass": {}},
            "one": {"node_position": {"body": "beam", "node": 3}},
            "same": {"node_acceleration": {"body": "beam", "node": 3}}
        },
        "bodies": {
            "beam": {"superelement": "beam.dcb.h5", "inertia_change": "constant"},
            "block": {"rigid": {"mass": 1, "inertia": [1, 1, 1], "points": {"pin": [0, 0, 0]}}, "position": [0.3, 0, 0]}
        },
        "joints": {
            "hinge": {"revolute": {"a": "ground", "b": "beam/a", "axis": [0, 0, 1]}},
            "ball": {"spherical": {"a": "block/pin", "b": "beam/b"}}
        },
        "loads": {
            "hum": {"part_load": {"body": "beam", "load": "hum", "factor": {"polynomial": [0, 1]}}},
            "off": {"part_load": {"body": "beam", "load": "other", "factor": 0}},
            "gust": {"force": {"at": "beam/b", "axes": "follower", "components": [0, {"polynomial": [0, 1]}, 0]}}
        }
    }));
    let found = demand(&text, "beam");
    assert_eq!(found.interfaces[0].observed_by, ["outputs.turn"]);
    assert_eq!(
        found.interfaces[1].observed_by,
        ["loads.gust", "outputs.side", "outputs.tip"]
    );
    assert_eq!(found.interfaces[1].loaded_by, ["joints.ball", "loads.gust"]);
    assert_eq!(found.coordinates_shown_by, ["outputs.modes"]);
    assert_eq!(found.whole_shown_by, ["outputs.all", "outputs.frame"]);
    assert_eq!(found.part_loads, ["hum"]);
    assert!(found.gravity);
    assert_eq!(
        found.inertia_change,
        dcb_formats::scene::InertiaChange::Constant
    );
    let node = [(3, vec!["outputs.one".to_owned(), "outputs.same".to_owned()])];
    assert_eq!(found.nodes, NodeDemand::Some(node.into()));
    let mut whole = text.clone();
    whole["fields"] = json!([{"body": "beam", "every": 0.1, "directory": "fields"}]);
    assert_eq!(
        demand(&whole, "beam").nodes,
        NodeDemand::All(vec!["fields[0]".into()])
    );
}

/// A crank in space that turns about z, a beam as its rod and a slider; `lift` raises the crank's pin, the rod and the slider.
fn crank_in_space(lift: f64) -> Value {
    // The rod is drawn along the world's y: its axes are the world's y, z and x.
    let inertia = json!([1e-4, 2e-4, 3e-4]);
    scene_text(
        3,
        json!({
            "gravity": [0, -9.81, 0],
            "bodies": {
                "crank": {"rigid": {"mass": 0.1, "inertia": inertia, "points": {"axle": [0, 0, 0], "pin": [0.1, 0, lift]}}},
                "beam": {
                    "superelement": "beam.dcb.h5", "position": [0.1, 0, lift],
                    "orientation": [0.5, 0.5, 0.5, 0.5]
                },
                "slider": {"rigid": {"mass": 0.1, "inertia": inertia, "points": {"pin": [0, 0, 0]}}, "position": [0.1, 0.3, lift]}
            },
            "ground": {"points": {"rail": [0.1, 0.3, lift]}},
            "joints": {
                "axle": {"revolute": {"a": "ground", "b": "crank/axle", "axis": [0, 0, 1]}},
                "wrist": {"revolute": {"a": "crank/pin", "b": "beam/a", "axis": [0, 0, 1]}},
                "pin": {"spherical": {"a": "beam/b", "b": "slider/pin"}},
                "guide": {"prismatic": {"a": "ground/rail", "b": "slider/pin", "axis": [0, 1, 0]}}
            },
            "drives": {"motor": {"angle": {"joint": "axle", "polynomial": [0, 0, 200]}}},
            "outputs": {
                "tip": {"position": {"at": "beam/b"}},
                "turn": {"angular_velocity": {"at": "beam/b"}},
                "modes": {"modal": {"body": "beam"}}
            }
        }),
    )
}

/// How far the rod's end leaves the plane, and how fast it turns out of it.
fn out_of_plane(text: &Value) -> f64 {
    let folder = Folder::with_parts();
    let mut mechanism = Mechanism::start(&folder.scene(text)).unwrap();
    let start = mechanism.output("tip").unwrap()[2];
    let mut most = 0.0_f64;
    for _ in 0..200 {
        mechanism.step(5e-4).unwrap();
        most = most.max((mechanism.output("tip").unwrap()[2] - start).abs());
        let spin = mechanism.output("turn").unwrap();
        most = most.max(1e-3 * spin[0].hypot(spin[1]));
    }
    most
}

#[test]
fn a_scene_that_is_its_mirror_image_moves_in_the_mirror() {
    let planes = |text: &Value| PlanesOfMotion::of(&rigid_scene(text), &parts(3, &["beam"]));
    let flat = crank_in_space(0.0);
    let found = planes(&flat);
    assert_eq!(found.planes.len(), 1, "{:?}", found.refused);
    assert_eq!(found.planes[0].normal, [0.0, 0.0, 1.0]);
    // The world's z is the rod's y.
    let own = demand(&flat, "beam").planes.planes[0];
    assert!((Vector3::from(own.normal) - Vector3::y()).norm() < 1e-12);
    assert!(own.offset.abs() < 1e-12);
    assert!(out_of_plane(&flat) < 1e-10);

    // What isn't its own image leaves the plane.
    let mut inertia = flat.clone();
    inertia["bodies"]["slider"]["rigid"]["inertia"] =
        json!([[2e-4, 0, 5e-5], [0, 2e-4, 0], [5e-5, 0, 3e-4]]);
    let mut gravity = flat.clone();
    gravity["gravity"] = json!([0, -9.81, 1]);
    let mut load = flat.clone();
    load["loads"] =
        json!({"push": {"force": {"at": "beam/b", "components": [0, 0, {"polynomial": [0, 50]}]}}});
    let mut start = flat.clone();
    start["bodies"]["beam"]["angular_velocity"] = json!([0, 1, 0]);
    let mut oblique = flat.clone();
    oblique["joints"]["wrist"]["revolute"]["axis"] = json!([0, 0.3, 1]);
    let cases = [
        (inertia, "principal axis of bodies.slider"),
        (gravity, "gravity isn't in the plane"),
        (load, "loads.push pushes out of the plane"),
        (start, "bodies.beam starts to turn out of the plane"),
        (oblique, "the axis of joints.wrist is oblique"),
        (crank_in_space(0.05), "off the plane"),
    ];
    for (text, why) in cases {
        let found = planes(&text);
        assert!(found.planes.is_empty(), "{why}: {:?}", found.planes);
        let across = found
            .refused
            .iter()
            .find(|line| line.contains("[0.0000, 0.0000, 1.0000]"));
        assert!(
            across.is_some_and(|line| line.contains(why)),
            "{why}: {:?}",
            found.refused
        );
    }
}

#[test]
fn what_is_off_the_plane_is_felt() {
    let mut pushed = crank_in_space(0.0);
    pushed["gravity"] = json!([0, -9.81, 1]);
    assert!(out_of_plane(&pushed) > 1e-6);
    let mut eccentric = crank_in_space(0.0);
    eccentric["bodies"]["bob"] = json!({
        "rigid": {"mass": 0.05, "inertia": [1e-5, 1e-5, 1e-5], "center_of_mass": [0, 0, 0.02], "points": {"pin": [0, 0, 0]}},
        "position": [0.1, 0.3, 0]
    });
    eccentric["joints"]["bob"] = json!({"fixed": {"a": "beam/b", "b": "bob/pin"}});
    let found = PlanesOfMotion::of(&rigid_scene(&eccentric), &parts(3, &["beam"]));
    assert!(found.planes.is_empty());
    assert!(out_of_plane(&eccentric) > 1e-6);
}

#[test]
fn a_clamped_beam_under_its_weight_has_one_plane_and_without_it_two() {
    let count = |rest: Value| {
        let scene = rigid_scene(&clamped(rest));
        PlanesOfMotion::of(&scene, &parts(3, &["beam"]))
            .planes
            .len()
    };
    // Along the beam nothing is off any plane through it; the world's x is across it.
    let tip = |components: Value| json!({"force": {"at": "beam/b", "components": components}});
    let push = json!({"loads": {"push": tip(json!([1, 0, 0]))}});
    assert_eq!(count(push), 2);
    let push = json!({"loads": {"push": tip(json!([0, 1, 0]))}});
    assert_eq!(count(push), 1);
    let push = json!({"gravity": [0, 0, 1], "loads": {"push": tip(json!([0, 1, 0]))}});
    assert_eq!(count(push), 0);
}

/// A wheel that a drive turns, and a rod fixed to a second wheel that gears with it.
fn geared(drive: Value, ratio: f64) -> Value {
    let wheel = |x: f64| json!({"rigid": {"mass": 1, "inertia": 1e-2, "points": {"axle": [0, 0]}}, "position": [x, 0]});
    scene_text(
        2,
        json!({
            "bodies": {"first": wheel(0.0), "second": wheel(1.0), "rod": {"superelement": "rod.dcb.h5", "position": [1, 0]}},
            "ground": {"points": {"other": [1, 0]}},
            "joints": {
                "one": {"revolute": {"a": "ground", "b": "first/axle"}},
                "two": {"revolute": {"a": "ground/other", "b": "second/axle"}},
                "gear": {"gear": {"first": "one", "second": "two", "ratio": ratio}},
                "root": {"fixed": {"a": "second/axle", "b": "rod/a"}}
            },
            "drives": {"motor": drive},
            "outputs": {"spin": {"angular_velocity": {"at": "second/axle"}}},
            "integrator": {"generalized_alpha": {"step": 1e-3, "end": 0.6}}
        }),
    )
}

#[test]
fn spins_that_drives_determine_are_those_of_the_run() {
    let table = json!({"speed": {"joint": "one", "table": {"times": [0, 0.2, 0.5], "values": [0, 12, -3]}}});
    let wave =
        json!({"angle": {"joint": "one", "harmonic": {"amplitude": 0.3, "angular_frequency": 40}}});
    let formula = json!({"angle": {"joint": "two", "formula": "3*exp(-((t - 0.3)/0.1)^2)"}});
    let folder = Folder::with_parts();
    for (drive, ratio) in [(table, -2.5), (wave, 0.4), (formula, 3.0)] {
        let text = geared(drive.clone(), ratio);
        let spin = demand(&text, "rod").spin;
        assert!(spin.known, "{drive}: {}", spin.reason);
        let mut mechanism = Mechanism::start(&folder.scene(&text)).unwrap();
        let mut most = number(&mut mechanism, "spin").abs();
        for _ in 0..600 {
            mechanism.step(1e-3).unwrap();
            most = most.max(number(&mut mechanism, "spin").abs());
        }
        let ratio = most / spin.rate;
        assert!(
            (ratio - 1.0).abs() < 2e-3,
            "{drive}: {most} of {}",
            spin.rate
        );
    }
    let input = json!({"angle": {"joint": "one", "input": {"initial": 0}}});
    assert!(!demand(&geared(input, 2.0), "rod").spin.known);
    let held = demand(&clamped(json!({})), "beam").spin;
    assert_eq!((held.rate, held.known), (0.0, true));
}

#[test]
fn analyses_without_a_run_ask_for_what_they_show() {
    let of = |analysis: Value| demand(&clamped(json!({"analysis": analysis})), "beam");
    let rest = of(json!("static"));
    assert_eq!(
        (rest.deflection, rest.band.frequency),
        (Deflection::Static, Some(0.0))
    );
    let rigid = of(json!("kinematic"));
    assert_eq!(
        (rigid.deflection, rigid.band.frequency),
        (Deflection::Rigid, Some(0.0))
    );
    let modes = of(json!({"modes": {"count": 3}}));
    assert_eq!(
        (modes.deflection, modes.band.frequency),
        (Deflection::Dynamic, None)
    );
}

/// The band of a clamped beam with loads, steps of 1e-4 and these keys.
fn band(rest: Value) -> Band {
    let mut text = clamped(rest);
    text["integrator"] = json!({"generalized_alpha": {"step": 1e-5, "end": 4}});
    demand(&text, "beam").band
}

fn tip_force(function: &Value) -> Value {
    json!({"push": {"force": {"at": "beam/b", "components": [0, 0, function]}}})
}

#[test]
fn smooth_forces_on_parts_that_stay_are_narrow_and_all_else_is_broad() {
    // 1 % of a Gaussian's spectrum is at 2 √ln 100 / τ.
    let gust = json!({"formula": "20*exp(-((t - 2)/0.1)^2)"});
    let narrow = band(json!({"loads": tip_force(&gust)})).frequency.unwrap();
    let expected = 2.0 * 100.0_f64.ln().sqrt() / 0.1 / TAU;
    assert!((narrow / expected - 1.0).abs() < 0.1, "{narrow} {expected}");
    let nothing = band(json!({}));
    assert_eq!(nothing.frequency, Some(0.0));

    let by_steps = 1.0 / (18.635 * 1e-5);
    let weak = json!({"mount": {"bushing": {"a": "ground", "b": "beam/b", "translation": [[[-1, -1], [0, 0], [1, 2]], 1, 1]}}});
    let coil = json!({"coil": {"spring": {"a": "ground", "b": "beam/b", "stiffness": 10}}});
    let broad = [
        (json!({"loads": tip_force(&json!(3))}), "acts at once"),
        (
            json!({"loads": tip_force(&json!({"pulse": {"shape": "rectangle", "amplitude": 3, "start": 1, "width": 0.5}}))}),
            "acts at once",
        ),
        (
            json!({"loads": tip_force(&json!({"formula": "if(t < 1, 0, t)"}))}),
            "acts at once",
        ),
        (
            json!({"loads": tip_force(&json!({"input": {}}))}),
            "is set from outside",
        ),
        (
            json!({"gravity": [0, 0, -1]}),
            "gravity acts from the start",
        ),
        (json!({"springs": weak}), "springs.mount is not linear"),
        (json!({"springs": coil}), "a line that turns"),
        (json!({"joints": {}}), "bodies.beam is not held"),
        (
            json!({"joints": {"ball": {"spherical": {"a": "ground", "b": "beam/a"}}}}),
            "joints.ball is spherical",
        ),
        (
            json!({"bodies": {"beam": {"superelement": "beam.dcb.h5", "velocity": [0, 0, 1]}}}),
            "starts with a velocity",
        ),
        (
            json!({
                "joints": {"slide": {"prismatic": {"a": "ground", "b": "beam/a", "axis": [0, 0, 1]}}},
                "drives": {"push": {"speed": {"joint": "slide", "table": {"times": [0, 1, 2], "values": [0, 1, 0], "interpolation": "linear"}}}}
            }),
            "drives.push acts at once",
        ),
    ];
    for (rest, why) in broad {
        let found = band(rest.clone());
        let told = found.reasons.join("; ");
        assert!(
            (found.frequency.unwrap() / by_steps - 1.0).abs() < 1e-4,
            "{rest}: {told}"
        );
        assert!(told.contains(why), "{rest}: {told}");
    }
    let mut adaptive = clamped(json!({"gravity": [0, 0, -1]}));
    adaptive["integrator"] = json!({"generalized_alpha": {
        "step": 1e-3, "end": 1, "adaptive": {"tolerance": 1e-4, "minimum_step": 1e-6, "maximum_step": 1e-2}
    }});
    let limit = demand(&adaptive, "beam").band.frequency.unwrap();
    assert!((limit * 18.635e-6 - 1.0).abs() < 1e-4, "{limit}");
}

#[test]
fn an_oscillator_beyond_the_band_follows_its_force() {
    // A sine that starts: its bend at time zero is what excites most. Natural frequencies at the band's end and at a tenth of it.
    let (force, frequency) = (2.0, 0.5);
    let wave = json!({"harmonic": {"amplitude": force, "frequency_hz": frequency}});
    let end = band(json!({"loads": tip_force(&wave)})).frequency.unwrap();
    assert!((end / (100.0 * frequency) - 1.0).abs() < 1e-9, "{end}");
    let oscillating = |natural: f64| {
        let stiffness = (TAU * natural).powi(2);
        let mut mechanism = started(&scene_text(
            2,
            json!({
                "bodies": {"block": {"rigid": {"mass": 1, "inertia": 1, "points": {"pin": [0, 0]}}}},
                "joints": {"slide": {"prismatic": {"a": "ground", "b": "block/pin", "axis": [1, 0]}}},
                "springs": {"mount": {"bushing": {"a": "ground", "b": "block/pin", "translation": [stiffness, 0]}}},
                "loads": {"push": {"force": {"at": "block/pin", "components": [wave, 0]}}},
                "outputs": {"x": {"position": {"at": "block/pin"}}}
            }),
        ));
        let step = 0.02 / natural;
        let mut most = 0.0_f64;
        for _ in 0..400 {
            mechanism.step(step).unwrap();
            let slowly = force * (TAU * frequency * mechanism.time()).sin() / stiffness;
            most = most.max((number(&mut mechanism, "x") - slowly).abs());
        }
        most / (force / stiffness)
    };
    let (at_end, below) = (oscillating(end), oscillating(0.1 * end));
    assert!(at_end < 0.0105, "{at_end}");
    assert!(below > 0.08, "{below}");
}
