//! Scenes made of text, and the superelements that they name.

use std::path::Path;

use dcb_formats::Component;
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_reducer::{Reduction, reduce};
use dcb_runtime::{Mechanism, Scene};
use dcb_samples::spatial_beam::BeamSection;
use dcb_samples::{Material, RodSection, SpatialBeam, planar_rod, spatial_beam};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder with `beam.dcb.h5` (spatial) and `rod.dcb.h5` (planar): 0.3 m from `a` to `b` along x, as soft as rubber, so that steps
/// that a test can afford resolve every oscillation.
pub struct Folder {
    pub place: TempDir,
}

impl Folder {
    pub fn with_parts() -> Self {
        let place = tempfile::tempdir().unwrap();
        store(&soft_beam(), &place.path().join("beam.dcb.h5"));
        let mut rod = soft_rod().into_draft();
        for interface in &mut rod.interfaces {
            // All that its node has, the rotation too.
            interface.directions = None;
        }
        let rod = Component::checked(rod).unwrap();
        store(&rod, &place.path().join("rod.dcb.h5"));
        Self { place }
    }

    pub fn scene(&self, text: &Value) -> Scene {
        Scene::parse(&text.to_string(), &self.place.path().join("scene.json")).unwrap()
    }
}

/// 0.3 m along x in space, as soft as rubber.
pub fn soft_beam() -> Component {
    spatial_beam(&SpatialBeam {
        elements: 3,
        end: [0.3, 0.0, 0.0],
        section: BeamSection::rectangle(0.03, 0.02),
        material: Material {
            youngs_modulus: 2e7,
            density: 1000.0,
            ..Material::STEEL
        },
        ..SpatialBeam::default()
    })
}

/// The same in the plane.
pub fn soft_rod() -> Component {
    planar_rod(3, &RodSection::round(0.3, 0.03, 2e7, 1000.0))
}

/// Writes a superelement with its nodal fields.
pub fn store(component: &Component, path: &Path) {
    let reduced = reduce(component, &Reduction::lowest(3), &mut ()).unwrap();
    let contents = Contents {
        superelement: &reduced.superelement,
        recovery: Some(&reduced.recovery),
        mesh: Some(&component.mesh),
    };
    write_superelement(path, &contents, &WriteOptions::default()).unwrap();
}

/// A scene without superelements.
pub fn rigid_scene(text: &Value) -> Scene {
    Scene::parse(&text.to_string(), Path::new("scene.json")).unwrap()
}

/// A scene without superelements, started.
pub fn started(text: &Value) -> Mechanism {
    Mechanism::start(&rigid_scene(text)).unwrap()
}

/// Metre, kilogram, second, a usual integrator, and what else the scene has.
pub fn scene_text(dimension: u32, rest: Value) -> Value {
    let mut scene = json!({
        "dimension": dimension,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 1}},
    });
    let all = scene.as_object_mut().unwrap();
    all.extend(rest.as_object().unwrap().clone());
    scene
}

/// The first number of an output.
pub fn number(mechanism: &mut Mechanism, output: &str) -> f64 {
    mechanism.output(output).unwrap()[0]
}

/// Steps of equal length up to a time.
pub fn run(mechanism: &mut Mechanism, end: f64, steps: u32) {
    for _ in 0..steps {
        mechanism.step(end / f64::from(steps)).unwrap();
    }
}
