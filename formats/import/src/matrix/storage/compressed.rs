//! Matrices that are stored line by line, a line being a row or a column: where each line starts, then the places across it, then values.

use dcb_formats::SparseMatrix;
use faer::sparse::SymbolicSparseColMat;

use crate::matrix::storage::collected::{Collected, not_finite};
use crate::matrix::storage::number::Number;
use crate::matrix::storage::stream::{Stream, each_reals};
use crate::stored::Content;
use dcb_formats::Error;

/// The lines along which a matrix is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Along {
    /// Compressed rows.
    Rows,
    /// Compressed columns.
    Columns,
}

impl Along {
    /// Row and column of a place across a line.
    #[inline]
    pub(crate) fn place(self, line: u32, across: u32) -> (u32, u32) {
        match self {
            Self::Rows => (line, across),
            Self::Columns => (across, line),
        }
    }

    fn line(self) -> &'static str {
        match self {
            Self::Rows => "row",
            Self::Columns => "column",
        }
    }

    fn across(self) -> &'static str {
        match self {
            Self::Rows => "column",
            Self::Columns => "row",
        }
    }
}

/// Places of the entries of a square matrix, which come before their values.
#[derive(Debug)]
pub(crate) struct Pattern {
    along: Along,
    /// Where each line starts, and the end of the last.
    starts: Vec<u32>,
    /// Places across the lines.
    across: Vec<u32>,
    /// Sorted, every place once, and both triangles or none.
    is_whole: bool,
}

impl Pattern {
    /// Compares starts and places with each other and with the size. Places behind the last start are room that was left, and don't count.
    ///
    /// # Errors
    /// What contradicts.
    pub(crate) fn checked(
        along: Along,
        size: u32,
        starts: Vec<u32>,
        mut across: Vec<u32>,
    ) -> Result<Self, String> {
        let line = along.line();
        if starts.len() != size as usize + 1 {
            return Err(format!(
                "{} starts of {line}s; a matrix with {size} {line}s has {}",
                starts.len(),
                u64::from(size) + 1
            ));
        }
        let (first, last) = (starts[0], starts[size as usize]);
        if first != 0 {
            return Err(format!(
                "the first {line} starts at entry {first}, not at 0"
            ));
        }
        if let Some(at) = starts.windows(2).position(|pair| pair[0] > pair[1]) {
            return Err(format!(
                "{line} {} starts at entry {} and ends before it, at {}",
                at + 1,
                starts[at],
                starts[at + 1]
            ));
        }
        if last as usize > across.len() {
            return Err(format!(
                "the last {line} ends at entry {last}, but there are {} of them",
                across.len()
            ));
        }
        across.truncate(last as usize);
        let mut pattern = Self {
            along,
            starts,
            across,
            is_whole: false,
        };
        if let Some(at) = pattern.across.iter().position(|&place| place >= size) {
            return Err(pattern.outside(at, size));
        }
        pattern.is_whole = pattern.looks_whole();
        Ok(pattern)
    }

    fn outside(&self, at: usize, size: u32) -> String {
        let found = match self.across[at] {
            place if place < 1 << 31 => format!("the 0-based {} {place}", self.along.across()),
            _ => format!("no {} that can be", self.along.across()),
        };
        format!(
            "entry {} in {} {} has {found}; the matrix has {size} of them",
            at + 1,
            self.along.line(),
            self.line_of(at) + 1
        )
    }

    /// The line that an entry is in.
    fn line_of(&self, entry: usize) -> u32 {
        (self
            .starts
            .partition_point(|&start| start as usize <= entry)
            - 1) as u32
    }

    fn looks_whole(&self) -> bool {
        let (mut has_before, mut has_behind) = (false, false);
        for (line, ends) in self.starts.windows(2).enumerate() {
            let places = &self.across[ends[0] as usize..ends[1] as usize];
            if !places.is_sorted_by(|a, b| a < b) {
                return false;
            }
            has_before |= places.first().is_some_and(|&place| (place as usize) < line);
            has_behind |= places.last().is_some_and(|&place| place as usize > line);
        }
        has_before == has_behind
    }

    /// Number of entries.
    pub(crate) fn len(&self) -> u64 {
        self.across.len() as u64
    }

    /// Line and place across it of each entry.
    pub(crate) fn places(&self) -> impl Iterator<Item = (u32, u32)> {
        let lines = (0..).zip(self.starts.windows(2));
        lines.flat_map(|(line, ends)| {
            let across = &self.across[ends[0] as usize..ends[1] as usize];
            across.iter().map(move |&across| (line, across))
        })
    }

    /// The matrix with values from a stream: without a copy where it is whole, as entries in file order otherwise.
    ///
    /// # Errors
    /// Those of the stream; values that aren't finite, by their place.
    pub(crate) fn with_values(
        self,
        stream: &mut (impl Stream + ?Sized),
        number: Number,
    ) -> Result<Content, Error> {
        match self.is_whole {
            true => self.whole(stream, number),
            false => self.by_entries(stream, number),
        }
    }

    fn whole(self, stream: &mut (impl Stream + ?Sized), number: Number) -> Result<Content, Error> {
        let sure = self.len().min(stream.held() / number.size() as u64);
        let mut values = Vec::with_capacity(sure as usize);
        each_reals(stream, number, self.len(), |first, batch| {
            if let Some(at) = batch.iter().position(|value| !value.is_finite()) {
                let entry = first as usize + at;
                let (row, column) = self.along.place(self.line_of(entry), self.across[entry]);
                return Err(not_finite(row, column, batch[at]));
            }
            values.extend_from_slice(batch);
            Ok(())
        })?;
        let size = self.starts.len() - 1;
        // A matrix by rows becomes its transpose, by columns.
        let symbolic =
            SymbolicSparseColMat::new_checked(size, size, self.starts, None, self.across);
        Ok(Content::Compressed(SparseMatrix::new(symbolic, values)))
    }

    fn by_entries(
        self,
        stream: &mut (impl Stream + ?Sized),
        number: Number,
    ) -> Result<Content, Error> {
        let mut collected = Collected::default();
        let mut line = 0;
        each_reals(stream, number, self.len(), |first, batch| {
            for (entry, &value) in (first as usize..).zip(batch) {
                while self.starts[line + 1] as usize <= entry {
                    line += 1;
                }
                let (row, column) = self.along.place(line as u32, self.across[entry]);
                collected.add(row, column, value)?;
            }
            Ok(())
        })?;
        Ok(collected.content())
    }
}
