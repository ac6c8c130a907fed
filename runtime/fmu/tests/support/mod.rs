//! Scenes with superelements, their archives, and archives as importers unpack them.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use dcb_formats::component::Component;
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::output::Replace;
use dcb_formats::results::Results;
use dcb_samples::spatial_beam::{BeamSection, SpatialBeam, spatial_beam};
use dcb_tests::lowest;
use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder with a scene.
pub struct Folder {
    place: TempDir,
}

/// An unpacked archive.
pub struct Unpacked {
    pub resources: PathBuf,
    pub token: String,
    pub description: String,
}

impl Folder {
    pub fn path(&self, name: &str) -> PathBuf {
        self.place.path().join(name)
    }

    pub fn write_scene(&self, scene: &Value) {
        fs::write(self.path("scene.json"), scene.to_string()).unwrap();
    }

    /// What the program `simulate` answers.
    pub fn simulate(&self, arguments: &[&str]) -> u8 {
        let folder = self.place.path().to_str().unwrap().to_owned() + "/";
        let arguments = arguments
            .iter()
            .map(|argument| argument.replace("./", &folder));
        let all = std::iter::once("simulate".to_owned())
            .chain(arguments)
            .chain(["--quiet".to_owned()]);
        dcb_programs::simulate::main(all.map(Into::into), dcb_programs::reduce::command)
    }

    /// The archive of the scene.
    pub fn pack(&self) -> PathBuf {
        let library = library();
        let library = library.to_str().unwrap();
        let done = self.simulate(&[
            "fmu",
            "./scene.json",
            "-o",
            "./unit.fmu",
            "--force",
            "--library",
            library,
        ]);
        assert_eq!(done, 0);
        self.path("unit.fmu")
    }

    /// The archive of the scene, unpacked into a folder of this name.
    pub fn unpacked(&self, name: &str) -> Unpacked {
        let target = self.path(name);
        let mut archive = zip::ZipArchive::new(File::open(self.pack()).unwrap()).unwrap();
        archive.extract(&target).unwrap();
        let description = fs::read_to_string(target.join("modelDescription.xml")).unwrap();
        Unpacked {
            resources: target.join("resources"),
            token: attribute(&description, "instantiationToken=\""),
            description,
        }
    }

    /// What a whole run of the scene records, with everything that the superelements have.
    pub fn results(&self) -> Results {
        let done = self.simulate(&[
            "./scene.json",
            "-o",
            "./scene.h5",
            "--force",
            "--model",
            "everything",
        ]);
        assert_eq!(done, 0);
        Results::open(self.path("scene.h5")).unwrap()
    }
}

/// The shared library, which cargo makes beside the tests.
pub fn library() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let library = test.with_file_name("libdcb_fmu.so");
    assert!(library.is_file(), "{} is not there", library.display());
    library
}

fn attribute(text: &str, start: &str) -> String {
    let (_, rest) = text.split_once(start).unwrap();
    rest.split_once('"').unwrap().0.to_owned()
}

/// A folder with a planar slider-crank: the sample of the repository.
pub fn slider_crank() -> Folder {
    let place = tempfile::tempdir().unwrap();
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/slider-crank");
    for name in ["scene.json", "rod.dcb.h5"] {
        fs::copy(samples.join(name), place.path().join(name)).unwrap();
    }
    Folder { place }
}

/// A folder with two flexible links in space, of files of one name: a shoulder with a torque from outside, an elbow, and forces at the tip.
pub fn arm() -> Folder {
    let folder = Folder {
        place: tempfile::tempdir().unwrap(),
    };
    for (name, beam) in [
        ("upper", SpatialBeam::default()),
        (
            "lower",
            SpatialBeam {
                elements: 6,
                end: [0.6, 0.0, 0.0],
                section: BeamSection::rectangle(0.01, 0.02),
                ..SpatialBeam::default()
            },
        ),
    ] {
        fs::create_dir(folder.path(name)).unwrap();
        write_part(&spatial_beam(&beam), &folder.path(name).join("link.dcb.h5"));
    }
    folder.write_scene(&arm_scene());
    folder
}

/// The scene of [`arm`].
pub fn arm_scene() -> Value {
    json!({
        "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"}, "gravity": [0, 0, -9.81],
        "constants": {"push": 3.0},
        "bodies": {
            "upper": {"superelement": "upper/link.dcb.h5", "damping": {"modal": 0.01}},
            "lower": {"superelement": "lower/link.dcb.h5", "position": [1, 0, 0]}
        },
        "joints": {
            "shoulder": {"revolute": {"a": "ground", "b": "upper/a", "axis": [0, 1, 0]}},
            "elbow": {"universal": {"a": "upper/b", "b": "lower/a", "axis": [0, 1, 0], "axis_b": [0, 0, 1]}}
        },
        "loads": {
            "motor": {"torque": {"at": "upper/a", "components": [0, {"input": {"initial": 0}}, 0]}},
            "gust": {"force": {"at": "lower/b", "components": [{"input": {"initial": 0}}, {"formula": "push*sin(20*t)"}, {"input": {"initial": 0.5}}]}}
        },
        "outputs": {
            "tip": {"position": {"at": "lower/b"}},
            "middle": {"node_displacement": {"body": "upper", "node": 4}},
            "angle": {"joint_coordinate": {"joint": "shoulder"}},
            "rate": {"joint_rate": {"joint": "shoulder"}},
            "pull": {"reaction": {"joint": "elbow"}},
            "energy": "energy"
        },
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 0.2}}
    })
}

fn write_part(component: &Component, path: &Path) {
    let reduced = lowest(component, 6);
    let contents = Contents {
        superelement: &reduced.superelement,
        recovery: Some(&reduced.recovery),
        mesh: Some(&component.mesh),
    };
    let options = WriteOptions {
        replace_existing: Replace::Overwrite,
        ..WriteOptions::default()
    };
    write_superelement(path, &contents, &options).unwrap();
}
