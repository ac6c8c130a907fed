//! Texts of a run on the terminal: the scene that was loaded, and the results.

use std::fmt::Write as _;
use std::path::Path;

use dcb_demand::pruning::Pruning;
use dcb_formats::results::frequency_unit;
use dcb_formats::scene::Scene;
use dcb_runtime::model::Model;
use dcb_runtime::run::{ModesReport, Report, RunReport, stiffened};

use crate::program::CommonArguments;
use crate::simulate::SceneArguments;

/// That something is left out, or with `--explain` what.
pub(super) fn told_of(pruning: &Pruning, arguments: &SceneArguments) -> String {
    match (arguments.explain, pruning.count()) {
        (true, _) => pruning.to_string(),
        (false, 0) => String::new(),
        (false, count) => format!(
            "leaves out what this scene does not need of its superelements ({count} item{}): changes the response of a body by {:.1e} at most, relative (--explain lists them, --model everything keeps all)\n",
            if count == 1 { "" } else { "s" },
            pruning.error()
        ),
    }
}

/// Text on the loaded scene.
pub(super) fn describe(scene: &Scene, model: &Model, common: &CommonArguments) -> String {
    let system = &model.system;
    let mut text = format!(
        "{} bod{}, {} degrees of freedom, {} constraint and spring rows, {} superelement file{}\n",
        system.bodies.len(),
        if system.bodies.len() == 1 { "y" } else { "ies" },
        system.dof_count(),
        system.rows.len(),
        model.files.len(),
        if model.files.len() == 1 { "" } else { "s" },
    );
    let stiffened: Vec<&str> = stiffened(model).collect();
    if !stiffened.is_empty() {
        let _ = writeln!(text, "with geometric stiffening: {}", stiffened.join(", "));
    }
    if common.verbose {
        for (name, body) in scene.bodies.keys().zip(&system.bodies) {
            let n = body.flexible.coordinate_count();
            let _ = writeln!(text, "  body {name:?}: {n} elastic coordinates");
        }
        for file in &model.files {
            let _ = writeln!(text, "  {} ({})", file.path.display(), file.digest);
            for warning in &file.warnings {
                let _ = writeln!(text, "    warned at reduction: {warning}");
            }
        }
    }
    text
}

/// Value found.
pub(super) fn told(report: &Report, path: &Path, scene: &Scene) -> String {
    let text = match report {
        Report::Transient(report) => return summary(report, path, scene),
        Report::Static(report) => format!(
            "at rest after {} iterations; the softest free direction has a frequency of {:.4e} {}\n",
            report.equilibrium.iterations,
            report.equilibrium.least_stiffness.sqrt() / std::f64::consts::TAU,
            frequency_unit(&scene.units)
        ),
        Report::Kinematic(report) => format!("{} times\n", report.times),
        Report::Modes(report) => modes_table(report, scene),
    };
    text + &last_line(path, report.is_complete())
}

/// Frequencies and damping.
fn modes_table(report: &ModesReport, scene: &Scene) -> String {
    let mut text = format!(
        "{} degrees of freedom, {} of them without stiffness\n{:>5} {:>18} {:>12} {:>12}\n",
        report.modes.dof_count,
        report.modes.rigid_count,
        "mode",
        format!("frequency [{}]", frequency_unit(&scene.units)),
        "damping",
        "growth"
    );
    for (index, mode) in report.modes.modes.iter().take(report.count).enumerate() {
        let _ = writeln!(
            text,
            "{:>5} {:>18.9} {:>12.5} {:>12.4e}",
            index + 1,
            mode.frequency(),
            // No minus before a zero.
            (1e5 * mode.damping_ratio()).round() / 1e5 + 0.0,
            mode.growth
        );
    }
    let unstable = report.modes.unstable().len();
    if unstable > 0 {
        let _ = writeln!(text, "{unstable} unstable: the growth is positive");
    }
    text
}

/// Text on a run over time.
fn summary(report: &RunReport, path: &Path, scene: &Scene) -> String {
    let steps = report.steps.max(1) as f64;
    let unit = &scene.units.time;
    let mut text = format!(
        "t = {:.6} {unit} after {} steps: {:.2} iterations and {:.2} factorizations a step, {:.1} us a step\n",
        report.time,
        report.steps,
        report.effort.iterations as f64 / steps,
        report.effort.factorizations as f64 / steps,
        1e6 * report.seconds / steps,
    );
    if let Some(share) = report.balance.share() {
        let _ = writeln!(
            text,
            "energy balance: largest defect {:.2e}, {share:.1e} of the largest energy stored or exchanged",
            report.balance.defect
        );
    }
    if let Some(profile) = &report.profile {
        let recording = (report.seconds - profile.total()).max(0.0);
        for (stage, seconds) in [
            ("predict", profile.predict),
            ("evaluate", profile.evaluate),
            ("factor", profile.factor),
            ("solve", profile.solve),
            ("correct", profile.correct),
            ("record and rest", recording),
        ] {
            let _ = writeln!(
                text,
                "  {stage:<16} {seconds:>9.4} s {:>5.1} %",
                100.0 * seconds / report.seconds.max(f64::MIN_POSITIVE)
            );
        }
    }
    text + &last_line(path, report.is_complete)
}

fn last_line(path: &Path, is_complete: bool) -> String {
    let state = if is_complete { "" } else { " (incomplete)" };
    format!("{}{state}\n", path.display())
}
