//! The gallery: every mechanism starts, does what its physics says, and makes a page with parts that bend.

use std::fs;

use crate::support::{Folder, stored};

struct Shown {
    folder: Folder,
    /// Time and recorded outputs of the last row.
    last: Vec<f64>,
    names: Vec<String>,
    largest: Vec<f64>,
    /// Standard error of the run.
    notes: String,
}

impl Shown {
    /// A scene of the gallery, as it is or to an earlier end.
    fn of(name: &str, options: &str) -> Self {
        let folder = Folder::empty();
        fs::create_dir_all(folder.path("gallery/parts")).unwrap();
        let gallery = stored("samples/gallery");
        for part in fs::read_dir(gallery.join("parts")).unwrap() {
            let part = part.unwrap();
            fs::copy(
                part.path(),
                folder.path("gallery/parts").join(part.file_name()),
            )
            .unwrap();
        }
        fs::create_dir(folder.path("gallery/scene")).unwrap();
        let scene = gallery.join(name).join("scene.json");
        fs::copy(scene, folder.path("gallery/scene/scene.json")).unwrap();
        let answer = folder.done(&format!(
            "gallery/scene/scene.json -o run.h5 --csv run.csv {options}"
        ));
        assert!(
            !answer.stderr.contains("frequency and phase"),
            "{}",
            answer.stderr
        );
        let table = folder.read("run.csv");
        let mut lines = table.lines();
        let names = lines
            .next()
            .unwrap()
            .split(',')
            .map(str::to_owned)
            .collect();
        let rows: Vec<Vec<f64>> = lines
            .map(|line| {
                line.split(',')
                    .map(|number| number.parse().unwrap())
                    .collect()
            })
            .collect();
        let largest = (0..rows[0].len())
            .map(|column| rows.iter().map(|row| row[column].abs()).fold(0.0, f64::max))
            .collect();
        let last = rows.last().unwrap().clone();
        folder.done("animate run.h5 --scene gallery/scene/scene.json");
        assert!(
            folder.read("run.html").contains("\"amplitudes\":{"),
            "{name}: nothing bends"
        );
        Self {
            folder,
            last,
            names,
            largest,
            notes: answer.stderr,
        }
    }

    fn column(&self, start: &str) -> usize {
        let found = self.names.iter().position(|name| name.starts_with(start));
        found.unwrap_or_else(|| panic!("{start} in {:?}", self.names))
    }

    fn last(&self, start: &str) -> f64 {
        self.last[self.column(start)]
    }

    fn largest(&self, start: &str) -> f64 {
        self.largest[self.column(start)]
    }
}

/// Two turns at 50 Hz end where they began; the stroke is that of the rigid triangle.
#[test]
fn a_slider_crank_comes_back() {
    let shown = Shown::of("slider-crank", "");
    assert!((shown.last("piston.x") - 0.23).abs() < 1e-4);
    assert!(shown.largest("piston.y").max(shown.largest("piston.z")) < 1e-9);
    assert!(shown.folder.path("run.html").is_file());
}

/// The tool ends where the joint angles put rigid arms, but for their sag.
#[test]
fn a_robot_reaches_its_goal() {
    let shown = Shown::of("robot", "");
    let (waist, shoulder, elbow) = (2.2_f64, 0.9_f64, 0.9_f64 - 1.4);
    let reach = 0.6 * shoulder.cos() + 0.56 * elbow.cos();
    let height = 0.4 + 0.6 * shoulder.sin() + 0.56 * elbow.sin();
    let found = [
        shown.last("tip.x"),
        shown.last("tip.y"),
        shown.last("tip.z"),
    ];
    let expected = [reach * waist.cos(), reach * waist.sin(), height];
    let off = (0..3)
        .map(|i| (found[i] - expected[i]).powi(2))
        .sum::<f64>()
        .sqrt();
    assert!(off < 5e-3, "{found:?} {expected:?}");
}

#[test]
fn a_wind_turbine_turns_its_blades() {
    let shown = Shown::of("wind-turbine", "--end 8");
    let (y, z) = (shown.last("tip.y"), shown.last("tip.z") - 30.0);
    assert!((y.hypot(z) - 21.0).abs() < 0.2, "{y} {z}");
    // The wind bends the blade down the wind.
    assert!(shown.largest("tip.x") > 0.02);
}

/// Energy is conserved, but for what the bars' damping takes, and the bars go through the places where they lie in line.
#[test]
fn a_double_four_bar_swings_through_its_singular_places() {
    let shown = Shown::of("double-four-bar", "--end 3");
    let lost = shown.last("energy.dissipated").abs();
    assert!(lost < 0.02 * 60.0, "{lost}");
    assert!(shown.largest("head.x") > 0.9);
}

/// The disc bends out most near the critical speed, which is passed before the end.
#[test]
fn a_rotor_passes_its_critical_speed() {
    let shown = Shown::of("rotor", "");
    let speed = shown.last("speed.z");
    assert!((speed - 400.0).abs() < 1.0, "{speed}");
    let (peak, end) = (
        shown.largest("disc.x"),
        shown.last("disc.x").hypot(shown.last("disc.y")),
    );
    assert!(peak > 2.0 * end, "{peak} {end}");
    // Nothing pulls along a shaft that spins about its own axis: the linear theory is right at any speed.
    assert!(
        !shown.notes.contains("of its first frequency"),
        "{}",
        shown.notes
    );
}

/// Eight stages of bars of 1 m at 45 degrees, less what they give way under the load.
#[test]
fn a_scissor_lift_rises() {
    let shown = Shown::of("scissor-lift", "");
    let rigid = 8.0 * std::f64::consts::FRAC_PI_4.sin();
    let height = shown.last("platform.y");
    assert!(height < rigid && height > 0.95 * rigid, "{height} {rigid}");
}

/// A fast gyroscope precesses at m g l/(I Ω): through 3.7 rad in 5 s or so, at its height.
#[test]
fn a_gyroscope_precesses() {
    let shown = Shown::of("gyroscope", "--end 1");
    let plate = 0.16 * 0.003 * 7850.0;
    let moment = (plate * 0.2 + 0.3 * 0.1) * 9.81;
    let spin = (plate * 0.16 / 6.0 + 2e-5) * 100.0;
    let expected = moment / spin;
    let angle = shown.last("hub.y").atan2(shown.last("hub.x"));
    assert!((angle / expected - 1.0).abs() < 0.1, "{angle} {expected}");
    assert!(shown.largest("hub.z") < 0.02);
}

/// Both pistons are at the ends of their strokes after full turns; gas forces turn the engine.
#[test]
fn an_engine_fires() {
    let shown = Shown::of("engine", "--end 0.06");
    // Three turns, at 50 a second.
    assert!((shown.last("piston_1.x") - 0.23).abs() < 2e-4);
    assert!((shown.last("piston_2.x") - 0.13).abs() < 2e-4);
    assert!(shown.largest("wrist_force.fx") > 5000.0);
}

/// The shipped crank with its controller: where friction lets it rest, beside its goal of -0.25 m.
#[test]
fn a_controlled_crank_comes_to_its_goal() {
    let folder = Folder::empty();
    for (name, to) in [
        ("slider-crank/rod.dcb.h5", "slider-crank"),
        ("controlled-crank/scene.json", "crank"),
    ] {
        fs::create_dir(folder.path(to)).unwrap();
        let file = name.rsplit_once('/').unwrap().1;
        fs::copy(stored("samples").join(name), folder.path(to).join(file)).unwrap();
    }
    folder.done("crank/scene.json -o run.h5");
    let way = folder.results_of("run.h5").history("way").unwrap();
    let end = way[(way.nrows() - 1, 0)];
    assert!((end + 0.25).abs() < 0.02, "{end}");
}
