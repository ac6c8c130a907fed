//! The `reduce PART.mtx` command: read, reduce, write, and say what was done.

use std::fmt::Write as _;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use dcb_formats::component_files::{ComponentFiles, Overrides, read_component, stem};
use dcb_formats::dcb::{
    Compression, Contents, Replace, WriteOptions, check_output, partial_path, write_superelement,
};
use serde_json::json;

use crate::cli::{CommonArguments, ReduceArguments};
use crate::error::Error;
use crate::inspect::{frequency_table, interface_table, mass_lines};
use crate::plausibility::si_factor;
use crate::quality::Quality;
use crate::timing::{Display, StageClock, StageTime};
use crate::{Grounding, LoosePieces, ModeSelection, Reduced, Reduction, reduce};

/// Modes kept where nothing is said.
const DEFAULT_MODES: usize = 20;
/// Modes listed unless all are asked for.
const LISTED_MODES: usize = 10;

/// What a command has to say, and which quality limits broke.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// For standard output.
    pub output: String,
    /// For standard error, and exit status 1.
    pub broken_limits: Vec<String>,
}

/// `PART.dcb.h5` beside `PART.mtx`.
fn default_output(stiffness: &Path) -> PathBuf {
    let mut name = stem(stiffness).into_os_string();
    name.push(".dcb.h5");
    PathBuf::from(name)
}

/// Removes the unfinished file and ends with status 130 when the user interrupts.
fn clean_up_on_interrupt(target: &Path) {
    let partial = partial_path(target);
    // A second handler can't be set (tests call the command twice in one process); the first one serves.
    let _ = ctrlc::set_handler(move || {
        let _ = std::fs::remove_file(&partial);
        eprintln!("interrupted; nothing was written");
        std::process::exit(130);
    });
}

/// Runs the command.
///
/// # Errors
/// Whatever made it impossible to read, reduce or write.
pub fn run(arguments: &ReduceArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let Some(stiffness) = &arguments.stiffness else {
        return Err(Error::Component("no stiffness matrix given".into()));
    };
    let target = arguments.output.clone().unwrap_or_else(|| default_output(stiffness));
    let replace = if arguments.force { Replace::Overwrite } else { Replace::Refuse };
    let overrides = Overrides {
        mass: arguments.mass.clone(),
        description: arguments.mesh.clone(),
        boundary: arguments.boundary.clone(),
    };
    let files = ComponentFiles::beside(stiffness, &overrides)?;
    refuse_input_as_output(&files, &target)?;
    check_output(&target, replace)?;
    clean_up_on_interrupt(&target);

    let show = !common.quiet && std::io::stderr().is_terminal();
    let mut clock = StageClock::new(if show { Display::Bars } else { Display::Silent });
    clock.start("read");
    let component = read_component(&files)?;
    let options = Reduction {
        modes: mode_selection(arguments, &component.units.time)?,
        grounding: if arguments.allow_grounded { Grounding::Allow } else { Grounding::Refuse },
        loose_pieces: if arguments.allow_loose { LoosePieces::Allow } else { LoosePieces::Refuse },
    };
    let mut reduced = reduce(&component, &options, &mut clock)?;
    let broken_limits = reduced.quality.broken_limits();
    if !broken_limits.is_empty() {
        clock.clear();
        return Ok(Outcome { output: quality_lines(&reduced.quality), broken_limits });
    }
    clock.stop();
    let provenance = &mut reduced.superelement.provenance;
    provenance.options = options_as_json(arguments, &options);
    if let Some(quality) = provenance.quality.as_object_mut() {
        quality.insert("stages".into(), json!(clock.stages()));
    }
    clock.start("write");
    let contents = Contents {
        superelement: &reduced.superelement,
        recovery: (!arguments.without_fields).then_some(&reduced.recovery),
        mesh: (!arguments.without_fields).then_some(&component.mesh),
    };
    let compression = if arguments.compress { Compression::Deflate } else { Compression::None };
    write_superelement(&target, &contents, &WriteOptions { replace_existing: replace, compression })?;
    clock.clear();
    if let Some(path) = &arguments.timings {
        write_timings(path, clock.stages())?;
    }
    if !common.quiet {
        for warning in &reduced.superelement.provenance.warnings {
            eprintln!("warning: {warning}");
        }
    }
    let listed = if common.verbose { usize::MAX } else { LISTED_MODES };
    Ok(Outcome { output: summary(&reduced, component.dofs.len(), &target, clock.stages(), listed), broken_limits })
}

fn refuse_input_as_output(files: &ComponentFiles, target: &Path) -> Result<(), Error> {
    let inputs = [Some(&files.stiffness), Some(&files.mass), Some(&files.description), files.boundary.as_ref()];
    let real = |path: &Path| path.canonicalize().ok();
    match inputs.into_iter().flatten().find(|input| real(input).is_some() && real(input) == real(target)) {
        None => Ok(()),
        Some(input) => Err(Error::Component(format!(
            "{}: is an input of this reduction and can't be its output; name another with -o",
            input.display()
        ))),
    }
}

fn mode_selection(arguments: &ReduceArguments, time_unit: &str) -> Result<ModeSelection, Error> {
    let Some(hertz) = arguments.max_frequency else {
        return Ok(ModeSelection::Lowest(arguments.modes.unwrap_or(DEFAULT_MODES)));
    };
    if !(hertz.is_finite() && hertz > 0.0) {
        return Err(Error::Component(format!("--max-frequency {hertz}: a positive number of Hz is wanted")));
    }
    let second = si_factor(time_unit).ok_or_else(|| {
        Error::Component(format!("--max-frequency is in Hz, but the time unit {time_unit:?} is not known; use --modes"))
    })?;
    Ok(ModeSelection::Below { eigenvalue: (2.0 * std::f64::consts::PI * hertz * second).powi(2) })
}

fn options_as_json(arguments: &ReduceArguments, options: &Reduction) -> serde_json::Value {
    let modes = match options.modes {
        ModeSelection::Lowest(count) => json!({ "lowest": count }),
        ModeSelection::Below { eigenvalue } => json!({ "below_eigenvalue": eigenvalue }),
    };
    json!({
        "modes": modes,
        "max_frequency_hz": arguments.max_frequency,
        "allow_grounded": arguments.allow_grounded,
        "allow_loose": arguments.allow_loose,
        "without_fields": arguments.without_fields,
        "compress": arguments.compress,
    })
}

fn write_timings(path: &Path, stages: &[StageTime]) -> Result<(), Error> {
    let total: f64 = stages.iter().map(|stage| stage.seconds).sum();
    let text = json!({ "stages": stages, "total_seconds": total }).to_string() + "\n";
    std::fs::write(path, text).map_err(|source| {
        Error::File(dcb_formats::Error::Io { path: path.to_path_buf(), action: "cannot write", source })
    })
}

fn summary(reduced: &Reduced, n_e: usize, target: &Path, stages: &[StageTime], listed: usize) -> String {
    let element = &reduced.superelement;
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}: {n_e} dofs reduced to {} modes and {} attachment rows (rank {})",
        element.name,
        element.mode_count(),
        element.boundary_row_count(),
        reduced.quality.residual_rank,
    );
    text += &mass_lines(element);
    text += &frequency_table(element, Some(&reduced.quality), listed);
    text += &interface_table(element);
    text += &quality_lines(&reduced.quality);
    let _ = writeln!(text, "stages");
    for stage in stages {
        let memory = stage.peak_megabytes.map_or(String::new(), |mb| format!("  {mb:8.0} MB"));
        let _ = writeln!(text, "  {:<12} {:9.3} s{memory}", stage.stage, stage.seconds);
    }
    let _ = writeln!(text, "wrote {}", target.display());
    text
}

/// The quality report for people.
pub fn quality_lines(quality: &Quality) -> String {
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let mut text = String::from("quality\n");
    let mut line = |what: &str, value: f64| {
        let _ = writeln!(text, "  {what:<46} {value:.1e}");
    };
    line("largest mode residual |Kφ-ω²Mφ|/|Kφ|", largest(&quality.mode_residuals));
    line("  of which rounding explains up to", largest(&quality.mode_residual_roundings));
    line("rounding in ω², relative", largest(&quality.eigenvalue_roundings));
    line("attachment residual", quality.attachment_residual);
    line("Φᵀ K G_res        (Eq. 29)", quality.stiffness_orthogonality);
    line("Φᵀ M G_res        (Eq. 30)", quality.mass_orthogonality);
    line("Φᵀ M Φ - I        (Eq. 31)", quality.mass_orthonormality);
    line("Φᵀ K Φ - Ω²       (Eq. 31)", quality.stiffness_diagonality);
    line("G_resᵀKG_res-G_res (Eq. 32)", quality.flexibility_identity);
    line("L1 Ψ              (Eq. 39)", quality.l1_norm);
    line("I3 Ψ              (Eq. 40)", quality.i3_norm);
    line("rigid motions, |K r|", largest(&quality.rigid_defects));
    line("mass matrix as a rigid body", quality.mass_defect);
    line("condition of F_res (scaled)", quality.flexibility_condition);
    let sturm = match quality.sturm.limit {
        Some(limit) => format!(
            "{} eigenvalues counted below {limit:.6e}, {} found",
            quality.sturm.counted, quality.sturm.found
        ),
        None => "no elastic motion to count".into(),
    };
    let _ = writeln!(text, "  {:<46} {sturm}", "Sturm count");
    let _ = writeln!(
        text,
        "  {:<46} {} from geometry, {} by the count",
        "motions without stiffness", quality.rigid_motions, quality.nullity
    );
    text
}
