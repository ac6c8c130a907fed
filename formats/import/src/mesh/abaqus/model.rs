//! What the lines of a deck make, line after line.

use super::super::cells::Cells;
use super::super::fields::{self, shown};
use super::super::label_sets::{Member, SetDraft, Sets, key_of};
use super::super::nodes::Nodes;
use super::constraints::{Constraints, unquoted};
use super::data_lines::{Elements, Line, point};
use super::element_types::cell_of;
use super::keyword::Keyword;

/// Keywords that make nodes or elements without listing them.
const GENERATORS: [&str; 8] = [
    "NGEN",
    "NFILL",
    "NCOPY",
    "NMAP",
    "ELGEN",
    "ELCOPY",
    "SYSTEM",
    "SYMMETRICMODELGENERATION",
];
/// Keywords that tie nodes to each other in ways that aren't followed here.
const TIES: [&str; 7] = [
    "TIE",
    "COUPLING",
    "KINEMATICCOUPLING",
    "DISTRIBUTINGCOUPLING",
    "CYCLICSYMMETRYMODEL",
    "EMBEDDEDELEMENT",
    "SHELLTOSOLIDCOUPLING",
];
/// What the lines after a keyword are.
#[derive(Debug, Default)]
enum Section {
    #[default]
    Skipped,
    Nodes {
        set: Option<usize>,
    },
    Elements(Elements),
    NodeSet {
        set: usize,
        is_generated: bool,
    },
    ElementSet {
        set: usize,
        is_generated: bool,
    },
    NodeSurface {
        set: usize,
    },
    Instance,
    Boundary,
    Mpc,
    /// Terms that are still to come; `None` before the line with their number.
    Equation {
        terms: Option<u64>,
        is_first: bool,
    },
}

/// Where sets belong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Scope {
    #[default]
    Part,
    Assembly,
}

/// A deck as far as it is read.
#[derive(Debug, Default)]
pub(super) struct Model {
    pub nodes: Nodes,
    pub cells: Cells,
    pub node_sets: Sets,
    pub element_sets: Sets,
    pub constraints: Constraints,
    section: Section,
    scope: Scope,
    pub part: Option<String>,
    instances: usize,
    pub notes: Vec<String>,
}

/// The index of a set, which is made if it isn't there.
fn set_at(sets: &mut Sets, name: &str, scope: Scope) -> Result<usize, String> {
    if name.is_empty() || name.contains(char::is_control) {
        return Err(format!("{} is no name of a set", shown(name.as_bytes())));
    }
    let entry = sets.entry(scoped(&key_of(name), scope));
    let at = entry.index();
    entry.or_insert_with(|| SetDraft::named(name));
    Ok(at)
}

/// Sets of the assembly have keys of their own: the part's may have the same names.
pub(super) fn scoped(key: &str, scope: Scope) -> String {
    match scope {
        Scope::Part => key.to_owned(),
        Scope::Assembly => format!("{ASSEMBLY}{key}"),
    }
}

/// Begins the keys of the assembly's sets; no name has it.
pub(super) const ASSEMBLY: char = '\u{1}';

impl Model {
    /// Begins what a keyword says. Gives the file to go on with, if there is one.
    pub fn keyword(&mut self, keyword: &Keyword) -> Result<Option<String>, String> {
        self.end_data()?;
        self.section = Section::Skipped;
        let mut input = keyword.get("INPUT");
        match keyword.name.as_str() {
            "INCLUDE" => {
                if input.is_none_or(str::is_empty) {
                    return Err("*INCLUDE has no INPUT=file".into());
                }
            }
            "NODE" => self.section = self.nodes(keyword)?,
            "ELEMENT" => self.section = self.elements(keyword)?,
            "NSET" => self.section = self.node_set(keyword)?,
            "ELSET" => {
                let set = self.element_set_of(keyword, "ELSET")?;
                let set = set.ok_or("*ELSET has no name; expected ELSET=name")?;
                let is_generated = keyword.get("GENERATE").is_some();
                self.section = Section::ElementSet { set, is_generated };
            }
            "SURFACE" => {
                let is_of_nodes = |kind: &str| kind.eq_ignore_ascii_case("NODE");
                if keyword.get("TYPE").is_some_and(is_of_nodes) {
                    let name = keyword.get("NAME").unwrap_or_default();
                    let set = set_at(&mut self.node_sets, name, self.scope)?;
                    self.section = Section::NodeSurface { set };
                }
            }
            "BOUNDARY" => self.section = Section::Boundary,
            "MPC" => self.section = Section::Mpc,
            "EQUATION" => self.section = Section::Equation { terms: None, is_first: true },
            "RIGIDBODY" => self.constraints.rigid_body(keyword)?,
            "TRANSFORM" => self.notes.push(format!(
                "*TRANSFORM turns axes of {}: CalculiX writes its matrices along the global axes all the same (GLOBAL=YES, its default)",
                shown(keyword.get("NSET").unwrap_or("some nodes").as_bytes())
            )),
            "PART" | "INSTANCE" | "ASSEMBLY" | "ENDASSEMBLY" => self.structure(keyword)?,
            name if GENERATORS.contains(&name) => {
                return Err(format!(
                    "*{name} makes nodes or coordinates that aren't listed; write the deck with every node and element in it, in global axes \
                     (with meshio: `meshio convert`, in Abaqus/CAE: write the input file)"
                ));
            }
            name if TIES.contains(&name) => self.notes.push(format!(
                "*{name} ties nodes to others; nodes that depend on others have no rows in the matrices"
            )),
            _ => input = None,
        }
        Ok(input.filter(|name| !name.is_empty()).map(str::to_owned))
    }

    fn nodes(&mut self, keyword: &Keyword) -> Result<Section, String> {
        if let Some(system) = keyword.get("SYSTEM")
            && !system.eq_ignore_ascii_case("R")
        {
            return Err(format!(
                "*NODE, SYSTEM={system} has cylindrical or spherical coordinates; write the deck with rectangular ones"
            ));
        }
        let set = match keyword.get("NSET") {
            Some(name) => Some(set_at(&mut self.node_sets, name, self.scope)?),
            None => None,
        };
        Ok(Section::Nodes { set })
    }

    fn elements(&mut self, keyword: &Keyword) -> Result<Section, String> {
        let element_type = keyword.get("TYPE").unwrap_or_default().to_uppercase();
        let is_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
        if element_type.is_empty() || !element_type.chars().all(is_name) {
            return Err(format!(
                "*ELEMENT has the type {}; expected TYPE=C3D20 or the like",
                shown(element_type.as_bytes())
            ));
        }
        Ok(Section::Elements(Elements {
            cell: cell_of(&element_type),
            element_type,
            set: self.element_set_of(keyword, "ELSET")?,
            pending: Vec::new(),
        }))
    }

    fn element_set_of(&mut self, keyword: &Keyword, key: &str) -> Result<Option<usize>, String> {
        let Some(name) = keyword.get(key) else {
            return Ok(None);
        };
        let set = set_at(&mut self.element_sets, name, self.scope)?;
        self.element_sets[set].is_internal |= keyword.get("INTERNAL").is_some();
        Ok(Some(set))
    }

    fn node_set(&mut self, keyword: &Keyword) -> Result<Section, String> {
        let Some(name) = keyword.get("NSET") else {
            return Err("*NSET has no name; expected NSET=name".into());
        };
        let set = set_at(&mut self.node_sets, name, self.scope)?;
        self.node_sets[set].is_internal |= keyword.get("INTERNAL").is_some();
        if let Some(elements) = keyword.get("ELSET") {
            let key = self.known_key(&self.element_sets, elements);
            self.node_sets[set].put(Member::NodesOf(key));
        }
        let is_generated = keyword.get("GENERATE").is_some();
        Ok(Section::NodeSet { set, is_generated })
    }

    /// Key of a set that is named: the assembly's before the part's.
    fn known_key(&self, sets: &Sets, name: &str) -> String {
        let key = key_of(name);
        let in_assembly = scoped(&key, Scope::Assembly);
        match sets.contains_key(&in_assembly) {
            true => in_assembly,
            false => key,
        }
    }

    /// Parts and their instances: one of each, in its place.
    fn structure(&mut self, keyword: &Keyword) -> Result<(), String> {
        let one = "only decks with one part and one instance are read; write a deck without parts and assemblies (Abaqus/CAE: model \
                   attribute \"do not use parts and assemblies in input files\"), whose labels are also those of the matrices";
        match keyword.name.as_str() {
            "PART" if self.part.is_some() => return Err(format!("a second *PART; {one}")),
            "PART" => {
                self.part = Some(keyword.get("NAME").unwrap_or("part").to_owned());
                self.notes.push(
                    "the deck has parts and an assembly: Abaqus numbers its nodes anew in matrices, so labels may not be those of the deck"
                        .into(),
                );
            }
            "INSTANCE" => {
                self.instances += 1;
                if self.instances > 1 {
                    return Err(format!("a second *INSTANCE; {one}"));
                }
                self.section = Section::Instance;
            }
            "ASSEMBLY" => self.scope = Scope::Assembly,
            _ => {}
        }
        Ok(())
    }

    /// A line of data.
    pub fn data(&mut self, line: &[u8]) -> Result<(), String> {
        let mut room = [&[][..]; 64];
        let line = Line::of(line, &mut room)?;
        let fields = line.fields;
        let Some(first) = fields.first() else {
            return Ok(());
        };
        match &mut self.section {
            Section::Skipped => {}
            Section::Nodes { set } => {
                let label = fields::label(first).map_err(|message| format!("node: {message}"))?;
                let point = point(&fields[1..])?;
                self.nodes.push(label, point);
                if let Some(set) = *set {
                    self.node_sets[set].put_label(label);
                }
            }
            Section::Elements(elements) => {
                if elements.take(&line)? {
                    self.end_data()?;
                }
            }
            Section::NodeSet {
                set,
                is_generated: true,
            } => self.node_sets[*set].put_range(fields)?,
            Section::ElementSet {
                set,
                is_generated: true,
            } => self.element_sets[*set].put_range(fields)?,
            Section::NodeSet { set, .. } => {
                let set = *set;
                let members = self.members(&self.node_sets, fields)?;
                add(&mut self.node_sets[set], members);
            }
            Section::ElementSet { set, .. } => {
                let set = *set;
                let members = self.members(&self.element_sets, fields)?;
                add(&mut self.element_sets[set], members);
            }
            // Behind the node or set stands its area.
            Section::NodeSurface { set } => {
                let set = *set;
                let members = self.members(&self.node_sets, &fields[..1])?;
                add(&mut self.node_sets[set], members);
            }
            Section::Instance => {
                let is_zero = |field: &&[u8]| field.is_empty() || fields::real(field) == Ok(0.0);
                if !fields.iter().take(3).all(is_zero) || fields.len() > 3 {
                    return Err(
                        "*INSTANCE moves its part; write a deck without parts and assemblies, or with the part in its place".into(),
                    );
                }
            }
            Section::Boundary => self.constraints.hold(first)?,
            Section::Mpc => {
                let named = fields.get(1).filter(|node| !node.is_empty());
                if let Some(node) = named {
                    self.constraints.depends(node)?;
                }
            }
            Section::Equation { .. } => self.equation(first, fields.len())?,
        }
        Ok(())
    }

    /// The number of terms of an equation, or a line of them: node, direction and factor each. The first node depends on the others.
    fn equation(&mut self, first: &[u8], count: usize) -> Result<(), String> {
        let Section::Equation { terms, is_first } = &mut self.section else {
            return Ok(());
        };
        let Some(left) = terms else {
            *terms = u64::try_from(fields::integer(first)?).ok();
            return Ok(());
        };
        let is_dependent = std::mem::replace(is_first, false);
        *left = left.saturating_sub(count.div_ceil(3) as u64);
        if *left == 0 {
            (*terms, *is_first) = (None, true);
        }
        match is_dependent {
            true => self.constraints.depends(first),
            false => Ok(()),
        }
    }

    /// Labels and names of sets in a line.
    fn members(&self, sets: &Sets, fields: &[&[u8]]) -> Result<Vec<Result<u32, Member>>, String> {
        let present = fields.iter().filter(|field| !field.is_empty());
        present
            .map(|field| match field[0] {
                b'0'..=b'9' | b'-' | b'+' => fields::label(field).map(Ok),
                _ => Ok(Err(Member::Set(self.known_key(sets, &unquoted(field))))),
            })
            .collect()
    }

    /// Ends the element that is being read.
    pub fn end_data(&mut self) -> Result<(), String> {
        let Section::Elements(elements) = &mut self.section else {
            return Ok(());
        };
        let label = elements.end(&mut self.cells)?;
        if let (Some(label), Some(set)) = (label, elements.set) {
            self.element_sets[set].put_label(label);
        }
        Ok(())
    }
}

fn add(set: &mut SetDraft, members: Vec<Result<u32, Member>>) {
    for member in members {
        match member {
            Ok(label) => set.put_label(label),
            Err(other) => set.put(other),
        }
    }
}
