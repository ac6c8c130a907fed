//! The `simulate campbell SCENE.json` command: whirl over the speed of a rotor, and critical speeds.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use dcb_formats::output::check_output;
use dcb_formats::scene::Scene;
use dcb_formats::terminal::one_line;
use dcb_formats::units::si_factor;
use dcb_report::{Axis, Cell, Chart, Column, Note, Series, Style, Table, write_svg};
use dcb_runtime::error::Error;
use dcb_runtime::run::refuse_inputs;
use dcb_runtime::whirl::{Campbell, CampbellRequest, SpeedPoint, Whirl, campbell};

use crate::outcome::Outcome;
use crate::program::CommonArguments;
use crate::simulate::replace;
use crate::simulate::scene::{Watcher, watch_for_interruption};

/// Speeds listed without --verbose.
const LISTED: usize = 8;

/// Options of a Campbell diagram.
#[derive(Debug, Args)]
pub(crate) struct CampbellArguments {
    /// Scene of a rotor that spins on the ground; its supports are alike in all directions.
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    /// Speeds in revolutions per minute, from above zero.
    #[arg(long, value_name = "FROM:TO:COUNT", value_parser = speeds)]
    rpm: Speeds,
    /// Excitations per revolution that critical speeds are wanted of; negative ones go against the spin.
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "1",
        allow_negative_numbers = true
    )]
    orders: Vec<f64>,
    /// Body whose angular velocity is the direction of the spin [default: the fastest].
    #[arg(long, value_name = "BODY")]
    rotor: Option<String>,
    /// Modes at each speed, the slowest.
    #[arg(long, value_name = "N", default_value_t = 8)]
    modes: usize,
    /// Write the modes as CSV.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the diagram.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Replace existing files.
    #[arg(long)]
    force: bool,
}

/// Equally spaced speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Speeds {
    from: f64,
    to: f64,
    count: usize,
}

fn speeds(text: &str) -> Result<Speeds, String> {
    let wrong = || {
        "expected FROM:TO:COUNT in revolutions per minute, for example 1000:30000:30, with 0 < FROM < TO and 2 to 10000 speeds".to_owned()
    };
    let parts: Vec<&str> = text.split(':').collect();
    let [from, to, count] = parts[..] else {
        return Err(wrong());
    };
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let found = Speeds {
        from: number(from).ok_or_else(wrong)?,
        to: number(to).ok_or_else(wrong)?,
        count: count.trim().parse().map_err(|_| wrong())?,
    };
    match found.from > 0.0 && found.to > found.from && (2..=10_000).contains(&found.count) {
        true => Ok(found),
        false => Err(wrong()),
    }
}

pub(crate) fn run(
    arguments: &CampbellArguments,
    common: &CommonArguments,
) -> Result<Outcome, Error> {
    let path = &arguments.scene;
    let scene = Scene::read(path)?;
    for target in arguments.csv.iter().chain(&arguments.svg) {
        check_output(target, replace(arguments.force))?;
        refuse_inputs(target, [path.as_path()], "the scene")?;
    }
    let time = &scene.units.time;
    let Some(seconds) = si_factor(time) else {
        return Err(Error::described(
            "units.time",
            format!(
                "is {time:?}, whose seconds aren't known; speeds are in revolutions per minute"
            ),
        ));
    };
    let per_rpm = TAU / 60.0 * seconds;
    let Speeds { from, to, count } = arguments.rpm;
    let step = (to - from) / (count - 1) as f64;
    let request = CampbellRequest {
        speeds: (0..count)
            .map(|i| (from + step * i as f64) * per_rpm)
            .collect(),
        orders: arguments.orders.clone(),
        rotor: arguments.rotor.clone(),
    };
    watch_for_interruption();
    let mut watcher = Watcher::new(common);
    let found = campbell(&scene, &request, &mut watcher);
    watcher.finish();
    let Some(diagram) = found.map_err(|error| error.in_file(path))? else {
        return Ok(Outcome::interrupted(
            "stopped before the last speed, nothing was written\n".to_owned(),
        ));
    };
    let drawn = Drawn {
        diagram: &diagram,
        per_rpm,
        per_hertz: seconds,
        modes: arguments.modes,
    };
    let mut text = drawn.text(match common.verbose {
        true => usize::MAX,
        false => LISTED,
    });
    if let Some(file) = &arguments.csv {
        drawn.table().write_csv(file)?;
        let _ = writeln!(text, "{}", file.display());
    }
    if let Some(file) = &arguments.svg {
        write_svg(&[drawn.chart()], file, replace(arguments.force))?;
        let _ = writeln!(text, "{}", file.display());
    }
    Ok(Outcome::done(text))
}

/// A diagram in the units that it is shown in.
struct Drawn<'a> {
    diagram: &'a Campbell,
    /// rad/time.
    per_rpm: f64,
    /// Cycles per time.
    per_hertz: f64,
    modes: usize,
}

impl Drawn<'_> {
    fn text(&self, listed: usize) -> String {
        let diagram = self.diagram;
        let mut text = format!(
            "done: whirl of {:?} at {} speeds\n{:>12}   frequency [Hz], + with the spin, - against it, = along and about the axis\n",
            one_line(&diagram.rotor),
            diagram.points.len(),
            "speed [rpm]",
        );
        let every = diagram.points.len().div_ceil(listed.max(1)).max(1);
        let last = diagram.points.len() - 1;
        for (index, point) in diagram.points.iter().enumerate() {
            if index % every != 0 && index != last {
                continue;
            }
            let _ = write!(text, "{:>12.1}  ", point.speed / self.per_rpm);
            for mode in point.modes.iter().take(self.modes) {
                let size = mode.frequency.abs() / self.per_hertz;
                let sign = match (mode.whirl, mode.frequency >= 0.0) {
                    (Whirl::Along, _) => '=',
                    (Whirl::Across, true) => '+',
                    (Whirl::Across, false) => '-',
                };
                let _ = write!(text, "{:>12}", format!("{sign}{size:.3}"));
            }
            text.push('\n');
        }
        if every > 1 {
            text += "-v lists every speed\n";
        }
        match diagram.criticals.is_empty() {
            true => text += "no critical speed between these speeds\n",
            false => {
                let _ = writeln!(text, "{:>12}{:>18}{:>8}", "critical [rpm]", "[Hz]", "order");
            }
        }
        for critical in &diagram.criticals {
            let frequency = critical.order.abs() * critical.speed / TAU / self.per_hertz;
            let several = match critical.count {
                1 => String::new(),
                count => format!("   {count} whirls"),
            };
            let _ = writeln!(
                text,
                "{:>14.3}{frequency:>18.6}{:>8}{several}",
                critical.speed / self.per_rpm,
                critical.order
            );
        }
        let grows: Vec<&SpeedPoint> = (diagram.points.iter())
            .filter(|point| point.modes.iter().any(|mode| mode.damping < -1e-8))
            .collect();
        if let Some(first) = grows.first() {
            let _ = writeln!(
                text,
                "unstable from {:.1} rpm on: a whirl grows there",
                first.speed / self.per_rpm
            );
        }
        text
    }

    fn table(&self) -> Table {
        let columns = vec![
            Column::new("speed", "speed", "rpm"),
            Column::new("mode", "mode", ""),
            Column::new("frequency", "frequency", "Hz"),
            Column::new("motion", "motion", ""),
            Column::new("damping", "damping", "1"),
        ];
        let rows = self.diagram.points.iter().flat_map(|point| {
            let modes = point.modes.iter().take(self.modes).enumerate();
            modes.map(move |(index, mode)| {
                vec![
                    Cell::Number(point.speed / self.per_rpm),
                    Cell::Count(index as u64 + 1),
                    Cell::Number(mode.frequency / self.per_hertz),
                    Cell::Text(motion(mode.whirl, mode.frequency).to_owned()),
                    Cell::Number(mode.damping),
                ]
            })
        });
        Table {
            columns,
            rows: rows.collect(),
        }
    }

    fn chart(&self) -> Chart {
        let of = |wanted: &str| -> Series {
            let points = self.diagram.points.iter().flat_map(|point| {
                let modes = point.modes.iter().take(self.modes);
                modes
                    .filter(|mode| motion(mode.whirl, mode.frequency) == wanted)
                    .map(|mode| {
                        [
                            point.speed / self.per_rpm,
                            mode.frequency.abs() / self.per_hertz,
                        ]
                    })
            });
            Series {
                name: wanted.to_owned(),
                points: points.collect(),
                style: Style::Marks,
            }
        };
        let mut series: Vec<Series> = ["forward", "backward", "along"]
            .map(of)
            .into_iter()
            .filter(|series| !series.points.is_empty())
            .collect();
        let mut orders: Vec<f64> = (self.diagram.criticals.iter())
            .map(|critical| critical.order.abs())
            .collect();
        orders.dedup();
        let ends = [self.diagram.points.first(), self.diagram.points.last()];
        for order in orders {
            let line = ends.into_iter().flatten().map(|point| {
                [
                    point.speed / self.per_rpm,
                    order * point.speed / TAU / self.per_hertz,
                ]
            });
            series.push(Series {
                name: format!("{order} per revolution"),
                points: line.collect(),
                style: Style::Line,
            });
        }
        let notes = self.diagram.criticals.iter().map(|critical| Note {
            label: format!("{:.0} rpm", critical.speed / self.per_rpm),
            told: format!("critical speed of order {}", critical.order),
            at: [
                critical.speed / self.per_rpm,
                critical.order.abs() * critical.speed / TAU / self.per_hertz,
            ],
        });
        Chart {
            title: format!("Whirl of {}", self.diagram.rotor),
            horizontal: Axis::linear("speed [rpm]"),
            vertical: Axis::linear("frequency [Hz]"),
            series,
            slopes: Vec::new(),
            notes: notes.collect(),
        }
    }
}

fn motion(whirl: Whirl, frequency: f64) -> &'static str {
    match (whirl, frequency >= 0.0) {
        (Whirl::Along, _) => "along",
        (Whirl::Across, true) => "forward",
        (Whirl::Across, false) => "backward",
    }
}
