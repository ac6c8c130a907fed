//! The `simulate linearize SCENE.json` command: A, B, C and D about an operating point.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use dcb_export::linear_system::LinearFile;
use dcb_formats::linear_system::{LinearSystem, Pole, Variable};
use dcb_formats::output::check_output;
use dcb_formats::results::frequency_unit;
use dcb_formats::scene::Scene;
use dcb_formats::terminal::one_line;
use dcb_runtime::error::Error;
use dcb_runtime::run::refuse_inputs;
use dcb_runtime::{LinearRequest, OperatingPoint, linearize};

use crate::outcome::Outcome;
use crate::program::CommonArguments;
use crate::simulate::replace;
use crate::simulate::scene::{Watcher, watch_for_interruption};

/// Poles, inputs and outputs that are listed without --verbose.
const LISTED: usize = 12;

/// Options of a linearization.
#[derive(Debug, Args)]
pub struct LinearizeArguments {
    /// Scene.
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    /// Operating point: the start, a stable rest near it, or a time that a run reaches.
    #[arg(long, value_name = "initial|static|TIME", default_value = "initial", value_parser = operating_point, allow_hyphen_values = true)]
    at: OperatingPoint,
    /// File; its ending says what it is: .h5, .npz or .mat [default: SCENE.linear.h5].
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing one.
    #[arg(long)]
    force: bool,
    /// Loads, components of loads as NAME/INDEX, and drives that are inputs [default: all that are declared as `input`, or all if none is].
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    inputs: Vec<String>,
    /// Outputs or recorded channels, for example reactions/JOINT [default: the scene's outputs].
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    outputs: Vec<String>,
    /// Number of states, by balanced truncation [default: all].
    #[arg(long, value_name = "N")]
    order: Option<usize>,
}

fn operating_point(text: &str) -> Result<OperatingPoint, String> {
    match text {
        "initial" => Ok(OperatingPoint::Initial),
        "static" => Ok(OperatingPoint::Static),
        number => match number.parse::<f64>() {
            Ok(time) if time >= 0.0 && time.is_finite() => Ok(OperatingPoint::Time(time)),
            _ => Err("expected `initial`, `static` or a time from zero on".to_owned()),
        },
    }
}

pub fn run(arguments: &LinearizeArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let path = &arguments.scene;
    let default = path.with_extension("linear.h5");
    let target = arguments.output.as_ref().unwrap_or(&default);
    let (kind, replace) = (LinearFile::of(target)?, replace(arguments.force));
    let scene = Scene::read(path)?;
    check_output(target, replace)?;
    refuse_inputs(target, [path.as_path()], "the scene")?;
    let superelements: Vec<PathBuf> = (scene.superelements())
        .map(|(_, of)| scene.resolve(&of.file))
        .collect();
    let superelements = superelements.iter().map(PathBuf::as_path);
    refuse_inputs(target, superelements, "a superelement of the scene")?;
    watch_for_interruption();
    let request = LinearRequest {
        inputs: arguments.inputs.clone(),
        outputs: arguments.outputs.clone(),
        order: arguments.order,
    };
    let mut watcher = Watcher::new(common);
    let found = linearize(&scene, arguments.at, &request, &mut watcher);
    watcher.finish();
    let Some(system) = found.map_err(|error| error.in_file(path))? else {
        return Ok(Outcome::interrupted(
            "stopped before the operating point, nothing was written\n".to_owned(),
        ));
    };
    for note in notes(&system, arguments.at) {
        common.told().say("note", &note);
    }
    kind.write(&system, target, replace)?;
    let told = described(&system, &scene, common) + &format!("{}\n", target.display());
    Ok(Outcome::done(told))
}

/// What a user can do something about.
fn notes(system: &LinearSystem, at: OperatingPoint) -> Vec<String> {
    let mut notes = Vec::new();
    if !system.is_equilibrium {
        notes.push(match at {
            OperatingPoint::Static => return notes,
            OperatingPoint::Initial | OperatingPoint::Time(_) => {
                "the mechanism moves here: the system is that of this instant, for deviations from its motion, and world axes turn against bodies that spin; --at static finds a rest nearby".to_owned()
            }
        });
    }
    let unstable = system
        .poles
        .iter()
        .filter(|pole| pole.is_unstable())
        .count();
    if unstable > 0 && system.is_equilibrium && at != OperatingPoint::Static {
        notes.push(format!(
            "{unstable} poles are unstable: this rest isn't one that the mechanism stays in; --at static finds a stable one nearby"
        ));
    }
    notes
}

/// Poles, inputs and outputs.
fn described(system: &LinearSystem, scene: &Scene, common: &CommonArguments) -> String {
    let unit = frequency_unit(&scene.units);
    let mut text = format!(
        "{} states, {} inputs, {} outputs at t = {} {}\n",
        system.order(),
        system.inputs.len(),
        system.outputs.len(),
        system.time,
        scene.units.time
    );
    let most = if common.verbose { usize::MAX } else { LISTED };
    list_poles(&mut text, &system.poles, &unit, &scene.units.time, most);
    list(&mut text, "inputs", "u0", &system.inputs, most);
    list(&mut text, "outputs", "y0", &system.outputs, most);
    if let Some(truncation) = &system.truncation {
        // Writing to a string doesn't fail.
        let _ = writeln!(
            text,
            "truncated from {} states, of which {} don't decay and are kept; error at any frequency at most {:.2e} (inputs and outputs scaled, largest Hankel singular value 1)",
            truncation.full_order, truncation.kept_apart, truncation.bound
        );
        if system.inputs.len() * system.outputs.len() <= LISTED {
            for (i, output) in system.outputs.iter().enumerate() {
                for (j, input) in system.inputs.iter().enumerate() {
                    let _ = writeln!(
                        text,
                        "  {} by {}: at most {:.2e} {}",
                        one_line(&output.name),
                        one_line(&input.name),
                        truncation.bounds[(i, j)],
                        quotient(output, input)
                    );
                }
            }
        }
    }
    text
}

fn quotient(output: &Variable, input: &Variable) -> String {
    format!("({})/({})", output.unit, input.unit)
}

/// One line for each pole or pair.
fn list_poles(text: &mut String, poles: &[Pole], unit: &str, time: &str, most: usize) {
    let _ = writeln!(
        text,
        "{:>18} {:>18} {:>12} {:>14}",
        format!("frequency [{unit}]"),
        format!("[rad/{time}]"),
        "damping",
        format!("growth [1/{time}]")
    );
    let single = || poles.iter().filter(|pole| pole.angular_frequency >= 0.0);
    for pole in single().take(most) {
        let _ = writeln!(
            text,
            "{:>18.9} {:>18.9} {:>12.5} {:>14.4e}{}",
            pole.frequency(),
            std::f64::consts::TAU * pole.frequency(),
            // No minus before a zero.
            (1e5 * pole.damping_ratio()).round() / 1e5 + 0.0,
            pole.growth,
            if pole.is_unstable() { "  unstable" } else { "" }
        );
    }
    let more = single().count().saturating_sub(most);
    if more > 0 {
        let _ = writeln!(text, "{:>18} {more} more (--verbose lists all)", "…");
    }
    let hidden = single()
        .skip(most)
        .filter(|pole| pole.is_unstable())
        .count();
    if hidden > 0 {
        let _ = writeln!(text, "{:>18} {hidden} of them unstable", "");
    }
}

fn list(text: &mut String, title: &str, value: &str, of: &[Variable], most: usize) {
    let _ = writeln!(text, "{title}");
    for variable in of.iter().take(most) {
        let line = format!(
            "{} [{}], {value} = {}",
            variable.name, variable.unit, variable.at
        );
        let _ = writeln!(text, "  {}", one_line(&line));
    }
    if of.len() > most {
        let _ = writeln!(text, "  … {} more", of.len() - most);
    }
}
