//! The file of a superelement as a scene reads it.
//!
//! A planar scene reads a spatial superelement through its plane of symmetry across z ([`PlanarPart`]). A part that isn't symmetric is refused.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use dcb_formats::description::nearest_name;
use dcb_formats::mesh::{Dimension, Mesh};
use dcb_formats::scene::{GeometricStiffening, SuperelementBody};
use dcb_formats::superelement::{RecoveryBasis, Stiffening, Superelement};
use dcb_superelement::Selection;

use crate::Error;
use crate::LeftOut;
use crate::PlanarPart;
use crate::{OpenSuperelement, SuperelementFiles};

/// An open file and its superelement, of the scene's dimension.
pub struct PartFile {
    opened: Arc<OpenSuperelement>,
    /// Map from a spatial file to the plane.
    planar: Option<PlanarPart>,
}

/// That a superelement isn't there, with the nearest name in its folder, and how it comes into being.
fn missing(path: &Path) -> String {
    let name = |path: &Path| {
        path.file_name()
            .map(|name| name.to_string_lossy().into_owned())
    };
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let there: Vec<String> = entries
        .filter_map(|entry| name(&entry.path()))
        .filter(|name| name.ends_with(".dcb.h5"))
        .collect();
    let wanted = name(path).unwrap_or_default();
    let stem = |name: &str| name.strip_suffix(".dcb.h5").unwrap_or(name).to_owned();
    let stems: Vec<String> = there.iter().map(|name| stem(name)).collect();
    let near = nearest_name(&stem(&wanted), stems.iter().map(String::as_str));
    let hint = near.map_or(String::new(), |near| {
        format!("; did you mean {near}.dcb.h5?")
    });
    format!(
        "there is no file {}{hint} (`reduce {}.mtx` makes it of a stiffness matrix)",
        path.display(),
        stem(&wanted)
    )
}

impl PartFile {
    /// The file at a path for a scene of this dimension; `at` is the place in the scene that names it.
    ///
    /// # Errors
    /// [`Error::Formats`], also for a planar superelement in a spatial scene, and for a spatial one in a planar scene that isn't
    /// symmetric.
    pub fn open(
        files: &SuperelementFiles,
        path: &Path,
        dimension: Dimension,
        at: &str,
    ) -> Result<Self, Error> {
        if !path.exists() {
            return Err(Error::described(at, missing(path)));
        }
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
                Some(PlanarPart::of(whole).map_err(|error| refused(format!(": {error}")))?)
            }
            _ => None,
        };
        Ok(Self { opened, planar })
    }

    /// In the scene's dimension.
    pub fn superelement(&self) -> &Superelement {
        match &self.planar {
            Some(planar) => planar.superelement(),
            None => &self.opened.superelement,
        }
    }

    /// Motions out of the plane of a planar scene; `None` if the file is of the scene's dimension.
    pub fn left_out(&self) -> Option<&LeftOut> {
        self.planar.as_ref().map(PlanarPart::left_out)
    }

    /// The digest of the file.
    pub fn digest(&self) -> &str {
        self.opened.file.digest()
    }

    /// Nodal fields in the scene's dimension.
    ///
    /// # Errors
    /// [`Error::Formats`].
    pub fn recovery(&self) -> Result<Option<RecoveryBasis>, Error> {
        let fields = self.opened.file.recovery()?;
        Ok(fields.map(|fields| self.recovered(fields)))
    }

    /// Those of some nodes in the scene's dimension.
    ///
    /// # Errors
    /// [`Error::Formats`].
    pub fn recovery_of(&self, nodes: &[u32]) -> Result<Option<RecoveryBasis>, Error> {
        let fields = self.opened.file.recovery_of(nodes)?;
        Ok(fields.map(|fields| self.recovered(fields)))
    }

    fn recovered(&self, fields: RecoveryBasis) -> RecoveryBasis {
        match &self.planar {
            Some(planar) => planar.recovery(&fields),
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
    /// [`Error::Formats`].
    pub fn node_position(&self, node: u32) -> Result<Option<[f64; 3]>, Error> {
        let position = self.opened.file.node_position(node)?;
        Ok(match self.planar {
            Some(_) => position.map(PlanarPart::position),
            None => position,
        })
    }

    /// The mesh; of a spatial part in a planar scene its nodes alone, seen along z.
    ///
    /// # Errors
    /// [`Error::Formats`].
    pub fn mesh(&self) -> Result<Option<Mesh>, Error> {
        let mesh = self.opened.file.mesh()?;
        Ok(match self.planar {
            Some(_) => mesh.map(PlanarPart::mesh),
            None => mesh,
        })
    }
}

/// A superelement as a body of the scene asks for it: with fewer modes, and with geometric stiffening or without.
pub struct AskedPart<'a> {
    read: &'a Superelement,
    /// The lowest modes, where the body says how many.
    truncation: Option<Selection>,
    superelement: Cow<'a, Superelement>,
}

impl<'a> AskedPart<'a> {
    /// Of the file that the body names.
    ///
    /// # Errors
    /// Those of [`Selection::lowest_modes`].
    pub fn of(file: &'a PartFile, body: &SuperelementBody) -> Result<Self, Error> {
        let read = file.superelement();
        let truncation = (body.modes)
            .map(|modes| Selection::lowest_modes(read, modes as usize))
            .transpose()?;
        let mut superelement = match &truncation {
            Some(truncation) => Cow::Owned(truncation.superelement(read)?),
            None => Cow::Borrowed(read),
        };
        if body.geometric_stiffening == GeometricStiffening::Off {
            superelement.to_mut().stiffening = Stiffening::default();
        }
        Ok(Self {
            read,
            truncation,
            superelement,
        })
    }

    /// The superelement with what was asked for.
    pub fn superelement(&self) -> &Superelement {
        &self.superelement
    }

    /// Its nodal fields from those of the file.
    ///
    /// # Errors
    /// Those of [`Selection::recovery`].
    pub fn recovered(&self, fields: RecoveryBasis) -> Result<RecoveryBasis, Error> {
        Ok(match &self.truncation {
            Some(truncation) => truncation.recovery(self.read, &fields)?,
            None => fields,
        })
    }
}

fn called(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Planar => "planar",
        Dimension::Spatial => "spatial",
    }
}
