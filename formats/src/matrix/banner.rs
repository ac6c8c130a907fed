//! The first line of a Matrix Market file, and the numbers that it asks of the size line.

use super::foreign;
use super::header::{Field, Layout, Symmetry, shown};
use super::number::{NotANumber, unsigned};

/// faer indexes with the positive half of 32 bits.
const LARGEST_DIMENSION: u64 = i32::MAX as u64;

/// A banner that is understood.
#[derive(Clone, Copy, Debug)]
pub(super) struct Banner {
    pub(super) is_vector: bool,
    pub(super) layout: Layout,
    pub(super) field: Field,
    pub(super) symmetry: Symmetry,
}

/// The numbers of the size line.
#[derive(Clone, Copy, Debug)]
pub(super) struct SizeLine {
    pub(super) rows: u64,
    pub(super) columns: u64,
    /// Entries that follow.
    pub(super) entries: u64,
}

impl Banner {
    /// Of a text whose first line that isn't blank is given.
    ///
    /// # Errors
    /// Found and expected.
    pub(super) fn of(text: &[u8], line: &[u8]) -> Result<Self, String> {
        let words: Vec<String> = words_of(line).map(shown).collect();
        let is_banner = ["%%matrixmarket", "%matrixmarket"].iter().any(|known| {
            words
                .first()
                .is_some_and(|word| word.eq_ignore_ascii_case(known))
        });
        if !is_banner {
            return Err(foreign::text_format(text, line));
        }
        if line.contains(&b'\r') {
            return Err("lines end with a bare carriage return; expected LF or CRLF".into());
        }
        let [_, object, layout, field, symmetry] = words.as_slice() else {
            return Err(format!(
                "{} words in the banner; expected `%%MatrixMarket matrix coordinate real symmetric` or the like",
                words.len()
            ));
        };
        let banner = Self {
            is_vector: is_vector(object)?,
            layout: Layout::named(layout)?,
            field: Field::named(field)?,
            symmetry: Symmetry::named(symmetry)?,
        };
        if banner.layout == Layout::Array && banner.field == Field::Pattern {
            return Err(
                "`array pattern` has neither places nor values; expected `coordinate pattern`"
                    .into(),
            );
        }
        if banner.is_vector && banner.symmetry != Symmetry::General {
            return Err("a vector with a symmetry; expected `general`".into());
        }
        Ok(banner)
    }

    /// The size line that belongs to this banner.
    ///
    /// # Errors
    /// Found and expected.
    pub(super) fn sizes(&self, line: &[u8]) -> Result<SizeLine, String> {
        let names: &[&str] = match (self.is_vector, self.layout) {
            (false, Layout::Coordinate) => &["rows", "columns", "entries"],
            (false, Layout::Array) => &["rows", "columns"],
            (true, Layout::Coordinate) => &["rows", "entries"],
            (true, Layout::Array) => &["rows"],
        };
        let numbers = size_numbers(line, names)?;
        let (rows, columns) = if self.is_vector {
            (numbers[0], 1)
        } else {
            (numbers[0], numbers[1])
        };
        if rows.max(columns) > LARGEST_DIMENSION {
            return Err(format!(
                "{rows} rows and {columns} columns; at most {LARGEST_DIMENSION} are supported"
            ));
        }
        if self.symmetry != Symmetry::General && rows != columns {
            return Err(format!(
                "{rows} rows and {columns} columns in a {} matrix",
                self.symmetry.name()
            ));
        }
        let entries = match (self.layout, self.symmetry) {
            (Layout::Coordinate, _) => numbers[names.len() - 1],
            (Layout::Array, Symmetry::General) => rows * columns,
            (Layout::Array, Symmetry::Symmetric | Symmetry::Hermitian) => rows * (rows + 1) / 2,
            (Layout::Array, Symmetry::Skew) => rows * rows.saturating_sub(1) / 2,
        };
        Ok(SizeLine {
            rows,
            columns,
            entries,
        })
    }
}

fn words_of(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

fn is_vector(object: &str) -> Result<bool, String> {
    match object.to_ascii_lowercase().as_str() {
        "matrix" => Ok(false),
        "vector" => Ok(true),
        _ => Err(format!("object `{object}`; expected `matrix` or `vector`")),
    }
}

impl Layout {
    fn named(word: &str) -> Result<Self, String> {
        match word.to_ascii_lowercase().as_str() {
            "coordinate" => Ok(Self::Coordinate),
            "array" => Ok(Self::Array),
            _ => Err(format!("format `{word}`; expected `coordinate` or `array`")),
        }
    }
}

impl Field {
    fn named(word: &str) -> Result<Self, String> {
        match word.to_ascii_lowercase().as_str() {
            "real" | "double" => Ok(Self::Real),
            "integer" | "unsigned-integer" => Ok(Self::Integer),
            "pattern" => Ok(Self::Pattern),
            "complex" => {
                Err("complex values; expected real ones (`real`, `integer` or `pattern`)".into())
            }
            _ => Err(format!(
                "field `{word}`; expected `real`, `integer` or `pattern`"
            )),
        }
    }
}

impl Symmetry {
    fn named(word: &str) -> Result<Self, String> {
        match word.to_ascii_lowercase().as_str() {
            "general" => Ok(Self::General),
            "symmetric" => Ok(Self::Symmetric),
            "skew-symmetric" => Ok(Self::Skew),
            "hermitian" => Ok(Self::Hermitian),
            _ => {
                let expected = "`general`, `symmetric` or `skew-symmetric`";
                Err(format!("symmetry `{word}`; expected {expected}"))
            }
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::General => "general",
            Self::Symmetric => "symmetric",
            Self::Skew => "skew-symmetric",
            Self::Hermitian => "hermitian",
        }
    }
}

/// Reads the numbers of the size line.
fn size_numbers(line: &[u8], names: &[&str]) -> Result<Vec<u64>, String> {
    let words: Vec<&[u8]> = words_of(line).collect();
    if words.len() != names.len() {
        return Err(format!(
            "size line `{}`; expected `{}`",
            shown(line),
            names.join(" ")
        ));
    }
    let number = |(word, name): (&&[u8], &&str)| match unsigned(word) {
        Ok((value, length)) if length == word.len() => Ok(value),
        Err(NotANumber::OutOfRange) => Err(format!("`{}` {name} is beyond 64 bits", shown(word))),
        _ => Err(format!(
            "`{}` as the number of {name}; expected a whole number, not negative",
            shown(word)
        )),
    };
    words.iter().zip(names).map(number).collect()
}
