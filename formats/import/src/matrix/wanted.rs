//! Matrices that are asked for, while a file is read from beginning to end.

use std::path::Path;

use dcb_formats::Error;

use crate::stored::{Reading, StoredMatrix};

/// Matrices by their place in the list of a file, and those that were found.
pub(super) struct Wanted<'a> {
    numbers: &'a [usize],
    found: Vec<Option<StoredMatrix>>,
}

impl<'a> Wanted<'a> {
    pub(super) fn new(numbers: &'a [usize]) -> Self {
        Self {
            numbers,
            found: numbers.iter().map(|_| None).collect(),
        }
    }

    /// Whether the matrix with this number is asked for.
    pub(super) fn has(&self, number: usize) -> bool {
        self.numbers.contains(&number)
    }

    /// Whether some weren't found yet.
    pub(super) fn misses_some(&self) -> bool {
        self.found.iter().any(Option::is_none)
    }

    /// The matrix with this number.
    pub(super) fn put(&mut self, number: usize, matrix: StoredMatrix) {
        if let Some(place) = self.numbers.iter().position(|&wanted| wanted == number) {
            self.found[place] = Some(matrix);
        }
    }

    /// What was read of a file: matrices by their numbers, and its digest.
    ///
    /// # Errors
    /// As [`Wanted::found`].
    pub(super) fn reading(
        mut self,
        path: &Path,
        matrices: Vec<(usize, StoredMatrix)>,
        sha256: String,
    ) -> Result<Reading, Error> {
        for (number, matrix) in matrices {
            self.put(number, matrix);
        }
        Ok(Reading {
            matrices: self.found(path)?,
            sha256,
        })
    }

    /// All of them, in the order in which they were asked for.
    ///
    /// # Errors
    /// [`Error::File`] if one isn't there.
    pub(super) fn found(self, path: &Path) -> Result<Vec<StoredMatrix>, Error> {
        let numbers = self.numbers;
        let found = self.found.into_iter().zip(numbers);
        let matrix = |(matrix, number): (Option<StoredMatrix>, &usize)| {
            matrix.ok_or_else(|| Error::File {
                path: path.into(),
                message: format!(
                    "has no matrix number {} (or it is asked for twice)",
                    number + 1
                ),
            })
        };
        found.map(matrix).collect()
    }
}
