//! A folder with a scene in it, the program run there, and what both look like afterwards.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use dcb_formats::Component;
use dcb_formats::component::{Interface, InterfaceKind, Role};
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::mesh::Direction;
use dcb_formats::results::{Outcome, Results};
use dcb_reducer::{Reduction, reduce};
use dcb_samples::{SpatialBeam, spatial_beam};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder of its own for each test.
pub struct Folder {
    place: TempDir,
}

/// How a run ended.
#[derive(Debug)]
pub struct Answer {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Answer {
    /// Asserts the exit code, and that standard error has all of these texts and nothing that only a programmer understands.
    #[track_caller]
    pub fn assert(&self, code: i32, texts: &[&str]) {
        assert_eq!(self.code, Some(code), "{self:?}");
        for text in texts {
            assert!(self.stderr.contains(text), "no {text:?} in {}", self.stderr);
        }
        for odd in ["panicked", "unwrap", "RUST_BACKTRACE"] {
            assert!(!self.stderr.contains(odd), "{}", self.stderr);
        }
    }
}

impl Folder {
    pub fn empty() -> Self {
        Self {
            place: tempfile::tempdir().unwrap(),
        }
    }

    /// `scene.json`.
    pub fn with(scene: &Value) -> Self {
        let made = Self::empty();
        made.write("scene.json", serde_json::to_string_pretty(scene).unwrap());
        made
    }

    /// The slider-crank of the samples: `scene.json` and `rod.dcb.h5`, a planar rod with interfaces `a` and `b` without rotation rows.
    pub fn slider_crank() -> Self {
        let made = Self::empty();
        let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/slider-crank");
        for name in ["scene.json", "rod.dcb.h5"] {
            fs::copy(samples.join(name), made.path(name)).unwrap();
        }
        // A tenth of a turn is enough.
        made.edit("scene.json", |scene| {
            scene["integrator"]["generalized_alpha"]["end"] = json!(0.004);
        });
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
        let (pair, watched, bare) = (
            more("pair", vec![1, 3]),
            more("watched", vec![2]),
            more("bare", vec![2]),
        );
        beam.interfaces.push(pair);
        beam.interfaces.push(Interface {
            role: Role::Output,
            ..watched
        });
        beam.interfaces.push(Interface {
            directions: Some(vec![Direction::Ux, Direction::Uy, Direction::Uz]),
            ..bare
        });
        made.store_lowest("beam.dcb.h5", &Component::checked(beam).unwrap(), modes);
        made
    }

    pub fn store(&self, name: &str, component: &Component) {
        self.store_lowest(name, component, 3);
    }

    fn store_lowest(&self, name: &str, component: &Component, modes: usize) {
        let reduced = reduce(component, &Reduction::lowest(modes), &mut ()).unwrap();
        let contents = Contents {
            superelement: &reduced.superelement,
            recovery: None,
            mesh: None,
        };
        write_superelement(&self.path(name), &contents, &WriteOptions::default()).unwrap();
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.place.path().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        fs::write(self.path(name), contents).unwrap();
    }

    /// Changes a JSON file.
    pub fn edit(&self, name: &str, change: impl FnOnce(&mut Value)) {
        let mut value = serde_json::from_str(&self.read(name)).unwrap();
        change(&mut value);
        self.write(name, serde_json::to_string_pretty(&value).unwrap());
    }

    /// Names and contents of all files.
    pub fn contents(&self) -> BTreeMap<String, Vec<u8>> {
        let files = fs::read_dir(self.place.path()).unwrap();
        files
            .map(|file| {
                let path = file.unwrap().path();
                let name = path.file_name().unwrap().to_str().unwrap().to_owned();
                let contents = if path.is_file() {
                    fs::read(&path).unwrap()
                } else {
                    Vec::new()
                };
                (name, contents)
            })
            .collect()
    }

    /// Standard output of a run that is interrupted soon after this file exists; it ends with 130.
    #[track_caller]
    pub fn interrupted(&self, words: &str, file: &str) -> String {
        self.stopped_by("INT", 130, words, file)
    }

    /// The same for any signal and exit status.
    #[track_caller]
    pub fn stopped_by(&self, signal: &str, status: i32, words: &str, file: &str) -> String {
        let child = self
            .command(words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        while !self.path(file).exists() {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(300));
        let sent = Command::new("kill")
            .args([&format!("-{signal}"), &child.id().to_string()])
            .status();
        assert!(sent.unwrap().success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(status));
        String::from_utf8(output.stdout).unwrap()
    }

    /// The program with these words, in this folder.
    pub fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_simulate"));
        command
            .args(words.split_whitespace())
            .current_dir(self.place.path())
            .stdin(Stdio::null());
        command
    }

    pub fn run(&self, words: &str) -> Answer {
        let output = self.command(words).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Answer {
            code: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// The same where files may not have more than so many KiB.
    pub fn run_within(&self, kibibytes: u32, words: &str) -> Answer {
        let program = env!("CARGO_BIN_EXE_simulate");
        let script = format!("ulimit -f {kibibytes}; exec '{program}' {words}");
        let mut command = Command::new("bash");
        command.args(["-c", &script]).current_dir(self.place.path());
        let output = command.stdin(Stdio::null()).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Answer {
            code: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// Runs what must be refused as unusable input, and leaves every file as it was.
    #[track_caller]
    pub fn refuses(&self, words: &str, texts: &[&str]) {
        let before = self.contents();
        self.run(words).assert(2, texts);
        assert!(self.contents() == before, "files have changed");
    }

    /// Runs what must succeed; what it said.
    #[track_caller]
    pub fn done(&self, words: &str) -> Answer {
        let answer = self.run(words);
        assert_eq!(answer.code, Some(0), "{answer:?}");
        answer
    }

    pub fn results(&self) -> Results {
        Results::open(self.path("scene.h5")).unwrap()
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

/// A planar scene with a block on a hinge, and what else it has.
pub fn pendulum(rest: Value) -> Value {
    let mut scene = json!({
        "dimension": 2,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "gravity": [0, -9.81],
        "bodies": {"bob": {"rigid": {"mass": 1, "inertia": 0.01, "points": {"pin": [-0.5, 0], "tip": [0.1, 0]}}, "position": [0.5, 0]}},
        "joints": {"hinge": {"revolute": {"a": "ground", "b": "bob/pin"}}},
        "outputs": {"angle": {"joint_coordinate": {"joint": "hinge"}}},
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 0.1}}
    });
    for (key, value) in rest.as_object().unwrap() {
        scene[key] = value.clone();
    }
    scene
}
