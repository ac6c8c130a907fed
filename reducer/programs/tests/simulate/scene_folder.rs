//! A folder with a scene in it, and what `simulate` leaves there.

use std::fs;
use std::time::Duration;

use dcb_formats::Component;
use dcb_formats::component::{Interface, InterfaceKind, Role};
use dcb_formats::mesh::Direction;
use dcb_formats::results::{Outcome, Results};
use dcb_reducer::{Reduction, reduce};
use dcb_samples::{SpatialBeam, spatial_beam};
use serde_json::{Value, json};

use crate::support::{Answer, Folder, list, stopped, stored};

impl Folder {
    /// `scene.json`.
    pub fn with(scene: &Value) -> Self {
        let made = Self::empty();
        made.write("scene.json", serde_json::to_string_pretty(scene).unwrap());
        made
    }

    /// The slider-crank of the samples: `scene.json` and `rod.dcb.h5`, a planar rod with interfaces `a` and `b` without rotation rows.
    pub fn slider_crank() -> Self {
        let made = Self::empty();
        for name in ["scene.json", "rod.dcb.h5"] {
            let sample = stored("samples/slider-crank").join(name);
            fs::copy(sample, made.path(name)).unwrap();
        }
        // A tenth of a turn is enough.
        made.set_integrator("end", 0.004);
        made
    }

    /// The same for one turn.
    pub fn one_turn() -> Self {
        let made = Self::slider_crank();
        made.set_integrator("end", 0.042);
        made
    }

    /// The same for so long that nobody waits for its end.
    pub fn endless() -> Self {
        let made = Self::slider_crank();
        made.set_scene("record", json!({"every": 1}));
        made.set_integrator("end", 1000.0);
        made
    }

    /// `scene.json` and `beam.dcb.h5`, a spatial beam: `a` and `b` are its ends, `pair` two nodes, `watched` an output, `bare` a node
    /// without rotation rows.
    pub fn beam(scene: &Value) -> Self {
        Self::beam_with_modes(scene, 3)
    }

    /// The same with so many modes.
    pub fn beam_with_modes(scene: &Value, modes: usize) -> Self {
        let made = Self::with(scene);
        let mut beam = spatial_beam(&SpatialBeam {
            elements: 4,
            ..SpatialBeam::default()
        })
        .into_draft();
        let more = |name: &str, nodes: Vec<u32>| Interface {
            name: name.into(),
            kind: InterfaceKind::Nodes,
            nodes,
            ..beam.interfaces[0].clone()
        };
        let pair = more("pair", vec![1, 3]);
        let watched = Interface {
            role: Role::Output,
            ..more("watched", vec![2])
        };
        let bare = Interface {
            directions: Some(vec![Direction::Ux, Direction::Uy, Direction::Uz]),
            ..more("bare", vec![2])
        };
        beam.interfaces.extend([pair, watched, bare]);
        made.store_lowest("beam.dcb.h5", &Component::checked(beam).unwrap(), modes);
        made
    }

    pub fn store(&self, name: &str, component: &Component) {
        self.store_lowest(name, component, 3);
    }

    pub fn store_lowest(&self, name: &str, component: &Component, modes: usize) {
        let reduced = reduce(component, &Reduction::lowest(modes), &mut ()).unwrap();
        self.store_superelement(name, &reduced.superelement);
    }

    /// Changes `scene.json`.
    pub fn set_scene(&self, place: &str, value: impl serde::Serialize) {
        self.set("scene.json", place, value);
    }

    /// Changes the integrator of `scene.json`.
    pub fn set_integrator(&self, key: &str, value: f64) {
        self.set_scene(&format!("integrator/generalized_alpha/{key}"), value);
    }

    /// Standard output of a run that is interrupted soon after this file exists; it ends with 130.
    #[track_caller]
    pub fn interrupted(&self, words: &str, file: &str) -> String {
        self.stopped_by("INT", 130, words, file)
    }

    /// The same for any signal and exit status.
    #[track_caller]
    pub fn stopped_by(&self, signal: &str, status: i32, words: &str, file: &str) -> String {
        let child = self.start(words);
        while !self.path(file).exists() {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(300));
        let answer = stopped(signal, child);
        assert_eq!(answer.code, Some(status));
        answer.stdout
    }

    /// Runs what must succeed; what it said.
    #[track_caller]
    pub fn done(&self, words: &str) -> Answer {
        let answer = self.run(words);
        assert_eq!(answer.code, Some(0), "{answer:?}");
        answer
    }

    pub fn results(&self) -> Results {
        self.results_of("scene.h5")
    }

    pub fn results_of(&self, name: &str) -> Results {
        Results::open(self.path(name)).unwrap()
    }

    /// The messages of the run's events.
    pub fn told(&self) -> Vec<String> {
        let events = self.results().events().unwrap().into_iter();
        events.map(|event| event.message).collect()
    }

    /// How many constraints the run told to be redundant.
    pub fn redundant(&self) -> u64 {
        let summary = self.results().provenance("summary").unwrap();
        let joints = list(&summary["redundant_constraints"]).iter();
        joints.map(|joint| joint["count"].as_u64().unwrap()).sum()
    }

    /// Why the run of the scene stopped, at what time, and how many rows it left.
    #[track_caller]
    pub fn stopped(&self) -> (String, Option<f64>, usize) {
        let results = self.results();
        match results.outcome() {
            Outcome::Complete => panic!("it is complete"),
            Outcome::Stopped { reason, time } => (reason.clone(), *time, results.step_count()),
        }
    }
}

/// A planar scene in metres, kilograms and seconds with these keys.
pub fn planar(keys: Value) -> Value {
    of_dimension(2, keys)
}

/// A spatial one.
pub fn spatial(keys: Value) -> Value {
    of_dimension(3, keys)
}

fn of_dimension(dimension: u8, keys: Value) -> Value {
    let units = json!({"length": "m", "mass": "kg", "time": "s"});
    with_keys(json!({"dimension": dimension, "units": units}), keys)
}

/// The keys in place of those that are there.
pub fn with_keys(mut scene: Value, keys: Value) -> Value {
    let keys = keys.as_object().unwrap().clone();
    scene.as_object_mut().unwrap().extend(keys);
    scene
}

/// A planar scene with a block on a hinge, and what else it has.
pub fn pendulum(rest: Value) -> Value {
    let block = json!({
        "gravity": [0, -9.81],
        "bodies": {"bob": {"rigid": {"mass": 1, "inertia": 0.01, "points": {"pin": [-0.5, 0], "tip": [0.1, 0]}}, "position": [0.5, 0]}},
        "joints": {"hinge": {"revolute": {"a": "ground", "b": "bob/pin"}}},
        "outputs": {"angle": {"joint_coordinate": {"joint": "hinge"}}},
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 0.1}}
    });
    planar(with_keys(block, rest))
}
