//! MATLAB files of version 5 (`save -v6`, `-v7`, SciPy's `savemat`): elements of a type and a length, some of them compressed.
//!
//! Numeric matrices are listed, those in structures by `/`; what is in cells, objects and arrays of structures is passed over. Numbers may
//! be stored in any smaller type than that of their matrix.

mod arrays;
mod elements;

use std::path::Path;

use dcb_formats::Error;

use self::arrays::{Class, Found, walk};
use self::elements::Body;
use crate::binary::hashed::hashed;
use crate::matrix::labels::{DOF_REF, IntegerTable};
use crate::matrix::storage::collected::{obstacle_of_shape, square};
use crate::matrix::storage::compressed::{Along, Pattern};
use crate::matrix::storage::dense::dense;
use crate::matrix::storage::number::Number;
use crate::matrix::storage::stream::{indices, integers};
use crate::stored::{Content, Listed, Reading, StoredMatrix};

/// Whether a file begins as those of version 5 or 4 do.
pub fn recognises(start: &[u8]) -> bool {
    is_version_5(start) || is_version_4(start)
}

fn is_version_5(start: &[u8]) -> bool {
    matches!(
        start.get(124..128),
        Some([0, 1, b'I', b'M'] | [1, 0, b'M', b'I'])
    )
}

/// Version 4 has no header; a matrix starts with type, rows, columns, imaginary part and length of the name with its NUL.
fn is_version_4(start: &[u8]) -> bool {
    let (numbers, _) = start.as_chunks::<4>();
    let Some(numbers) = numbers.first_chunk::<5>() else {
        return false;
    };
    [
        numbers.map(i32::from_le_bytes),
        numbers.map(i32::from_be_bytes),
    ]
    .into_iter()
    .any(|[kind, rows, columns, imaginary, length]| {
        let is_kind = matches!(kind, 0..=52 | 1000..=1052) && kind % 10 <= 2;
        let name = usize::try_from(length)
            .ok()
            .filter(|length| (2..=64).contains(length))
            .and_then(|length| start.get(20..20 + length));
        let is_letter = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
        let is_name = name
            .and_then(<[u8]>::split_last)
            .is_some_and(|(last, letters)| *last == 0 && letters.iter().all(is_letter));
        is_kind && rows >= 0 && columns >= 0 && matches!(imaginary, 0 | 1) && is_name
    })
}

/// The numeric matrices of a file, in file order.
///
/// # Errors
/// [`Error::File`] with the place for what isn't a file of version 5, or is cut off; [`Error::Io`].
pub fn list(path: &Path) -> Result<Vec<Listed>, Error> {
    let mut listed = Vec::new();
    walk(path, &mut |found, _| {
        if !is_table(found) {
            listed.push(Listed {
                name: found.name.clone(),
                shape: found.shape(),
                obstacle: obstacle(found),
            });
        }
        Ok(())
    })?;
    Ok(listed)
}

fn is_table(found: &Found) -> bool {
    found.name.eq_ignore_ascii_case(DOF_REF)
}

fn obstacle(found: &Found) -> Option<String> {
    if found.is_complex {
        return Some("complex".into());
    }
    if found.is_logical {
        return Some("logical".into());
    }
    match found.shape() {
        Some((rows, columns)) => obstacle_of_shape(rows, columns),
        None => Some(format!("{} dimensions", found.sizes.len())),
    }
}

/// Reads matrices by their place in the list; a table `dof_ref` labels their rows.
///
/// # Errors
/// As [`list`]; [`Error::File`] with place and name for matrices that can't be stiffness or mass, and labels that can't be.
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let (matrices, sha256) = hashed(path, || read_matrices(path, wanted))?;
    Ok(Reading { matrices, sha256 })
}

fn read_matrices(path: &Path, wanted: &[usize]) -> Result<Vec<StoredMatrix>, Error> {
    let mut read: Vec<Option<StoredMatrix>> = wanted.iter().map(|_| None).collect();
    let mut labels = None;
    let mut number = 0;
    walk(path, &mut |found, body| {
        if is_table(found) {
            labels = Some(table_of(found, body)?);
            return Ok(());
        }
        if let Some(at) = wanted.iter().position(|&wanted| wanted == number) {
            read[at] = Some(matrix(found, body)?);
        }
        number += 1;
        Ok(())
    })?;
    let refused = |message| Error::File {
        path: path.into(),
        message,
    };
    let missing = || refused(format!("has {number} matrices, fewer than were asked for"));
    let mut matrices: Vec<StoredMatrix> = read
        .into_iter()
        .collect::<Option<_>>()
        .ok_or_else(missing)?;
    if let Some(labels) = labels {
        let labelled = labels.label_rows(&mut matrices);
        labelled.map_err(|message| refused(format!("{DOF_REF} {message}")))?;
    }
    Ok(matrices)
}

/// Reads an array of integers with one or two columns, by name without regard to case.
pub(crate) fn table(path: &Path, name: &str) -> Result<Option<IntegerTable>, Error> {
    let mut table = None;
    walk(path, &mut |found, body| {
        if found.name.eq_ignore_ascii_case(name) && table.is_none() {
            table = Some(table_of(found, body)?);
        }
        Ok(())
    })?;
    Ok(table)
}

fn table_of(found: &Found, body: &mut Body<'_>) -> Result<IntegerTable, Error> {
    let refused =
        |body: &Body<'_>, message: String| body.refused(format!("{}: {message}", found.name));
    let Some((rows, columns)) = found.shape().filter(|_| found.class == Class::Dense) else {
        return Err(refused(
            body,
            "isn't a full matrix; a table of dofs is one".into(),
        ));
    };
    let count = rows.checked_mul(columns);
    let mut part = body.numbers()?;
    let number = part.number();
    let values = match count {
        Some(count) if count <= part.count() => integers(&mut part, number, count)?,
        _ => return Err(part.too_few(rows, columns)),
    };
    part.finish()?;
    IntegerTable::of(columns, values, true).map_err(|message| refused(body, message))
}

fn matrix(found: &Found, body: &mut Body<'_>) -> Result<StoredMatrix, Error> {
    let refused =
        |body: &Body<'_>, message: String| body.refused(format!("{}: {message}", found.name));
    if let Some(obstacle) = obstacle(found) {
        return Err(refused(
            body,
            format!("{obstacle}; stiffness and mass are real and square"),
        ));
    }
    let (rows, columns) = found.shape().unwrap_or_default();
    let size = square(rows, columns).map_err(|message| refused(body, message))?;
    let (number, content) = match found.class {
        Class::Sparse => sparse(found, body, size)?,
        Class::Dense => {
            let mut part = body.numbers()?;
            if part.count() != rows.saturating_mul(columns) {
                return Err(part.too_few(rows, columns));
            }
            let number = part.number();
            let content = dense(&mut part, number, Along::Columns, size)?;
            part.finish()?;
            (number, content)
        }
    };
    Ok(StoredMatrix {
        digits: number.digits(),
        ..StoredMatrix::unlabelled(found.name.clone(), size as usize, content)
    })
}

fn sparse(found: &Found, body: &mut Body<'_>, size: u32) -> Result<(Number, Content), Error> {
    let mut list = || {
        let mut part = body.numbers()?;
        let (number, count) = (part.number(), part.count());
        let read = indices(&mut part, number, count)?;
        part.finish()?;
        Ok(read)
    };
    let (rows, starts) = (list()?, list()?);
    let pattern = Pattern::checked(Along::Columns, size, starts, rows)
        .map_err(|message| body.refused(format!("{}: {message}", found.name)))?;
    let mut part = body.numbers()?;
    if part.count() < pattern.len() {
        return Err(part.too_few(pattern.len(), 1));
    }
    let number = part.number();
    let content = pattern.with_values(&mut part, number)?;
    part.finish()?;
    Ok((number, content))
}
