//! Entries of a file while they wait for their place.
//!
//! Sorted files repeat the row or the column for many lines, so it is kept once for all of them: 12 bytes an entry, against 24 that
//! an entry below the diagonal and its mirror image take in the end. Files in no order take 20 bytes.

use std::ops::Range;

use rayon::prelude::*;

use super::assemble::Expansion;

/// A stored entry, 0-based.
#[derive(Clone, Copy, Debug)]
pub struct Triplet {
    /// Row.
    pub row: u32,
    /// Column.
    pub column: u32,
    /// Value.
    pub value: f64,
}

/// In which order entries come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// Column after column, in each by rows.
    ByColumns,
    /// Row after row, in each by columns.
    ByRows,
}

/// Entries in file order.
#[derive(Debug, Default)]
pub struct Entries {
    runs: Vec<Run>,
    /// Rows in runs of one column, columns in runs of one row.
    others: Vec<u32>,
    values: Vec<f64>,
}

/// Entries that follow each other in one row or column, from a number on.
#[derive(Clone, Copy, Debug)]
struct Run {
    start: u32,
    along: RowOrColumn,
}

/// A row or a column, told apart by the bit that no index has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct RowOrColumn(u32);

impl RowOrColumn {
    const IS_COLUMN: u32 = 1 << 31;

    fn row(index: u32) -> Self {
        Self(index)
    }

    fn column(index: u32) -> Self {
        Self(index | Self::IS_COLUMN)
    }

    fn is_column(self) -> bool {
        self.0 & Self::IS_COLUMN != 0
    }

    /// Of the row or column.
    fn index(self) -> u32 {
        self.0 & !Self::IS_COLUMN
    }

    /// Row and column of the entry on this line with the other index.
    #[inline(always)]
    fn place(self, other: u32) -> (u32, u32) {
        if self.is_column() {
            (other, self.index())
        } else {
            (self.index(), other)
        }
    }
}

/// Entries that are renumbered by all threads.
const WORTH_THREADS: usize = 1 << 16;

impl Entries {
    /// None yet, with room for some; `None` without memory.
    pub fn with_capacity(capacity: usize) -> Option<Self> {
        let mut entries = Self::default();
        entries.others.try_reserve_exact(capacity).ok()?;
        entries.values.try_reserve_exact(capacity).ok()?;
        Some(entries)
    }

    /// Of compressed columns: where each column starts and the last one ends, and rows, all counted from 1 and looked through before. Zeros are
    /// left out.
    pub fn in_columns(starts: &[u32], mut rows: Vec<u32>, mut values: Vec<f64>) -> Self {
        let mut runs = Vec::new();
        let mut end = 0;
        for (column, ends) in (0..).zip(starts.windows(2)) {
            let start = end;
            for at in ends[0] as usize - 1..ends[1] as usize - 1 {
                if values[at] != 0.0 {
                    rows[end] = rows[at] - 1;
                    values[end] = values[at];
                    end += 1;
                }
            }
            if end > start {
                runs.push(Run {
                    start: start as u32,
                    along: RowOrColumn::column(column),
                });
            }
        }
        rows.truncate(end);
        values.truncate(end);
        Self {
            runs,
            others: rows,
            values,
        }
    }

    /// Memory of so many entries in sorted files.
    pub fn bytes_of(count: usize) -> u64 {
        ((size_of::<u32>() + size_of::<f64>()) * count) as u64
    }

    /// Gives room back of which most was not needed.
    pub fn give_back_room(&mut self) {
        if self.values.len() < self.values.capacity() / 2 {
            self.others.shrink_to_fit();
            self.values.shrink_to_fit();
        }
    }

    /// Memory that they take.
    pub fn bytes(&self) -> u64 {
        let bytes = self.runs.capacity() * size_of::<Run>()
            + self.others.capacity() * size_of::<u32>()
            + self.values.capacity() * size_of::<f64>();
        bytes as u64
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Adds one.
    #[inline(always)]
    pub fn push(&mut self, entry: Triplet) {
        let other = match self.runs.last() {
            Some(run) if run.along == RowOrColumn::row(entry.row) => entry.column,
            Some(run) if run.along == RowOrColumn::column(entry.column) => entry.row,
            _ => self.begin_run(entry),
        };
        self.others.push(other);
        self.values.push(entry.value);
    }

    /// Begins a run along the row, or along the column if that of the entry before is the same; returns the other index.
    #[inline]
    fn begin_run(&mut self, entry: Triplet) -> u32 {
        let before = self.others.len().wrapping_sub(1);
        if let Some(run) = self.runs.last_mut()
            && run.start as usize == before
            && let (row, column) = run.along.place(self.others[before])
            && column == entry.column
        {
            run.along = RowOrColumn::column(column);
            self.others[before] = row;
            return entry.row;
        }
        self.runs.push(Run {
            start: self.others.len() as u32,
            along: RowOrColumn::row(entry.row),
        });
        entry.column
    }

    /// Gives every row and column the number that stands at its place in a list; both are in the list, and the new numbers below 2³¹.
    pub fn renumber(&mut self, numbers: &[u32]) {
        for run in &mut self.runs {
            let number = numbers[run.along.index() as usize];
            run.along = match run.along.is_column() {
                true => RowOrColumn::column(number),
                false => RowOrColumn::row(number),
            };
        }
        let new = |other: &mut u32| *other = numbers[*other as usize];
        match self.others.len() < WORTH_THREADS {
            true => self.others.iter_mut().for_each(new),
            false => self.others.par_iter_mut().for_each(new),
        }
    }

    /// Entry (i, j) becomes (j, i).
    pub fn transpose(&mut self) {
        for run in &mut self.runs {
            run.along = match run.along.is_column() {
                true => RowOrColumn::row(run.along.index()),
                false => RowOrColumn::column(run.along.index()),
            };
        }
    }

    /// Whether they stand row after row; so does a single one.
    pub fn stand_by_rows(&self) -> bool {
        self.runs.iter().all(|run| !run.along.is_column())
    }

    /// Whether they stand in compressed columns, or rows, behind a place, or behind nothing: columns rise, and rows in them. The last place.
    pub(super) fn rise_behind(
        &self,
        before: Option<(u32, u32)>,
        order: Order,
    ) -> Option<Option<(u32, u32)>> {
        let mut last = before;
        for (run, range) in self.ranges() {
            let others = &self.others[range];
            let (first, end) = (others.first()?, others.last()?);
            let place = |other: u32| {
                let (row, column) = run.along.place(other);
                match order {
                    Order::ByColumns => (column, row),
                    Order::ByRows => (row, column),
                }
            };
            if last.is_some_and(|last| last >= place(*first)) || !others.is_sorted_by(|a, b| a < b)
            {
                return None;
            }
            last = Some(place(*end));
        }
        Some(last)
    }

    /// Entries above the diagonal, and below it.
    pub fn triangle_counts(&self) -> (usize, usize) {
        let (mut above, mut below) = (0, 0);
        for (run, range) in self.ranges() {
            let line = run.along.index();
            let others = &self.others[range];
            let smaller = others.iter().filter(|&&other| other < line).count();
            let larger = others.iter().filter(|&&other| other > line).count();
            let (before, behind) = match run.along.is_column() {
                true => (smaller, larger),
                false => (larger, smaller),
            };
            above += before;
            below += behind;
        }
        (above, below)
    }

    /// Puts other entries behind its own; together they are no more than 32 bits count.
    pub fn append(&mut self, other: Self) {
        let before = self.others.len() as u32;
        let runs = other.runs.into_iter().map(|run| Run {
            start: before + run.start,
            ..run
        });
        self.runs.extend(runs);
        self.others.extend_from_slice(&other.others);
        self.values.extend_from_slice(&other.values);
    }

    /// Hands out rows and values of entries that stand in compressed columns, and adds their number in each column.
    pub(super) fn into_columns(mut self, counts: &mut [u32]) -> (Vec<u32>, Vec<f64>) {
        let mut end = self.others.len();
        for run in self.runs.iter().rev() {
            let others = &mut self.others[run.start as usize..end];
            let line = run.along.index();
            match run.along.is_column() {
                true => counts[line as usize] += others.len() as u32,
                false => others.iter_mut().for_each(|other| {
                    counts[*other as usize] += 1;
                    *other = line;
                }),
            }
            end = run.start as usize;
        }
        (self.others, self.values)
    }

    /// Each run with the numbers of its entries.
    fn ranges(&self) -> impl Iterator<Item = (&Run, Range<usize>)> {
        self.whole().ranges()
    }

    /// All of them, in file order.
    pub fn iter(&self) -> impl Iterator<Item = Triplet> {
        self.whole().iter()
    }

    fn whole(&self) -> Part<'_> {
        Part {
            entries: self,
            runs: 0..self.runs.len(),
        }
    }

    /// About so many parts of about the same length, in file order. A row or column that is kept once is not divided.
    pub(super) fn parts(&self, count: usize) -> impl Iterator<Item = Part<'_>> {
        let first_run = move |part: usize| {
            let first = (self.len() as u64 * part as u64 / count as u64) as u32;
            match part == count {
                true => self.runs.len(),
                false => self.runs.partition_point(|run| run.start < first),
            }
        };
        (0..count).map(move |part| Part {
            entries: self,
            runs: first_run(part)..first_run(part + 1),
        })
    }
}

/// Some of the runs of entries.
#[derive(Clone, Debug)]
pub(super) struct Part<'a> {
    entries: &'a Entries,
    runs: Range<usize>,
}

impl<'a> Part<'a> {
    /// Each run with the numbers of its entries.
    fn ranges(&self) -> impl Iterator<Item = (&'a Run, Range<usize>)> + use<'a> {
        let Entries { runs, values, .. } = self.entries;
        let end = match runs.get(self.runs.end) {
            Some(next) => next.start as usize,
            None => values.len(),
        };
        let runs = &runs[self.runs.clone()];
        let ends = runs.iter().skip(1).map(|run| run.start as usize);
        let ends = ends.chain([end]);
        (runs.iter().zip(ends)).map(|(run, end)| (run, run.start as usize..end))
    }

    /// Its entries, in file order.
    pub(super) fn iter(&self) -> impl Iterator<Item = Triplet> + use<'a> {
        let Entries { others, values, .. } = self.entries;
        self.ranges().flat_map(move |(run, range)| {
            let along = run.along;
            let others = others[range.clone()].iter();
            others.zip(&values[range]).map(move |(&other, &value)| {
                let (row, column) = along.place(other);
                Triplet { row, column, value }
            })
        })
    }

    /// Adds the number of entries in each column; of their mirror images too, those off the diagonal, if they have some.
    pub(super) fn count_columns(&self, expansion: Expansion, counts: &mut [u32]) {
        // What 32 bits don't hold is refused before the counts are used.
        let add = |count: &mut u32, more: u32| *count = count.wrapping_add(more);
        for (run, range) in self.ranges() {
            let length = range.len() as u32;
            let others = &self.entries.others[range];
            // Entries of the run are in its line, images in the lines across it, or the other way round.
            let (along, across) = match (run.along.is_column(), expansion.mirrors()) {
                (true, false) => (true, false),
                (false, false) => (false, true),
                (_, true) => (true, true),
            };
            let line = run.along.index() as usize;
            if across {
                others
                    .iter()
                    .for_each(|&other| add(&mut counts[other as usize], 1));
            }
            if along {
                add(&mut counts[line], length);
            }
            if along && across {
                let on_diagonal = others
                    .iter()
                    .filter(|&&other| other as usize == line)
                    .count();
                counts[line] = counts[line].wrapping_sub(on_diagonal as u32);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_come_back_in_file_order_whatever_that_is() {
        let by_rows = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];
        let by_columns = by_rows.map(|(row, column)| (column, row));
        let in_no_order = [
            (5, 1),
            (3, 1),
            (3, 1),
            (3, 2),
            (4, 2),
            (0, 0),
            (0, 0),
            (4, 2),
        ];
        let places = [&by_rows[..], &by_columns, &in_no_order, &by_columns].concat();
        let mut entries = Entries::default();
        for (number, &(row, column)) in places.iter().enumerate() {
            let value = number as f64;
            entries.push(Triplet { row, column, value });
        }
        let back: Vec<_> = entries
            .iter()
            .map(|entry| ((entry.row, entry.column), entry.value as usize))
            .collect();
        let expected: Vec<_> = places.iter().copied().zip(0..).collect();
        assert_eq!(back, expected);
        let numbers = [9, 2, 7, 0, 1, 3];
        entries.renumber(&numbers);
        let back: Vec<_> = entries
            .iter()
            .map(|entry| (entry.row, entry.column))
            .collect();
        let new = |index: u32| numbers[index as usize];
        let expected: Vec<_> = places
            .iter()
            .map(|&(row, column)| (new(row), new(column)))
            .collect();
        assert_eq!(back, expected);
        assert!(entries.runs.len() < 18, "{:?}", entries.runs);
    }

    #[test]
    fn parts_are_all_of_it() {
        let places: Vec<(u32, u32)> = (0..40).map(|at| (at / 4, at % 4)).collect();
        let mut entries = Entries::default();
        for &(row, column) in &places {
            let value = 1.0;
            entries.push(Triplet { row, column, value });
        }
        for count in 1..15 {
            let parts: Vec<_> = entries.parts(count).collect();
            assert_eq!(parts.len(), count);
            let of_parts = parts.iter().flat_map(Part::iter);
            let of_parts: Vec<_> = of_parts.map(|entry| (entry.row, entry.column)).collect();
            assert_eq!(of_parts, places, "{count} parts");
            let longest = parts.iter().map(|part| part.iter().count()).max();
            assert!(
                longest <= Some(40 / count + 4),
                "{count} parts: {longest:?}"
            );
        }
        assert_eq!(
            Entries::default()
                .parts(2)
                .flat_map(|part| part.iter())
                .count(),
            0
        );
    }

    #[test]
    fn zeros_of_compressed_columns_are_left_out() {
        let columns = Entries::in_columns(
            &[1, 3, 5, 6],
            vec![1, 2, 1, 3, 3],
            vec![0.0, 2.0, 0.0, 0.0, 5.0],
        );
        let kept: Vec<_> = columns
            .iter()
            .map(|entry| (entry.row, entry.column, entry.value))
            .collect();
        assert_eq!(kept, [(1, 0, 2.0), (2, 2, 5.0)]);
        assert_eq!(columns.triangle_counts(), (0, 1));
    }

    #[test]
    fn compressed_columns_are_known_whatever_their_runs() {
        let of = |places: &[(u32, u32)]| {
            let mut entries = Entries::default();
            for (number, &(row, column)) in places.iter().enumerate() {
                let value = number as f64;
                entries.push(Triplet { row, column, value });
            }
            entries
        };
        // Rows of a column, a row over two columns, single entries.
        let rising = [(0, 0), (2, 0), (3, 0), (3, 1), (3, 2), (0, 4), (4, 4)];
        assert_eq!(
            of(&rising).rise_behind(None, Order::ByColumns),
            Some(Some((4, 4)))
        );
        assert_eq!(
            of(&rising).rise_behind(Some((0, 0)), Order::ByColumns),
            None
        );
        assert_eq!(
            of(&[]).rise_behind(Some((3, 1)), Order::ByColumns),
            Some(Some((3, 1)))
        );
        for (at, place) in [(1, (0, 0)), (2, (1, 0)), (4, (2, 1)), (6, (4, 3))] {
            let mut places = rising;
            places[at] = place;
            assert_eq!(
                of(&places).rise_behind(None, Order::ByColumns),
                None,
                "{places:?}"
            );
        }
        let mut counts = [0; 5];
        let (rows, values) = of(&rising).into_columns(&mut counts);
        assert_eq!(rows, rising.map(|(row, _)| row));
        assert_eq!(values, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(counts, [3, 1, 1, 0, 2]);
        let columns = Entries::in_columns(
            &[1, 4, 5, 6, 6, 8],
            [0, 2, 3, 3, 3, 0, 4].map(|row| row + 1).to_vec(),
            (1..8).map(f64::from).collect(),
        );
        let places: Vec<_> = columns
            .iter()
            .map(|entry| (entry.row, entry.column))
            .collect();
        assert_eq!(places, rising);
        let mut by_rows = of(&[(0, 0), (0, 1), (1, 0), (1, 3)]);
        assert!(by_rows.stand_by_rows() && by_rows.rise_behind(None, Order::ByColumns).is_none());
        by_rows.transpose();
        assert_eq!(
            by_rows.rise_behind(None, Order::ByColumns),
            Some(Some((1, 3)))
        );
    }
}
