//! The files of a prepared scene.

use std::path::{Path, PathBuf};

use dcb_formats::dcb::{Compression, Contents, WriteOptions, write_superelement};

use dcb_formats::mesh::Mesh;
use dcb_formats::output::Replace;
use dcb_formats::output::write_text;
use dcb_formats::superelement::{RecoveryBasis, Superelement};
use serde::Serialize;

use super::Prepared;
use dcb_demand::pruning::{Carried, Carrying, NarrowedScene};
use dcb_demand::{AskedPart, PartFile, SuperelementFiles};
use dcb_formats::scene::{BodyKind, DampingOverride, ModalRatios, Scene, SuperelementBody};
use dcb_runtime::body::{Compatibility, FlexibleBody};
use dcb_runtime::error::Error;
use dcb_runtime::run::refuse_inputs;
use dcb_superelement::selection::{NodeSelection, Selection};

/// A superelement as it was written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PreparedFile {
    /// Bodies that are made of it.
    pub bodies: Vec<String>,
    /// The file, in the folder of the prepared scene.
    pub file: PathBuf,
    /// Modes and dynamic attachments.
    pub coordinates: usize,
    /// Bytes.
    pub size: u64,
    /// Source.
    pub from: PathBuf,
    /// Modes and dynamic attachments of that.
    pub of_coordinates: usize,
    /// Bytes of that.
    pub of_size: u64,
}

/// Bodies that are made of one file in one way.
struct Group {
    of: SuperelementBody,
    carried: Option<Carried>,
    bodies: Vec<String>,
    /// Whether the scene writes displacement fields of one of them.
    is_drawn: bool,
}

/// Writes the superelements and the scene, `scene.json`, into a folder that is there.
///
/// # Errors
/// Those of files that can't be read or written.
pub fn write(
    prepared: &Prepared,
    folder: &Path,
    replace: Replace,
) -> Result<Vec<PreparedFile>, Error> {
    let NarrowedScene {
        mut scene,
        carrying,
    } = prepared.narrowed.clone();
    // A path would lead elsewhere from the new folder.
    scene.schema = scene
        .schema
        .filter(|schema| schema.contains("://") && !schema.starts_with("file:"));
    let groups = groups(&scene, &carrying);
    let open = SuperelementFiles::default();
    let names = file_names(&groups);
    for name in &names {
        let target = folder.join(name);
        let sources: Vec<PathBuf> = (groups.iter())
            .map(|group| scene.resolve(&group.of.file))
            .collect();
        let sources = sources.iter().map(PathBuf::as_path);
        refuse_inputs(&target, sources, "a superelement of the scene")?;
    }
    let mut written = Vec::new();
    for (group, name) in groups.iter().zip(&names) {
        let (file, kept) = group.write(&open, &scene, &folder.join(name), replace)?;
        for body in &group.bodies {
            if let Some(described) = scene.bodies.get_mut(body)
                && let BodyKind::Superelement(of) = &mut described.kind
            {
                of.damping = of.damping.as_ref().map(|damping| kept.damping(damping));
                of.file = PathBuf::from(name);
                of.modes = None;
            }
        }
        written.push(file);
    }
    let path = folder.join("scene.json");
    let text = serde_json::to_string_pretty(&scene).unwrap_or_default();
    write_text(&path, &(text + "\n"))?;
    Ok(written)
}

/// Bodies by what they are made of, in the order of the scene.
fn groups(scene: &Scene, carrying: &Carrying) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (name, of) in scene.superelements() {
        let carried = carrying.bodies.get(name);
        let is_same = |group: &&mut Group| {
            (&group.of.file, group.of.modes, group.carried.as_ref())
                == (&of.file, of.modes, carried)
                && group.of.geometric_stiffening == of.geometric_stiffening
        };
        let is_drawn = scene.fields.iter().any(|field| field.body == name);
        match groups.iter_mut().find(is_same) {
            Some(group) => {
                group.bodies.push(name.to_owned());
                group.is_drawn |= is_drawn;
            }
            None => groups.push(Group {
                of: of.clone(),
                carried: carried.cloned(),
                bodies: vec![name.to_owned()],
                is_drawn,
            }),
        }
    }
    groups
}

/// Names of the small files: each that of the large one, with that of the first body where several large or small ones are of one name.
fn file_names(groups: &[Group]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for group in groups {
        let stem = stem(group);
        let same = groups.iter().filter(|other| self::stem(other) == stem);
        let wanted = match group.bodies.first() {
            Some(body) if same.count() > 1 => format!("{stem}-{}", plain(body)),
            _ => stem,
        };
        let numbered = (2..).map(|number| format!("{wanted}-{number}"));
        let mut candidates = std::iter::once(wanted.clone()).chain(numbered);
        let name = candidates.find_map(|name| {
            let name = format!("{name}.dcb.h5");
            (!names.contains(&name)).then_some(name)
        });
        names.extend(name);
    }
    names
}

fn stem(group: &Group) -> String {
    let name = group.of.file.file_name().unwrap_or_default();
    let name = name.to_string_lossy();
    name.strip_suffix(".dcb.h5").unwrap_or(&name).to_owned()
}

/// The name of a body as part of that of a file.
fn plain(body: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    let characters = body.chars();
    characters
        .map(|c| if is_plain(c) { c } else { '_' })
        .collect()
}

/// Places of the modes kept, of so many.
struct KeptModes {
    modes: Vec<usize>,
    of_modes: usize,
}

impl Group {
    fn write(
        &self,
        open: &SuperelementFiles,
        scene: &Scene,
        target: &Path,
        replace: Replace,
    ) -> Result<(PreparedFile, KeptModes), Error> {
        let from = scene.resolve(&self.of.file);
        let at = format!("bodies.{}.superelement", self.bodies.join(","));
        let file = PartFile::open(open, &from, scene.dimension, &at)?;
        let read = file.superelement();
        let asked = AskedPart::of(&file, &self.of)?;
        let whole = asked.superelement();
        let mut selection = self.selection(whole)?;
        if self.is_drawn {
            selection = selection.with_nodes(NodeSelection::All);
        }
        let small = selection.superelement(whole)?;
        let (recovery, mesh) = fields(&file, &selection)?;
        let recovery = recovery.map(|basis| -> Result<RecoveryBasis, Error> {
            Ok(selection.recovery(whole, &asked.recovered(basis)?)?)
        });
        let recovery = recovery.transpose()?;
        write_superelement(
            target,
            &Contents {
                superelement: &small,
                recovery: recovery.as_ref(),
                mesh: mesh.as_ref(),
            },
            &WriteOptions {
                replace_existing: replace,
                compression: Compression::None,
            },
        )?;
        let count = |of: &Superelement| -> Result<usize, Error> {
            let body = FlexibleBody::from_superelement(of, Compatibility::Strong)?;
            Ok(body.coordinate_count())
        };
        let kept = KeptModes {
            modes: selection.modes().to_vec(),
            of_modes: read.mode_count(),
        };
        let made = PreparedFile {
            bodies: self.bodies.clone(),
            file: target.file_name().map(PathBuf::from).unwrap_or_default(),
            coordinates: count(&small)?,
            size: size(target)?,
            of_coordinates: count(read)?,
            of_size: size(&from)?,
            from,
        };
        Ok((made, kept))
    }

    /// A body that doesn't deflect keeps its interfaces, without a coordinate.
    fn selection(&self, whole: &Superelement) -> Result<Selection, Error> {
        match &self.carried {
            Some(Carried::Selection(selection)) => Ok((**selection).clone()),
            None => Ok(Selection::everything(whole)),
            Some(Carried::Rigid) => {
                let loose = whole
                    .modes
                    .eigenvalues
                    .iter()
                    .take_while(|value| **value <= 0.0);
                let kept = 0..loose.count();
                let none = Selection::everything(whole).with_modes(kept)?;
                let nodes = NodeSelection::Only(Default::default());
                Ok(none.with_attachments(0).with_nodes(nodes))
            }
        }
    }
}

impl KeptModes {
    /// The same ratios for the modes that are left; further entries are those of attachments.
    fn damping(&self, damping: &DampingOverride) -> DampingOverride {
        let DampingOverride::Modal(ratios) = damping else {
            return damping.clone();
        };
        DampingOverride::Modal(match ratios {
            ModalRatios::Uniform(ratio) => ModalRatios::Uniform(*ratio),
            ModalRatios::PerMode(list) => {
                let last = list.last().copied().unwrap_or(0.0);
                let of = |mode: &usize| list.get(*mode).copied().unwrap_or(last);
                let attached = list.get(self.of_modes..).filter(|rest| !rest.is_empty());
                let attached = attached.map_or_else(|| vec![last], <[f64]>::to_vec);
                ModalRatios::PerMode(self.modes.iter().map(of).chain(attached).collect())
            }
        })
    }
}

/// Nodal fields and mesh, as far as the selection has nodes: a few nodes need no cells.
fn fields(
    file: &PartFile,
    selection: &Selection,
) -> Result<(Option<RecoveryBasis>, Option<Mesh>), Error> {
    Ok(match selection.nodes() {
        NodeSelection::All => (file.recovery()?, file.mesh()?),
        NodeSelection::Only(nodes) if nodes.is_empty() => (None, None),
        NodeSelection::Only(nodes) => {
            let nodes: Vec<u32> = nodes.iter().copied().collect();
            (
                file.recovery_of(&nodes)?,
                file.mesh()?.map(Mesh::points_alone),
            )
        }
    })
}

fn size(path: &Path) -> Result<u64, Error> {
    let told = |source| dcb_formats::Error::io(path, "cannot read", source);
    Ok(std::fs::metadata(path).map_err(told)?.len())
}
