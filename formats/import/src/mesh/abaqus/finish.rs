//! A deck that is read becomes a mesh: labels become places, sets get their members.

use std::path::Path;

use dcb_formats::Error;

use super::super::FoundMesh;
use super::super::label_sets::{SetDraft, Sets, resolved};
use super::super::node_sets::Marks;
use super::constraints::Known;
use super::model::{ASSEMBLY, Model, Scope, scoped};

impl Model {
    /// The mesh, with all sets.
    ///
    /// # Errors
    /// What doesn't fit together.
    pub fn finish(mut self, path: &Path, bytes: u64) -> Result<FoundMesh, Error> {
        let refused = |message: String| Error::File {
            path: path.into(),
            message,
        };
        let mut notes = std::mem::take(&mut self.notes);
        let index = self.nodes.indexed(path, &mut notes)?;
        self.cells.tie(path, &index)?;
        let cells = &self.cells;
        let cell_index = cells.by_label(path)?;
        let mut cell_marks = Marks::new(cells.len(), bytes);
        let no_nodes = |_: &str, _: &mut Vec<u32>, _: &mut Marks| Ok(());
        let element_sets = resolved(
            &self.element_sets,
            &cell_index.index,
            &mut cell_marks,
            no_nodes,
        );
        let element_sets = element_sets.map_err(refused)?;
        let drafts = &self.element_sets;
        let nodes_of = |key: &str, into: &mut Vec<u32>, marks: &mut Marks| {
            let Some(at) = drafts.get_index_of(key) else {
                return Err(format!("names the elements {key}, which aren't there"));
            };
            for cell in &element_sets.members[at] {
                for node in cells.cell(&cell_index, *cell).1 {
                    marks.put(into, *node).map_err(|e| e.message())?;
                }
            }
            Ok(())
        };
        let mut marks = Marks::new(self.nodes.labels.len(), bytes);
        let node_sets = resolved(&self.node_sets, &index, &mut marks, nodes_of).map_err(refused)?;
        let mut known = Known {
            nodes: &index,
            sets: &self.node_sets,
            members: &node_sets.members,
            marks: &mut marks,
        };
        let bound = (self.constraints.tied(&mut known, nodes_of)).map_err(refused)?;
        let part = self.part.as_deref().unwrap_or("part");
        for (set, (unknown, first)) in self.node_sets.values().zip(&node_sets.unknown) {
            if *unknown > 0 {
                notes.push(format!(
                    "node set {}: {unknown} labels that no node has are left out, the first is {first}",
                    set.name
                ));
            }
        }
        let sets = named(&self.node_sets, node_sets.members, part);
        let is_free = |set: &(usize, &String, &SetDraft)| {
            !set.2.is_internal
                && !self
                    .node_sets
                    .contains_key(set.1.trim_start_matches(ASSEMBLY))
        };
        let mut cell_sets = Vec::new();
        let with_keys = (drafts.iter().enumerate()).map(|(at, (key, set))| (at, key, set));
        for (_, key, set) in with_keys.filter(is_free) {
            let mut nodes = Vec::new();
            marks.start();
            nodes_of(key, &mut nodes, &mut marks).map_err(refused)?;
            cell_sets.push((set.name.clone(), nodes));
        }
        Ok(FoundMesh {
            points: self.nodes.points,
            labels: Some(self.nodes.labels),
            cells: self.cells.finish(),
            sets,
            cell_sets,
            rigid_bodies: bound.rigid_bodies,
            held: bound.held,
            dependent: bound.dependent,
            notes,
            ..FoundMesh::default()
        })
    }
}

/// Sets with their names, without those that Abaqus/CAE made for itself. A part's set that the assembly has too gets the part's name in front.
fn named(sets: &Sets, members: Vec<Vec<u32>>, part: &str) -> Vec<(String, Vec<u32>)> {
    let all = sets.iter().zip(members);
    all.filter(|((_, set), _)| !set.is_internal)
        .map(|((key, set), members)| {
            let is_hidden = sets.contains_key(&scoped(key, Scope::Assembly));
            match is_hidden {
                true => (format!("{part}.{}", set.name), members),
                false => (set.name.clone(), members),
            }
        })
        .collect()
}
