//! The files of a part, whatever program wrote them.

use std::path::Path;

use crate::program::Told;
use clap::Args;
use dcb_formats::component::{Component, Source, Units};
use dcb_formats::component_files::{ComponentFiles, read_component};
use dcb_import::{
    Import, Imported, LostOrder, MeshBeside, NamedFile, NodeOrder, RequestedSet, RowSource, import,
    is_json, is_matrix_market, mass_beside, mesh_beside, units,
};
use dcb_reducer::error::{CommandRefusal, Error};
use dcb_workflow::siblings::SiblingArguments;

/// Heading of options in the help.
const OTHER_PROGRAMS: &str = "Files of other programs (docs/import.md)";

/// What files of other programs don't say.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct ImportArguments {
    /// Units of length, mass and time, for example m,kg,s or mm,t,s.
    #[arg(help_heading = OTHER_PROGRAMS, long, value_name = "UNITS", value_parser = units)]
    pub units: Option<Units>,
    /// Which row is which motion: directions of every node (ux,uy,uz), or a table (FILE).
    ///
    /// A table is a file with the label and the direction of each row, FILE or FILE#NAME.
    ///
    /// Without either: what the files say, else ux,uy,uz.
    #[arg(help_heading = OTHER_PROGRAMS, long, value_name = "DOFS")]
    pub dofs: Option<RowSource>,
    /// Order of the nodes of rows without labels: file or label (rising) [default: file].
    #[arg(help_heading = OTHER_PROGRAMS, long, value_name = "ORDER", value_parser = node_order)]
    pub node_order: Option<NodeOrder>,
    /// Node sets that become interfaces, SET[:KIND],... [default: all sets, average].
    #[arg(help_heading = OTHER_PROGRAMS, long, value_name = "SETS", value_delimiter = ',')]
    pub interfaces: Option<Vec<RequestedSet>>,
    /// Find the order of the rows from the stiffness, if it got lost.
    #[arg(help_heading = OTHER_PROGRAMS, long)]
    pub repair_order: bool,
    /// Name of the component [default: that of the stiffness file].
    #[arg(help_heading = OTHER_PROGRAMS, long, value_name = "NAME")]
    pub name: Option<String>,
}

/// Order of nodes as the command line names it.
pub(crate) fn node_order(text: &str) -> Result<NodeOrder, String> {
    match text {
        "file" => Ok(NodeOrder::File),
        "label" => Ok(NodeOrder::Label),
        _ => Err("expected file or label".into()),
    }
}

impl ImportArguments {
    fn are_given(&self) -> bool {
        self.units.is_some()
            || self.dofs.is_some()
            || self.node_order.is_some()
            || self.interfaces.is_some()
            || self.repair_order
            || self.name.is_some()
    }

    /// The import of a stiffness and what goes with it.
    pub(crate) fn import(
        &self,
        stiffness: &Path,
        mass: Option<&Path>,
        mesh: Option<&Path>,
    ) -> Result<Import, Error> {
        let stiffness = NamedFile::of(stiffness);
        let mesh = match mesh {
            Some(mesh) => Some(mesh.to_path_buf()),
            None => mesh_beside(&stiffness.path).map(|beside| beside.path),
        };
        Ok(Import {
            mass: mass.map(NamedFile::of),
            mesh,
            dofs: self.dofs.clone(),
            node_order: self.node_order.unwrap_or_default(),
            lost_order: match self.repair_order {
                true => LostOrder::Repair,
                false => LostOrder::Refuse,
            },
            interfaces: self.interfaces.clone(),
            units: self.units.clone(),
            name: self.name.clone(),
            stiffness,
        })
    }
}

/// Says which of two meshes beside a stiffness is read, if none is named.
pub(crate) fn tell_unread_mesh(stiffness: &Path, named: Option<&Path>, told: Told) {
    let beside = match named {
        Some(_) => None,
        None => mesh_beside(&NamedFile::of(stiffness).path),
    };
    if let Some(MeshBeside {
        path,
        unread: Some(unread),
    }) = beside
    {
        let message = format!(
            "the mesh is {}, which has the labels of the nodes; {} beside it is not read (--mesh {1} reads it instead)",
            path.display(),
            unread.display()
        );
        told.say("note", &message);
    }
}

/// The files of a part.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct PartArguments {
    #[command(flatten)]
    pub siblings: SiblingArguments,
    #[command(flatten)]
    pub import: ImportArguments,
}

/// Where a part is.
pub(crate) struct PartFiles {
    /// Its files by their roles.
    pub files: ComponentFiles,
    /// What is to be imported, where they are another program's.
    import: Option<Import>,
    /// Whether its mesh was found beside the stiffness, not named.
    mesh_is_found: bool,
}

impl PartFiles {
    /// Finds the files of a part: `PART.mtx` and those beside it, or another program's.
    ///
    /// # Errors
    /// A file that is missing, or that can't be such a matrix.
    pub(crate) fn of(stiffness: &Path, arguments: &PartArguments) -> Result<Self, Error> {
        let PartArguments { siblings, import } = arguments;
        let named = NamedFile::of(stiffness);
        let is_own = !named.path.exists()
            || named.path.is_dir()
            || named.name.is_none() && !import.are_given() && is_own(&named.path, siblings)?;
        if is_own {
            let files = ComponentFiles::beside(stiffness, &siblings.overrides())?;
            return Ok(Self {
                files,
                import: None,
                mesh_is_found: false,
            });
        }
        if let Some(boundary) = &siblings.boundary {
            return Err(CommandRefusal::BoundaryOfImport {
                path: boundary.clone(),
            }
            .into());
        }
        let import = import.import(
            stiffness,
            siblings.mass.as_deref(),
            siblings.mesh.as_deref(),
        )?;
        let mass = match &import.mass {
            Some(mass) => mass.path.clone(),
            None => match mass_beside(&import.stiffness)? {
                Some(mass) => mass.path,
                None => import.stiffness.path.clone(),
            },
        };
        let files = ComponentFiles {
            stiffness: named.path,
            mass,
            description: import.mesh.clone().unwrap_or_default(),
            boundary: None,
            loads: Vec::new(),
            stresses: Vec::new(),
            stiffening: Vec::new(),
        };
        Ok(Self {
            files,
            import: Some(import),
            mesh_is_found: siblings.mesh.is_none(),
        })
    }

    /// Reads the part, in so many bytes of memory if there is a limit, and tells how another program's files were understood.
    ///
    /// # Errors
    /// What is wrong with the files.
    pub(crate) fn read(&self, memory: Option<u64>, told: Told) -> Result<Component, Error> {
        match &self.import {
            None => Ok(read_component(&self.files, memory)?),
            Some(request) => {
                if self.mesh_is_found {
                    tell_unread_mesh(&self.files.stiffness, None, told);
                }
                let Imported { component, report } = import(request)?;
                for note in &report.notes {
                    told.say("note", note);
                }
                Ok(component)
            }
        }
    }

    /// Names and digests of the files, and how they were imported.
    ///
    /// # Errors
    /// What is wrong with the files.
    pub(crate) fn sources(&self) -> Result<Vec<Source>, Error> {
        match &self.import {
            None => Ok(self.files.sources()?),
            // What a mesh includes is known once it is read.
            Some(request) => Ok(import(request)?.component.sources.clone()),
        }
    }
}

/// Whether files are those of a component: Matrix Market and JSON.
fn is_own(stiffness: &Path, siblings: &SiblingArguments) -> Result<bool, dcb_formats::Error> {
    type Kind = fn(&Path) -> Result<bool, dcb_formats::Error>;
    let files: [(Option<&Path>, Kind); 3] = [
        (Some(stiffness), is_matrix_market),
        (siblings.mass.as_deref(), is_matrix_market),
        (siblings.mesh.as_deref(), is_json),
    ];
    // What isn't there is told by the reader. A pipe can be read only once.
    let looked_at = |path: &&Path| path.is_file();
    for (path, is_kind) in files {
        if let Some(path) = path.filter(looked_at)
            && !is_kind(path)?
        {
            return Ok(false);
        }
    }
    Ok(true)
}
