//! The file of a superelement as a scene reads it.
//!
//! A planar scene reads a spatial superelement through its plane of symmetry across z: the coordinates that move in it, as a planar superelement
//! ([`InPlane`]). A part that isn't symmetric is refused.

use std::path::Path;

use dcb_formats::dcb::SuperelementFile;
use dcb_formats::mesh::{Dimension, Mesh};
use dcb_formats::superelement::{RecoveryBasis, Superelement};

use crate::error::Error;
use crate::pruning::LeftOut;
use crate::selection::{InPlane, Normal, SYMMETRIC};

/// Planar scenes lie in x, y.
const NORMAL: Normal = Normal::Z;

/// An open file and its superelement, of the scene's dimension.
pub(crate) struct PartFile {
    file: SuperelementFile,
    superelement: Superelement,
    /// What a spatial file is read through, and what that leaves out.
    in_plane: Option<(InPlane, LeftOut)>,
}

impl PartFile {
    /// Opens the file for a scene of this dimension; `at` is the place in the scene that names it.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Description`] for a planar superelement in a spatial scene, and for a spatial one in a planar scene that isn't
    /// symmetric.
    pub fn open(path: &Path, dimension: Dimension, at: &str) -> Result<Self, Error> {
        let file = SuperelementFile::open(path)?;
        let whole = file.superelement()?;
        let refused = |why: String| {
            let message = format!(
                "{} is {}, but the scene is {}{why}",
                path.display(),
                called(whole.dimension),
                called(dimension)
            );
            Error::described(at, message)
        };
        match (whole.dimension, dimension) {
            (Dimension::Planar, Dimension::Spatial) => Err(refused(
                "; reduce a component of the scene's dimension".to_owned(),
            )),
            (Dimension::Spatial, Dimension::Planar) => {
                let in_plane = InPlane::of(&whole, NORMAL, SYMMETRIC)
                    .map_err(|error| refused(format!(": {error}")))?;
                let superelement = in_plane.superelement(&whole)?;
                let left_out = left_out(&whole, &superelement);
                Ok(Self {
                    file,
                    superelement,
                    in_plane: Some((in_plane, left_out)),
                })
            }
            _ => Ok(Self {
                file,
                superelement: whole,
                in_plane: None,
            }),
        }
    }

    /// In the scene's dimension.
    pub fn superelement(&self) -> &Superelement {
        &self.superelement
    }

    /// What leads out of the plane of a planar scene; `None` if the file is of the scene's dimension.
    pub fn left_out(&self) -> Option<&LeftOut> {
        self.in_plane.as_ref().map(|(_, left_out)| left_out)
    }

    /// The digest of the file.
    pub fn digest(&self) -> &str {
        self.file.digest()
    }

    /// [`SuperelementFile::recovery`] in the scene's dimension.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn recovery(&self) -> Result<Option<RecoveryBasis>, Error> {
        let fields = self.file.recovery()?;
        Ok(fields.map(|fields| self.recovered(fields)))
    }

    /// [`SuperelementFile::recovery_of`] in the scene's dimension.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn recovery_of(&self, nodes: &[u32]) -> Result<Option<RecoveryBasis>, Error> {
        let fields = self.file.recovery_of(nodes)?;
        Ok(fields.map(|fields| self.recovered(fields)))
    }

    fn recovered(&self, fields: RecoveryBasis) -> RecoveryBasis {
        match &self.in_plane {
            Some((in_plane, _)) => in_plane.recovery(&fields),
            None => fields,
        }
    }

    /// Nodes of the mesh, if the file has one.
    pub fn node_count(&self) -> Option<usize> {
        self.file.node_count()
    }

    /// [`SuperelementFile::node_position`] in the scene's dimension.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn node_position(&self, node: u32) -> Result<Option<[f64; 3]>, Error> {
        let position = self.file.node_position(node)?;
        Ok(match self.in_plane {
            Some(_) => position.map(|position| NORMAL.flat(position)),
            None => position,
        })
    }

    /// The mesh; of a spatial part in a planar scene its nodes alone, seen along z.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn mesh(&self) -> Result<Option<Mesh>, Error> {
        let mesh = self.file.mesh()?;
        Ok(match self.in_plane {
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
