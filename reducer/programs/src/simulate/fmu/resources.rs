//! The folder that a unit is made of: the scene and its superelements, of whose nodal fields only those that outputs name.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use dcb_cosimulation::SCENE;
use dcb_formats::dcb::{Compression, Contents, SuperelementFile, WriteOptions, write_superelement};
use dcb_formats::mesh::Mesh;
use dcb_formats::output::{Replace, write_text};
use dcb_formats::scene::{BodyKind, Scene};
use dcb_runtime::error::Error;

use super::archive::Member;

/// What was written.
pub struct Resources {
    superelements: Vec<Part>,
}

/// A superelement of the archive.
struct Part {
    from: PathBuf,
    name: String,
    /// Nodes of its mesh that outputs name.
    nodes: BTreeSet<u32>,
    /// Bytes before and after.
    sizes: [u64; 2],
}

impl Resources {
    /// Writes a scene and its superelements into a folder.
    pub fn write(mut scene: Scene, folder: &Path) -> Result<Self, Error> {
        let mut parts = parts(&scene);
        for part in &mut parts {
            part.write(folder)?;
        }
        let names: BTreeMap<PathBuf, String> = parts
            .iter()
            .map(|part| (part.from.clone(), part.name.clone()))
            .collect();
        let origin = scene.directory.clone();
        for body in scene.bodies.values_mut() {
            if let BodyKind::Superelement(of) = &mut body.kind
                && let Some(name) = names.get(&origin.join(&of.file))
            {
                of.file = PathBuf::from(name);
            }
        }
        // Nothing is recorded by a unit, and no fields are written.
        scene.schema = None;
        scene.record = None;
        scene.fields.clear();
        let text = serde_json::to_string_pretty(&scene).unwrap_or_default();
        write_text(&folder.join(SCENE), &(text + "\n"))?;
        Ok(Self {
            superelements: parts,
        })
    }

    /// Its files for the archive.
    pub fn members(&self, folder: &Path) -> Result<Vec<Member>, Error> {
        let names = self.superelements.iter().map(|part| part.name.as_str());
        let names = std::iter::once(SCENE).chain(names);
        let member = |name: &str| {
            let path = folder.join(name);
            let content = std::fs::read(&path)
                .map_err(|source| dcb_formats::Error::io(&path, "cannot read", source))?;
            Ok(Member::new(format!("resources/{name}"), content))
        };
        names.map(member).collect()
    }

    /// One line on each superelement.
    pub fn parts(&self) -> impl Iterator<Item = String> {
        self.superelements.iter().map(|part| {
            let [before, after] = part.sizes;
            let nodes = match part.nodes.len() {
                0 => "without nodal fields".to_owned(),
                1 => "with the fields of 1 node".to_owned(),
                count => format!("with the fields of {count} nodes"),
            };
            format!(
                "{} from {}: {after} of {before} bytes, {nodes}",
                part.name,
                part.from.display()
            )
        })
    }
}

/// The superelements of a scene, each once, with names of their own.
fn parts(scene: &Scene) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    for (body, of) in scene.superelements() {
        let from = scene.resolve(&of.file);
        let nodes = scene.outputs.values().filter_map(|output| output.node());
        let nodes = nodes.filter(|(of, _)| *of == body).map(|(_, node)| node);
        match parts.iter_mut().find(|part| part.from == from) {
            Some(part) => part.nodes.extend(nodes),
            None => {
                let nodes = nodes.collect();
                let name = free_name(&from, &parts);
                parts.push(Part {
                    from,
                    name,
                    nodes,
                    sizes: [0; 2],
                });
            }
        }
    }
    parts
}

/// The name of a file in plain letters, with a number where another one has it.
fn free_name(path: &Path, parts: &[Part]) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.strip_suffix(".dcb.h5").unwrap_or(&name);
    let plain = |c: char| match c {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '-' | '_' | '.' => c,
        _ => '_',
    };
    let stem: String = stem.chars().map(plain).collect();
    let mut name = format!("{stem}.dcb.h5");
    // Some systems don't tell small letters from capitals.
    let is_taken = |name: &str| {
        parts
            .iter()
            .any(|part| part.name.eq_ignore_ascii_case(name))
    };
    let mut number = 2;
    while is_taken(&name) {
        name = format!("{stem}-{number}.dcb.h5");
        number += 1;
    }
    name
}

impl Part {
    fn write(&mut self, folder: &Path) -> Result<(), Error> {
        let file = SuperelementFile::open(&self.from)?;
        let superelement = file.for_dynamics()?;
        let nodes: Vec<u32> = self.nodes.iter().copied().collect();
        let (recovery, mesh) = match nodes.is_empty() {
            true => (None, None),
            false => (
                file.recovery_of(&nodes)?,
                file.mesh()?.map(Mesh::points_alone),
            ),
        };
        let target = folder.join(&self.name);
        write_superelement(
            &target,
            &Contents {
                superelement: &superelement,
                recovery: recovery.as_ref(),
                mesh: mesh.as_ref(),
            },
            &WriteOptions {
                replace_existing: Replace::Refuse,
                compression: Compression::None,
            },
        )?;
        let size = |path: &Path| -> Result<u64, Error> {
            let data = std::fs::metadata(path)
                .map_err(|source| dcb_formats::Error::io(path, "cannot read", source))?;
            Ok(data.len())
        };
        self.sizes = [size(&self.from)?, size(&target)?];
        Ok(())
    }
}
