//! Nodes with labels, and how they are found by them.

use dcb_formats::Error;
use std::path::Path;

/// Nodes as a file lists them.
#[derive(Debug, Default)]
pub(super) struct Nodes {
    pub labels: Vec<u32>,
    pub points: Vec<[f64; 3]>,
    /// What else must agree where a node is listed again, a number each; empty where there is nothing.
    pub tags: Vec<u32>,
}

impl Nodes {
    /// One more node; whether its label stands twice shows at the end.
    pub fn push(&mut self, label: u32, point: [f64; 3]) {
        self.labels.push(label);
        self.points.push(point);
    }

    /// Finds nodes by their labels. A node that is listed again at the same place counts once, with a note.
    ///
    /// # Errors
    /// [`Error::Location`] for a label that stands at two places, [`Error::File`] without nodes.
    pub fn indexed(&mut self, path: &Path, notes: &mut Vec<String>) -> Result<LabelIndex, Error> {
        if self.labels.is_empty() {
            return Err(Error::File {
                path: path.into(),
                message: "has no nodes".into(),
            });
        }
        let mut index = LabelIndex::of(&self.labels);
        let again = index.repeated();
        if again.is_empty() {
            return Ok(index);
        }
        let mut is_repeated = vec![false; self.labels.len()];
        for (first, second) in again.iter().copied() {
            let (before, now) = (self.points[first as usize], self.points[second as usize]);
            if before != now {
                return Err(Error::Location {
                    path: path.into(),
                    location: format!("node {}", self.labels[first as usize]),
                    message: format!(
                        "stands twice, at {before:?} and at {now:?}; every node needs a label of its own"
                    ),
                });
            }
            if self.tags.get(first as usize) != self.tags.get(second as usize) {
                return Err(Error::Location {
                    path: path.into(),
                    location: format!("node {}", self.labels[first as usize]),
                    message:
                        "stands twice, with different coordinate systems for its displacements"
                            .into(),
                });
            }
            is_repeated[second as usize] = true;
        }
        notes.push(format!(
            "{} nodes are listed again at the same place (node {}): counted once",
            again.len(),
            self.labels[again[0].0 as usize]
        ));
        retain(&mut self.labels, &is_repeated);
        retain(&mut self.points, &is_repeated);
        retain(&mut self.tags, &is_repeated);
        index = LabelIndex::of(&self.labels);
        Ok(index)
    }
}

/// Keeps what isn't repeated.
fn retain<T>(items: &mut Vec<T>, is_repeated: &[bool]) {
    let mut repeated = is_repeated.iter();
    items.retain(|_| repeated.next() != Some(&true));
}

/// Places of things by their labels.
#[derive(Debug)]
pub(super) struct LabelIndex {
    /// Label in the upper half, place in the lower one; sorted.
    sorted: Vec<u64>,
    /// Place + 1 of each label, where the labels are dense enough.
    table: Vec<u32>,
}

impl LabelIndex {
    pub fn of(labels: &[u32]) -> Self {
        let mut sorted: Vec<u64> = (labels.iter().zip(0u64..))
            .map(|(label, place)| u64::from(*label) << 32 | place)
            .collect();
        if !sorted.is_sorted() {
            sorted.sort_unstable();
        }
        let largest = sorted.last().map_or(0, |last| (last >> 32) as usize);
        let mut table = Vec::new();
        if largest <= 4 * labels.len() {
            table.resize(largest + 1, 0);
            // Backwards, so that the first of equal labels stays.
            for entry in sorted.iter().rev() {
                table[(entry >> 32) as usize] = *entry as u32 + 1;
            }
        }
        Self { sorted, table }
    }

    /// Places with equal labels: the first one, and one of the others.
    pub fn repeated(&self) -> Vec<(u32, u32)> {
        let mut first = 0;
        let mut pairs = Vec::new();
        for at in 1..self.sorted.len() {
            if self.sorted[at] >> 32 == self.sorted[first] >> 32 {
                pairs.push((self.sorted[first] as u32, self.sorted[at] as u32));
            } else {
                first = at;
            }
        }
        pairs
    }

    /// Place of a label.
    pub fn place(&self, label: u32) -> Option<u32> {
        if !self.table.is_empty() {
            return self.table.get(label as usize)?.checked_sub(1);
        }
        let at = self
            .sorted
            .partition_point(|entry| entry >> 32 < u64::from(label));
        let entry = self.sorted.get(at)?;
        (entry >> 32 == u64::from(label)).then_some(*entry as u32)
    }

    /// Labels and places from one label to another, both included, by rising label.
    pub fn between(&self, first: u32, last: u32) -> impl ExactSizeIterator<Item = (u32, u32)> {
        let start = (self.sorted).partition_point(|entry| entry >> 32 < u64::from(first));
        let end = (self.sorted).partition_point(|entry| entry >> 32 <= u64::from(last));
        self.sorted[start..end.max(start)]
            .iter()
            .map(|entry| ((entry >> 32) as u32, *entry as u32))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn labels_are_found_whether_they_are_dense_or_far_apart() {
        for labels in [vec![3, 1, 2], vec![2_000_000_000, 5, 70_000]] {
            let index = LabelIndex::of(&labels);
            for (place, label) in labels.iter().enumerate() {
                assert_eq!(index.place(*label), Some(place as u32));
            }
            assert_eq!(index.place(4), None);
            assert_eq!(index.place(u32::MAX), None);
            let mut rising = labels.clone();
            rising.sort_unstable();
            let all: Vec<u32> = index.between(0, u32::MAX).map(|(label, _)| label).collect();
            assert_eq!(all, rising);
            assert_eq!(index.between(rising[1], rising[1]).len(), 1);
            assert_eq!(index.between(9, 4).len(), 0);
        }
    }

    #[test]
    fn a_node_listed_again_counts_once_and_at_another_place_is_refused() {
        let mut notes = Vec::new();
        let mut nodes = Nodes::default();
        nodes.push(7, [0.0; 3]);
        nodes.push(5, [1.0, 0.0, 0.0]);
        nodes.push(7, [0.0; 3]);
        nodes.push(9, [2.0, 0.0, 0.0]);
        let index = nodes.indexed(Path::new("a.inp"), &mut notes).unwrap();
        assert_eq!(nodes.labels, [7, 5, 9]);
        assert_eq!(nodes.points[2][0], 2.0);
        assert_eq!(index.place(9), Some(2));
        assert_eq!(
            notes,
            ["1 nodes are listed again at the same place (node 7): counted once"]
        );
        nodes.push(5, [1.0, 0.0, 0.5]);
        let error = nodes.indexed(Path::new("a.inp"), &mut notes).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a.inp: node 5: stands twice, at [1.0, 0.0, 0.0] and at [1.0, 0.0, 0.5]; every node needs a label of its own"
        );
    }
}
