//! Node sets as interfaces.

use std::str::FromStr;

use dcb_formats::component::{Interface, InterfaceKind, Role, Weights};
use dcb_formats::description::{listed, suggestion};

/// A node set that becomes an interface, as the command line names it: `SET` or `SET:KIND`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RequestedSet {
    /// Name of the set, compared without regard to case.
    pub name: String,
    /// `average` if none is given.
    pub kind: InterfaceKind,
}

impl FromStr for RequestedSet {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (name, kind) = match text.rsplit_once(':') {
            Some((name, kind)) => (name.trim(), kind.trim()),
            None => (text.trim(), InterfaceKind::Average.name()),
        };
        let kinds = [
            InterfaceKind::Nodes,
            InterfaceKind::Average,
            InterfaceKind::Rigid,
        ];
        let found = kinds.into_iter().find(|known| known.name() == kind);
        match found {
            Some(kind) if !name.is_empty() => Ok(Self {
                name: name.to_owned(),
                kind,
            }),
            Some(_) => Err(format!("`{text}` names no set; expected SET or SET:KIND")),
            None => Err(format!(
                "`{kind}` is no kind of interface; expected nodes, average or rigid"
            )),
        }
    }
}

/// Interfaces made of sets, and remarks for the user.
pub(crate) struct Interfaces {
    pub interfaces: Vec<Interface>,
    pub notes: Vec<String>,
}

/// Sets with their names.
type Sets = [(String, Vec<u32>)];

/// The sets that are asked for, of nodes or of cells,, or every set that may be one. Nodes are in the order of the component.
///
/// # Errors
/// A set that isn't there or is empty.
pub(crate) fn interfaces(
    (sets, cell_sets): (&Sets, &Sets),
    asked: Option<&[RequestedSet]>,
    may_be_one: impl Fn(&[u32]) -> bool,
) -> Result<Interfaces, String> {
    if let Some(asked) = asked {
        let all = [sets, cell_sets].concat();
        let interfaces = asked
            .iter()
            .map(|asked| of_requested(&all, asked))
            .collect::<Result<_, _>>()?;
        return Ok(Interfaces {
            interfaces,
            notes: Vec::new(),
        });
    }
    let (mut interfaces, mut notes) = (Vec::new(), Vec::new());
    for (name, nodes) in sets.iter().filter(|(_, nodes)| may_be_one(nodes)) {
        interfaces.push(interface(name, InterfaceKind::Average, nodes));
    }
    let names = || interfaces.iter().map(|interface| interface.name.as_str());
    match interfaces.len() {
        0 => {}
        count => notes.push(format!(
            "{} became {}, kind average: {}; --interfaces names others, or another kind",
            counted(count, "node set"),
            if count == 1 {
                "an interface"
            } else {
                "interfaces"
            },
            listed(names())
        )),
    }
    Ok(Interfaces { interfaces, notes })
}

fn of_requested(sets: &Sets, asked: &RequestedSet) -> Result<Interface, String> {
    let names = || sets.iter().map(|(name, _)| name.as_str());
    let known = || match sets.is_empty() {
        true => "the mesh has no node sets".to_owned(),
        false => format!("the mesh has: {}", listed(names())),
    };
    let found = sets
        .iter()
        .find(|(name, _)| *name == asked.name)
        .or_else(|| {
            sets.iter()
                .find(|(name, _)| name.eq_ignore_ascii_case(&asked.name))
        });
    match found {
        None => Err(format!(
            "no node set is named \"{}\"{} ({})",
            asked.name,
            suggestion(&asked.name, names()),
            known()
        )),
        Some((name, nodes)) if nodes.is_empty() => Err(format!(
            "the node set \"{name}\" is empty; an interface needs at least one node"
        )),
        Some((name, nodes)) => Ok(interface(name, asked.kind, nodes)),
    }
}

fn interface(name: &str, kind: InterfaceKind, nodes: &[u32]) -> Interface {
    Interface {
        // Scenes write `body/interface`.
        name: name.replace('/', "-"),
        kind,
        nodes: nodes.to_vec(),
        position: None,
        weights: Weights::Uniform,
        axes: None,
        directions: None,
        role: Role::Attachment,
    }
}

/// `1 node set`, `2 node sets`.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    match count {
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    }
}
