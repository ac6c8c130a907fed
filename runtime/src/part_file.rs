//! The file of a superelement as a scene reads it.
//!
//! A planar scene reads a spatial superelement through its plane of symmetry across z: the coordinates that move in it, as a planar superelement
//! ([`InPlane`]). A part that isn't symmetric is refused.

use std::path::Path;
use std::sync::Arc;

use dcb_formats::mesh::{Dimension, Mesh};
use dcb_formats::superelement::{RecoveryBasis, Superelement};

use crate::error::Error;
use crate::pruning::LeftOut;
use crate::selection::{InPlane, Normal, SYMMETRIC};
use crate::superelement_files::{OpenSuperelement, SuperelementFiles};

/// Planar scenes lie in x, y.
const NORMAL: Normal = Normal::Z;

/// An open file and its superelement, of the scene's dimension.
pub(crate) struct PartFile {
    opened: Arc<OpenSuperelement>,
    /// What a spatial file is read through in the plane.
    planar: Option<InItsPlane>,
}

struct InItsPlane {
    in_plane: InPlane,
    superelement: Superelement,
    left_out: LeftOut,
}

impl PartFile {
    /// The file at a path for a scene of this dimension; `at` is the place in the scene that names it.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Description`] for a planar superelement in a spatial scene, and for a spatial one in a planar scene that isn't
    /// symmetric.
    pub fn open(
        files: &SuperelementFiles,
        path: &Path,
        dimension: Dimension,
        at: &str,
    ) -> Result<Self, Error> {
        let opened = files.at(path)?;
        let whole = &opened.superelement;
        let refused = |why: String| {
            let message = format!(
                "{} is {}, but the scene is {}{why}",
                path.display(),
                called(whole.dimension),
                called(dimension)
            );
            Error::described(at, message)
        };
        let planar = match (whole.dimension, dimension) {
            (Dimension::Planar, Dimension::Spatial) => {
                return Err(refused(
                    "; reduce a component of the scene's dimension".to_owned(),
                ));
            }
            (Dimension::Spatial, Dimension::Planar) => {
                let in_plane = InPlane::of(whole, NORMAL, SYMMETRIC)
                    .map_err(|error| refused(format!(": {error}")))?;
                let superelement = in_plane.superelement(whole)?;
                let left_out = left_out(whole, &superelement);
                Some(InItsPlane {
                    in_plane,
                    superelement,
                    left_out,
                })
            }
            _ => None,
        };
        Ok(Self { opened, planar })
    }

    /// In the scene's dimension.
    pub fn superelement(&self) -> &Superelement {
        match &self.planar {
            Some(planar) => &planar.superelement,
            None => &self.opened.superelement,
        }
    }

    /// What leads out of the plane of a planar scene; `None` if the file is of the scene's dimension.
    pub fn left_out(&self) -> Option<&LeftOut> {
        self.planar.as_ref().map(|planar| &planar.left_out)
    }

    /// The digest of the file.
    pub fn digest(&self) -> &str {
        self.opened.file.digest()
    }

    /// Nodal fields in the scene's dimension.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn recovery(&self) -> Result<Option<RecoveryBasis>, Error> {
        let fields = self.opened.file.recovery()?;
        Ok(fields.map(|fields| self.recovered(fields)))
    }

    /// Those of some nodes in the scene's dimension.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn recovery_of(&self, nodes: &[u32]) -> Result<Option<RecoveryBasis>, Error> {
        let fields = self.opened.file.recovery_of(nodes)?;
        Ok(fields.map(|fields| self.recovered(fields)))
    }

    fn recovered(&self, fields: RecoveryBasis) -> RecoveryBasis {
        match &self.planar {
            Some(planar) => planar.in_plane.recovery(&fields),
            None => fields,
        }
    }

    /// Nodes of the mesh, if the file has one.
    pub fn node_count(&self) -> Option<usize> {
        self.opened.file.node_count()
    }

    /// A node's position in the scene's dimension.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn node_position(&self, node: u32) -> Result<Option<[f64; 3]>, Error> {
        let position = self.opened.file.node_position(node)?;
        Ok(match self.planar {
            Some(_) => position.map(|position| NORMAL.flat(position)),
            None => position,
        })
    }

    /// The mesh; of a spatial part in a planar scene its nodes alone, seen along z.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn mesh(&self) -> Result<Option<Mesh>, Error> {
        let mesh = self.opened.file.mesh()?;
        Ok(match self.planar {
            Some(_) => mesh.map(flat),
            None => mesh,
        })
    }
}

fn called(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Planar => "planar",
        Dimension::Spatial => "spatial",
    }
}

fn flat(mesh: Mesh) -> Mesh {
    let nodes = mesh.coordinates.chunks_exact(3);
    let points = nodes.flat_map(|node| {
        let [x, y, _] = NORMAL.flat([node[0], node[1], node[2]]);
        [x, y]
    });
    Mesh {
        dimension: Dimension::Planar,
        coordinates: points.collect(),
        cells: Vec::new(),
        point_sets: mesh.point_sets,
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
