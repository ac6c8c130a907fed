//! A superelement from a file that anybody may have made.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use faer::Mat;

use super::check::rules;
use super::contract::Counts;
use super::shapes::{check_shapes, count};
use super::{FORMAT, FORMAT_VERSION, FormatVersion, assemble, check, names};
use crate::Error;
use crate::hdf5_files::container::{Container, on_large_stack};
use crate::hdf5_files::digest;
use crate::hdf5_files::inventory::{self, Finding, Hashes, Inventory};
use crate::hdf5_files::version::{FileKind, read_version, text_attribute};
use crate::identities;
use crate::mesh::{CellBlock, Dof, Mesh};
use crate::superelement::{RecoveryBasis, Superelement};

/// The kind of files that are read here.
const KIND: FileKind = FileKind {
    called: "a superelement",
    format: FORMAT,
    version: FORMAT_VERSION,
};
/// Where it comes from.
const WRITTEN_BY: &str = "a superelement is what `reduce` writes";

/// An open `.dcb.h5` file. Opening checks its version, its digest and all shapes; data are read, and checked
/// against their hashes, when asked for. A large file opens at once.
#[derive(Debug)]
pub struct SuperelementFile {
    path: PathBuf,
    container: Container,
    inventory: Inventory,
    counts: Counts,
    version: FormatVersion,
    digest: String,
    /// Read when fields are first asked for.
    field_dofs: OnceLock<Vec<Dof>>,
}

/// Reads a superelement without its nodal fields.
///
/// # Errors
/// As [`SuperelementFile::open`] and [`SuperelementFile::superelement`].
pub fn read_superelement(path: &Path) -> Result<Superelement, Error> {
    SuperelementFile::open(path)?.superelement()
}

impl SuperelementFile {
    /// Opens a file and checks everything but the data.
    ///
    /// # Errors
    /// The file can't be read, isn't a superelement, is of a higher major version, is damaged, or its parts don't
    /// fit each other; the message names the place.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        let io = |action| {
            let path = path.clone();
            move |source| Error::io(&path, action, source)
        };
        let unusable = |message: String| Error::File {
            path: path.clone(),
            message,
        };
        let at = |finding: Finding| Error::Location {
            path: path.clone(),
            location: finding.path,
            message: finding.message,
        };

        let status = std::fs::metadata(&path).map_err(io("cannot read"))?;
        if !status.is_file() {
            return Err(unusable(
                "isn't a file; a superelement is a file NAME.dcb.h5".to_owned(),
            ));
        }
        let file = File::open(&path).map_err(io("cannot read"))?;
        let take = || {
            let container = Container::open(file, status.len(), WRITTEN_BY).map_err(unusable)?;
            container.allow_reading();
            let attributes = inventory::root_attributes(&container).map_err(at)?;
            let version = read_version(&attributes, &KIND).map_err(at)?;
            let inventory = Inventory::take(&container, Hashes::Required).map_err(at)?;
            Ok((container, version, inventory))
        };
        let (container, version, inventory) = on_large_stack(take).map_err(io("cannot read"))??;
        let digest = text_attribute(&inventory, "/", "digest")
            .map_err(at)?
            .to_owned();
        let found = inventory.digest();
        if !digest::is_right(&digest, &found) {
            let message = format!(
                "digest is {digest}, but the file's contents give {found}: they were changed or damaged"
            );
            return Err(at(Finding {
                path: "/".to_owned(),
                message,
            }));
        }
        let counts = count(&inventory).map_err(at)?;
        check_shapes(&inventory, &counts).map_err(at)?;
        Ok(Self {
            path,
            container,
            inventory,
            counts,
            version,
            digest,
            field_dofs: OnceLock::new(),
        })
    }

    /// The version that the file says it is.
    pub fn format_version(&self) -> FormatVersion {
        self.version
    }

    /// The digest, checked on opening: it identifies the superelement.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// Reads the superelement.
    ///
    /// # Errors
    /// [`Error::Location`]: data that don't match their hash, or numbers that break the contract.
    pub fn superelement(&self) -> Result<Superelement, Error> {
        let superelement = assemble::superelement(self).map_err(|finding| self.told(finding))?;
        check::superelement(&superelement).map_err(|finding| self.told(finding))?;
        if let Some(derivation) =
            (superelement.derivation.as_ref()).filter(|_| assemble::says_derivation(self))
        {
            check::derivation::derivation(&superelement, derivation)
                .map_err(|finding| self.told(finding))?;
        }
        Ok(superelement)
    }

    /// Reads the superelement for whoever is about to compute with it: its numbers don't contradict each other.
    ///
    /// # Errors
    /// As [`SuperelementFile::superelement`]; [`Error::Location`] too where an identity of [`identities::at_load`] doesn't hold.
    pub fn for_dynamics(&self) -> Result<Superelement, Error> {
        let superelement = self.superelement()?;
        match identities::at_load(&superelement)
            .into_iter()
            .find(|identity| !identity.holds())
        {
            None => Ok(superelement),
            Some(broken) => Err(self.told(Finding::at(
                broken.path,
                format!(
                    "{} doesn't hold: off by {:.1e}, {:.0e} is allowed; datasets contradict each other. Make the file anew with `reduce`; `reduce verify` shows all that is wrong",
                    broken.what, broken.defect, broken.limit
                ),
            ))),
        }
    }

    /// Whether it has nodal fields and a mesh for them.
    pub fn has_fields(&self) -> bool {
        self.has("/fields/dofs") && self.node_count().is_some()
    }

    /// Reads the nodal fields, if the file has them.
    ///
    /// # Errors
    /// As [`SuperelementFile::superelement`].
    pub fn recovery(&self) -> Result<Option<RecoveryBasis>, Error> {
        if !self.has("/fields/dofs") {
            return Ok(None);
        }
        let read = || {
            let dofs = self.field_dofs()?.to_vec();
            self.checked_recovery(dofs, |path| self.field(path))
        };
        read().map(Some).map_err(|finding| self.told(finding))
    }

    /// Reads the nodal fields of some nodes, if the file has fields: the basis has only rows of these nodes, and none of a node that
    /// the fields leave out.
    ///
    /// Of fields stored contiguously, as `reduce` writes them, only the bytes of these rows are read, however large the file. They
    /// can't be compared with a `sha256` over the whole array; [`SuperelementFile::verify_digests`] does that. Compressed fields are
    /// read and compared as a whole, a row at a time.
    ///
    /// # Errors
    /// As [`SuperelementFile::superelement`].
    pub fn recovery_of(&self, nodes: &[u32]) -> Result<Option<RecoveryBasis>, Error> {
        if !self.has("/fields/dofs") {
            return Ok(None);
        }
        let read = || {
            let all = self.field_dofs()?;
            let wanted: BTreeSet<u32> = nodes.iter().copied().collect();
            let columns: Vec<usize> = (0..all.len())
                .filter(|column| wanted.contains(&all[*column].node))
                .collect();
            let dofs = columns.iter().map(|column| all[*column]).collect();
            self.checked_recovery(dofs, |path| self.field_columns(path, &columns))
        };
        read().map(Some).map_err(|finding| self.told(finding))
    }

    fn checked_recovery(
        &self,
        dofs: Vec<Dof>,
        field: impl Fn(&str) -> Result<Mat<f64>, Finding>,
    ) -> Result<RecoveryBasis, Finding> {
        let basis = RecoveryBasis {
            dofs,
            modes: field("/modes/shapes")?,
            residual: field("/residual/shapes")?,
            enrichment: match self.has("/enrichment/shapes") {
                true => Some(field("/enrichment/shapes")?),
                false => None,
            },
        };
        let columns = [self.counts.modes, self.counts.rows, self.counts.enrichment];
        check::fields::recovery(&basis, self.counts.dimension, columns, self.node_count())?;
        Ok(basis)
    }

    fn field_dofs(&self) -> Result<&[Dof], Finding> {
        match self.field_dofs.get() {
            Some(dofs) => Ok(dofs),
            None => {
                let dofs = assemble::field_dofs(self)?;
                Ok(self.field_dofs.get_or_init(|| dofs))
            }
        }
    }

    /// Nodes of the mesh, if the file has one.
    pub fn node_count(&self) -> Option<usize> {
        let points = self.inventory.entries.get("/mesh/points")?;
        points.line.shape.first().copied()
    }

    /// Where a node of the mesh is, component axes; `None` if there is no mesh, or no such node in it. Only these coordinates are
    /// read, and they aren't compared with a hash.
    ///
    /// # Errors
    /// As [`SuperelementFile::superelement`].
    pub fn node_position(&self, node: u32) -> Result<Option<[f64; 3]>, Error> {
        let node = node as usize;
        if self.node_count().is_none_or(|count| node >= count) {
            return Ok(None);
        }
        let path = "/mesh/points";
        let position = self.some_rows(path, node, 1).and_then(|coordinates| {
            rules::finite(path, &coordinates)?;
            Ok(assemble::point(&coordinates))
        });
        position.map(Some).map_err(|finding| self.told(finding))
    }

    /// Reads the mesh, if the file has one.
    ///
    /// # Errors
    /// As [`SuperelementFile::superelement`].
    pub fn mesh(&self) -> Result<Option<Mesh>, Error> {
        if !self.has("/mesh/points") {
            return Ok(None);
        }
        let read = || {
            let mesh = self.read_mesh()?;
            check::fields::mesh(&mesh, self.counts.dimension)?;
            Ok(mesh)
        };
        read().map(Some).map_err(|finding| self.told(finding))
    }

    /// Checks the hash of every dataset and returns how many there are.
    ///
    /// # Errors
    /// The first dataset whose data don't match.
    pub fn verify_digests(&self) -> Result<usize, Error> {
        self.check_hashes().map_err(|finding| self.told(finding))
    }

    fn told(&self, finding: Finding) -> Error {
        Error::Location {
            path: self.path.clone(),
            location: finding.path,
            message: finding.message,
        }
    }

    pub(super) fn counts(&self) -> &Counts {
        &self.counts
    }

    pub(super) fn container(&self) -> &Container {
        &self.container
    }

    pub(super) fn inventory(&self) -> &Inventory {
        &self.inventory
    }

    pub(super) fn has(&self, path: &str) -> bool {
        self.inventory.entries.contains_key(path)
    }

    fn read_mesh(&self) -> Result<Mesh, Finding> {
        let mut cells = Vec::new();
        loop {
            let path = format!("/mesh/cells/{}", cells.len());
            let data = format!("{path}/data");
            if !self.has(&data) {
                break;
            }
            let cell_type = self
                .texts(&format!("{path}/type"))?
                .pop()
                .unwrap_or_default();
            let nodes_per_cell = self.entry(&data)?.line.shape.get(1).copied().unwrap_or(0);
            cells.push(CellBlock {
                cell_type,
                nodes_per_cell,
                nodes: self.nodes(&data)?,
            });
        }
        let mut point_sets = BTreeMap::new();
        for path in self.inventory.entries.keys() {
            if let Some(link) = path.strip_prefix("/mesh/point_sets/") {
                let name = names::decode(link).ok_or_else(|| {
                    Finding::at(path, "isn't a name as the format writes it".to_owned())
                })?;
                point_sets.insert(name, self.nodes(path)?);
            }
        }
        Ok(Mesh {
            dimension: self.counts.dimension,
            coordinates: self.reals("/mesh/points")?,
            cells,
            point_sets,
        })
    }

    fn nodes(&self, path: &str) -> Result<Vec<u32>, Finding> {
        let ids = self
            .integers(path)?
            .into_iter()
            .map(u32::try_from)
            .collect::<Result<Vec<_>, _>>();
        ids.map_err(|_| {
            Finding::at(
                path,
                format!("names a node that isn't from 0 to {}", u32::MAX),
            )
        })
    }
}
