//! `simulate init`: a scene of superelements in a chain, as a text with comments that runs as it stands.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use dcb_formats::Superelement;
use dcb_formats::component::Units;
use dcb_formats::dcb::read_superelement;
use dcb_formats::mesh::Dimension;
use dcb_formats::output::{check_output, write_stream};
use dcb_formats::superelement::InterfaceFrame;
use dcb_formats::units::si_factor;
use dcb_runtime::error::Error;
use dcb_runtime::run::refuse_inputs;
use pathdiff::diff_paths;
use serde_json::json;

use crate::outcome::Outcome;
use crate::simulate::replace;

/// Standard acceleration of free fall, m/s².
const GRAVITY: f64 = 9.81;
/// Steps in a period of a part's lowest mode.
const STEPS: f64 = 100.0;
/// Periods of the lowest mode, and swings of the chain, that the draft covers.
const PERIODS: f64 = 20.0;
/// Steps of the draft, at most.
const MOST_STEPS: f64 = 20_000.0;

/// Superelements.
#[derive(Debug, Args)]
pub(crate) struct InitArguments {
    /// Superelements, from the ground on: the last interface of each is joined to the first of the next. A file may come again.
    #[arg(value_name = "PART.dcb.h5", required = true)]
    parts: Vec<PathBuf>,
    /// Scene.
    #[arg(long, short, value_name = "SCENE.json", default_value = "scene.json")]
    output: PathBuf,
    /// Replace an existing one.
    #[arg(long)]
    force: bool,
}

/// A superelement in the chain.
struct Link {
    /// Name of the body.
    name: String,
    /// Path from the folder of the scene.
    file: String,
    part: Superelement,
    /// Component's origin, world axes.
    position: [f64; 3],
}

impl Link {
    fn first(&self) -> &InterfaceFrame {
        &self.part.interfaces[0]
    }

    fn last(&self) -> &InterfaceFrame {
        &self.part.interfaces[self.part.interfaces.len() - 1]
    }
}

/// Writes the draft.
pub(crate) fn run(arguments: &InitArguments) -> Result<Outcome, Error> {
    let (target, replace) = (&arguments.output, replace(arguments.force));
    check_output(target, replace)?;
    let parts = arguments.parts.iter().map(PathBuf::as_path);
    refuse_inputs(target, parts, "a superelement")?;
    let links = chain(&arguments.parts, target)?;
    let text = draft(&links);
    write_stream(target, replace, |out| out.write_all(text.as_bytes()))?;
    let path = target.display();
    Ok(Outcome::done(format!(
        "wrote {path}: {} in a chain from the ground, falling; run it with: simulate {path}\n",
        match links.len() {
            1 => "1 body".to_owned(),
            count => format!("{count} bodies"),
        }
    )))
}

/// The parts one after another, each where the one before it ends.
fn chain(parts: &[PathBuf], target: &Path) -> Result<Vec<Link>, Error> {
    let mut links: Vec<Link> = Vec::new();
    let mut names = BTreeSet::new();
    let mut end = [0.0; 3];
    for path in parts {
        let part = read_superelement(path)?;
        let refused = |message: String| {
            Err(Error::from(dcb_formats::Error::File {
                path: path.clone(),
                message,
            }))
        };
        if part.interfaces.is_empty() {
            return refused("has no interface to join it by; reduce it with one".into());
        }
        if let Some(first) = links.first() {
            if first.part.dimension != part.dimension {
                return refused(format!(
                    "is {}, but {} isn't; a draft is of one kind",
                    kind(part.dimension),
                    first.file
                ));
            }
            if first.part.units != part.units {
                return refused(format!(
                    "has the units {}, but {} has {}; reduce both in the same",
                    unit_names(&part.units),
                    first.file,
                    unit_names(&first.part.units)
                ));
            }
        }
        let mut link = Link {
            name: unused(&mut names, &part.name),
            file: file_name(path, target),
            part,
            position: [0.0; 3],
        };
        let (from, to) = (link.first().position, link.last().position);
        let origin = link.part.origin;
        link.position = std::array::from_fn(|axis| end[axis] - from[axis] - origin[axis]);
        end = std::array::from_fn(|axis| end[axis] + to[axis] - from[axis]);
        links.push(link);
    }
    Ok(links)
}

fn kind(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Planar => "planar",
        Dimension::Spatial => "spatial",
    }
}

fn unit_names(units: &Units) -> String {
    format!("{}, {}, {}", units.length, units.mass, units.time)
}

/// A body's name: that of the part, with a number where it is taken; no slashes.
fn unused(taken: &mut BTreeSet<String>, name: &str) -> String {
    let name = name.replace('/', "-");
    let mut found = name.clone();
    let mut number = 2;
    while !taken.insert(found.clone()) {
        found = format!("{name}-{number}");
        number += 1;
    }
    found
}

/// A file as the scene names it: from its own folder where that is possible.
fn file_name(path: &Path, target: &Path) -> String {
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let from = |path: &Path| path.canonicalize().ok();
    let way = from(path).zip(from(folder));
    let way = way.and_then(|(path, folder)| diff_paths(path, folder));
    way.unwrap_or_else(|| path.to_owned())
        .to_string_lossy()
        .replace('\\', "/")
}

/// The text of the scene.
fn draft(links: &[Link]) -> String {
    let first = &links[0].part;
    let units = &first.units;
    let d = first.dimension.coordinate_count();
    let [length, time] = [&units.length, &units.time].map(|unit| si_factor(unit).unwrap_or(1.0));
    let gravity = GRAVITY * time * time / length;
    let mut down = vec![0.0; d];
    down[d - 1] = -gravity;
    let mut text = String::from(
        "{\n  // A draft to start from: every line may be changed. docs/scene.md explains all keys.\n",
    );
    let mut line = |key: &str, value: &str, comment: &str| {
        if !comment.is_empty() {
            let _ = writeln!(text, "  // {comment}");
        }
        let _ = writeln!(text, "  {key:?}: {value},");
    };
    line("dimension", &d.to_string(), "");
    let names = json!({"length": units.length, "mass": units.mass, "time": units.time});
    line(
        "units",
        &names.to_string(),
        "Those of the superelements: all numbers are in them, angles in rad.",
    );
    line(
        "gravity",
        &json!(down).to_string(),
        &format!(
            "Acceleration of free fall, {}/{}^2, world axes.",
            units.length, units.time
        ),
    );
    line(
        "bodies",
        &listed(links.iter().map(|link| (link.name.clone(), body(link, d)))),
        "Where the origin of each part's drawing lies. Modal damping: ratio to critical of the free part.",
    );
    line(
        "joints",
        &listed(joints(links)),
        "Each part turns about an axis at its first interface. Other kinds: fixed, spherical, prismatic, universal ...",
    );
    let tip = &links[links.len() - 1];
    let at = format!("{}/{}", tip.name, tip.last().name);
    let outputs = [
        ("tip".to_owned(), json!({"position": {"at": at}})),
        (
            "axle_force".to_owned(),
            json!({"reaction": {"joint": "joint-1"}}),
        ),
        ("energy".to_owned(), json!("energy")),
    ];
    line(
        "outputs",
        &listed(outputs.into_iter()),
        "What is recorded for you; simulate plot draws it.",
    );
    let (step, end) = times(links, gravity);
    line(
        "record",
        &json!({"interval": tidy(end / 400.0)}).to_string(),
        &format!("A row every so many {}.", units.time),
    );
    let _ = writeln!(
        text,
        "  // {STEPS} steps in a period of the lowest elastic mode of the parts, free in space. Time is in {}.",
        units.time
    );
    let integrator = json!({"generalized_alpha": {"step": step, "end": end}});
    let _ = writeln!(text, "  \"integrator\": {integrator}\n}}");
    text
}

/// An object with one entry a line.
fn listed(entries: impl Iterator<Item = (String, serde_json::Value)>) -> String {
    let lines: Vec<String> = entries
        .map(|(name, value)| format!("    {}: {value}", json!(name)))
        .collect();
    format!("{{\n{}\n  }}", lines.join(",\n"))
}

fn body(link: &Link, d: usize) -> serde_json::Value {
    let position: Vec<f64> = link.position[..d].iter().map(|x| tidy(*x)).collect();
    json!({"superelement": link.file, "position": position, "damping": {"modal": 0.01}})
}

/// One at the first interface of each part.
fn joints(links: &[Link]) -> impl Iterator<Item = (String, serde_json::Value)> {
    links.iter().enumerate().map(|(index, link)| {
        let before = match index {
            0 => "ground".to_owned(),
            _ => {
                let before = &links[index - 1];
                format!("{}/{}", before.name, before.last().name)
            }
        };
        let mut joint = json!({"a": before, "b": format!("{}/{}", link.name, link.first().name)});
        if link.part.dimension == Dimension::Spatial {
            joint["axis"] = json!([0, 1, 0]);
            let others = (index > 0).then(|| (&links[index - 1].part, links[index - 1].last()));
            let mut all = others.into_iter().chain([(&link.part, link.first())]);
            if !all.all(|(part, interface)| turns(part, interface)) {
                joint["orientation"] = json!("body");
            }
        }
        let name = format!("joint-{}", index + 1);
        (name, json!({"revolute": joint}))
    })
}

/// Whether an interface has rows of rotations.
fn turns(part: &Superelement, interface: &InterfaceFrame) -> bool {
    part.rows
        .iter()
        .any(|row| part.interfaces[row.interface].name == interface.name && row.direction >= 3)
}

/// Step and end: the step follows the lowest mode of all parts; the end shows some of its periods and a swing of the chain.
fn times(links: &[Link], gravity: f64) -> (f64, f64) {
    let eigenvalues = links.iter().flat_map(|link| &link.part.modes.eigenvalues);
    let lowest = eigenvalues
        .copied()
        .filter(|value| *value > 0.0)
        .fold(f64::INFINITY, f64::min);
    let reach: f64 = links
        .iter()
        .map(|link| {
            let (from, to) = (link.first().position, link.last().position);
            (0..3)
                .map(|axis| (to[axis] - from[axis]).powi(2))
                .sum::<f64>()
                .sqrt()
        })
        .sum();
    let swing = std::f64::consts::TAU * (reach.max(1e-3 * gravity) / gravity).sqrt();
    let period = match lowest.is_finite() {
        true => std::f64::consts::TAU / lowest.sqrt(),
        false => swing,
    };
    let step = rounded(period / STEPS);
    let end = rounded((PERIODS * period).max(swing)).min(MOST_STEPS * step);
    (step, end)
}

/// A number without the digits of rounding, and no minus before a zero.
fn tidy(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value) + 0.0
}

/// The next number below with one digit.
fn rounded(value: f64) -> f64 {
    let power = 10_f64.powi(value.log10().floor() as i32);
    let digit = (value / power).floor().max(1.0);
    // The shortest decimal, without rounding of the product.
    format!("{digit}e{}", value.log10().floor() as i32)
        .parse()
        .unwrap_or(digit * power)
}
