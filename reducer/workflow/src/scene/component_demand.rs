//! Demand of a scene on a component that isn't reduced yet.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use dcb_demand::PlanarPart;
use dcb_demand::demand::{Demand, Involvement, NodeDemand, PartInterface, Parts, PlaneOfMotion};
use dcb_demand::pruning::Pruned;
use dcb_formats::component::{Component, Interface, InterfaceKind, NamedLoad, Role, Weights};
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::mesh::{Dimension, Direction, Mesh};
use dcb_formats::scene::{Compatibility, DampingOverride, ModalRatios};
use dcb_formats::superelement::Superelement;

use super::PartInScene;
use super::interfaces::part_interfaces;
use dcb_reducer::error::Error;

/// Nodes that are looked at count as rows of the error's bounds up to this number: each takes three solutions with the factorization.
const NODES_WITH_BOUNDS: usize = 64;
/// Name of the interface that stands for them; another one of this name is refused.
pub(super) const WATCHED: &str = "nodes that the scene looks at";

/// Demand on a component by all bodies that are made of it.
#[derive(Clone, Debug)]
pub struct ComponentDemand {
    /// The demand.
    pub demand: Demand,
    /// Notes on the demand and its sources.
    pub notes: Vec<String>,
    /// The component as it is to be reduced: without loads that don't act, with the nodes that are looked at as an output interface.
    pub component: Component,
    /// Names of the loads on its inside that don't act.
    pub idle_loads: Vec<String>,
    /// The scene's file.
    pub scene: PathBuf,
    /// How the scene's interfaces follow the coordinates.
    pub compatibility: Compatibility,
    /// The scene's dimension: a spatial component may be meant for a planar scene.
    pub dimension: Dimension,
}

impl ComponentDemand {
    /// Of the bodies that are made of a component.
    ///
    /// # Errors
    /// [`Error::InScene`] where scene and component don't fit each other; those of [`part_interfaces`].
    pub fn of(part: &PartInScene, component: Component) -> Result<Self, Error> {
        refuse_misfit(part, &component)?;
        let dimension = part.scene.dimension;
        let interfaces = match component.dimension() == dimension {
            true => part_interfaces(&component)?,
            false => PlanarPart::interfaces(&part_interfaces(&component)?),
        };
        let Neighbours {
            superelements,
            mut notes,
        } = Neighbours::of(part);
        let mut parts: Parts = Parts::new();
        for (name, of) in &superelements {
            parts.insert(name.clone(), PartInterface::all_of(of));
        }
        for body in &part.bodies {
            parts.insert(body.clone(), interfaces.clone());
        }
        let demand_of = |body: &str| {
            Demand::of(&part.scene, body, &parts).map_err(|error| part.refused(&error.to_string()))
        };
        let demands: Result<Vec<Demand>, Error> =
            part.bodies.iter().map(|body| demand_of(body)).collect();
        let mut demands = demands?;
        // Planes stand in the same order in every body's demand.
        let mut shared = vec![true; demands.first().map_or(0, |one| one.planes.planes.len())];
        for (name, _) in part.others() {
            let neighbour = superelements.get(name);
            let demand = neighbour.map(|_| demand_of(name)).transpose()?;
            for (index, shared) in shared.iter_mut().enumerate() {
                let of = neighbour.zip(demand.as_ref());
                *shared &= of.is_some_and(|(of, demand)| {
                    let plane = demand.planes.planes.get(index);
                    plane.is_some_and(|plane| is_symmetric(of, demand, plane))
                });
            }
        }
        for demand in &mut demands {
            keep_planes(demand, &shared);
        }
        let demand = Demand::united(&demands, &interfaces)
            .ok_or_else(|| part.refused("has no body of this part"))?;
        refuse_unknown(part, &demand, &component)?;
        notes.extend(notes_on(part));
        if component.dimension() != dimension {
            refuse_fields(part, &demand)?;
            notes.push(
                "the scene is planar: the spatial part is taken through its plane of symmetry, without further columns".to_owned(),
            );
        }
        let watched = watched(&demand, component.dimension(), &mut notes);
        let is_idle = |load: &mut NamedLoad| !demand.part_loads.contains(&load.name);
        let mut idle_loads = Vec::new();
        let component = component
            .changed(|draft| {
                idle_loads.extend(draft.loads.extract_if(.., is_idle).map(|load| load.name));
                draft.interfaces.extend(watched);
            })
            .map_err(|fault| part.refused(&fault.to_string()))?;
        Ok(Self {
            demand,
            notes,
            component,
            idle_loads,
            scene: part.path.clone(),
            compatibility: part.scene.compatibility,
            dimension,
        })
    }

    /// Whether a spatial part is seen by a planar scene.
    pub fn is_seen_in_plane(&self) -> bool {
        self.component.dimension() != self.dimension
    }

    /// Where a node is, in the scene's dimension.
    pub(super) fn position(&self, node: u32) -> [f64; 3] {
        let position = self.component.mesh.position(node);
        match self.is_seen_in_plane() {
            true => PlanarPart::position(position),
            false => position,
        }
    }

    /// The mesh in the scene's dimension.
    pub(super) fn mesh(&self) -> Mesh {
        let mesh = self.component.mesh.clone();
        match self.is_seen_in_plane() {
            true => PlanarPart::mesh(mesh),
            false => mesh,
        }
    }

    /// Whether the part needs no deflection at all.
    pub fn is_rigid(&self) -> bool {
        let Demand {
            involvement,
            interfaces,
            ..
        } = &self.demand;
        match involvement {
            Involvement::Unused => true,
            Involvement::Locked => interfaces.iter().all(|used| used.observed_by.is_empty()),
            Involvement::Involved => false,
        }
    }

    /// Nodes of the mesh that are looked at, and by whom; empty where none are, or all.
    pub(super) fn named_nodes(&self) -> BTreeMap<u32, Vec<String>> {
        match &self.demand.nodes {
            NodeDemand::Some(nodes) => nodes.clone(),
            NodeDemand::None | NodeDemand::All(_) => BTreeMap::new(),
        }
    }

    /// Nodes whose displacement is bounded too.
    pub(super) fn watched_nodes(&self) -> &[u32] {
        let mut interfaces = self.component.interfaces.iter();
        let watched = interfaces.find(|interface| interface.name == WATCHED);
        watched.map_or(&[], |watched| watched.nodes.as_slice())
    }
}

/// Nodes that are looked at, so that their displacement is bounded too.
fn watched(demand: &Demand, dimension: Dimension, notes: &mut Vec<String>) -> Option<Interface> {
    let nodes = match &demand.nodes {
        NodeDemand::None => return None,
        NodeDemand::All(by) => {
            notes.push(format!(
                "{} wants the whole field: the error's bounds are those of the interfaces, not of every node",
                by.join(", ")
            ));
            return None;
        }
        NodeDemand::Some(nodes) if nodes.len() > NODES_WITH_BOUNDS => {
            notes.push(format!(
                "{} nodes are looked at, more than {NODES_WITH_BOUNDS}: the error's bounds are those of the interfaces alone",
                nodes.len()
            ));
            return None;
        }
        NodeDemand::Some(nodes) => nodes.keys().copied().collect(),
    };
    Some(Interface {
        name: WATCHED.to_owned(),
        kind: InterfaceKind::Nodes,
        nodes,
        position: None,
        weights: Weights::Uniform,
        axes: None,
        directions: Some(Direction::ALL[..dimension.coordinate_count()].to_vec()),
        role: Role::Output,
    })
}

/// Superelements of the scene that are made of other parts, as far as there are files.
struct Neighbours {
    superelements: BTreeMap<String, Superelement>,
    notes: Vec<String>,
}

impl Neighbours {
    fn of(part: &PartInScene) -> Self {
        let mut known: BTreeMap<PathBuf, Option<Superelement>> = BTreeMap::new();
        let (mut superelements, mut notes) = (BTreeMap::new(), Vec::new());
        for (name, of) in part.others() {
            let path = part.scene.resolve(&of.file);
            let found = known.entry(path.clone()).or_insert_with(|| {
                match neighbour(&path, part.scene.dimension) {
                    Ok(superelement) => Some(superelement),
                    Err(error) => {
                        notes.push(format!(
                            "what depends on the interfaces of {} is taken in every direction: {error}",
                            of.file.display()
                        ));
                        None
                    }
                }
            });
            if let Some(superelement) = found {
                superelements.insert(name.to_owned(), superelement.clone());
            }
        }
        Self {
            superelements,
            notes,
        }
    }
}

/// The superelement of a file, in the scene's dimension.
fn neighbour(path: &Path, dimension: Dimension) -> Result<Superelement, Error> {
    let superelement = SuperelementFile::open(path)?.for_dynamics()?;
    match superelement.dimension == Dimension::Spatial && dimension == Dimension::Planar {
        true => Ok(PlanarPart::of(&superelement)?.superelement().clone()),
        false => Ok(superelement),
    }
}

/// Whether a part moves in a plane by itself: its superelement is symmetric to it.
fn is_symmetric(superelement: &Superelement, demand: &Demand, plane: &PlaneOfMotion) -> bool {
    let mut demand = demand.clone();
    demand.planes.planes = vec![*plane];
    // Only the plane is of interest: anything may be left out beside it.
    Pruned::of(superelement, &demand, None, f64::INFINITY)
        .is_ok_and(|pruned| pruned.plane.is_some())
}

fn keep_planes(demand: &mut Demand, shared: &[bool]) {
    let planes = std::mem::take(&mut demand.planes.planes);
    for (plane, shared) in planes.into_iter().zip(shared) {
        match shared {
            true => demand.planes.planes.push(plane),
            false => {
                let [x, y, z] = plane.normal;
                demand.planes.refused.push(format!(
                    "across [{x:.4}, {y:.4}, {z:.4}] of the component: other parts aren't known to be symmetric to it"
                ));
            }
        }
    }
}

fn refuse_fields(part: &PartInScene, demand: &Demand) -> Result<(), Error> {
    match &demand.nodes {
        NodeDemand::All(by) => Err(part.refused(&format!(
            "{} wants the whole field, and that of a spatial part isn't drawn in the plane",
            by.join(", ")
        ))),
        NodeDemand::None | NodeDemand::Some(_) => Ok(()),
    }
}

fn refuse_misfit(part: &PartInScene, component: &Component) -> Result<(), Error> {
    let (wanted, own) = (part.scene.dimension, component.dimension());
    let called = |dimension: Dimension| match dimension {
        Dimension::Planar => "planar",
        Dimension::Spatial => "spatial",
    };
    if wanted == Dimension::Spatial && own == Dimension::Planar {
        return Err(part.refused(&format!(
            "the scene is {}, but the component is {}",
            called(wanted),
            called(own)
        )));
    }
    let (wanted, own) = (&part.scene.units, &component.units);
    if wanted != own {
        return Err(part.refused(&format!(
            "the scene is in {}, {}, {}, but the component is in {}, {}, {}; use the same units in both",
            wanted.length, wanted.mass, wanted.time, own.length, own.mass, own.time
        )));
    }
    Ok(())
}

/// Nodes and loads that the component doesn't have.
fn refuse_unknown(part: &PartInScene, demand: &Demand, component: &Component) -> Result<(), Error> {
    if let NodeDemand::Some(nodes) = &demand.nodes {
        let directions = &Direction::ALL[..component.dimension().coordinate_count()];
        let moves = |node: u32| {
            directions
                .iter()
                .all(|direction| component.dofs.row(node, *direction).is_some())
        };
        let count = component.mesh.node_count();
        if let Some((node, by)) =
            (nodes.iter()).find(|(node, _)| **node as usize >= count || !moves(**node))
        {
            return Err(part.refused(&format!(
                "{} names node {node}, which the component doesn't have with every translation (mesh of {count} nodes, counted from 0)",
                by.join(", ")
            )));
        }
    }
    let has = |name: &String| component.loads.iter().any(|load| load.name == *name);
    match demand.part_loads.iter().find(|name| !has(name)) {
        Some(name) => {
            let known: Vec<String> = component
                .loads
                .iter()
                .map(|load| format!("{:?}", load.name))
                .collect();
            let known = match known.is_empty() {
                true => "it has none".to_owned(),
                false => format!("it has {}", known.join(", ")),
            };
            Err(part.refused(&format!("the component has no load {name:?}; {known}")))
        }
        None => Ok(()),
    }
}

/// Settings of the scene that count modes of the file, and outputs outside the error.
fn notes_on(part: &PartInScene) -> Vec<String> {
    let mut notes = Vec::new();
    for name in &part.bodies {
        let Some(of) = part.superelement(name) else {
            continue;
        };
        if of.modes.is_some() {
            notes.push(format!(
                "bodies.{name}.modes counts modes of the file, which are others from now on; take it out of the scene"
            ));
        }
        if let Some(DampingOverride::Modal(ModalRatios::PerMode(_))) = of.damping {
            notes.push(format!(
                "bodies.{name}.damping.modal is a list by modes of the file, which are others from now on"
            ));
        }
    }
    match part.scene.compatibility {
        Compatibility::Strong => {}
        Compatibility::Static | Compatibility::Weak => notes.push(
            "errors are those with strong compatibility, which the scene doesn't use".to_owned(),
        ),
    }
    notes
}
