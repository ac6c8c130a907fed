//! A component before and after its members were checked against each other.

use std::ops::Deref;

use super::component_masses::check_component_masses;
use super::fault::{ComponentFault, Place, fault};
use super::geometry::{check_directions, check_mesh, check_nodal};
use super::interfaces::{check_interfaces, check_names_beside_boundary};
use super::label::{check_label, check_units};
use super::operators::{
    check_boundary, check_geometric_stiffness, check_loads, check_size, symmetric,
};
use super::stress::check_stresses;
use super::{
    ComponentMasses, Damping, GeometricStiffness, Interface, NamedLoad, NamedStress, Source, Units,
};
use crate::SparseMatrix;
use crate::mesh::{Dimension, DofMap, Mesh};

/// A component as somebody has put it together: nothing is checked yet.
#[derive(Clone, Debug)]
pub struct ComponentDraft {
    /// Name.
    pub name: String,
    /// Unit system.
    pub units: Units,
    /// Geometry.
    pub mesh: Mesh,
    /// Row ↔ node and direction, n_e of them.
    pub dofs: DofMap,
    /// K_ee, (n_e, n_e), full symmetric storage, sorted, no duplicates.
    pub stiffness: SparseMatrix,
    /// M_ee, (n_e, n_e), full symmetric storage, positive semi-definite.
    pub mass: SparseMatrix,
    /// Exact component masses, if the FE code gave them.
    pub component_masses: Option<ComponentMasses>,
    /// Requested interfaces, in row order.
    pub interfaces: Vec<Interface>,
    /// Rows of L_b given as a matrix, (n_rows, n_e); they follow the interfaces' rows.
    pub explicit_boundary: Option<SparseMatrix>,
    /// Loads on the inside, by name.
    pub loads: Vec<NamedLoad>,
    /// Stress and strain inside, by name.
    pub stresses: Vec<NamedStress>,
    /// Geometric stiffness, if the FE code gave it.
    pub geometric_stiffness: Option<GeometricStiffness>,
    /// Damping.
    pub damping: Damping,
    /// Where everything came from.
    pub sources: Vec<Source>,
    /// Notes for the reader of the files: duplicates summed, asymmetry averaged and the like.
    pub notes: Vec<String>,
}

impl ComponentDraft {
    /// A component with stiffness, mass, mesh and dofs, and without anything that is optional.
    pub fn new(
        name: &str,
        units: Units,
        (mesh, dofs): (Mesh, DofMap),
        stiffness: SparseMatrix,
        mass: SparseMatrix,
    ) -> Self {
        Self {
            name: name.to_owned(),
            units,
            mesh,
            dofs,
            stiffness,
            mass,
            component_masses: None,
            interfaces: Vec::new(),
            explicit_boundary: None,
            loads: Vec::new(),
            stresses: Vec::new(),
            geometric_stiffness: None,
            damping: Damping::None,
            sources: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Planar or spatial.
    pub fn dimension(&self) -> Dimension {
        self.mesh.dimension
    }
}

/// A component ready to be reduced: every member has been checked against the others. Its members are those of the [`ComponentDraft`]
/// that it was made from, to be read.
#[derive(Clone, Debug)]
pub struct Component(ComponentDraft);

impl Component {
    /// Checks a component. Matrices that are symmetric within rounding become exactly so, axes of interfaces exactly orthonormal, and
    /// the directions of frames get their order.
    ///
    /// # Errors
    /// The first thing that is wrong in itself or doesn't fit the rest, with its place: names, units, ids of nodes, sizes, numbers that
    /// aren't finite, asymmetry beyond rounding, component masses that aren't those of the mass matrix. Whether the stiffness is that of
    /// a free component, and the mass positive, is found by the reduction.
    pub fn checked(draft: ComponentDraft) -> Result<Self, ComponentFault> {
        let mut of = draft;
        let n_e = of.stiffness.nrows();
        of.stiffness = symmetric(of.stiffness, n_e, Place::Stiffness, &mut of.notes)?;
        of.mass = symmetric(of.mass, n_e, Place::Mass, &mut of.notes)?;
        of.geometric_stiffness = (of.geometric_stiffness)
            .map(|stiffness| stiffness.symmetric(n_e, &mut of.notes))
            .transpose()?;
        Self::of_operators(of)
    }

    /// The same of operators that are in order, finite and exactly symmetric, as a [`crate::matrix::MatrixReader`] makes them.
    pub(crate) fn of_operators(draft: ComponentDraft) -> Result<Self, ComponentFault> {
        let mut of = draft;
        check_label("component.name", &of.name)?;
        check_units(&of.units)?;
        check_mesh(&of.mesh)?;
        let n_e = of.stiffness.nrows();
        check_dofs(&of.dofs, &of.mesh, n_e)?;
        of.interfaces = check_interfaces(of.interfaces, &of.mesh, of.dofs.pattern().as_deref())?;
        of.damping.check()?;
        check_size(&of.mass, n_e, &Place::Mass)?;
        if let Some(boundary) = &of.explicit_boundary {
            check_boundary(boundary, &of.dofs)?;
            check_names_beside_boundary(&of.interfaces)?;
        }
        check_loads(&of.loads, n_e)?;
        check_stresses(&of.stresses, &of.mesh, n_e)?;
        if let Some(stiffness) = &of.geometric_stiffness {
            let size = (n_e, of.mesh.dimension);
            check_geometric_stiffness(stiffness, size, &of.interfaces)?;
        }
        if let Some(masses) = &of.component_masses {
            check_component_masses(masses, &of)?;
        }
        Ok(Self(of))
    }

    /// This component with a change, checked again.
    ///
    /// # Errors
    /// As [`Component::checked`].
    pub fn changed(self, change: impl FnOnce(&mut ComponentDraft)) -> Result<Self, ComponentFault> {
        let mut draft = self.into_draft();
        change(&mut draft);
        Self::checked(draft)
    }

    /// Its members, to be changed and checked again.
    pub fn into_draft(self) -> ComponentDraft {
        self.0
    }
}

impl Deref for Component {
    type Target = ComponentDraft;

    fn deref(&self) -> &ComponentDraft {
        &self.0
    }
}

/// One owner for each row of the stiffness: the mesh's nodes, in its directions, and internal rows beside them.
fn check_dofs(dofs: &DofMap, mesh: &Mesh, rows: usize) -> Result<(), ComponentFault> {
    let (found, expected) = (dofs.node_count(), mesh.node_count());
    if found != expected {
        return Err(fault(
            "component.dofs",
            format!("are of {found} nodes, but the mesh has {expected}"),
        ));
    }
    if dofs.len() != rows {
        return Err(fault(
            "component.dofs",
            format!(
                "the stiffness matrix has {rows} rows, but there are {} dofs; expected one for each row",
                dofs.len()
            ),
        ));
    }
    check_nodal(dofs.rows())?;
    check_directions(mesh.dimension, |wanted| {
        let mut directions = dofs.nodal().map(|(row, dof)| (row, dof.direction));
        directions.find(|(_, direction)| wanted(*direction))
    })
}
