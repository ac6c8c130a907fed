//! `reduce inspect`: what a superelement holds, for people and as JSON.

use std::fmt::Write as _;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;
use dcb_assembly::AssemblyReport;
use dcb_formats::Superelement;
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::mesh::{Dimension, Direction};
use dcb_formats::terminal::one_line;
use dcb_import::MatrixFile;
use dcb_import::stored::Listed;
use serde_json::json;

use crate::outcome::Outcome;
use crate::program::Detail;
use crate::reduce::assemble;
use crate::reduce::part::report::{further_columns, internal_rows, verdict};
use crate::reduce::study::band;
use crate::reduce::superelement::error_report::Report;
use crate::reduce::superelement::stress_lines::stress_lines;
use dcb_formats::units::{hertz, hertz_unit, si_factor};
use dcb_reducer::error::Error;
use dcb_reducer::quality::Quality;
use dcb_reducer::quality::lines::quality_lines;
use dcb_reducer::scientific::{row, scientific};

/// Superelement to show.
#[derive(Debug, Args)]
pub struct InspectArguments {
    /// Superelement, or a file with another program's matrices.
    file: PathBuf,
    /// As JSON.
    #[arg(long)]
    json: bool,
    /// Band of frequencies for the errors, Hz [default: up to half the highest mode].
    #[arg(long, value_name = "FMIN:FMAX", allow_hyphen_values = true, value_parser = band)]
    band: Option<[f64; 2]>,
}

/// For whom something is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// People.
    Text,
    /// Programs.
    Json,
}

impl InspectArguments {
    /// A file over the usual band.
    pub fn of(file: &Path, form: Form) -> Self {
        Self {
            file: file.to_path_buf(),
            json: form == Form::Json,
            band: None,
        }
    }
}

/// Errors are estimated over a band in Hz, or over the usual one.
pub fn run(arguments: &InspectArguments, detail: Detail) -> Result<Outcome, Error> {
    let file = match SuperelementFile::open(&arguments.file) {
        Ok(file) => file,
        Err(error) => {
            return match MatrixFile::recognised(&arguments.file) {
                Ok(Some(file)) => Ok(Outcome::done(matrices(
                    &file,
                    &arguments.file,
                    arguments.json,
                ))),
                Err(foreign) if arguments.file.is_file() && !is_hdf5(&arguments.file) => {
                    Err(foreign.into())
                }
                _ => Err(error.into()),
            };
        }
    };
    let element = file.superelement()?;
    let errors = Report::of(&element, arguments.band)?;
    let output = match arguments.json {
        false if detail == Detail::Verdict => {
            let asked = errors.as_ref().filter(|_| arguments.band.is_some());
            short(&file, &element, asked)?
        }
        false => text(&file, &element, errors.as_ref())?,
        true => as_json(&file, &element, errors.as_ref())?,
    };
    Ok(Outcome::done(output))
}

/// Whether a file begins as superelements do.
fn is_hdf5(path: &Path) -> bool {
    let mut start = [0; 8];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start == *b"\x89HDF\r\n\x1a\n"
}

/// Matrices of another program's file.
fn matrices(file: &MatrixFile, path: &Path, as_json: bool) -> String {
    let listed = file.listed();
    if as_json {
        let of_one = |one: &Listed| json!({"name": one.name, "shape": one.shape.map(|(rows, columns)| [rows, columns]), "obstacle": one.obstacle});
        let all: Vec<_> = listed.iter().map(of_one).collect();
        let value = json!({"file": path, "format": file.format_name(), "matrices": all});
        return format!("{value}\n");
    }
    let mut text = format!("{}: {}\n", path.display(), file.format_name());
    for (number, one) in listed.iter().enumerate() {
        let name = match one.name.is_empty() {
            true => format!("#{}", number + 1),
            false => one_line(&one.name).into_owned(),
        };
        let shape = one.shape.map_or_else(
            || "size known once it is read".to_owned(),
            |(rows, columns)| format!("{rows} x {columns}"),
        );
        let obstacle = one
            .obstacle
            .iter()
            .map(|why| format!(", {why}"))
            .collect::<String>();
        let _ = writeln!(text, "{name:<12} {shape}{obstacle}");
    }
    if listed.is_empty() {
        text.push_str("no matrices\n");
    }
    text.push_str("stiffness and mass become a component with `reduce import`\n");
    text
}

/// Mass, centre and inertia.
pub fn mass_lines(element: &Superelement) -> String {
    let (units, inertia, origin) = (&element.units, &element.inertia, element.origin);
    let mut text = String::new();
    let mut line = |label: &str, values: &[f64], unit: &str| {
        let line = format!("{label:<7} {} {unit}", row(values));
        let _ = writeln!(text, "{}", line.trim_end());
    };
    line("mass", &[inertia.mass], &units.mass);
    let d = element.dimension.coordinate_count();
    line("centre", &origin[..d], &units.length);
    let unit = format!("{}·{}²", units.mass, units.length);
    match element.dimension {
        Dimension::Planar => {
            line(
                "inertia",
                &[inertia.tensor[2][2]],
                &format!("{unit} about the centre"),
            );
        }
        Dimension::Spatial => {
            line("inertia", &inertia.tensor[0], "");
            line(
                "",
                &inertia.tensor[1],
                &format!("{unit} about the centre, component axes"),
            );
            line("", &inertia.tensor[2], "");
        }
    }
    text
}

/// The kept modes; residuals where a report is at hand.
pub fn frequency_table(element: &Superelement, quality: Option<&Quality>, listed: usize) -> String {
    let time = &element.units.time;
    let mut text = String::new();
    if element.mode_count() == 0 {
        text += "no mode is kept\n";
    } else {
        let heading = format!("frequency [{}]", hertz_unit(time));
        let _ = writeln!(text, "mode   {heading:>20}    damping   residual");
    }
    let reported = quality.map(|quality| quality.mode_residuals.as_slice());
    let reported = reported.unwrap_or_default();
    let places = places_in_report(element, reported.len());
    for (i, eigenvalue) in element.modes.eigenvalues.iter().enumerate().take(listed) {
        let residual = (places.get(i).copied().flatten())
            .and_then(|place| reported.get(place))
            .map_or(String::new(), |r| scientific(*r, 1));
        let damping = element.modes.damping.get(i).copied().unwrap_or(0.0);
        let _ = writeln!(
            text,
            "{:4}   {:20.9}   {damping:8.5}   {residual}",
            i + 1,
            hertz(*eigenvalue, time)
        );
    }
    let hidden = element.mode_count().saturating_sub(listed);
    if hidden > 0 {
        let last = element.modes.eigenvalues.last().copied().unwrap_or(0.0);
        let _ = writeln!(
            text,
            "{:>4}   {:20.9}   the last of {hidden} more",
            "…",
            hertz(last, time)
        );
    }
    if element.modes.first_omitted_eigenvalue.is_finite() {
        let _ = writeln!(
            text,
            "       {:20.9}   the first left out",
            hertz(element.modes.first_omitted_eigenvalue, time)
        );
    } else {
        let _ = writeln!(text, "       every finite mode is kept");
    }
    text
}

/// Where each mode is in a report on this many: selections made after the report have left out modes.
fn places_in_report(element: &Superelement, reported: usize) -> Vec<Option<usize>> {
    let mut places: Vec<Option<usize>> = (0..element.mode_count()).map(Some).collect();
    let mut count = places.len();
    for selection in element.selections().iter().rev() {
        if count == reported {
            break;
        }
        for place in &mut places {
            *place = place.and_then(|place| selection.modes.get(place).copied());
        }
        count = selection.of_modes;
    }
    places
}

/// The interfaces with their rows.
pub fn interface_table(element: &Superelement) -> String {
    if element.interfaces.is_empty() {
        return "no interface: nothing can be attached\n".into();
    }
    let width = element
        .interfaces
        .iter()
        .map(|interface| interface.name.chars().count())
        .fold(9, usize::max);
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{:<width$}  kind      role        rows   at, from the centre [{}]",
        "interface", element.units.length
    );
    for (index, interface) in element.interfaces.iter().enumerate() {
        let rows: Vec<_> = element
            .rows
            .iter()
            .filter(|row| row.interface == index)
            .collect();
        let d = element.dimension.coordinate_count();
        let at: Vec<String> = interface.position[..d]
            .iter()
            .map(|x| format!("{:>14}", scientific(*x, 6)))
            .collect();
        let role = match interface.role {
            dcb_formats::component::Role::Attachment => "attachment",
            dcb_formats::component::Role::Output => "output",
        };
        let _ = writeln!(
            text,
            "{:<width$}  {:<9} {role:<10} {:5} {}",
            interface.name,
            interface.kind.name(),
            rows.len(),
            at.concat()
        );
    }
    let sigma: Vec<String> = element
        .residual
        .sigma_squared
        .iter()
        .take(6)
        .map(|s| format!("{:.4}", hertz(*s, &element.units.time)))
        .collect();
    let reduction = Quality::stored(element).and_then(|quality| quality.interface_reduction);
    let start = match (sigma.is_empty(), reduction.filter(|it| it.leaves_out())) {
        (true, None) => "; the modes say all there is".to_owned(),
        (true, Some(it)) => format!("; {} direction(s) are left out", it.available - it.kept),
        (false, _) => format!(
            "; their frequencies start at {} {}",
            sigma.join(", "),
            hertz_unit(&element.units.time)
        ),
    };
    let _ = writeln!(
        text,
        "attachment coordinates: {} for {} rows{start}",
        element.residual.sigma_squared.len(),
        element.rows.len()
    );
    let further = further_columns(element);
    if let Some(further) = further.strip_prefix(", ") {
        let _ = writeln!(text, "besides: {further}");
    }
    text
}

/// What the file is.
fn heading(file: &SuperelementFile, element: &Superelement) -> String {
    format!(
        "{}: {} superelement, format {}, units {} {} {}, frame {}\n",
        element.name,
        match element.dimension {
            Dimension::Planar => "planar",
            Dimension::Spatial => "spatial",
        },
        file.format_version(),
        element.units.length,
        element.units.mass,
        element.units.time,
        element.frame_kind.name()
    )
}

/// What it is good for, and what can be attached to it; errors over a band that was asked for.
fn short(
    file: &SuperelementFile,
    element: &Superelement,
    errors: Option<&Report>,
) -> Result<String, Error> {
    let quality = Quality::stored(element);
    let mut text = heading(file, element) + &verdict(element, quality.as_ref());
    if let Some(report) = AssemblyReport::stored(element) {
        text += &assemble::accuracy(&report, &element.units.time);
    }
    text += &interface_table(element);
    let _ = writeln!(text, "fields   {}", stored_fields(file, element)?);
    text += &stress_lines(element);
    if let Some(errors) = errors {
        text += &errors.text();
    }
    for warning in &element.provenance.warnings {
        let _ = writeln!(text, "warning  {}", one_line(warning));
    }
    text += "-v lists modes, checks, error bounds and the files that it was made from\n";
    Ok(text)
}

/// Fields, mesh and rows without either.
fn stored_fields(file: &SuperelementFile, element: &Superelement) -> Result<String, Error> {
    let fields = file.recovery()?.map_or("none".to_owned(), |basis| {
        format!("{} degrees of freedom", basis.dofs.len())
    });
    let mesh = file.mesh()?.map_or("none".to_owned(), |mesh| {
        format!("{} nodes", mesh.node_count())
    });
    let internal = match internal_rows(element) {
        0 => String::new(),
        count => format!("; {count} internal rows, without fields"),
    };
    Ok(format!("{fields}; mesh {mesh}{internal}"))
}

fn text(
    file: &SuperelementFile,
    element: &Superelement,
    errors: Option<&Report>,
) -> Result<String, Error> {
    let quality = Quality::stored(element);
    let mut text = heading(file, element) + &verdict(element, quality.as_ref());
    let _ = writeln!(text, "digest   {}", file.digest());
    text += &mass_lines(element);
    text += &frequency_table(element, quality.as_ref(), usize::MAX);
    if let Some(report) = AssemblyReport::stored(element) {
        text += &assemble::accuracy(&report, &element.units.time);
        text += &assemble::bounds_table(element, &report);
    }
    text += &interface_table(element);
    let _ = writeln!(text, "fields   {}", stored_fields(file, element)?);
    text += &stress_lines(element);
    if let Some(quality) = &quality {
        text += &quality_lines(quality, &element.units.time);
    }
    if let Some(errors) = errors {
        text += &errors.text();
    }
    for input in &element.provenance.inputs {
        let _ = writeln!(
            text,
            "made from {} ({}, sha256 {})",
            one_line(&input.file_name),
            one_line(&input.role),
            one_line(&input.sha256)
        );
    }
    let _ = writeln!(text, "made by  {}", one_line(&element.provenance.generator));
    for warning in &element.provenance.warnings {
        let _ = writeln!(text, "warning  {}", one_line(warning));
    }
    Ok(text)
}

fn as_json(
    file: &SuperelementFile,
    element: &Superelement,
    errors: Option<&Report>,
) -> Result<String, Error> {
    let time = &element.units.time;
    let interfaces: Vec<_> = element
        .interfaces
        .iter()
        .enumerate()
        .map(|(index, interface)| {
            let rows = element.rows.iter().filter(|row| row.interface == index);
            let directions: Vec<_> = rows
                .map(|row| {
                    usize::try_from(row.direction)
                        .ok()
                        .and_then(|d| Direction::NAMES.get(d))
                })
                .collect();
            json!({
                "name": interface.name,
                "kind": interface.kind.name(),
                "role": match interface.role {
                    dcb_formats::component::Role::Attachment => "attachment",
                    dcb_formats::component::Role::Output => "output",
                },
                "position": &interface.position[..element.dimension.coordinate_count()],
                "rows": directions,
            })
        })
        .collect();
    let value = json!({
        "name": element.name,
        "format_version": file.format_version().to_string(),
        "digest": file.digest(),
        "dimension": element.dimension.coordinate_count(),
        "units": { "length": element.units.length, "mass": element.units.mass, "time": time },
        "frame": { "kind": element.frame_kind.name(), "origin": &element.origin[..element.dimension.coordinate_count()] },
        "mass": element.inertia.mass,
        "inertia": match element.dimension {
            Dimension::Planar => json!(element.inertia.tensor[2][2]),
            Dimension::Spatial => json!(element.inertia.tensor),
        },
        "eigenvalues": element.modes.eigenvalues,
        "frequencies_hz": si_factor(time).map(|_| {
            element.modes.eigenvalues.iter().map(|value| hertz(*value, time)).collect::<Vec<_>>()
        }),
        "first_omitted_eigenvalue": Some(element.modes.first_omitted_eigenvalue).filter(|value| value.is_finite()),
        "damping": element.modes.damping,
        "interfaces": interfaces,
        "residual_rank": element.residual.sigma_squared.len(),
        "residual_sigma_squared": element.residual.sigma_squared,
        "internal_rows": internal_rows(element),
        "stresses": element.stresses.iter().map(|field| json!({
            "name": field.name, "quantity": field.quantity.name(), "places": field.points.len(),
            "components": field.components.iter().map(|one| one.name()).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "has_fields": file.recovery()?.is_some(),
        "errors": errors.map(Report::json),
        "quality": element.provenance.quality,
        "options": element.provenance.options,
        "generator": element.provenance.generator,
        "inputs": element.provenance.inputs.iter().map(|input| json!({
            "role": input.role, "file": input.file_name, "sha256": input.sha256,
        })).collect::<Vec<_>>(),
        "warnings": element.provenance.warnings,
    });
    let text = serde_json::to_string_pretty(&value).map_err(|_| Error::NotFinite {
        what: "the JSON output",
    })?;
    Ok(text + "\n")
}
