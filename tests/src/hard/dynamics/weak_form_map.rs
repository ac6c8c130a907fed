//! Where the paper's weak form survives: a grid of steps, spectral radii and numbers of modes on the slider-crank of the literature, what
//! h σ_min > 2 √3 (1 + ρ)/(1 - ρ) says of it.

use dcb_formats::scene::Scheme;
use dcb_runtime::Compatibility;
use dcb_runtime::integrator::Method;
use dcb_runtime::watch::compatibility_window::WeakWindow;
use serde_json::{Value, json};

use crate::hard::case::{Bounded, HardCase};
use crate::hard::dynamics::step_rules;
use crate::hard::dynamics::steps::patient;
use crate::pages::raw_lines;
use crate::rod::reduced::{Benchmark, ReducedRod};

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
