//! The superelements of a scene, each file read once however many bodies are made of it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use dcb_formats::component::Units;
use dcb_formats::mesh::{Dimension, Mesh};
use dcb_formats::superelement::{RecoveryBasis, Superelement};
use faer::Mat;
use indexmap::IndexMap;

use super::bodies;
use crate::body::{Compatibility, FlexibleBody, RigidBody};
use crate::error::Error;
use dcb_demand::{AskedPart, Carried, Carrying, LeftOut, PartFile, SuperelementFiles};
use dcb_formats::scene::{self, Body, BodyKind, Scene, SuperelementBody};
use dcb_superelement::{ErrorBounds, MadeFor};

/// Content of one file that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedFile {
    /// Where it was read from.
    pub path: PathBuf,
    /// Digest over its contents.
    pub digest: String,
    /// Warnings of its reduction.
    pub warnings: Vec<String>,
}

/// Nodal fields of one node.
pub struct FieldsOfNode {
    /// Rows of this node alone.
    pub basis: RecoveryBasis,
    /// At rest, component axes.
    pub position: [f64; 3],
}

/// Files that were opened and bodies that were made of them.
pub struct Library {
    units: Units,
    dimension: Dimension,
    compatibility: Compatibility,
    carrying: Carrying,
    open: SuperelementFiles,
    files: IndexMap<PathBuf, OpenFile>,
}

/// How a body uses a superelement, and what is carried of it.
#[derive(Clone, PartialEq)]
struct Use {
    of: SuperelementBody,
    carried: Option<Carried>,
}

struct OpenFile {
    file: PartFile,
    bodies: Vec<(Use, Arc<FlexibleBody>)>,
    fields: Vec<(Use, Arc<(RecoveryBasis, Mesh)>)>,
}

impl OpenFile {
    /// The superelement as the scene has it for a body.
    fn asked(&self, name: &str, of: &SuperelementBody) -> Result<AskedPart<'_>, Error> {
        let available = self.file.superelement().mode_count();
        match of.modes {
            Some(wanted) if wanted as usize > available => Err(Error::described(
                format!("bodies.{name}.modes"),
                format!("is {wanted}, but the superelement has {available} modes"),
            )),
            _ => Ok(AskedPart::of(&self.file, of)?),
        }
    }

    /// The superelement as a body carries it; `None` where it carries it as rigid.
    fn carried_as(&self, name: &str, used: &Use) -> Result<Option<Superelement>, Error> {
        let asked = self.asked(name, &used.of)?;
        Ok(match &used.carried {
            Some(Carried::Rigid) => None,
            Some(Carried::Selection(selection)) => {
                Some(selection.superelement(asked.superelement())?)
            }
            None => Some(asked.superelement().clone()),
        })
    }

    /// The body in its own coordinates.
    fn flexible_body(
        &self,
        name: &str,
        used: &Use,
        compatibility: Compatibility,
    ) -> Result<FlexibleBody, Error> {
        let of = &used.of;
        let Some(superelement) = self.carried_as(name, used)? else {
            let asked = self.asked(name, of)?;
            return FlexibleBody::rigid(&RigidBody::locked(asked.superelement()));
        };
        let mut body = FlexibleBody::from_superelement(&superelement, compatibility)?;
        let of_file = self.file.superelement().selections().len();
        body.made_for = MadeFor::of_run(&superelement, of_file);
        if body.is_stiffened() && of.inertia_change != scene::InertiaChange::SecondOrder {
            return Err(Error::described(
                format!("bodies.{name}.inertia_change"),
                "must be \"second-order\" with geometric stiffening, which is of that order; or set \"geometric_stiffening\": \"off\"",
            ));
        }
        body = body.with_inertia_change(of.inertia_change);
        if let Some(damping) = &of.damping {
            let modes: Vec<usize> = match &used.carried {
                Some(Carried::Selection(selection)) => selection.modes().to_vec(),
                Some(Carried::Rigid) | None => (0..body.mode_count).collect(),
            };
            bodies::damp(
                &mut body,
                damping,
                &modes,
                self.file.superelement().mode_count(),
            );
        }
        Ok(body)
    }

    /// Nodal fields of the file as a body has them.
    fn recovered(
        &self,
        basis: RecoveryBasis,
        used: &Use,
        body: &str,
        at: &str,
    ) -> Result<RecoveryBasis, Error> {
        if self.file.superelement().enrichment.is_some() && basis.enrichment.is_none() {
            return Err(Error::described(
                at,
                format!(
                    "needs the nodal fields of the further columns of body {body:?}, which its file (of format 1.0) doesn't have; reduce it again"
                ),
            ));
        }
        let asked = self.asked(body, &used.of)?;
        let basis = asked.recovered(basis)?;
        match &used.carried {
            Some(Carried::Selection(selection)) => {
                Ok(selection.recovery(asked.superelement(), &basis)?)
            }
            // Its nodes move with the frame alone.
            Some(Carried::Rigid) => {
                let none = || Mat::zeros(basis.dofs.len(), 0);
                Ok(RecoveryBasis {
                    modes: none(),
                    residual: none(),
                    enrichment: None,
                    dofs: basis.dofs,
                })
            }
            None => Ok(basis),
        }
    }
}

fn without_fields(body: &str, at: &str) -> Error {
    Error::described(
        at,
        format!(
            "needs nodal fields, but the superelement of body {body:?} has none; reduce it with them"
        ),
    )
}

impl Library {
    /// Empty, for superelements in the scene's units and dimension.
    pub fn for_scene(scene: &Scene, carrying: &Carrying, open: &SuperelementFiles) -> Self {
        Self {
            units: scene.units.clone(),
            dimension: scene.dimension,
            compatibility: scene.compatibility,
            carrying: carrying.clone(),
            open: open.clone(),
            files: IndexMap::new(),
        }
    }

    /// The description of one body of the scene.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Description`], and those of [`FlexibleBody`]'s constructors.
    pub fn body(
        &mut self,
        scene: &Scene,
        name: &str,
        body: &Body,
    ) -> Result<Arc<FlexibleBody>, Error> {
        match &body.kind {
            BodyKind::Rigid(rigid) => {
                let rigid = bodies::rigid(scene, name, rigid);
                Ok(Arc::new(FlexibleBody::rigid(&rigid)?))
            }
            BodyKind::Superelement(of) => self.superelement(scene, name, of),
        }
    }

    fn superelement(
        &mut self,
        scene: &Scene,
        name: &str,
        of: &SuperelementBody,
    ) -> Result<Arc<FlexibleBody>, Error> {
        let path = scene.resolve(&of.file);
        let compatibility = self.compatibility;
        self.open(&path, name)?;
        let used = self.use_of(name, of);
        let opened = &mut self.files[&path];
        let known = opened.bodies.iter().find(|(same, _)| *same == used);
        if let Some((_, body)) = known {
            return Ok(body.clone());
        }
        let body = opened.flexible_body(name, &used, compatibility)?;
        let body = Arc::new(body);
        opened.bodies.push((used, body.clone()));
        Ok(body)
    }

    /// Bounds of what a body's superelement leaves out; `None` for rigid bodies, and for files that don't tell.
    ///
    /// # Errors
    /// As [`Library::body`].
    pub fn error_bounds(
        &mut self,
        scene: &Scene,
        name: &str,
    ) -> Result<Option<ErrorBounds>, Error> {
        let Some((opened, used)) = self.flexible(scene, name) else {
            return Ok(None);
        };
        match opened.carried_as(name, &used)? {
            Some(superelement) => Ok(ErrorBounds::of(&superelement, self.compatibility)?),
            None => Ok(None),
        }
    }

    fn open(&mut self, path: &Path, name: &str) -> Result<(), Error> {
        if self.files.contains_key(path) {
            return Ok(());
        }
        let at = format!("bodies.{name}.superelement");
        let file = PartFile::open(&self.open, path, self.dimension, &at)?;
        let (found, expected) = (&file.superelement().units, &self.units);
        if found != expected {
            return Err(Error::described(
                at,
                format!(
                    "{} is in {}, {}, {}, but the scene is in {}, {}, {}; use the same units in both",
                    path.display(),
                    found.length,
                    found.mass,
                    found.time,
                    expected.length,
                    expected.mass,
                    expected.time
                ),
            ));
        }
        self.files.insert(
            path.to_owned(),
            OpenFile {
                file,
                bodies: Vec::new(),
                fields: Vec::new(),
            },
        );
        Ok(())
    }

    /// Nodal fields and mesh of a body's superelement, all of them, read when they are first asked for. `at` is who asks.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Description`] if the file has none.
    pub fn fields(
        &mut self,
        scene: &Scene,
        body: &str,
        at: &str,
    ) -> Result<Arc<(RecoveryBasis, Mesh)>, Error> {
        let none = || without_fields(body, at);
        let (opened, used) = self.flexible(scene, body).ok_or_else(none)?;
        let known = opened.fields.iter().find(|(same, _)| *same == used);
        if let Some((_, fields)) = known {
            return Ok(fields.clone());
        }
        if opened.file.left_out().is_some() {
            return Err(Error::described(
                at,
                format!(
                    "needs the mesh of body {body:?} in the plane, but its superelement is spatial; ask for nodes in outputs, or use the part in space"
                ),
            ));
        }
        let basis = opened.file.recovery()?.ok_or_else(none)?;
        let basis = opened.recovered(basis, &used, body, at)?;
        let mesh = opened.file.mesh()?.ok_or_else(none)?;
        let fields = Arc::new((basis, mesh));
        opened.fields.push((used, fields.clone()));
        Ok(fields)
    }

    /// Nodal fields of one node of a body's superelement, without those of the others; `at` is who asks.
    ///
    /// # Errors
    /// As [`Library::fields`], and [`Error::Description`] if they don't have the node.
    pub fn fields_of_node(
        &mut self,
        scene: &Scene,
        body: &str,
        node: u32,
        at: &str,
    ) -> Result<FieldsOfNode, Error> {
        let none = || without_fields(body, at);
        let (opened, used) = self.flexible(scene, body).ok_or_else(none)?;
        let basis = opened.file.recovery_of(&[node])?.ok_or_else(none)?;
        let basis = opened.recovered(basis, &used, body, at)?;
        let node_count = opened.file.node_count().ok_or_else(none)?;
        let moves = basis.dofs.iter().filter(|dof| !dof.direction.is_rotation());
        match opened.file.node_position(node)? {
            Some(position) if moves.count() == self.dimension.coordinate_count() => {
                Ok(FieldsOfNode { basis, position })
            }
            _ => Err(Error::described(
                format!("{at}.node"),
                format!(
                    "is {node}, but the fields of body {body:?} don't have it (mesh of {node_count} nodes, counted from 0)"
                ),
            )),
        }
    }

    /// Motions of a body's superelement out of the plane of the scene; `None` for rigid bodies and superelements of the scene's dimension.
    pub fn out_of_plane(&mut self, scene: &Scene, body: &str) -> Option<&LeftOut> {
        let (opened, _) = self.flexible(scene, body)?;
        opened.file.left_out()
    }

    /// The open file that a body is made of, and how the body uses it.
    fn flexible(&mut self, scene: &Scene, body: &str) -> Option<(&mut OpenFile, Use)> {
        let BodyKind::Superelement(of) = &scene.bodies.get(body)?.kind else {
            return None;
        };
        let used = self.use_of(body, of);
        let opened = self.files.get_mut(&scene.resolve(&of.file))?;
        Some((opened, used))
    }

    fn use_of(&self, body: &str, of: &SuperelementBody) -> Use {
        Use {
            of: of.clone(),
            carried: self.carrying.bodies.get(body).cloned(),
        }
    }

    /// Content that was read.
    pub fn into_files(self) -> Vec<LoadedFile> {
        self.files
            .into_iter()
            .map(|(path, opened)| LoadedFile {
                path,
                digest: opened.file.digest().to_owned(),
                warnings: opened.file.superelement().provenance.warnings.clone(),
            })
            .collect()
    }
}
