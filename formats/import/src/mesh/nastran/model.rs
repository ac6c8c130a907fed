//! What the cards of a deck make, and the mesh in the end.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::mesh::Direction;
use indexmap::IndexMap;

use super::super::FoundMesh;
use super::super::cells::Cells;
use super::super::label_sets::{SetDraft, Sets, resolved};
use super::super::node_sets::Marks;
use super::super::nodes::{LabelIndex, Nodes};
use super::cards::Card;
use super::case_control::CaseControl;
use super::coordinate_systems::Systems;
use super::elements::shape;
use super::set_text::SetWords;
use crate::stored::RowLabel;

/// Whether a card counts.
pub(super) fn is_wanted(name: &str) -> bool {
    matches!(
        name,
        "GRID"
            | "GRDSET"
            | "SPOINT"
            | "SET1"
            | "SET3"
            | "EXTRN"
            | "CORD1R"
            | "CORD1C"
            | "CORD1S"
            | "CORD2R"
            | "CORD2C"
            | "CORD2S"
    ) || shape(name).is_some()
}

/// A blank field of a grid: GRDSET says what it means.
const BLANK: i64 = i64::MIN;

/// A deck as far as it is read.
#[derive(Debug, Default)]
pub(super) struct Model {
    /// Coordinates in their systems until the end; tags are the systems of displacements.
    nodes: Nodes,
    /// System of each grid's coordinates and of its displacements.
    systems_of: Vec<[i32; 2]>,
    held: Vec<u32>,
    defaults: [Option<i64>; 2],
    default_held: bool,
    is_held_blank: Vec<u32>,
    systems: Systems,
    cells: Cells,
    without_middles: usize,
    scalar_points: Vec<(u32, u32)>,
    scalar_count: u64,
    sets: Vec<(String, SetDraft)>,
    /// Ids and components, and the section that they are in.
    rows: Vec<(u32, u32)>,
    rows_in: Option<usize>,
    section: usize,
}

impl Model {
    /// `BEGIN BULK`, `BEGIN SUPER`.
    pub fn begin_section(&mut self) {
        self.section += 1;
    }

    /// Takes a card.
    pub fn card(&mut self, card: &Card) -> Result<(), String> {
        match card.name.as_str() {
            "GRID" => self.grid(card),
            "GRDSET" => {
                self.defaults = [card.system(1)?, card.system(5)?];
                self.default_held = holds(card.field(6));
                Ok(())
            }
            "SPOINT" => self.scalar_points(card),
            "SET1" => self.set(card, 1, format!("set1_{}", card.label(0)?)),
            "SET3" => match card.field(1).eq_ignore_ascii_case(b"GRID") {
                true => self.set(card, 2, format!("set3_{}", card.label(0)?)),
                false => Ok(()),
            },
            "EXTRN" => self.rows(card),
            name if name.starts_with("CORD") => self.systems.take(card),
            _ => self.element(card),
        }
    }

    fn grid(&mut self, card: &Card) -> Result<(), String> {
        let label = card.label(0)?;
        let systems = [card.system(1)?, card.system(5)?].map(|system| system.unwrap_or(BLANK));
        let [places, displacements] = systems.map(|system| match system {
            BLANK => Ok(i32::MIN),
            system => i32::try_from(system)
                .map_err(|_| format!("coordinate system {system} is beyond any label")),
        });
        match card.field(6) {
            b"" => self.is_held_blank.push(label),
            held if holds(held) => self.held.push(label),
            _ => {}
        }
        self.systems_of.push([places?, displacements?]);
        self.nodes.push(label, card.point(2)?);
        Ok(())
    }

    fn scalar_points(&mut self, card: &Card) -> Result<(), String> {
        if card.field(1).eq_ignore_ascii_case(b"THRU") {
            let (first, last) = (card.label(0)?, card.label(2)?);
            if last < first {
                return Err(format!(
                    "SPOINT goes from {first} to {last}; the first label is the smaller one"
                ));
            }
            self.scalar_points.push((first, last));
            self.scalar_count += u64::from(last - first) + 1;
            return Ok(());
        }
        for (at, field) in card.fields().enumerate() {
            if !field.is_empty() {
                let label = card.label(at)?;
                self.scalar_points.push((label, label));
                self.scalar_count += 1;
            }
        }
        Ok(())
    }

    fn set(&mut self, card: &Card, first: usize, name: String) -> Result<(), String> {
        let mut words = SetWords::default();
        for field in card.fields().skip(first) {
            if !field.is_empty() && !field.eq_ignore_ascii_case(b"SKIN") {
                words
                    .take(field)
                    .map_err(|message| format!("{}: {message}", card.name))?;
            }
        }
        self.sets.push((name, words.finish()));
        Ok(())
    }

    fn rows(&mut self, card: &Card) -> Result<(), String> {
        if self.rows_in.is_some_and(|section| section != self.section) {
            return Err(
                "EXTRN stands in two parts of the file; one superelement a file is read".into(),
            );
        }
        self.rows_in = Some(self.section);
        let count = card.fields().count();
        for at in (0..count)
            .step_by(2)
            .filter(|at| !card.field(*at).is_empty())
        {
            let components = match card.field(at + 1) {
                b"" | b"0" => 0,
                _ => card.label(at + 1)?,
            };
            self.rows.push((card.label(at)?, components));
        }
        Ok(())
    }

    fn element(&mut self, card: &Card) -> Result<(), String> {
        let Some(shape) = shape(&card.name) else {
            return Ok(());
        };
        let label = card.label(0)?;
        let (linear, corners) = shape.linear;
        let quadratic = shape.quadratic.filter(|(_, count)| {
            let middles = (corners..*count).map(|at| card.field(shape.first + at));
            let present = middles
                .filter(|field| !matches!(*field, b"" | b"0"))
                .count();
            self.without_middles += usize::from(present > 0 && present < count - corners);
            present == count - corners
        });
        let (cell, count) = quadratic.unwrap_or((linear, corners));
        let mut nodes = [0; 20];
        for (at, node) in nodes[..count].iter_mut().enumerate() {
            let place = shape.order.map_or(at, |order| order[at]);
            *node = card.label(shape.first + place)?;
        }
        let block = self.cells.block(cell, count);
        self.cells
            .push(block, label, nodes[..count].iter().copied());
        Ok(())
    }

    /// The mesh.
    ///
    /// # Errors
    /// What doesn't fit together.
    pub fn finish(
        mut self,
        path: &Path,
        bytes: u64,
        control: CaseControl,
    ) -> Result<FoundMesh, Error> {
        let refused = |message: String| Error::File {
            path: path.into(),
            message,
        };
        let mut mesh = FoundMesh::default();
        self.in_basic_axes().map_err(refused)?;
        let index = self.nodes.indexed(path, &mut mesh.notes)?;
        self.displacement_axes(&mut mesh).map_err(refused)?;
        self.cells.tie(path, &index)?;
        if self.without_middles > 0 {
            mesh.notes.push(format!(
                "{} elements have some of their mid-side nodes: taken by their corners",
                self.without_middles
            ));
        }
        let mut marks = Marks::new(self.nodes.labels.len(), bytes);
        if self.scalar_count > bytes + (1 << 20) {
            return Err(refused(format!(
                "has {} scalar points, far more than a file of this size should",
                self.scalar_count
            )));
        }
        let ranges = self.scalar_points.iter();
        mesh.scalar_points = ranges.flat_map(|(first, last)| *first..=*last).collect();
        mesh.scalar_points.sort_unstable();
        mesh.scalar_points.dedup();
        let both = mesh
            .scalar_points
            .iter()
            .find(|point| index.place(**point).is_some());
        if let Some(point) = both {
            return Err(refused(format!("{point} is a grid and a scalar point")));
        }
        self.sets_of(&mut mesh, control, &index, &mut marks)
            .map_err(refused)?;
        if self.rows_in.is_some() {
            mesh.rows = Some(self.row_labels(&mesh, &index).map_err(refused)?);
        }
        if self.default_held {
            self.held.append(&mut self.is_held_blank);
        }
        marks.start();
        for place in self.held.iter().filter_map(|label| index.place(*label)) {
            (marks.put(&mut mesh.held, place)).map_err(|error| refused(error.message()))?;
        }
        mesh.points = self.nodes.points;
        mesh.labels = Some(self.nodes.labels);
        mesh.cells = self.cells.finish();
        Ok(mesh)
    }

    /// Coordinates go to basic axes, systems of displacements to the tags of the nodes.
    fn in_basic_axes(&mut self) -> Result<(), String> {
        let defaults = self.defaults.map(|system| system.unwrap_or(0));
        let actual = |system: i32, default: i64| match system {
            i32::MIN => default,
            system => i64::from(system),
        };
        let index = LabelIndex::of(&self.nodes.labels);
        let (points, systems_of) = (&self.nodes.points, &self.systems_of);
        self.systems.resolve(|label| {
            let place = index.place(label)? as usize;
            Some((actual(systems_of[place][0], defaults[0]), points[place]))
        })?;
        for (node, (point, systems)) in self
            .nodes
            .points
            .iter_mut()
            .zip(&self.systems_of)
            .enumerate()
        {
            let said = |message: String| format!("GRID {}: {message}", self.nodes.labels[node]);
            *point = (self.systems.point(actual(systems[0], defaults[0]), *point)).map_err(said)?;
            // -1 stays what it is: a point of a fluid.
            self.nodes.tags.push(actual(systems[1], defaults[1]) as u32);
        }
        Ok(())
    }

    fn displacement_axes(&self, mesh: &mut FoundMesh) -> Result<(), String> {
        let mut fluid = 0;
        for (node, (system, point)) in self.nodes.tags.iter().zip(&self.nodes.points).enumerate() {
            if *system == u32::MAX {
                fluid += 1;
                continue;
            }
            let axes = (self.systems.axes(i64::from(*system), *point))
                .map_err(|message| format!("GRID {}: {message}", self.nodes.labels[node]))?;
            if let Some(axes) = axes {
                mesh.displacement_axes.push((node as u32, axes));
            }
        }
        if fluid > 0 {
            mesh.notes.push(format!(
                "{fluid} grids are points of a fluid (CD = -1), not of the structure"
            ));
        }
        Ok(())
    }

    fn sets_of(
        &mut self,
        mesh: &mut FoundMesh,
        control: CaseControl,
        index: &LabelIndex,
        marks: &mut Marks,
    ) -> Result<(), String> {
        let mut sets: Sets = IndexMap::new();
        for (number, set) in control.sets {
            if control.of_elements.contains(&number) {
                mesh.notes
                    .push(format!("SET {number} is used for elements: no node set"));
                continue;
            }
            // A later set of the same number counts.
            sets.insert(format!("set_{number}"), set);
        }
        sets.extend(std::mem::take(&mut self.sets));
        let found = resolved(&sets, index, marks, |_, _, _| Ok(()))?;
        let named = sets.into_keys().zip(found.members);
        for ((name, nodes), (unknown, first)) in named.zip(found.unknown) {
            if unknown > 0 {
                mesh.notes.push(format!(
                    "{name} has {unknown} labels that are no grids, the first is {first}: taken for a set of something else"
                ));
            } else {
                mesh.sets.push((name, nodes));
            }
        }
        Ok(())
    }

    /// Rows by rising id, the components of a grid together.
    fn row_labels(
        &mut self,
        mesh: &FoundMesh,
        index: &LabelIndex,
    ) -> Result<Vec<RowLabel>, String> {
        self.rows.sort_unstable();
        let mut rows: Vec<RowLabel> = Vec::new();
        for pair in self.rows.windows(2) {
            if pair[0].0 == pair[1].0 {
                return Err(format!("EXTRN names {} twice", pair[0].0));
            }
        }
        for (id, components) in &self.rows {
            if *components == 0 {
                if mesh.scalar_points.binary_search(id).is_err() {
                    return Err(format!(
                        "EXTRN names the scalar point {id}, which isn't there"
                    ));
                }
                rows.push(RowLabel::Internal {
                    point: *id,
                    number: 0,
                });
                continue;
            }
            if index.place(*id).is_none() {
                return Err(format!("EXTRN names grid {id}, which isn't there"));
            }
            let mut digits: Vec<u8> = components.to_string().into_bytes();
            digits.sort_unstable();
            if let Some(pair) = digits.windows(2).find(|pair| pair[0] == pair[1]) {
                let component = pair[0] - b'0';
                return Err(format!(
                    "EXTRN names component {component} of grid {id} twice"
                ));
            }
            for digit in digits {
                let direction =
                    Direction::from_index(usize::from(digit).wrapping_sub(usize::from(b'1')));
                let direction = direction.ok_or_else(|| {
                    format!("EXTRN: {components} of grid {id} are no components; they are the digits 1 to 6")
                })?;
                rows.push(RowLabel::Nodal {
                    node: *id,
                    direction,
                });
            }
        }
        Ok(rows)
    }
}

/// Whether a field of permanent constraints holds a direction.
fn holds(field: &[u8]) -> bool {
    field.iter().any(|byte| matches!(byte, b'1'..=b'6'))
}
