//! A spatial superelement as planar scenes have it: through its plane of symmetry across z.

use dcb_formats::mesh::{Dimension, Mesh};
use dcb_formats::superelement::{RecoveryBasis, Superelement};

use crate::Error;
use crate::LeftOut;
use crate::demand::PartInterface;
use dcb_superelement::selection::{InPlane, Normal, SYMMETRIC};

/// Planar scenes lie in x, y.
const NORMAL: Normal = Normal::Z;

/// The coordinates of a spatial superelement that move in the plane, as a planar superelement.
pub struct PlanarPart {
    in_plane: InPlane,
    superelement: Superelement,
    left_out: LeftOut,
}

impl PlanarPart {
    /// Of a spatial superelement whose part is symmetric about the plane, to 10⁻⁶.
    ///
    /// # Errors
    /// [`dcb_superelement::Error::Asymmetric`] with how far it is from that; those of [`InPlane::of`].
    pub fn of(whole: &Superelement) -> Result<Self, Error> {
        let in_plane = InPlane::of(whole, NORMAL, SYMMETRIC)?;
        let superelement = in_plane.superelement(whole)?;
        Ok(Self {
            left_out: left_out(whole, &superelement),
            in_plane,
            superelement,
        })
    }

    /// The planar superelement.
    pub fn superelement(&self) -> &Superelement {
        &self.superelement
    }

    /// Places of its modes among those of the spatial one.
    pub fn modes(&self) -> &[usize] {
        self.in_plane.selection().modes()
    }

    /// Motions out of the plane.
    pub fn left_out(&self) -> &LeftOut {
        &self.left_out
    }

    /// Its nodal fields.
    pub fn recovery(&self, whole: &RecoveryBasis) -> RecoveryBasis {
        self.in_plane.recovery(whole)
    }

    /// A point seen along z.
    pub fn position(point: [f64; 3]) -> [f64; 3] {
        NORMAL.flat(point)
    }

    /// The nodes of a spatial mesh, seen along z.
    pub fn mesh(mesh: Mesh) -> Mesh {
        let nodes = mesh.coordinates.chunks_exact(3);
        let points = nodes.flat_map(|node| {
            let [x, y, _] = Self::position([node[0], node[1], node[2]]);
            [x, y]
        });
        Mesh {
            dimension: Dimension::Planar,
            coordinates: points.collect(),
            cells: Vec::new(),
            point_sets: mesh.point_sets,
        }
    }

    /// The interfaces of a spatial part that have directions in the plane, seen along z.
    pub fn interfaces(spatial: &[PartInterface]) -> Vec<PartInterface> {
        let flat = spatial.iter().map(|interface| interface.across(NORMAL));
        flat.filter(|interface| interface.directions.contains(&true))
            .collect()
    }
}

fn left_out(whole: &Superelement, planar: &Superelement) -> LeftOut {
    let of = |what: &str, count: fn(&Superelement) -> usize| {
        let (all, kept) = (count(whole), count(planar));
        (all > kept).then(|| format!("{} of {all} {what}", all - kept))
    };
    let counts = [
        of("modes", Superelement::mode_count),
        of("interface directions", Superelement::boundary_row_count),
        of("further columns", |of| {
            of.basis_count() - of.mode_count() - of.boundary_row_count()
        }),
        of("loads", |of| of.loads.len()),
    ];
    let counts: Vec<String> = counts.into_iter().flatten().collect();
    LeftOut {
        what: format!(
            "{} that lead out of the plane across {}",
            counts.join(", "),
            NORMAL.name()
        ),
        why: "the scene is planar, and the spatial part is symmetric to the plane".to_owned(),
        cost: None,
    }
}
