//! Superelements put together: parts, rigid bodies, joints and springs become one superelement with interfaces of its own.
//!
//! Compatibility is dual, as in the reduction: joints are forces on both sides (`closing.rs`). Where a part gives way without mass these forces are solved for, elsewhere
//! the motions that the joints allow get a basis (`whole.rs`), so that nothing indefinite remains. Over it the assembly is reduced like a mesh: free-free modes,
//! residual flexibility (`assembled.rs`), and inertia invariants that follow from the parts' without loss (`inertia.rs`). `bounds.rs` says what the parts'
//! own truncation does to the frequencies. Derivations: `docs/assemblies.md`.

mod assembled;
mod beyond;
mod bounds;
mod chosen;
mod closing;
mod error;
mod fields;
mod inertia;
mod joint;
mod measure;
mod part;
mod report;
mod responses;
mod spot;
mod spring;
mod stresses;
mod whole;

use std::path::PathBuf;

use dcb_formats::assembly::Assembly;
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::mesh::Mesh;
use dcb_formats::scene::BodyKind;
use dcb_formats::superelement::{RecoveryBasis, Superelement};
use nalgebra::{Matrix3, Vector3};

pub use assembled::KeptModes;
pub use bounds::ModeBound;
pub use error::Error;
pub use fields::Inside;
pub use joint::Meeting;
pub use report::{AssemblyReport, PartReport};
pub use responses::ResponseEstimate;
pub use whole::LooseMotions;

use assembled::{Basis, Certified, superelement};
use bounds::{Count, shares};
use chosen::Chosen;
use closing::Closing;
use fields::{first_nodes, joined_mesh, recovered};
use joint::{Fit, Held, held};
use measure::stiffness;
use part::Part;
use report::Known;
use responses::estimate;
use spot::{Place, refuse_observed};
use spring::sprung;
use stresses::stresses;
use whole::Whole;

/// Gap of places that are joined, by the size of the whole, where nothing is said.
const ALLOWED_GAP: f64 = 1e-6;
/// Placements of one file that differ by less than this, by the size of the whole, are the same.
const SAME_PLACE: f64 = 1e-9;

/// A superelement's file as an assembly uses it.
#[derive(Clone, Debug)]
pub struct LoadedPart {
    /// Its content.
    pub superelement: Superelement,
    /// Its mesh and fields.
    pub inside: Inside,
    /// The file.
    pub file: PathBuf,
    /// Its digest.
    pub digest: String,
}

/// Whether meshes and fields are taken along.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InsideChoice {
    /// Where the files have them.
    #[default]
    Kept,
    /// Not even where they have them.
    LeftOut,
}

/// What is asked of an assembly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The modes that are kept.
    pub modes: KeptModes,
    /// Treatment of motions without stiffness.
    pub loose: LooseMotions,
}

/// The assembly as one superelement.
#[derive(Clone, Debug)]
pub struct Assembled {
    /// For the dynamics.
    pub superelement: Superelement,
    /// Nodal shapes of the parts that have them.
    pub recovery: Option<RecoveryBasis>,
    /// Their meshes.
    pub mesh: Option<Mesh>,
    /// How its parts fit, and what limits it.
    pub report: AssemblyReport,
}

/// The superelements of an assembly in the order of its bodies; `None` for rigid bodies.
///
/// # Errors
/// [`Error::File`] for a file that isn't a superelement; [`Error::Body`] for other units or another dimension.
pub fn load(assembly: &Assembly, inside: InsideChoice) -> Result<Vec<Option<LoadedPart>>, Error> {
    let mut all = Vec::new();
    for (name, body) in &assembly.scene.bodies {
        let BodyKind::Superelement(of) = &body.kind else {
            all.push(None);
            continue;
        };
        let path = assembly.scene.resolve(&of.file);
        let file = SuperelementFile::open(&path)?;
        let superelement = file.for_dynamics()?;
        if superelement.dimension != assembly.scene.dimension {
            return Err(Error::body(
                name,
                format!(
                    "{} has {} dimensions, the assembly {}",
                    path.display(),
                    superelement.dimension.coordinate_count(),
                    assembly.scene.dimension.coordinate_count()
                ),
            ));
        }
        let (own, whole) = (&superelement.units, &assembly.scene.units);
        if own != whole {
            return Err(Error::body(
                name,
                format!(
                    "{} is in {}, {}, {} and the assembly in {}, {}, {}; reduce all parts in one system of units",
                    path.display(),
                    own.length,
                    own.mass,
                    own.time,
                    whole.length,
                    whole.mass,
                    whole.time
                ),
            ));
        }
        let inside = match inside {
            InsideChoice::LeftOut => Inside::default(),
            InsideChoice::Kept => Inside {
                recovery: file.recovery()?,
                mesh: file.mesh()?,
            },
        };
        all.push(Some(LoadedPart {
            superelement,
            inside,
            digest: file.digest().to_owned(),
            file: path,
        }));
    }
    Ok(all)
}

/// Puts the bodies together. `loaded` are their superelements ([`load`]).
///
/// # Errors
/// [`Error::Place`] where joints, springs or interfaces don't fit their places, [`Error::Whole`] if the result isn't one body, [`Error::NotFinite`].
pub fn assemble(
    assembly: &Assembly,
    loaded: Vec<Option<LoadedPart>>,
    options: &Options,
) -> Result<Assembled, Error> {
    let scene = &assembly.scene;
    let mut parts = Vec::new();
    let mut insides = Vec::new();
    let mut files: Vec<Option<(PathBuf, String)>> = Vec::new();
    for ((name, body), loaded) in scene.bodies.iter().zip(loaded) {
        let mirror = assembly.mirrors.get(name);
        let reflection = mirror.map_or_else(Matrix3::identity, |mirror| mirror.reflection());
        let (element, inside, file) = match loaded {
            None => (None, Inside::default(), None),
            Some(of) => (Some(of.superelement), of.inside, Some((of.file, of.digest))),
        };
        parts.push(Part::of(name, body, reflection, scene.dimension, element)?);
        insides.push(inside);
        files.push(file);
    }
    let size = size(&parts);
    refuse_twice(&parts, &files, size)?;
    let fit = Fit {
        dimension: scene.dimension,
        size,
        allowed: assembly.allow_gap.unwrap_or(ALLOWED_GAP * size),
        length_unit: &scene.units.length,
    };
    let (joined, meetings) = joints(assembly, &fit, &parts)?;
    let mut springs = Vec::new();
    for (name, spring) in &scene.springs {
        springs.extend(sprung(name, spring, scene, scene.dimension, &parts)?);
    }
    let mass: f64 = parts.iter().map(|part| part.mass).sum();
    let centre = parts
        .iter()
        .fold(Vector3::zeros(), |sum, part| sum + part.mass * part.centre)
        / mass;
    let chosen = Chosen::of(assembly, &parts, &first_nodes(&insides), centre)?;
    let closing = Closing::of(&joined, &springs, &chosen.measures, &parts)?;
    let whole = Whole::of(&parts, &closing, centre, options.loose)?;
    let basis = Basis::of(&whole, &closing, &chosen, options.modes);
    let count = Count::of(&parts, &joined, &springs);
    let bounds = count
        .as_ref()
        .ok()
        .map(|count| mode_bounds(&parts, &closing, &whole, &basis, count));
    let certified = count
        .as_ref()
        .ok()
        .zip(bounds.as_ref())
        .map(|(count, bounds)| {
            let still = whole.rigid.ncols();
            let place = still + basis.eigenvalues.len();
            let from = basis.first_omitted.min(count.limit);
            let loose = whole.loose.ncols();
            Certified {
                eigenvalue_bound: count.lower(place, from),
                eigenvalue_errors: (0..loose)
                    .map(|_| 0.0)
                    .chain(bounds.iter().map(|of| {
                        if of.lower > 0.0 {
                            of.reduced / of.lower - 1.0
                        } else {
                            f64::MAX
                        }
                    }))
                    .collect(),
            }
        });
    // Without a bound from below nothing is known of what the modes leave out.
    let certified = certified.filter(|of: &Certified| {
        of.eigenvalue_bound > 0.0 && of.eigenvalue_errors.iter().all(|error| *error < f64::MAX)
    });
    let (mut element, columns, coupling) = superelement(
        assembly, &parts, &whole, &closing, chosen, &basis, certified,
    )?;
    element.stresses = stresses(&parts, &columns, centre, &first_nodes(&insides));
    let responses = match (&count, basis.eigenvalues.last()) {
        (Ok(count), Some(highest)) => {
            estimate(&parts, &whole, &closing, 0.25 * highest, count.limit)
        }
        _ => None,
    };
    let known = Known {
        meetings,
        modes: bounds,
        responses,
        without_estimate: count.err(),
        damping_coupling: coupling,
    };
    let report = AssemblyReport::of(&parts, &files, &whole, known);
    let mode_count = element.mode_count();
    let mut assembled = Assembled {
        mesh: joined_mesh(&parts, &insides, scene.dimension),
        recovery: recovered(&parts, &insides, &columns, mode_count),
        superelement: element,
        report,
    };
    assembled.superelement.provenance = assembled.report.provenance(&parts, &files);
    Ok(assembled)
}

/// What joints hold, and how well their places meet.
fn joints(
    assembly: &Assembly,
    fit: &Fit<'_>,
    parts: &[Part],
) -> Result<(Vec<Held>, Vec<Meeting>), Error> {
    let scene = &assembly.scene;
    let mut all = Vec::new();
    let mut meetings = Vec::new();
    for (name, joint) in &scene.joints {
        let location = format!("joints.{name}.{}", joint.kind());
        let Some([a, b]) = joint.attachments() else {
            return Err(Error::place(location, "joins no two places"));
        };
        for place in [a, b] {
            refuse_observed(&location, place, parts)?;
        }
        let places = [
            Place::of(&format!("{location}.a"), a, scene, parts)?,
            Place::of(&format!("{location}.b"), b, scene, parts)?,
        ];
        let (own, meeting) = held(name, joint, &places, fit, parts)?;
        all.extend(own);
        meetings.push(meeting);
    }
    Ok((all, meetings))
}

/// Frequencies of the kept elastic modes between their bounds.
fn mode_bounds(
    parts: &[Part],
    closing: &Closing,
    whole: &Whole,
    basis: &Basis,
    count: &Count<'_>,
) -> Vec<ModeBound> {
    let (still, loose) = (whole.rigid.ncols(), whole.loose.ncols());
    let squares = &basis.eigenvalues[loose..];
    let shapes = basis.modes.subcols(loose, squares.len()).to_owned();
    let shares = shares(parts, closing, &stiffness(parts), squares, &shapes);
    let bound = |(k, (reduced, shares)): (usize, (&f64, Vec<f64>))| ModeBound {
        reduced: *reduced,
        lower: count.lower(still + loose + k, *reduced).min(*reduced),
        shares,
    };
    squares.iter().zip(shares).enumerate().map(bound).collect()
}

/// Diagonal of the box around all places, centres and radii of gyration.
fn size(parts: &[Part]) -> f64 {
    let mut low = Vector3::repeat(f64::INFINITY);
    let mut high = Vector3::repeat(f64::NEG_INFINITY);
    let mut take = |point: Vector3<f64>| {
        low = low.inf(&point);
        high = high.sup(&point);
    };
    for part in parts {
        take(part.centre);
        if let Some(flexible) = part.flexible() {
            let radius = flexible.element.inertia.radius_of_gyration();
            take(part.centre + Vector3::repeat(radius));
            take(part.centre - Vector3::repeat(radius));
            for row in &flexible.element.rows {
                take(part.place(row.position));
            }
        }
    }
    let size = (high - low).norm();
    if size > 0.0 && size.is_finite() {
        size
    } else {
        1.0
    }
}

/// One file twice at one place is a part counted twice.
fn refuse_twice(
    parts: &[Part],
    files: &[Option<(PathBuf, String)>],
    size: f64,
) -> Result<(), Error> {
    for (i, part) in parts.iter().enumerate() {
        for (j, other) in parts[..i].iter().enumerate() {
            let (Some((file, digest)), Some((_, same))) = (&files[i], &files[j]) else {
                continue;
            };
            let apart =
                (part.centre - other.centre).norm() / size + (part.axes - other.axes).norm();
            if digest == same && apart < SAME_PLACE {
                return Err(Error::body(
                    &part.name,
                    format!(
                        "is {} at the place of {:?}, which is the same file; give one of them another `position`",
                        file.display(),
                        other.name
                    ),
                ));
            }
        }
    }
    Ok(())
}
