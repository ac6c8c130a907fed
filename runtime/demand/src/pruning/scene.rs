//! All superelements of a scene, each as the scene needs it.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use indexmap::IndexMap;
use nalgebra::Vector3;

use super::{Carried, Carrying, NarrowedScene, Pruned};
use crate::demand::{Demand, NodeDemand, PartInterface, Parts, PlanesOfMotion};
use crate::{AskedPart, Error, LeftOut, PartFile, SuperelementFiles};
use dcb_formats::further_column::Answer;
use dcb_formats::scene::{Analysis, Compatibility, RedundantConstraints, Scene, SuperelementBody};
use dcb_formats::superelement::Superelement;
use dcb_superelement::selection::{ObservedNodes, Selection};

/// Planes with normals of a smaller sine are the same.
const PARALLEL: f64 = 1e-6;

/// Contents of the superelements that a scene carries.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pruning {
    /// By the names of the bodies.
    pub bodies: IndexMap<String, Pruned>,
    /// Normal of a plane that no motion of the scene leaves, world axes, if that is made use of.
    pub plane: Option<[f64; 3]>,
}

/// A body and the superelement that it is made of, as far as the scene says itself.
struct Given<'a> {
    name: &'a str,
    file: &'a PartFile,
    asked: AskedPart<'a>,
    /// Without its Krylov columns, where it is taken so.
    plain: Option<Plain>,
}

/// A superelement without its Krylov columns, and how it is taken from the whole.
struct Plain {
    selection: Selection,
    superelement: Superelement,
}

impl Pruning {
    /// Finds out. Nothing is left out with weak compatibility, whose interface forces are coordinates.
    ///
    /// # Errors
    /// Those of files that can't be read, of [`Demand::of`] and of [`Pruned::of`].
    pub fn of(scene: &Scene, open: &SuperelementFiles, tolerance: f64) -> Result<Self, Error> {
        if scene.compatibility == Compatibility::Weak {
            return Ok(Self::default());
        }
        let files = opened(scene, open)?;
        Self::of_given(scene, &all_given(scene, &files)?, tolerance)
    }

    /// Finds out what else isn't needed where no Krylov column is carried: these make a superelement so exact that it can be a reference. `None` where there are none.
    /// What the lack of the columns costs isn't among the costs.
    ///
    /// # Errors
    /// Those of [`Self::of`].
    pub fn without_krylov_columns(
        scene: &Scene,
        open: &SuperelementFiles,
        tolerance: f64,
    ) -> Result<Option<Self>, Error> {
        if scene.compatibility == Compatibility::Weak {
            return Ok(None);
        }
        let files = opened(scene, open)?;
        let mut given = all_given(scene, &files)?;
        let mut had_columns = false;
        for part in &mut given {
            had_columns |= part.drop_krylov_columns()?;
        }
        match had_columns {
            true => Self::of_given(scene, &given, tolerance).map(Some),
            false => Ok(None),
        }
    }

    fn of_given(scene: &Scene, given: &[Given], tolerance: f64) -> Result<Self, Error> {
        let parts: Parts = (given.iter())
            .map(|given| {
                (
                    given.name.to_owned(),
                    PartInterface::all_of(given.superelement()),
                )
            })
            .collect();
        let prune = |planes: Planes| -> Result<Self, Error> {
            let mut bodies = IndexMap::new();
            for given in given {
                let pruned = given.pruned(scene, &parts, tolerance, planes)?;
                bodies.insert(given.name.to_owned(), pruned);
            }
            Ok(Self {
                bodies,
                plane: None,
            })
        };
        // A plane of motion is one if every part is symmetric to it.
        let mut in_planes = prune(Planes::Scene)?;
        match in_planes.leaves_no_plane() {
            true => {
                in_planes.stay_in_plane(scene, &parts);
                Ok(in_planes)
            }
            false => prune(Planes::None),
        }
    }

    /// Leaves out what leads out of the plane of the bodies, for a motion over time if it is along the frames of the scene. Not where redundant
    /// constraints are refused: those that hold motion out of the plane are among them.
    fn stay_in_plane(&mut self, scene: &Scene, parts: &Parts) {
        let is_wanted = matches!(scene.analysis, Analysis::Transient)
            && scene.redundant_constraints == RedundantConstraints::MinimumNorm;
        let mut normals = (self.bodies.iter()).filter_map(|(name, pruned)| {
            let turn = scene.bodies.get(name)?.placement().orientation;
            let mut across = Vector3::zeros();
            across[pruned.plane?.axes()[2]] = 1.0;
            Some(turn * across)
        });
        let Some(normal) = normals.next().filter(|_| is_wanted) else {
            return;
        };
        let planes = PlanesOfMotion::of(scene, parts).planes;
        self.plane = (planes.iter())
            .filter(|plane| plane.is_along_frames)
            .map(|plane| Vector3::from(plane.normal))
            .find(|own| own.cross(&normal).norm() <= PARALLEL)
            .map(Into::into);
        let Some([x, y, z]) = self.plane else { return };
        for pruned in self.bodies.values_mut() {
            pruned.left_out.push(LeftOut {
                what: format!(
                    "motion out of the plane across [{x}, {y}, {z}] and the constraints that hold it"
                ),
                why: "scene and parts are symmetric to it, so that nothing excites it".to_owned(),
                cost: None,
            });
        }
    }

    /// Everything is carried, as far as it isn't rigid.
    ///
    /// # Errors
    /// Those of files that can't be read.
    pub fn nothing(scene: &Scene, open: &SuperelementFiles) -> Result<Self, Error> {
        let files = opened(scene, open)?;
        let mut bodies = IndexMap::new();
        for (name, of) in scene.superelements() {
            let given = Given::of(name, of, &files[&scene.resolve(&of.file)])?;
            let whole = given.asked.superelement();
            let selection = Selection::everything(whole);
            let everything = Pruned {
                has_bound_modes: !selection.allows_fewer_modes(whole),
                carried: Carried::Selection(Box::new(selection)),
                left_out: Vec::new(),
                plane: None,
                error: 0.0,
            };
            bodies.insert(name.to_owned(), everything);
        }
        Ok(Self {
            bodies,
            plane: None,
        })
    }

    /// Whether every body stays in a plane, or none does.
    fn leaves_no_plane(&self) -> bool {
        let mut planar = self.bodies.values().map(|pruned| match &pruned.carried {
            Carried::Selection(_) => Some(pruned.plane),
            Carried::Rigid => None,
        });
        let first = planar.by_ref().flatten().next();
        planar.flatten().all(|plane| Some(plane) == first)
    }

    /// The scene with what is carried.
    pub fn applied_to(&self, scene: &Scene) -> NarrowedScene {
        let carried =
            (self.bodies.iter()).map(|(name, pruned)| (name.clone(), pruned.carried.clone()));
        NarrowedScene {
            scene: scene.clone(),
            carrying: Carrying {
                bodies: carried.collect(),
                plane: self.plane,
            },
        }
    }

    /// How many things are left out.
    pub fn count(&self) -> usize {
        self.bodies
            .values()
            .map(|pruned| pruned.left_out.len())
            .sum()
    }

    /// Contents left out, in words, body by body.
    pub fn left_out(&self) -> IndexMap<String, Vec<String>> {
        let bodies = self.bodies.iter();
        let told = bodies.map(|(name, pruned)| {
            let lines = pruned.left_out.iter().map(ToString::to_string);
            (name.clone(), lines.collect())
        });
        told.collect()
    }

    /// What leaving out does, in one sentence; `None` where nothing is left out.
    pub fn summary(&self) -> Option<String> {
        let count = self.count();
        let s = match count {
            0 => return None,
            1 => "",
            _ => "s",
        };
        let effect = match self.error() {
            error if error < f64::EPSILON => "responses do not change".to_owned(),
            error => format!("responses change by at most {error:.1e}"),
        };
        Some(format!(
            "simplified for this scene: {count} part{s} of the models left out, {effect}"
        ))
    }

    /// The largest change of a body's response.
    pub fn error(&self) -> f64 {
        let errors = self.bodies.values().map(|pruned| pruned.error);
        errors.fold(0.0, f64::max)
    }
}

impl Display for Pruning {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        for (name, pruned) in &self.bodies {
            if pruned.left_out.is_empty() {
                writeln!(f, "body {name:?}: everything is carried")?;
                continue;
            }
            writeln!(f, "body {name:?}:")?;
            for left_out in &pruned.left_out {
                writeln!(f, "  {left_out}")?;
            }
        }
        Ok(())
    }
}

/// Which planes count.
#[derive(Clone, Copy)]
enum Planes {
    Scene,
    None,
}

impl<'a> Given<'a> {
    fn of(name: &'a str, of: &SuperelementBody, file: &'a PartFile) -> Result<Self, Error> {
        Ok(Self {
            name,
            file,
            asked: AskedPart::of(file, of)?,
            plain: None,
        })
    }

    /// Takes the superelement without its Krylov columns; whether it has any.
    fn drop_krylov_columns(&mut self) -> Result<bool, Error> {
        let whole = self.asked.superelement();
        let names = (whole.enrichment.iter()).flat_map(|enrichment| &enrichment.names);
        let (krylov, others): (Vec<&str>, Vec<&str>) =
            names.map(String::as_str).partition(|name| {
                matches!(
                    Answer::named(name, whole.dimension),
                    Some(Answer::Krylov(_))
                )
            });
        if krylov.is_empty() {
            return Ok(false);
        }
        let selection = Selection::everything(whole).with_enrichment(&others)?;
        self.plain = Some(Plain {
            superelement: selection.superelement(whole)?,
            selection,
        });
        Ok(true)
    }

    /// The superelement that something is left out of.
    fn superelement(&self) -> &Superelement {
        match &self.plain {
            Some(plain) => &plain.superelement,
            None => self.asked.superelement(),
        }
    }

    fn pruned(
        &self,
        scene: &Scene,
        parts: &Parts,
        tolerance: f64,
        planes: Planes,
    ) -> Result<Pruned, Error> {
        let mut demand = Demand::of(scene, self.name, parts)?;
        if matches!(planes, Planes::None) {
            demand.planes.planes.clear();
        }
        let nodes = match &demand.nodes {
            NodeDemand::None => None,
            NodeDemand::Some(nodes) => {
                let nodes: Vec<u32> = nodes.keys().copied().collect();
                self.observed(&nodes)?
            }
            NodeDemand::All(_) => None,
        };
        let mut pruned = Pruned::of(self.superelement(), &demand, nodes.as_ref(), tolerance)?;
        if self.plain.is_some()
            && let Carried::Selection(selection) = &mut pruned.carried
        {
            let own = (**selection).clone();
            **selection = own.of_richer(self.asked.superelement());
            pruned.left_out.push(LeftOut {
                what: "Krylov columns".to_owned(),
                why: "they are there for the reference".to_owned(),
                cost: None,
            });
        }
        pruned.left_out.splice(..0, self.file.left_out().cloned());
        Ok(pruned)
    }

    /// Nodes of the file; `None` if it has no fields, of which the model will complain.
    fn observed(&self, nodes: &[u32]) -> Result<Option<ObservedNodes>, Error> {
        let Some(basis) = self.file.recovery_of(nodes)? else {
            return Ok(None);
        };
        let origin = self.asked.superelement().origin;
        let mut positions = Vec::new();
        for node in nodes {
            if let Some(position) = self.file.node_position(*node)? {
                let relative = std::array::from_fn(|axis| position[axis] - origin[axis]);
                positions.push((*node, relative));
            }
        }
        let basis = self.asked.recovered(basis)?;
        let basis = match &self.plain {
            Some(plain) => plain
                .selection
                .recovery(self.asked.superelement(), &basis)?,
            None => basis,
        };
        Ok(Some(ObservedNodes { basis, positions }))
    }
}

fn all_given<'a>(
    scene: &'a Scene,
    files: &'a IndexMap<PathBuf, PartFile>,
) -> Result<Vec<Given<'a>>, Error> {
    let bodies = scene.superelements();
    bodies
        .map(|(name, of)| Given::of(name, of, &files[&scene.resolve(&of.file)]))
        .collect()
}

fn opened(scene: &Scene, open: &SuperelementFiles) -> Result<IndexMap<PathBuf, PartFile>, Error> {
    let mut files = IndexMap::new();
    for (name, of) in scene.superelements() {
        let path = scene.resolve(&of.file);
        if !files.contains_key(&path) {
            let at = format!("bodies.{name}.superelement");
            let file = PartFile::open(open, &path, scene.dimension, &at)?;
            files.insert(path, file);
        }
    }
    Ok(files)
}
