//! Stress or strain at places inside a component, as a matrix over its degrees of freedom.

use schemars::JsonSchema;
use serde::Deserialize;

use super::fault::{ComponentFault, Place, fault};
use super::operators::check_entries;
use crate::SparseMatrix;
use crate::mesh::{Dimension, Mesh};

/// What rows of a stress matrix give.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum StressQuantity {
    /// Cauchy stress, mass/(length·time²).
    #[default]
    Stress,
    /// Small strain, tensor components: ε_xy is half of the engineering shear γ_xy.
    Strain,
}

impl StressQuantity {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Stress, Self::Strain];

    /// Name as files write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stress => "stress",
            Self::Strain => "strain",
        }
    }
}

/// A component of a symmetric tensor, in axes of the component.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Deserialize,
    serde::Serialize,
    JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum StressComponent {
    /// (x, x).
    Xx,
    /// (y, y).
    Yy,
    /// (z, z).
    Zz,
    /// (x, y).
    Xy,
    /// (y, z).
    Yz,
    /// (z, x).
    Zx,
}

impl StressComponent {
    /// All of them, in the order of their indices in files.
    pub const ALL: [Self; 6] = [Self::Xx, Self::Yy, Self::Zz, Self::Xy, Self::Yz, Self::Zx];

    /// Name as files write it.
    pub fn name(self) -> &'static str {
        super::PAIRS_OF_AXES[self.index()]
    }

    /// Index in files: 0 to 5.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The component of an index.
    pub fn from_index(index: usize) -> Option<Self> {
        Self::ALL.get(index).copied()
    }

    /// Its two axes.
    pub fn axes(self) -> (usize, usize) {
        [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)][self.index()]
    }

    /// The component of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|known| known.name() == name)
    }

    /// Those that a body of this dimension has where nothing else is said: planar without z.
    pub fn usual(dimension: Dimension) -> &'static [Self] {
        match dimension {
            Dimension::Planar => &[Self::Xx, Self::Yy, Self::Xy],
            Dimension::Spatial => &Self::ALL,
        }
    }
}

/// Von Mises' equivalent stress of components σ; components that aren't listed are zero.
///
/// ```text
/// σ_v² = ½ ((σ_xx − σ_yy)² + (σ_yy − σ_zz)² + (σ_zz − σ_xx)²) + 3 (σ_xy² + σ_yz² + σ_zx²)
/// ```
pub fn von_mises(components: &[StressComponent], values: &[f64]) -> f64 {
    let mut full = [0.0; 6];
    for (component, value) in components.iter().zip(values) {
        full[component.index()] = *value;
    }
    let [xx, yy, zz, xy, yz, zx] = full;
    let differences = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (0.5 * differences + 3.0 * (xy * xy + yz * yz + zx * zx)).sqrt()
}

/// Whether these components make von Mises' stress of a body.
pub fn have_von_mises(components: &[StressComponent], dimension: Dimension) -> bool {
    (StressComponent::usual(dimension).iter()).all(|needed| components.contains(needed))
}

/// Where a stress is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressPoint {
    /// Position (planar: z = 0).
    pub position: [f64; 3],
    /// The node that it belongs to, if it is at one.
    pub node: Option<u32>,
}

/// Stress or strain at some places, over all dofs of the component.
#[derive(Clone, Debug)]
pub struct NamedStress {
    /// Unique name.
    pub name: String,
    /// Stress or strain.
    pub quantity: StressQuantity,
    /// Components at every place, in the order of the rows.
    pub components: Vec<StressComponent>,
    /// Places, component coordinates.
    pub points: Vec<StressPoint>,
    /// S, (places x components, n_e): place after place, at each its components.
    pub matrix: SparseMatrix,
}

/// Names that differ; places, components and rows that belong together.
pub(super) fn check_stresses(
    stresses: &[NamedStress],
    mesh: &Mesh,
    n_e: usize,
) -> Result<(), ComponentFault> {
    for (index, of) in stresses.iter().enumerate() {
        let at = format!("component.stresses.{}", of.name);
        super::check_label(&at, &of.name)?;
        if stresses[..index].iter().any(|other| other.name == of.name) {
            return Err(fault(at, "the name stands twice"));
        }
        check_components(&at, &of.components, mesh.dimension)?;
        check_points(&at, &of.points, mesh)?;
        let place = Place::Stress(index);
        let (rows, columns) = (of.matrix.nrows(), of.matrix.ncols());
        let needed = of.points.len() * of.components.len();
        if (rows, columns) != (needed, n_e) {
            let names: Vec<&str> = of.components.iter().map(|one| one.name()).collect();
            return Err(ComponentFault::at(
                place,
                format!(
                    "is {rows} x {columns}; {} places with {} components ({}) of a part with {n_e} dofs need {needed} x {n_e}",
                    of.points.len(),
                    of.components.len(),
                    names.join(" ")
                ),
            ));
        }
        check_entries(&of.matrix, &place)?;
    }
    Ok(())
}

fn check_components(
    at: &str,
    components: &[StressComponent],
    dimension: Dimension,
) -> Result<(), ComponentFault> {
    let location = || format!("{at}.components");
    if components.is_empty() {
        return Err(fault(
            location(),
            "is empty; expected at least one of xx yy zz xy yz zx",
        ));
    }
    for (index, component) in components.iter().enumerate() {
        if components[..index].contains(component) {
            return Err(fault(
                location(),
                format!("names {} twice", component.name()),
            ));
        }
        let is_out_of_plane = matches!(component, StressComponent::Yz | StressComponent::Zx);
        if dimension == Dimension::Planar && is_out_of_plane {
            return Err(fault(
                location(),
                format!(
                    "names {}, which a planar component doesn't have",
                    component.name()
                ),
            ));
        }
    }
    Ok(())
}

fn check_points(at: &str, points: &[StressPoint], mesh: &Mesh) -> Result<(), ComponentFault> {
    if points.is_empty() {
        return Err(fault(
            at,
            "names no place; give `point_set`, `nodes` or `positions`",
        ));
    }
    for point in points {
        if let Some(node) = point.node
            && node as usize >= mesh.node_count()
        {
            return Err(fault(
                format!("{at}.nodes"),
                format!(
                    "names node {node}, but the mesh has {} nodes, counted from 0",
                    mesh.node_count()
                ),
            ));
        }
        if point.position.iter().any(|x| !x.is_finite()) {
            return Err(fault(
                format!("{at}.positions"),
                "has a number that isn't finite",
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn von_mises_of_pure_states() {
        let all = StressComponent::ALL;
        let of = |values: [f64; 6]| von_mises(&all, &values);
        assert_eq!(of([3.0, 0.0, 0.0, 0.0, 0.0, 0.0]), 3.0, "tension");
        assert_eq!(of([5.0, 5.0, 5.0, 0.0, 0.0, 0.0]), 0.0, "pressure");
        let shear = of([0.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
        assert!((shear - 2.0 * 3.0_f64.sqrt()).abs() < 1e-15, "{shear}");
        // Plane stress by its three components.
        let planar = von_mises(StressComponent::usual(Dimension::Planar), &[4.0, 1.0, 2.0]);
        assert!((planar - (16.0_f64 + 1.0 - 4.0 + 12.0).sqrt()).abs() < 1e-14);
    }
}
