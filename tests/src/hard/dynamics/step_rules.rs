//! What the step, the spectral radius and the level of the constraints do to the error of the slider-crank's deflection: the measured rules
//! of `docs/stability.md`.

use std::time::Instant;

use dcb_runtime::integrator::Method;
use dcb_runtime::simulation::Simulation;
use serde_json::{Value, json};

use crate::mechanism::{method, run, stabilized};
use crate::pages::{rows, table, text};
use crate::rod::corotated::CorotatedSliderCrank;
use crate::rod::deflection::{apart, history, reference_history};
use crate::rod::reduced::{Benchmark, ReducedRod};

/// Steps a revolution that the errors of long steps are looked at with; they divide 360, or are a multiple of it.
pub const STEPS: [usize; 10] = [5, 10, 20, 40, 60, 90, 120, 180, 360, 720];

/// Two revolutions at one step.
#[derive(Clone, Debug)]
pub struct StepFinding {
    /// Steps a revolution.
    pub steps: usize,
    /// Steps in a period of the rod's first mode, free from its joints.
    pub per_period: f64,
    /// Largest error of the deflection, by its largest value, as far as it went.
    pub error: f64,
    /// The error that stopped it, or what was told.
    pub said: Option<String>,
}

fn started(rod: &ReducedRod, method: Method) -> Simulation {
    let mechanism = rod.mechanism();
    mechanism.start(&mechanism.rigid_start(), method)
}

/// Deflections of the classical equations at multiples of an interval, from zero on, in steps of at most `step`.
pub fn classical(
    rod: &ReducedRod,
    equations: &CorotatedSliderCrank,
    interval: f64,
    count: usize,
    step: f64,
) -> Vec<f64> {
    let start = rod.mechanism().rigid_start();
    let n = equations.rod.stiffness.nrows();
    let zeros = vec![0.0; n];
    let mut motion = equations.start(&zeros, &zeros, start.spin);
    let parts = (interval / step).ceil() as usize;
    let mut deflections = vec![0.0];
    for _ in 0..count {
        equations.advance(&mut motion, interval / parts as f64, parts);
        deflections.push(rod.deflection(motion.position.rows(3, n).as_slice()));
    }
    deflections
}

/// 5 modes, ρ 0.8, two revolutions at each of these steps against the classical equations with all modes.
pub fn step_findings(steps: &[usize]) -> Vec<StepFinding> {
    let whole = ReducedRod::new(Benchmark::first(), 4, 12);
    let expected = classical(
        &whole,
        &whole.classical(),
        whole.revolution() / 360.0,
        720,
        whole.revolution() / 7200.0,
    );
    let find = |steps: &usize| step_finding(*steps, &expected);
    steps.iter().map(find).collect()
}

fn step_finding(steps: usize, expected: &[f64]) -> StepFinding {
    let rod = ReducedRod::new(Benchmark::first(), 4, 5);
    let mut simulation = started(&rod, method(0.8));
    let step = rod.revolution() / steps as f64;
    let (mut found, mut exact) = (vec![0.0], vec![0.0]);
    let mut said = None;
    for index in 1..=2 * steps {
        if let Err(error) = simulation.step(step) {
            said = Some(error.to_string());
            break;
        }
        if (index * 360) % steps == 0 {
            found.push(rod.deflection_in(&mut simulation));
            exact.push(expected[index * 360 / steps]);
        }
    }
    let told = simulation.resolution().told().into_iter().next();
    if let (Some(told), None) = (told, &said) {
        said = Some(format!(
            "{:?} with {:.1} steps in a period",
            told.part, told.steps_per_period
        ));
    }
    StepFinding {
        steps,
        per_period: std::f64::consts::TAU / (rod.body.stiffness[0].sqrt() * step),
        error: apart(&found, &exact),
        said,
    }
}

/// The raw lines.
pub fn lines() -> Vec<Value> {
    let steps = step_findings(&STEPS).into_iter().map(|finding| {
        json!({
            "kind": "step", "steps": finding.steps, "per_period": finding.per_period, "error": finding.error, "said": finding.said,
        })
    });
    let mut lines: Vec<Value> = steps.collect();
    for radius in [0.9, 0.8, 0.5, 0.0] {
        for steps in [360, 1440, 7200] {
            let rod = ReducedRod::new(Benchmark::first(), 4, 8);
            let error = apart(&history(&rod, method(radius), steps), &reference_history(4));
            lines.push(json!({"kind": "damping", "rho": radius, "steps": steps, "error": error}));
        }
    }
    for (name, of) in [
        ("index 3", method as fn(f64) -> Method),
        ("stabilized index 2", stabilized as fn(f64) -> Method),
    ] {
        for steps in [720, 3600] {
            let rod = ReducedRod::new(Benchmark::first(), 4, 5);
            let error = apart(&history(&rod, of(0.8), steps), &reference_history(4));
            let mut simulation = started(&rod, of(0.8));
            let clock = Instant::now();
            run(&mut simulation, 2.0 * rod.revolution(), 2 * steps, |_| {});
            let seconds = clock.elapsed().as_secs_f64();
            let (made, effort) = simulation.effort();
            simulation.refresh();
            let open = velocity_misfit(&mut simulation);
            lines.push(json!({
                "kind": "formulation", "formulation": name, "steps": steps, "error": error, "velocity_misfit": open,
                "iterations": effort.iterations as f64 / made as f64, "microseconds": 1e6 * seconds / made as f64,
            }));
        }
    }
    lines
}

/// The largest velocity at which a joint opens, m/s.
fn velocity_misfit(simulation: &mut Simulation) -> f64 {
    let (system, state) = (simulation.system().clone(), simulation.state().clone());
    let evaluation = simulation.refresh();
    let defects =
        (0..system.rows.len()).filter_map(|row| evaluation.velocity_defect(&system, &state, row));
    defects.fold(0.0, |most: f64, defect| most.max(defect.abs()))
}

/// The tables of the page.
pub fn render(lines: &[Value]) -> String {
    let of =
        |kind: &str| -> Vec<&Value> { lines.iter().filter(|line| line["kind"] == kind).collect() };
    let short = |line: &Value, key: &str| {
        line[key]
            .as_f64()
            .map_or("-".to_owned(), |value| format!("{value:.1e}"))
    };
    let mut page = "\n**Step.** 5 modes, ρ 0.8, two revolutions; error of the deflection by its largest value, as far as the run went.\n\n".to_owned();
    page += &table(
        &[
            "steps a revolution",
            "steps in a period of the first mode",
            "error",
            "what is said",
        ],
        &rows(&of("step"), |line| {
            vec![
                line["steps"].to_string(),
                format!("{:.1}", line["per_period"].as_f64().expect("a number")),
                short(line, "error"),
                line["said"].as_str().unwrap_or("").to_owned(),
            ]
        }),
    );
    page += "\n**Spectral radius.** 8 modes, two revolutions; the same error at 360, 1440 and 7200 steps a revolution.\n\n";
    let damping: Vec<Vec<String>> = of("damping")
        .chunks(3)
        .map(|lines| {
            let mut row = vec![lines[0]["rho"].to_string()];
            row.extend(lines.iter().map(|line| short(line, "error")));
            row
        })
        .collect();
    page += &table(&["ρ", "360", "1440", "7200"], &damping);
    page += "\n**Level of the constraints.** 5 modes, ρ 0.8, two revolutions.\n\n";
    page += &table(
        &[
            "formulation",
            "steps a revolution",
            "error",
            "joints open at [m/s]",
            "iterations a step",
            "µs a step",
        ],
        &rows(&of("formulation"), |line| {
            vec![
                text(line, "formulation"),
                line["steps"].to_string(),
                short(line, "error"),
                short(line, "velocity_misfit"),
                format!("{:.2}", line["iterations"].as_f64().expect("a number")),
                format!("{:.0}", line["microseconds"].as_f64().expect("a number")),
            ]
        }),
    );
    page
}
