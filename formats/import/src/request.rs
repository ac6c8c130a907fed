//! An import as it is asked for.

use std::path::PathBuf;
use std::str::FromStr;

use dcb_formats::component::{Source, Units};
use dcb_formats::mesh::Direction;
use dcb_formats::snapshot::digest_of;

use crate::interfaces::RequestedSet;
use crate::source::named_file::NamedFile;

/// Files of another program, and what they don't say.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// Stiffness matrix.
    pub stiffness: NamedFile,
    /// Mass matrix; found by the stiffness where its partner is known.
    pub mass: Option<NamedFile>,
    /// Mesh with the nodes of the rows. Only matrices with rotations can do without.
    pub mesh: Option<PathBuf>,
    /// Which row is which motion, where the matrices don't say it; ux, uy, uz at every node if nothing does.
    pub dofs: Option<RowSource>,
    /// Order of the nodes where rows have no labels.
    pub node_order: NodeOrder,
    /// Whether an order that got lost may be found from the stiffness.
    pub lost_order: LostOrder,
    /// Sets that become interfaces; all that may if none are named.
    pub interfaces: Option<Vec<RequestedSet>>,
    /// Unit system of the numbers; no file of another program says it.
    pub units: Option<Units>,
    /// Name of the component; the stem of the stiffness file's name if there is none.
    pub name: Option<String>,
}

impl Import {
    /// Whatever decides the component beside the files, as a source of its own: options in words, and their digest.
    pub(crate) fn options(&self) -> Source {
        let name = |file: &NamedFile| file.name.clone().unwrap_or_else(|| "alone".into());
        let dofs = match &self.dofs {
            None => "as found".to_owned(),
            Some(RowSource::Pattern(pattern)) => {
                let names: Vec<&str> = pattern.iter().map(|direction| direction.name()).collect();
                names.join(",")
            }
            Some(RowSource::Table(table)) => format!("by table, {}", name(table)),
        };
        let order = match self.node_order {
            NodeOrder::File => "nodes as in the mesh",
            NodeOrder::Label => "nodes by label",
        };
        let lost = match self.lost_order {
            LostOrder::Refuse => "",
            LostOrder::Repair => ", order repaired",
        };
        let interfaces = match &self.interfaces {
            None => "every set".to_owned(),
            Some(sets) => {
                let sets = sets.iter();
                let sets: Vec<String> = sets
                    .map(|set| format!("{:?}:{}", set.name, set.kind.name()))
                    .collect();
                sets.join(",")
            }
        };
        let units = match &self.units {
            None => "of the component file".to_owned(),
            Some(Units { length, mass, time }) => format!("{length:?},{mass:?},{time:?}"),
        };
        let text = format!(
            "stiffness {:?}, mass {:?}, dofs {dofs}, {order}{lost}, interfaces {interfaces}, units {units}, name {:?}",
            name(&self.stiffness),
            self.mass.as_ref().map_or_else(|| "found".into(), name),
            self.name.as_deref().unwrap_or_default()
        );
        Source {
            role: "import".into(),
            sha256: digest_of(text.as_bytes()),
            file_name: text,
        }
    }
}

/// Where it is said which row is which motion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RowSource {
    /// Every node has these directions, node after node.
    Pattern(Vec<Direction>),
    /// A file with a label and a direction for each row.
    Table(NamedFile),
}

impl FromStr for RowSource {
    type Err = String;

    /// `ux,uy,uz`, or the name of a file.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parse = |name: &str| Direction::from_name(&name.trim().to_ascii_lowercase());
        let pattern: Option<Vec<Direction>> = text.split(',').map(parse).collect();
        match pattern {
            Some(pattern) => {
                let is_repeated = |at: usize| pattern[..at].contains(&pattern[at]);
                match (0..pattern.len()).find(|&at| is_repeated(at)) {
                    Some(at) => Err(format!("names {} twice", pattern[at].name())),
                    None => Ok(Self::Pattern(pattern)),
                }
            }
            None => {
                let is_list = text.contains(',') && !std::path::Path::new(text).exists();
                match is_list {
                    true => Err(format!(
                        "`{text}` is neither a list of ux, uy, uz, rx, ry, rz nor a file"
                    )),
                    false => Ok(Self::Table(NamedFile::of(text.as_ref()))),
                }
            }
        }
    }
}

/// Order of the nodes of a mesh whose labels the rows don't have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NodeOrder {
    /// As the file of the mesh lists them.
    #[default]
    File,
    /// By rising label.
    Label,
}

/// Treatment of matrices whose rows are in an order that nobody knows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LostOrder {
    /// Refuse them.
    #[default]
    Refuse,
    /// Find it from the null space of the stiffness, and say so.
    Repair,
}

/// Units as the command line has them: `m,kg,s`.
///
/// # Errors
/// Anything but three names.
pub fn units(text: &str) -> Result<Units, String> {
    let names: Vec<&str> = text.split(',').map(str::trim).collect();
    match names.as_slice() {
        [length, mass, time] if names.iter().all(|name| !name.is_empty()) => Ok(Units {
            length: (*length).to_owned(),
            mass: (*mass).to_owned(),
            time: (*time).to_owned(),
        }),
        _ => Err(format!(
            "`{text}` names no three units; expected length, mass and time, for example m,kg,s or mm,t,s"
        )),
    }
}
