//! Whirl and critical speeds of rotors against closed forms, and what is no rotor.

use std::f64::consts::TAU;
use std::path::Path;

use dcb_formats::SparseMatrix;
use dcb_formats::scene::Scene;
use dcb_runtime::run::Observer;
use dcb_runtime::whirl::{Campbell, CampbellRequest, Whirl, campbell};
use dcb_samples::spatial_beam::{BeamMass, BeamSection, BeamTheory};
use dcb_samples::{SpatialBeam, shaft, spatial_beam};
use dcb_tests::dense::{dense, sparse};
use dcb_tests::lowest;
use faer::Mat;
use serde_json::{Value, json};

struct Quiet;

impl Observer for Quiet {
    fn note(&mut self, _: f64, _: &str) {}
    fn progress(&mut self, _: f64, _: f64) {}
    fn is_stopped(&self) -> bool {
        false
    }
}

const MASS: f64 = 3.0;
const DIAMETRAL: f64 = 0.02;
const STIFFNESS: f64 = 2e5;
const ARM: f64 = 0.1;

/// A rigid rotor along z on two equal bushings, `arm` before and behind its centre of mass.
fn rigid(polar: f64) -> Value {
    let spring = |name: &str| json!({"bushing": {"a": format!("ground/{name}"), "b": format!("rotor/{name}"), "translation": [STIFFNESS, STIFFNESS, 1e5]}});
    json!({
        "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
        "ground": {"points": {"left": [0, 0, -ARM], "right": [0, 0, ARM]}},
        "bodies": {"rotor": {
            "rigid": {"mass": MASS, "inertia": [DIAMETRAL, DIAMETRAL, polar], "points": {"left": [0, 0, -ARM], "right": [0, 0, ARM]}},
            "angular_velocity": [0, 0, 10]
        }},
        "springs": {"left": spring("left"), "right": spring("right")},
        "analysis": {"modes": {"count": 8}}
    })
}

pub(super) fn whirl_of(
    scene: &Value,
    folder: &Path,
    request: &CampbellRequest,
) -> Result<Campbell, String> {
    let scene = Scene::parse(&scene.to_string(), &folder.join("scene.json"))
        .map_err(|error| error.to_string())?;
    campbell(&scene, request, &mut Quiet)
        .map(Option::unwrap)
        .map_err(|error| error.to_string())
}

pub(super) fn request(speeds: &[f64], orders: &[f64]) -> CampbellRequest {
    CampbellRequest {
        speeds: speeds.to_vec(),
        orders: orders.to_vec(),
        rotor: None,
    }
}

/// Tilting of a gyroscope on springs: I_t ω² − I_p Ω ω − k_t = 0, both signs; bouncing: k/m whatever the speed.
#[test]
fn a_rigid_rotor_whirls_as_its_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let polar = 0.9 * DIAMETRAL;
    let speeds = [50.0, 200.0, 600.0, 1500.0];
    let found = whirl_of(&rigid(polar), folder.path(), &request(&speeds, &[1.0])).unwrap();
    assert_eq!(found.rotor, "rotor");
    let bounce = (2.0 * STIFFNESS / MASS).sqrt();
    let tilting = 2.0 * STIFFNESS * ARM * ARM;
    for point in &found.points {
        let gyroscopic = polar * point.speed;
        let root = (gyroscopic * gyroscopic + 4.0 * DIAMETRAL * tilting).sqrt();
        let mut expected = vec![
            bounce,
            -bounce,
            (gyroscopic + root) / (2.0 * DIAMETRAL),
            (gyroscopic - root) / (2.0 * DIAMETRAL),
        ];
        let mut across: Vec<f64> = (point.modes.iter())
            .filter(|mode| mode.whirl == Whirl::Across)
            .map(|mode| TAU * mode.frequency)
            .collect();
        expected.sort_by(f64::total_cmp);
        across.sort_by(f64::total_cmp);
        assert_eq!(across.len(), 4, "{:?}", point.modes);
        for (found, expected) in across.iter().zip(&expected) {
            let off = (found - expected).abs();
            assert!(
                off < 1e-8 * (expected.abs() + point.speed),
                "{found} {expected}"
            );
        }
        let along: Vec<f64> = (point.modes.iter())
            .filter(|mode| mode.whirl == Whirl::Along)
            .map(|mode| TAU * mode.frequency)
            .collect();
        assert!(
            (along[0] / (2e5 / MASS).sqrt() - 1.0).abs() < 1e-8,
            "{along:?}"
        );
    }
}

/// Unbalance meets the bounce at √(k/m), and the tilt at √(k_t/(I_t − I_p)): never, for a disk.
#[test]
fn critical_speeds_of_a_rigid_rotor() {
    let folder = tempfile::tempdir().unwrap();
    let speeds: Vec<f64> = (1..=30).map(|i| 50.0 * f64::from(i)).collect();
    let bounce = (2.0 * STIFFNESS / MASS).sqrt();
    let tilting = 2.0 * STIFFNESS * ARM * ARM;
    for polar in [0.5 * DIAMETRAL, 1.6 * DIAMETRAL] {
        let found = whirl_of(
            &rigid(polar),
            folder.path(),
            &request(&speeds, &[1.0, -1.0]),
        )
        .unwrap();
        let of = |order: f64| -> Vec<f64> {
            let all = found
                .criticals
                .iter()
                .filter(|critical| critical.order == order);
            // The bounce and the tilt may meet there.
            all.flat_map(|critical| std::iter::repeat_n(critical.speed, critical.count))
                .collect()
        };
        let mut forward = vec![bounce];
        if polar < DIAMETRAL {
            forward.push((tilting / (DIAMETRAL - polar)).sqrt());
        }
        let mut backward = vec![bounce, (tilting / (DIAMETRAL + polar)).sqrt()];
        for (order, expected) in [(1.0, &mut forward), (-1.0, &mut backward)] {
            expected.sort_by(f64::total_cmp);
            let found = of(order);
            assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
            for (found, expected) in found.iter().zip(expected.iter()) {
                assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
            }
        }
    }
}

/// A uniform round shaft on two stiff bearings: the critical speeds of an Euler-Bernoulli beam without rotary inertia are its bending frequencies,
/// (kπ/l)² √(EI/ρA), because points on the axis have no gyroscopic moment.
#[test]
fn a_slender_shaft_is_critical_at_its_bending_frequencies() {
    let folder = tempfile::tempdir().unwrap();
    let side = 0.02;
    let shaft = spatial_beam(&SpatialBeam {
        elements: 16,
        section: BeamSection::rectangle(side, side),
        theory: BeamTheory::EulerBernoulli,
        mass: BeamMass::Consistent,
        ..SpatialBeam::default()
    });
    dcb_tests::write_bare(
        &folder.path().join("shaft.dcb.h5"),
        &lowest(&shaft, 12).superelement,
    );
    let scene = json!({
        "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
        "ground": {"points": {"a": [0, 0, 0], "b": [1, 0, 0]}},
        "bodies": {"shaft": {"superelement": "shaft.dcb.h5", "angular_velocity": [100, 0, 0]}},
        "springs": {
            "a": {"bushing": {"a": "ground/a", "b": "shaft/a", "translation": [1e9, 1e9, 1e9]}},
            "b": {"bushing": {"a": "ground/b", "b": "shaft/b", "translation": [0, 1e9, 1e9]}}
        },
        "analysis": {"modes": {"count": 8}}
    });
    let speeds: Vec<f64> = (1..=24).map(|i| 120.0 * f64::from(i)).collect();
    let found = whirl_of(&scene, folder.path(), &request(&speeds, &[1.0])).unwrap();
    let (young, density) = (2.1e11, 7850.0);
    let stiffness = young * side.powi(4) / 12.0;
    let unit = (std::f64::consts::PI).powi(2) * (stiffness / (density * side * side)).sqrt();
    let criticals: Vec<f64> = found
        .criticals
        .iter()
        .map(|critical| critical.speed)
        .collect();
    assert!(criticals.len() >= 2, "{criticals:?}");
    for (k, found) in criticals.iter().take(2).enumerate() {
        let expected = unit * ((k + 1) as f64).powi(2);
        assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
    }
}

/// The rotor of example 5.9.1 of the book by Friswell and others, on the shaft in `shaft.dcb.h5`; mass, polar and diametral inertia of each disk.
pub(super) fn rotor_of_the_book([small, large]: [[f64; 3]; 2]) -> Value {
    let disk = |[mass, polar, diametral]: [f64; 3], x: f64| {
        json!({
            "rigid": {"mass": mass, "inertia": [polar, diametral, diametral], "points": {"hub": [0, 0, 0]}},
            "position": [x, 0, 0], "angular_velocity": [100, 0, 0]
        })
    };
    let bearing = |at: &str, along: f64| json!({"bushing": {"a": format!("ground/{at}"), "b": format!("shaft/{at}"), "translation": [along, 1e6, 1e6]}});
    json!({
        "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
        "ground": {"points": {"left": [0, 0, 0], "right": [1.5, 0, 0]}},
        "bodies": {
            "shaft": {"superelement": "shaft.dcb.h5", "angular_velocity": [100, 0, 0]},
            "small": disk(small, 0.5), "large": disk(large, 1.0)
        },
        "joints": {
            "first": {"fixed": {"a": "shaft/disk-1", "b": "small/hub"}},
            "second": {"fixed": {"a": "shaft/disk-2", "b": "large/hub"}}
        },
        "springs": {"left": bearing("left", 1e6), "right": bearing("right", 0.0)},
        "analysis": {"modes": {"count": 8}}
    })
}

/// The rotor of example 5.9.1 of the book by Friswell and others, whirling as ROSS has it (`tests/data/whirl`): a shaft without gyroscopic moments. Ours has that of its
/// rigid tilting, from the polar inertia of its nodes, unless this is taken away.
#[test]
fn the_rotor_of_the_book_whirls_as_in_ross() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/whirl/ross.json");
    let data: Value = serde_json::from_str(&std::fs::read_to_string(data).unwrap()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    // Six dofs a node; the fourth turns about the shaft.
    let turning = |dof: usize| if dof % 6 == 3 { 0.03 } else { 1.0 };
    let thinned = |own: &SparseMatrix| {
        let own = dense(own);
        sparse(&Mat::from_fn(own.nrows(), own.ncols(), |i, j| {
            turning(i) * own[(i, j)] * turning(j)
        }))
    };
    let thin = shaft(12).changed(|draft| {
        draft.mass = thinned(&draft.mass);
        if let Some(masses) = &mut draft.component_masses {
            masses.matrices = masses.matrices.iter().map(thinned).collect();
        }
    });
    let element = lowest(&thin.unwrap(), 24).superelement;
    dcb_tests::write_bare(&folder.path().join("shaft.dcb.h5"), &element);
    let disk = |index: usize| {
        let of = |key: &str| data["disks"][index][key].as_f64().unwrap();
        [of("mass"), of("polar"), of("diametral")]
    };
    let scene = rotor_of_the_book([disk(0), disk(1)]);
    let rpm = TAU / 60.0;
    let numbers = |of: &Value| -> Vec<f64> {
        of.as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_f64().unwrap())
            .collect()
    };
    let speeds: Vec<f64> = numbers(&data["rpm"])
        .iter()
        .map(|speed| speed * rpm)
        .collect();
    let grid: Vec<f64> = (1..=60).map(|i| 200.0 * f64::from(i) * rpm).collect();
    let asked = CampbellRequest {
        rotor: Some("shaft".into()),
        ..request(&speeds, &[])
    };
    let found = whirl_of(&scene, folder.path(), &asked).unwrap();
    for (point, expected) in found.points.iter().zip(data["hertz"].as_array().unwrap()) {
        let across = point
            .modes
            .iter()
            .filter(|mode| mode.whirl == Whirl::Across);
        let across: Vec<f64> = across.map(|mode| mode.frequency).collect();
        for (found, expected) in across.iter().zip(numbers(expected)) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        }
    }
    let asked = CampbellRequest {
        orders: vec![1.0, -1.0],
        speeds: grid,
        ..asked
    };
    let found = whirl_of(&scene, folder.path(), &asked).unwrap();
    for order in [1.0, -1.0] {
        let of_ross = data["criticals"].as_array().unwrap().iter();
        let expected: Vec<f64> = of_ross
            .filter(|one| one["order"].as_f64() == Some(order))
            .map(|one| one["rpm"].as_f64().unwrap())
            .collect();
        let ours = found.criticals.iter().filter(|one| one.order == order);
        let ours: Vec<f64> = ours.map(|one| one.speed / rpm).collect();
        assert!(expected.len() >= 3);
        for (found, expected) in ours.iter().zip(&expected) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{ours:?} {expected}");
        }
    }
}

#[test]
fn what_is_no_rotor_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let asked = request(&[100.0, 200.0], &[1.0]);
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut scene = rigid(0.01);
        change(&mut scene);
        whirl_of(&scene, folder.path(), &asked).unwrap_err()
    };
    let unlike = refused(&|scene| {
        scene["springs"]["left"]["bushing"]["translation"] = json!([2e5, 3e5, 1e5]);
    });
    assert!(
        unlike.contains("aren't alike in all directions"),
        "{unlike}"
    );
    let still = refused(&|scene| scene["bodies"]["rotor"]["angular_velocity"] = json!([0, 0, 0]));
    assert!(still.contains("angular_velocity: is zero"), "{still}");
    let stator = refused(&|scene| {
        scene["bodies"]["stator"] =
            json!({"rigid": {"mass": 1, "inertia": [1, 1, 1], "points": {"p": [0, 0, 0]}}});
    });
    assert!(
        stator.contains("all bodies have to spin as one"),
        "{stator}"
    );
    let moving = refused(&|scene| scene["bodies"]["rotor"]["velocity"] = json!([1, 0, 0]));
    assert!(moving.contains("isn't that of a turn"), "{moving}");
    let mut scene = rigid(0.01);
    scene["gravity"] = json!([0, -9.81, 0]);
    let unknown = CampbellRequest {
        rotor: Some("rotr".into()),
        ..asked
    };
    let error = whirl_of(&scene, folder.path(), &unknown).unwrap_err();
    assert!(error.contains("there is no body \"rotr\""), "{error}");
}
