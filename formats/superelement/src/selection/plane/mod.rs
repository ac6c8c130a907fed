//! Demands of a motion in a plane on a spatial superelement.

mod parity;
mod planar;
mod symmetry;

use dcb_formats::mesh::{Dimension, Direction, Dof};
use dcb_formats::superelement::{Modes, RecoveryBasis, Superelement};
use faer::Mat;

use super::basis::Basis;
use super::{InterfaceSelection, Selection};
use crate::Error;
use parity::{Norms, Parities, Parity, turn};
use planar::planar;
use symmetry::refuse_asymmetric;

/// Couplings of a component that counts as symmetric are below this.
pub const SYMMETRIC: f64 = 1e-6;

/// Normal of a plane of motion through the component: an axis of the component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normal {
    /// The plane is y, z.
    X,
    /// The plane is z, x.
    Y,
    /// The plane is x, y.
    Z,
}

impl Normal {
    /// Axes of the plane, then the normal: a right-handed triad.
    pub fn axes(self) -> [usize; 3] {
        match self {
            Self::X => [1, 2, 0],
            Self::Y => [2, 0, 1],
            Self::Z => [0, 1, 2],
        }
    }

    /// Name of the axis.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        }
    }

    /// A point in the axes of the plane; the third coordinate is 0.
    pub fn flat(self, point: [f64; 3]) -> [f64; 3] {
        let [a, b, _] = self.axes();
        [point[a], point[b], 0.0]
    }

    /// Whether a direction, of `ux uy uz rx ry rz`, is one of the plane: a translation in it or the rotation about the normal.
    pub fn moves(self, direction: usize) -> bool {
        self.planar_direction(direction).is_some()
    }

    /// Directions in the plane: two translations and the rotation about the normal.
    fn directions(self) -> [Direction; 3] {
        let [a, b, c] = self.axes();
        [Direction::ALL[a], Direction::ALL[b], Direction::ALL[3 + c]]
    }

    /// Index among the planar `ux uy uz rx ry rz` of a spatial direction index; `None` if it leads out of the plane.
    pub fn planar_direction(self, direction: usize) -> Option<usize> {
        let at = self
            .directions()
            .iter()
            .position(|own| own.index() == direction)?;
        Some([0, 1, 5][at])
    }
}

/// The coordinates of a symmetric component that a motion in its plane of symmetry moves, and no others.
///
/// The plane goes through the centre of mass. Nothing is lost for motions in it, but for couplings below the tolerance; reactions that hold the component in
/// the plane act on a component that is rigid against them.
#[derive(Clone, Debug, PartialEq)]
pub struct InPlane {
    normal: Normal,
    selection: Selection,
    planar: Basis,
    /// Places of the loads that act in the plane.
    loads: Vec<usize>,
}

impl InPlane {
    /// Finds the coordinates and checks that they don't couple with the others: by interface shapes, flexibility and mass of the attachments, L1, I1,
    /// I3, L3, I2 and geometric stiffening, each relative to the most that it could be. Couplings up to `tolerance` are neglected.
    ///
    /// # Errors
    /// [`Error::Asymmetric`] with the largest coupling; [`Error::Selection`] for a planar superelement, or an attachment with explicit rows;
    /// those of [`Selection::superelement`].
    pub fn of(whole: &Superelement, normal: Normal, tolerance: f64) -> Result<Self, Error> {
        if whole.dimension == Dimension::Planar {
            return Err(Error::Selection {
                body: whole.name.clone(),
                message: "it is planar already".to_owned(),
            });
        }
        let mut selection = Selection::everything(whole);
        selection.turn = turn(whole, normal, &Norms::of(whole))?;
        let turned = selection.superelement(whole)?;
        let norms = Norms::of(&turned);
        let parities = Parities::of(&turned, normal, &norms)?;
        refuse_asymmetric(&turned, normal, &norms, &parities, tolerance)?;

        let inside = |parities: &[Parity]| -> Vec<usize> {
            let places = 0..parities.len();
            places
                .filter(|place| parities[*place] == Parity::In)
                .collect()
        };
        let rows = inside(&parities.rows);
        selection.modes = inside(&parities.modes);
        selection.enrichment = inside(&parities.further);
        let mut in_plane = selection.clone();
        for (index, use_of) in selection.interfaces.iter_mut().enumerate() {
            if *use_of == InterfaceSelection::Loaded {
                *use_of = InterfaceSelection::along(whole, index, &normal.directions());
            }
            if !rows.iter().any(|row| whole.rows[*row].interface == index) {
                in_plane.interfaces[index] = InterfaceSelection::Dropped;
            }
        }
        // Rows of an interface in the planar order.
        let mut rows = rows;
        let order = |row: &usize| {
            let of = &whole.rows[*row];
            let direction = usize::try_from(of.direction).ok();
            let first_of_node = whole
                .rows
                .iter()
                .position(|other| (other.interface, other.node) == (of.interface, of.node));
            (
                first_of_node,
                direction.and_then(|direction| normal.planar_direction(direction)),
            )
        };
        rows.sort_by_key(order);
        Ok(Self {
            normal,
            planar: in_plane.basis_over(whole, rows)?,
            loads: loads_in_plane(&turned, normal, &norms, &parities, tolerance),
            selection,
        })
    }

    /// The component in space with the coordinates in the plane alone: its rows all stay.
    pub fn selection(&self) -> &Selection {
        &self.selection
    }

    /// The planar superelement: x, y of the file are the axes of the plane in cyclic order after the normal, its rows those in the plane.
    ///
    /// Points of the plane's axes are kept; an interface's frame is kept where its third axis is the normal and is parallel to the body's otherwise. Loads
    /// that act out of the plane aren't in it. What the thickness changes takes part in the inertia, ∫ρ ψ_z ψ_z, which planar files don't have, is in
    /// its centrifugal stiffening.
    ///
    /// # Errors
    /// [`Error::NoEigenvalues`] if the residual matrices aren't finite.
    pub fn superelement(&self, whole: &Superelement) -> Result<Superelement, Error> {
        let spatial = self.planar.superelement(whole)?;
        let planar = planar(&spatial, self.normal, &self.loads);
        Ok(Superelement {
            // Modes out of the plane aren't omitted, they don't take part.
            modes: Modes {
                first_omitted_eigenvalue: whole.modes.first_omitted_eigenvalue,
                ..planar.modes
            },
            ..planar
        })
    }

    /// Nodal fields of the planar superelement from those of the spatial one: displacements in the plane, of nodes off it as well.
    pub fn recovery(&self, whole: &RecoveryBasis) -> RecoveryBasis {
        let spatial = self.planar.recovery(whole);
        let (rows, dofs): (Vec<usize>, Vec<Dof>) = (spatial.dofs.iter().enumerate())
            .filter_map(|(row, dof)| {
                let direction = self.normal.planar_direction(dof.direction.index())?;
                let direction = Direction::from_index(direction)?;
                Some((row, Dof { direction, ..*dof }))
            })
            .unzip();
        let picked = |fields: &Mat<f64>| {
            Mat::from_fn(rows.len(), fields.ncols(), |i, k| fields[(rows[i], k)])
        };
        RecoveryBasis {
            modes: picked(&spatial.modes),
            residual: picked(&spatial.residual),
            enrichment: spatial.enrichment.as_ref().map(picked),
            dofs,
        }
    }
}

/// Loads whose resultant and work out of the plane are below the tolerance.
fn loads_in_plane(
    whole: &Superelement,
    normal: Normal,
    norms: &Norms,
    parities: &Parities,
    tolerance: f64,
) -> Vec<usize> {
    let [a, b, c] = normal.axes();
    let all = parities.of_basis();
    let radius = whole.inertia.radius_of_gyration();
    let lies_inside = |place: &usize| {
        let load = &whole.loads[*place];
        let size = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
        let (force, moment) = (load.force, load.moment.map(|moment| moment / radius));
        let rigid = [
            size(&[force[a], force[b], moment[c]]),
            size(&[force[c], moment[a], moment[b]]),
        ];
        let mut elastic = [0.0; 2];
        for (k, parity) in all.iter().enumerate() {
            let work = parity::cosine(load.work[k], norms.energy[k], 1.0);
            elastic[usize::from(*parity == Parity::Out)] += work * work;
        }
        let is_small =
            |[inside, outside]: [f64; 2]| outside <= tolerance * tolerance * (inside + outside);
        is_small(rigid) && is_small(elastic)
    };
    (0..whole.loads.len()).filter(lies_inside).collect()
}
