//! Where the paper's weak form survives: a grid of steps, spectral radii and numbers of modes on the slider-crank of the literature, what
//! h σ_min > 2 √3 (1 + ρ)/(1 - ρ) says of it, and the table and picture of `docs/stability.md`.

use std::path::Path;

use dcb_formats::output::Replace;
use dcb_formats::scene::Scheme;
use dcb_runtime::Compatibility;
use dcb_runtime::export::picture::{Axis, Chart, Series, Style, write_svg};
use dcb_runtime::integrator::Method;
use dcb_runtime::watch::compatibility_window::WeakWindow;
use serde_json::{Value, json};

use crate::hard::case::{Bounded, HardCase};
use crate::hard::dynamics::step_rules;
use crate::hard::dynamics::steps::patient;
use crate::pages::accuracy::{machine, table};
use crate::raw_lines::raw_lines;
use crate::rod::reduced::{Benchmark, ReducedRod};

/// The generated part of `docs/stability.md` stands between these lines.
pub const MARKERS: [&str; 2] = [
    "<!-- generated from data/weak_form_map.jsonl -->\n",
    "<!-- end of the generated map -->\n",
];

/// The second generated part stands between these.
pub const RULE_MARKERS: [&str; 2] = [
    "<!-- rules from data/weak_form_map.jsonl -->\n",
    "<!-- end of the generated rules -->\n",
];

/// A deflection of the rod's middle beyond this part of its length is no motion of the mechanism, whose largest is 0.019.
const DIVERGED: f64 = 1.0;
/// Cells down to this part of the limit can survive: μ is somewhat above σ_min, and half damped it grows slowly.
const MARGIN: f64 = 0.5;

/// Steps, spectral radii and modes to look at.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Steps a revolution.
    pub steps: &'static [usize],
    /// Spectral radii.
    pub radii: &'static [f64],
    /// Modes of the rod of four elements, which has 12.
    pub modes: &'static [usize],
    /// Revolutions that a cell runs, but no more than `most` steps.
    pub revolutions: usize,
    /// Most steps of a cell.
    pub most: usize,
}

/// What the default tests look at.
pub const COARSE: Grid = Grid {
    steps: &[50, 100, 500, 2000, 10_000],
    radii: &[0.9, 0.8, 0.5, 0.0],
    modes: &[0, 2, 5, 8, 12],
    revolutions: 4,
    most: 2000,
};

/// What `docs/data/weak_form_map.jsonl` has.
pub const FULL: Grid = Grid {
    steps: &[
        50, 72, 100, 150, 200, 360, 500, 1000, 2000, 5000, 10_000, 20_000, 50_000,
    ],
    radii: &[0.9, 0.8, 0.5, 0.0],
    modes: &[0, 1, 2, 3, 5, 8, 12],
    revolutions: 20,
    most: 20_000,
};

/// One cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Steps a revolution.
    pub steps: usize,
    /// ρ.
    pub radius: f64,
    /// Modes.
    pub modes: usize,
    /// h σ_min over the smallest that is damped; infinite where nothing grows.
    pub ratio: f64,
    /// Steps that it was to run.
    pub asked: usize,
    /// Steps after which it failed; `asked` if it didn't.
    pub survived: usize,
}

impl Cell {
    /// Whether it ran to its end.
    pub fn is_stable(&self) -> bool {
        self.survived == self.asked
    }

    /// Whether the criterion says that it does.
    pub fn is_allowed(&self) -> bool {
        self.ratio > 1.0
    }

    /// Whether it contradicts the criterion, which is sharp but for a margin on the safe side.
    pub fn contradicts(&self) -> bool {
        match (self.is_allowed(), self.is_stable()) {
            (true, stable) => !stable,
            (false, stable) => stable && self.ratio < MARGIN,
        }
    }

    fn line(&self) -> Value {
        json!({
            "kind": "cell", "steps": self.steps, "rho": self.radius, "modes": self.modes,
            "ratio": self.ratio.is_finite().then_some(self.ratio), "asked": self.asked, "survived": self.survived,
        })
    }

    fn of_line(line: &Value) -> Self {
        let count = |key: &str| line[key].as_u64().expect(key) as usize;
        Self {
            steps: count("steps"),
            radius: line["rho"].as_f64().expect("rho"),
            modes: count("modes"),
            ratio: line["ratio"].as_f64().unwrap_or(f64::INFINITY),
            asked: count("asked"),
            survived: count("survived"),
        }
    }
}

/// Steps until a step fails or the rod's middle is beyond all measure; `most` if it never is.
pub fn survived(rod: &ReducedRod, method: Method, step: f64, most: usize) -> usize {
    let mechanism = rod.mechanism();
    let mut simulation = mechanism.start(&mechanism.rigid_start(), method);
    for index in 0..most {
        if simulation.step(step).is_err() {
            return index;
        }
        let deflection = rod.deflection_in(&mut simulation).abs();
        if deflection.is_nan() || deflection > DIVERGED {
            return index;
        }
    }
    most
}

/// All cells of a grid.
pub fn measure(grid: &Grid) -> Vec<Cell> {
    let benchmark = Benchmark::first();
    let mut cells = Vec::new();
    for &modes in grid.modes {
        let rod = ReducedRod::with(benchmark, 4, modes, Compatibility::Weak);
        let mechanism = rod.mechanism();
        for &radius in grid.radii {
            let simulation = mechanism.start(&mechanism.rigid_start(), patient(radius));
            let scheme = Scheme::generalized_alpha(radius);
            let window = WeakWindow::of(simulation.system(), simulation.state(), &scheme);
            let smallest = window.bodies[0].smallest_step;
            for &steps in grid.steps {
                let step = rod.revolution() / steps as f64;
                let asked = (grid.revolutions * steps).min(grid.most);
                cells.push(Cell {
                    steps,
                    radius,
                    modes,
                    ratio: step / smallest,
                    asked,
                    survived: survived(&rod, patient(radius), step, asked),
                });
            }
        }
    }
    cells
}

/// σ_min of the rod by modes, 1/s.
fn growths(grid: &Grid) -> Vec<Value> {
    let of = |modes: usize| {
        let rod = ReducedRod::with(Benchmark::first(), 4, modes, Compatibility::Weak);
        let mechanism = rod.mechanism();
        let simulation = mechanism.start(&mechanism.rigid_start(), patient(0.8));
        let scheme = Scheme::generalized_alpha(0.8);
        let window = WeakWindow::of(simulation.system(), simulation.state(), &scheme);
        let body = &window.bodies[0];
        json!({
            "kind": "growth", "modes": modes, "negative_eigenvalues": body.negative_eigenvalue_count,
            "sigma_min": body.sigma_min.is_finite().then_some(body.sigma_min),
            "first_omitted": rod.body.first_omitted_eigenvalue.is_finite().then(|| rod.body.first_omitted_eigenvalue.sqrt()),
        })
    };
    grid.modes.iter().map(|modes| of(*modes)).collect()
}

/// The raw lines, without the first, which is the machine's.
pub fn lines(grid: &Grid) -> Vec<Value> {
    let mut lines = growths(grid);
    lines.extend(measure(grid).iter().map(Cell::line));
    lines.extend(step_rules::lines());
    lines
}

/// The cells of raw lines.
pub fn cells(raw: &str) -> Vec<Cell> {
    let lines = raw_lines(raw);
    let cells = lines.iter().filter(|line| line["kind"] == "cell");
    cells.map(Cell::of_line).collect()
}

/// Everything between the markers.
pub fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let cells = cells(raw);
    let mut page = String::new();
    for line in lines.iter().filter(|line| line["kind"] == "machine") {
        page += &machine(line);
    }
    let wrong = cells
        .iter()
        .filter(|cell| cell.is_allowed() != cell.is_stable());
    let unsafe_ones = cells
        .iter()
        .filter(|cell| cell.is_allowed() && !cell.is_stable());
    let ratios: Vec<String> = wrong
        .clone()
        .map(|cell| format!("{:.2}", cell.ratio))
        .collect();
    page += &format!(
        "\n{} cells; the criterion says what happens in all but {}, of which {} are unstable where it says stable.{}\n",
        cells.len(),
        wrong.count(),
        unsafe_ones.count(),
        if ratios.is_empty() {
            String::new()
        } else {
            format!(
                " The others survive at {} of the smallest step.",
                ratios.join(", ")
            )
        }
    );
    page += "\nσ_min by modes, against the first frequency that the modes leave out:\n\n";
    let growth: Vec<Vec<String>> = lines
        .iter()
        .filter(|line| line["kind"] == "growth")
        .map(|line| {
            let number = |key: &str| {
                line[key]
                    .as_f64()
                    .map_or("-".to_owned(), |value| format!("{value:.0}"))
            };
            vec![
                line["modes"].to_string(),
                line["negative_eigenvalues"].to_string(),
                number("sigma_min"),
                number("first_omitted"),
            ]
        })
        .collect();
    page += &table(
        &[
            "modes",
            "negative eigenvalues",
            "σ_min [1/s]",
            "first left out [rad/s]",
        ],
        &growth,
    );
    for group in groups(&cells, |cell| cell.radius) {
        page += &format!(
            "\n**ρ = {}**: steps survived, `all` of those asked for; bold where the criterion allows the step.\n\n",
            group[0].radius
        );
        page += &survival_table(&group);
    }
    page + "\n![steps survived over the step by the smallest stable one](pictures/weak-form-map.svg)\n"
}

/// The second generated part: the measured rules.
pub fn render_rules(raw: &str) -> String {
    step_rules::render(&raw_lines(raw))
}

/// Cells with the same value of something, in the order of their appearance.
fn groups(cells: &[Cell], of: impl Fn(&Cell) -> f64) -> Vec<Vec<Cell>> {
    let mut groups: Vec<Vec<Cell>> = Vec::new();
    for cell in cells {
        match groups.iter_mut().find(|group| of(&group[0]) == of(cell)) {
            Some(group) => group.push(*cell),
            None => groups.push(vec![*cell]),
        }
    }
    groups
}

fn survival_table(cells: &[Cell]) -> String {
    let columns = groups(cells, |cell| cell.steps as f64);
    let mut titles = vec!["modes".to_owned()];
    titles.extend(columns.iter().map(|column| column[0].steps.to_string()));
    let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
    let rows: Vec<Vec<String>> = groups(cells, |cell| cell.modes as f64)
        .iter()
        .map(|row| {
            let shown = row.iter().map(|cell| {
                let survived = if cell.is_stable() {
                    "all".to_owned()
                } else {
                    cell.survived.to_string()
                };
                if cell.is_allowed() {
                    format!("**{survived}**")
                } else {
                    survived
                }
            });
            std::iter::once(row[0].modes.to_string())
                .chain(shown)
                .collect()
        })
        .collect();
    table(&titles, &rows)
}

/// Every cell in which something grows: steps survived over the step by the smallest stable one.
fn chart(raw: &str) -> Chart {
    let cells = cells(raw);
    let series = groups(&cells, |cell| cell.radius)
        .into_iter()
        .map(|group| Series {
            name: format!("ρ = {}", group[0].radius),
            points: group
                .iter()
                .filter(|cell| cell.ratio.is_finite())
                .map(|cell| [cell.ratio, cell.survived.max(1) as f64])
                .collect(),
            style: Style::Marks,
        })
        .collect();
    Chart {
        title: String::new(),
        horizontal: Axis::logarithmic("h σ_min (1 - ρ) / (2 √3 (1 + ρ))"),
        vertical: Axis::logarithmic("steps survived"),
        series,
        slopes: Vec::new(),
        notes: Vec::new(),
    }
}

/// Writes the picture into a folder.
pub fn write_picture(raw: &str, folder: &Path) {
    std::fs::create_dir_all(folder).expect("a folder");
    write_svg(
        &[chart(raw)],
        &folder.join("weak-form-map.svg"),
        Replace::Overwrite,
    )
    .expect("a picture");
}

/// The coarse grid as a hard case.
pub fn coarse_map() -> HardCase {
    let cells = measure(&COARSE);
    for cell in &cells {
        println!("{cell:?}");
    }
    let contradicting = cells.iter().filter(|cell| cell.contradicts()).count();
    let diverging = cells.iter().filter(|cell| !cell.is_stable()).count();
    assert!(diverging > cells.len() / 3);
    HardCase {
        group: "dynamics",
        name: "coarse_map",
        naive_method: "the paper's weak form on a grid of steps, ρ and modes",
        naive: format!("diverges in {diverging} of {} cells", cells.len()),
        ours: "refused where it diverges: cells that contradict h σ_min > 2 √3 (1 + ρ)/(1 - ρ)"
            .into(),
        error: Some(Bounded {
            found: contradicting as f64,
            bound: 0.0,
        }),
    }
}
