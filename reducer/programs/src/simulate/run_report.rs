//! Texts of a run on the terminal: the scene that was loaded, and the results.

use std::fmt::Write as _;
use std::path::Path;

use dcb_demand::pruning::Pruning;
use dcb_formats::component::Units;
use dcb_formats::results::{Results, frequency_unit};
use dcb_formats::scene::Scene;
use dcb_formats::units::{DerivedUnits, four_digits};
use dcb_runtime::analysis::effective_damping::{DampedPart, EffectiveDamping};
use dcb_runtime::error::Error;
use dcb_runtime::frequency::{FrequencyReport, RandomOutput, Solution};
use dcb_runtime::model::Model;
use dcb_runtime::run::{ModesReport, Report, RunReport, stiffened};

use crate::program::{CommonArguments, Detail};
use crate::simulate::SceneArguments;
use crate::simulate::show::last_values;

/// Outputs below this part of the largest of their unit are rounding.
const NEGLIGIBLE: f64 = 1e-9;

/// That something is left out, or with `--explain` what.
pub(super) fn told_of(pruning: &Pruning, arguments: &SceneArguments) -> String {
    match (arguments.explain, pruning.summary()) {
        (true, _) => pruning.to_string(),
        (false, None) => String::new(),
        (false, Some(summary)) => {
            format!("{summary} (--explain lists them, --model everything keeps all)\n")
        }
    }
}

/// Text on the loaded scene.
pub(super) fn describe(scene: &Scene, model: &Model, common: &CommonArguments) -> String {
    let system = &model.system;
    let mut text = format!(
        "{} bod{}, {} degrees of freedom before their joints, {} constraint and spring rows, {} superelement file{}\n",
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

/// What a run is told of: what it found, and how.
pub(super) struct Told<'a> {
    pub report: &'a Report,
    /// File of the results.
    pub path: &'a Path,
    pub scene: &'a Scene,
    /// How many notes were told.
    pub notes: usize,
    pub detail: Detail,
}

impl Told<'_> {
    /// The verdict, what was loaded, and the values found; the file last.
    ///
    /// # Errors
    /// Those of reading the results.
    pub(super) fn text(&self, loaded: &str) -> Result<String, Error> {
        let scene = self.scene;
        let notes = match self.notes {
            0 => String::new(),
            1 => "; 1 note".to_owned(),
            count => format!("; {count} notes"),
        };
        let (verdict, rest) = match self.report {
            Report::Transient(report) => (
                verdict(report, &scene.units.time),
                effort(report, &scene.units, self.detail),
            ),
            Report::Static(report) => {
                let softest = report.equilibrium.least_stiffness.sqrt() / std::f64::consts::TAU;
                let found = format!(
                    "done: at rest after {} iterations; the softest motion has a frequency of {} {}",
                    report.equilibrium.iterations,
                    four_digits(softest),
                    frequency_unit(&scene.units)
                );
                (found, last_values(&Results::open(self.path)?)?)
            }
            Report::InertiaRelief(report) => {
                let s = if report.free_count == 1 { "" } else { "s" };
                let found = format!(
                    "done: at rest in the frame that the loads accelerate along {} motion{s} without stiffness, after {} iterations",
                    report.free_count, report.iterations
                );
                (found, last_values(&Results::open(self.path)?)?)
            }
            Report::Kinematic(report) => (
                format!("done: positions at {} times", report.times),
                String::new(),
            ),
            Report::Modes(report) => (modes_verdict(report, scene), modes_table(report, scene)),
            Report::Frequency(report) => (
                frequency_verdict(report, scene),
                frequency_table(report, scene),
            ),
        };
        let state = match self.report.is_complete() {
            true => "",
            false => " (incomplete)",
        };
        Ok(format!(
            "{verdict}{notes}\n{loaded}{rest}{}{state}\n",
            self.path.display()
        ))
    }
}

/// How many modes, and the first of them.
fn modes_verdict(report: &ModesReport, scene: &Scene) -> String {
    let unit = frequency_unit(&scene.units);
    let count = report.modes.modes.len().min(report.count);
    let first = (report.modes.modes.iter())
        .map(|mode| mode.frequency())
        .find(|frequency| *frequency > 0.0);
    let first = first.map_or(String::new(), |frequency| {
        format!(
            ", the first oscillation at {} {unit}",
            four_digits(frequency)
        )
    });
    let unstable = match report.modes.unstable().len() {
        0 => String::new(),
        count => format!("; {count} unstable"),
    };
    format!("done: {count} modes{first}{unstable}")
}

/// How many frequencies, and how they were solved.
fn frequency_verdict(report: &FrequencyReport, scene: &Scene) -> String {
    let frequencies = &report.responses.frequency;
    let (first, last) = (frequencies.first(), frequencies.last());
    let range = match (first, last) {
        (Some(first), Some(last)) => format!(
            " from {} to {} {}",
            four_digits(*first),
            four_digits(*last),
            frequency_unit(&scene.units)
        ),
        _ => String::new(),
    };
    let how = match report.solution {
        Solution::Modes => "by modes",
        Solution::ComplexModes => "by complex modes, because damping couples the real ones",
        Solution::Direct => "each solved directly",
    };
    format!(
        "done: {} outputs by {} inputs at {} frequencies{range}, {how}",
        report.responses.outputs.len(),
        report.responses.inputs.len(),
        frequencies.len()
    )
}

/// Peaks, and outputs under random inputs.
fn frequency_table(report: &FrequencyReport, scene: &Scene) -> String {
    let unit = frequency_unit(&scene.units);
    let mut text = format!(
        "{} degrees of freedom left by the joints\n",
        report.freedoms
    );
    if !report.peaks.is_empty() {
        let _ = writeln!(
            text,
            "{:>14} {:>13} {:>8} {:>9} {:>9}   response",
            format!("peak at [{unit}]"),
            "amplitude",
            "phase",
            "damping",
            "error"
        );
    }
    for peak in &report.peaks {
        let damping = peak
            .damping
            .map_or("-".to_owned(), |ratio| format!("{ratio:.5}"));
        let error = told_error(peak.error);
        let _ = writeln!(
            text,
            "{:>14.6} {:>13.5e} {:>7.1}° {damping:>9} {error:>9}   {} by {} [{}]",
            peak.frequency, peak.amplitude, peak.phase, peak.output, peak.input, peak.unit
        );
        if !peak.paths.is_empty() {
            let parts = peak.paths.iter();
            let parts: Vec<String> = parts
                .map(|(name, part)| format!("{name} {}", percent(*part)))
                .collect();
            let _ = writeln!(text, "{:>14} of it: {}", "", parts.join(", "));
        }
    }
    if !report.random.is_empty() {
        let _ = writeln!(
            text,
            "{:>13} {:>22} {:>9}   output under the random inputs",
            "rms",
            format!("zero crossings [{unit}]"),
            "error"
        );
    }
    // What rounding makes of outputs that don't move is left to the files.
    let largest = |unit: &str| {
        let alike = report.random.iter().filter(|output| output.unit == unit);
        alike.map(|output| output.rms).fold(0.0, f64::max)
    };
    let moving = |output: &&RandomOutput| output.rms > NEGLIGIBLE * largest(&output.unit);
    for output in report.random.iter().filter(moving) {
        let error = told_error(output.error);
        let _ = writeln!(
            text,
            "{:>13.5e} {:>22.5} {error:>9}   {} [{}]",
            output.rms, output.zero_crossings, output.name, output.unit
        );
    }
    text.push_str(&damping_table(&report.damping, scene));
    text
}

/// Frequencies and damping.
fn modes_table(report: &ModesReport, scene: &Scene) -> String {
    let mut text = format!(
        "{} degrees of freedom left by the joints, {} of them without stiffness\n{:>5} {:>18} {:>18} {:>12} {:>12}\n",
        report.modes.dof_count,
        report.modes.rigid_count,
        "mode",
        format!("frequency [{}]", frequency_unit(&scene.units)),
        format!("[rad/{}]", scene.units.time),
        "damping",
        "growth"
    );
    for (index, mode) in report.modes.modes.iter().take(report.count).enumerate() {
        let _ = writeln!(
            text,
            "{:>5} {:>18.9} {:>18.9} {:>12.5} {:>12.4e}",
            index + 1,
            mode.frequency(),
            std::f64::consts::TAU * mode.frequency(),
            // No minus before a zero.
            (1e5 * mode.damping_ratio()).round() / 1e5 + 0.0,
            mode.growth
        );
    }
    let unstable = report.modes.unstable().len();
    if unstable > 0 {
        let _ = writeln!(text, "{unstable} unstable: the growth is positive");
    }
    text.push_str(&damping_table(&report.damping, scene));
    text
}

/// Ratios to critical below this are rounding.
const NO_DAMPING: f64 = 1e-10;
/// Parts that have a column of their own.
const MOST_PARTS: usize = 6;

/// What each part has of the damping of each mode; nothing where nothing damps.
fn damping_table(modes: &[EffectiveDamping], scene: &Scene) -> String {
    let Some(first) = modes.first() else {
        return String::new();
    };
    let largest = |part: usize| {
        let ratios = modes.iter().map(|mode| mode.shares[part].ratio.abs());
        ratios.fold(0.0, f64::max)
    };
    let mut parts: Vec<usize> = (0..first.shares.len())
        .filter(|part| largest(*part) > 0.0)
        .collect();
    if parts.is_empty() {
        return String::new();
    }
    parts.sort_by(|a, b| largest(*b).total_cmp(&largest(*a)));
    let others = parts.split_off(parts.len().min(MOST_PARTS));
    parts.sort_unstable();
    let mut text = format!(
        "damping of the undamped modes at rest, ratio to critical, and what each part has of it\n{:>18} {:>12}",
        format!("frequency [{}]", frequency_unit(&scene.units)),
        "damping",
    );
    let title = |part: usize| match first.shares[part].part {
        DampedPart::AssembledModes => "assembled",
        DampedPart::LossFactor => "loss factor",
        _ => first.shares[part].name.as_str(),
    };
    for part in &parts {
        let _ = write!(text, " {:>12}", title(*part));
    }
    if !others.is_empty() {
        let _ = write!(text, " {:>12}", "others");
    }
    text.push('\n');
    for mode in modes {
        let _ = write!(text, "{:>18.9} {:>12}", mode.frequency, ratio(mode.ratio));
        for part in &parts {
            let _ = write!(text, " {:>12}", ratio(mode.shares[*part].ratio));
        }
        if !others.is_empty() {
            let rest: f64 = others.iter().map(|part| mode.shares[*part].ratio).sum();
            let _ = write!(text, " {:>12}", ratio(rest));
        }
        text.push('\n');
    }
    text
}

/// One line: how far a run over time came, and how well its energy balance closes.
fn verdict(report: &RunReport, time: &str) -> String {
    let word = match report.is_complete {
        true => "done",
        false => "stopped",
    };
    let balance = report.balance.share().map_or(String::new(), |share| {
        format!("; energy balance closes to {share:.1e} of the largest energy")
    });
    format!(
        "{word}: {} {time} in {} steps{balance}",
        short(report.time),
        report.steps
    )
}

/// A ratio to critical; zero where it is rounding.
fn ratio(of: f64) -> String {
    match of.abs() < NO_DAMPING {
        true => "0".to_owned(),
        false => format!("{of:.4e}"),
    }
}

/// A relative error, or a dash where it isn't known.
fn told_error(error: Option<f64>) -> String {
    error.map_or("-".to_owned(), |error| format!("{error:.1e}"))
}

/// To a tenth of a percent, without the sign of what rounds to nothing.
fn percent(part: f64) -> String {
    let tenths = (1e3 * part).round() + 0.0;
    format!("{:.1} %", tenths / 10.0)
}

/// A time without digits that say nothing.
fn short(value: f64) -> String {
    let text = format!("{value:.6}");
    match value.abs() < 1e-3 && value != 0.0 {
        true => format!("{value:.4e}"),
        false => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
    }
}

/// Effort of a run over time: counts where tables are wanted, times of stages where they were measured.
fn effort(report: &RunReport, units: &Units, detail: Detail) -> String {
    let steps = report.steps.max(1) as f64;
    let mut text = String::new();
    if detail == Detail::Tables {
        let _ = writeln!(
            text,
            "{:.2} iterations and {:.2} factorizations a step, {:.1} us a step",
            report.effort.iterations as f64 / steps,
            report.effort.factorizations as f64 / steps,
            1e6 * report.seconds / steps,
        );
        let energy = DerivedUnits::of(&units.length, &units.mass, &units.time).energy;
        let _ = writeln!(
            text,
            "largest defect of the energy balance {:.2e} {energy}, largest energy {:.2e} {energy}",
            report.balance.defect, report.balance.largest
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
    text
}
