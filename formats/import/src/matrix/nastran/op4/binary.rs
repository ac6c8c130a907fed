//! Nastran's OUTPUT4, binary: Fortran's records in either byte order, integers of 32 or 64 bits.
//!
//! A header has columns, rows (negative: *bigmat*), form, type, and a name of eight characters, of which 64-bit files put four into each
//! word. A column has its number, its first row (0: strings) and the words that follow; a word is as long as an integer. Zeros of dense
//! columns are left out.

use std::path::Path;

use dcb_formats::Error;

use crate::binary::file::{BinaryFile, ByteOrder};
use crate::binary::hashed::hashed;
use crate::matrix::nastran::op4::records::{Precision, Records, Word};
use crate::matrix::nastran::op4::{Header, Places, Run};
use crate::matrix::storage::collected::Collected;
use crate::matrix::storage::number::SINGLE_DIGITS;
use crate::matrix::wanted::Wanted;
use crate::stored::{Listed, Reading, Rows, StoredMatrix, Triangles};

/// Bytes of a header: four integers and a name.
fn header_bytes(word: Word) -> u64 {
    6 * word.bytes()
}

/// Whether a file begins with a matrix: a record of 24 or 48 bytes with a type from 1 to 4, and then a record that can be a column.
pub fn recognises(start: &[u8]) -> bool {
    told(start).is_some_and(|(order, word)| {
        let integer = |at: u64| {
            let at = usize::try_from(at).ok()?;
            let bytes = start.get(at..at + 4)?.try_into().ok()?;
            Some(match order {
                ByteOrder::Little => u32::from_le_bytes(bytes),
                ByteOrder::Big => u32::from_be_bytes(bytes),
            })
        };
        // Of 64-bit integers the half that counts comes second in big-endian files.
        let half = match (word, order) {
            (Word::Long, ByteOrder::Big) => 4,
            _ => 0,
        };
        let length = header_bytes(word);
        integer(4 + length) == u32::try_from(length).ok()
            && matches!(integer(4 + 3 * word.bytes() + half), Some(1..=4))
            && integer(8 + length).is_none_or(|column| u64::from(column) >= 3 * word.bytes())
    })
}

/// Byte order and size of integers, by the length of the first record.
fn told(start: &[u8]) -> Option<(ByteOrder, Word)> {
    let length = *start.first_chunk::<4>()?;
    [ByteOrder::Little, ByteOrder::Big]
        .into_iter()
        .find_map(|order| {
            let length = match order {
                ByteOrder::Little => u32::from_le_bytes(length),
                ByteOrder::Big => u32::from_be_bytes(length),
            };
            let words = [Word::Short, Word::Long].into_iter();
            let mut fitting = words.filter(|word| u64::from(length) == header_bytes(*word));
            Some((order, fitting.next()?))
        })
}

/// The matrices of a file, without reading their numbers.
///
/// # Errors
/// [`Error::File`] with the place for what isn't OUTPUT4, or doesn't fit the file; [`Error::Io`].
pub fn list(path: &Path) -> Result<Vec<Listed>, Error> {
    let mut file = File::open(path)?;
    let mut found = Vec::new();
    while let Some(header) = file.header()? {
        found.push(header.listed());
        file.pass(&header)?;
    }
    Ok(found)
}

/// Reads matrices by their place in the list.
///
/// # Errors
/// As [`list`]; [`Error::File`] for matrices that aren't real and square, places outside, values that aren't finite.
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let (matrices, sha256) = hashed(path, || {
        let mut file = File::open(path)?;
        let mut wanted = Wanted::new(wanted);
        let mut number = 0;
        while wanted.misses_some()
            && let Some(header) = file.header()?
        {
            match wanted.has(number) {
                true => wanted.put(number, file.matrix(header)?),
                false => file.pass(&header)?,
            }
            number += 1;
        }
        wanted.found(path)
    })?;
    Ok(Reading { matrices, sha256 })
}

/// A file with matrices.
struct File {
    records: Records,
}

/// What begins a column.
struct Column {
    /// 1-based; behind the last one of the matrix where it ends.
    number: u64,
    /// 1-based; 0 for strings.
    first_row: u64,
    words: u64,
}

impl File {
    fn open(path: &Path) -> Result<Self, Error> {
        let start = BinaryFile::open_parts(path)?.take::<4>()?;
        let (order, word) = told(&start).ok_or_else(|| Error::File {
            path: path.into(),
            message: "doesn't begin with a record of 24 or 48 bytes, as binary OUTPUT4 does".into(),
        })?;
        let records = Records::open(path, order, word)?;
        Ok(Self { records })
    }

    /// The next header; `None` at the end of the file.
    fn header(&mut self) -> Result<Option<Header>, Error> {
        if self.records.is_at_end() {
            return Ok(None);
        }
        let word = self.records.word();
        let length = self.records.begin()?;
        if length != header_bytes(word) {
            return Err(self.records.refused(format!(
                "a record of {length} bytes; expected the next matrix, which begins with one of {}",
                header_bytes(word)
            )));
        }
        let mut integers = [0; 4];
        for integer in &mut integers {
            *integer = self.records.integer()?;
        }
        let mut name = self.records.text()?.to_vec();
        if word == Word::Long {
            let second = self.records.text()?;
            if name[4..].iter().all(|byte| matches!(byte, 0 | b' ')) {
                name.truncate(4);
            }
            name.extend(second);
        }
        let header = Header::new(integers, &name);
        let header = header.map_err(|message| self.records.refused(message))?;
        self.records.end()?;
        Ok(Some(header))
    }

    /// Begins the record of a column.
    fn column(&mut self, places: &mut Places) -> Result<Column, Error> {
        self.records.begin()?;
        let mut integers = [0; 3];
        for integer in &mut integers {
            let value = self.records.integer()?;
            *integer = u64::try_from(value).map_err(|_| {
                self.records.refused(format!(
                    "{value} as the column, first row or words of a column; none of them is negative"
                ))
            })?;
        }
        let [number, first_row, words] = integers;
        let begun = places.begin(number);
        begun.map_err(|message| self.records.refused(message))?;
        Ok(Column {
            number,
            first_row,
            words,
        })
    }

    /// Leaves the columns of a matrix out.
    fn pass(&mut self, header: &Header) -> Result<(), Error> {
        let mut places = Places::new(header);
        loop {
            let column = self.column(&mut places)?;
            self.records.end()?;
            if column.number > header.columns {
                return Ok(());
            }
        }
    }

    fn matrix(&mut self, header: Header) -> Result<StoredMatrix, Error> {
        let size = header
            .size()
            .map_err(|message| self.records.refused(message))?;
        let content = self.entries(&header)?.content();
        let is_single = self.precision(&header) == Precision::Single;
        let note = "stored in single precision, with 7 digits; export in double precision";
        Ok(StoredMatrix {
            name: header.name,
            size: size as usize,
            triangles: Triangles::Both,
            content,
            rows: Rows::Unlabelled,
            digits: is_single.then_some(SINGLE_DIGITS),
            notes: if is_single {
                vec![note.into()]
            } else {
                Vec::new()
            },
        })
    }

    fn precision(&self, header: &Header) -> Precision {
        match (header.numbers.is_double(), self.records.word()) {
            (false, Word::Short) => Precision::Single,
            _ => Precision::Double,
        }
    }

    /// Reads the columns of a real matrix.
    fn entries(&mut self, header: &Header) -> Result<Collected, Error> {
        let precision = self.precision(header);
        let words_each = match (precision, self.records.word()) {
            (Precision::Double, Word::Short) => 2,
            _ => 1,
        };
        let mut places = Places::new(header);
        let mut entries = Collected::default();
        loop {
            let column = self.column(&mut places)?;
            if column.number > header.columns {
                self.records.end()?;
                break;
            }
            let bytes = column.words.checked_mul(self.records.word().bytes());
            if bytes != Some(self.records.left()) {
                return Err(self.records.refused(format!(
                    "column {} announces {} words, but its record has {} bytes left",
                    column.number,
                    column.words,
                    self.records.left()
                )));
            }
            let mut numbers = Numbers {
                records: &mut self.records,
                places: &mut places,
                entries: &mut entries,
                precision,
                words_each,
            };
            match column.first_row {
                0 => numbers.strings(header)?,
                first_row => numbers.take(
                    Run {
                        first_row,
                        length: column.words,
                    },
                    Zeros::LeftOut,
                )?,
            }
            self.records.end()?;
        }
        Ok(entries)
    }
}

/// What becomes of zeros.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Zeros {
    /// They fill up a dense column.
    LeftOut,
    /// They are entries.
    Kept,
}

/// The numbers of a column on their way.
struct Numbers<'a> {
    records: &'a mut Records,
    places: &'a mut Places,
    entries: &'a mut Collected,
    precision: Precision,
    words_each: u64,
}

impl Numbers<'_> {
    fn strings(&mut self, header: &Header) -> Result<(), Error> {
        while self.records.left() > 0 {
            let first = self.records.integer()?;
            let run = match header.is_bigmat {
                true => Run::unpacked(first, self.records.integer()?),
                false => Run::packed(first),
            };
            let run = run.ok_or_else(|| {
                self.records.refused(format!(
                    "column {}: {first} as the length of a string",
                    self.places.column()
                ))
            })?;
            self.take(run, Zeros::Kept)?;
        }
        Ok(())
    }

    fn take(&mut self, run: Run, zeros: Zeros) -> Result<(), Error> {
        let column = self.places.column();
        let count = run.length / self.words_each;
        if !run.length.is_multiple_of(self.words_each) {
            return Err(self.records.refused(format!(
                "column {column}: {} words for numbers of {} words",
                run.length, self.words_each
            )));
        }
        let taken = self.places.take(run.first_row, count);
        taken.map_err(|message| self.records.refused(message))?;
        // Within the sizes of the matrix, which 31 bits hold.
        let (column, mut row) = (column as u32 - 1, run.first_row as u32 - 1);
        let entries = &mut *self.entries;
        self.records.reals(self.precision, count, |value| {
            if value != 0.0 || zeros == Zeros::Kept {
                entries.add(row, column, value)?;
            }
            row += 1;
            Ok(())
        })
    }
}
