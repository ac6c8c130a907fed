//! Which matrices of a file are stiffness and mass.

use crate::source::matrix_file::MatrixFile;
use crate::stored::Listed;
use dcb_formats::Error;

/// Matrices of a file that are named in an error.
const NAMED: usize = 20;

/// The matrix that is asked for by name or number; without it, the only one that can be meant.
///
/// # Errors
/// [`Error::File`] with the list of what is there.
pub(crate) fn chosen(file: &MatrixFile, asked: Option<&str>) -> Result<usize, Error> {
    match asked {
        Some(name) => by_name(file, name),
        None => match usable(file.listed()).as_slice() {
            [only] => Ok(*only),
            _ => match pairs(file.listed()).as_slice() {
                [(stiffness, _)] => Ok(*stiffness),
                _ => Err(unclear(file)),
            },
        },
    }
}

/// The partner of a stiffness matrix in its own file, if it is there.
pub(crate) fn mass_of(file: &MatrixFile, stiffness: usize) -> Option<usize> {
    let of_it = |pair: &&(usize, usize)| pair.0 == stiffness;
    pairs(file.listed())
        .iter()
        .find(of_it)
        .map(|(_, mass)| *mass)
}

fn by_name(file: &MatrixFile, name: &str) -> Result<usize, Error> {
    let listed = file.listed();
    let exact = |one: &Listed| one.name.eq_ignore_ascii_case(name);
    let last = |one: &Listed| {
        let own = one.name.rsplit('/').next().unwrap_or(&one.name);
        own.eq_ignore_ascii_case(name)
    };
    let number = || {
        let number: usize = name.parse().ok()?;
        (1..=listed.len()).contains(&number).then(|| number - 1)
    };
    let of = |wanted: &dyn Fn(&Listed) -> bool| -> Vec<usize> {
        (0..listed.len())
            .filter(|&at| wanted(&listed[at]))
            .collect()
    };
    let found = match of(&exact).as_slice() {
        [] => of(&last),
        some => some.to_vec(),
    };
    match (found.as_slice(), number()) {
        ([only], _) => Ok(*only),
        ([], Some(number)) => Ok(number),
        ([], None) => Err(file.refused(format!(
            "has no matrix named {name:?}; it has {}",
            list(listed)
        ))),
        (several, _) => Err(file.refused(format!(
            "has {} matrices named {name:?}; name one by its number in the list, #1 to #{}: {}",
            several.len(),
            listed.len(),
            list(listed)
        ))),
    }
}

/// Matrices that may be a stiffness or mass: square, as far as it shows.
fn usable(listed: &[Listed]) -> Vec<usize> {
    let is_square = |one: &Listed| one.shape.is_none_or(|(rows, columns)| rows == columns);
    (0..listed.len())
        .filter(|&at| listed[at].obstacle.is_none() && is_square(&listed[at]))
        .collect()
}

/// Stiffness and mass by their names: `KAAX` and `MAAX`, `K` and `M`, `stiffness` and `mass`, in one group.
fn pairs(listed: &[Listed]) -> Vec<(usize, usize)> {
    let usable = usable(listed);
    let mut found = Vec::new();
    for &stiffness in &usable {
        let Some(partner) = mass_name(&listed[stiffness].name) else {
            continue;
        };
        let is_partner = |&&at: &&usize| {
            listed[at].name.eq_ignore_ascii_case(&partner)
                && listed[at].shape == listed[stiffness].shape
        };
        let mut masses = usable.iter().filter(is_partner);
        if let (Some(mass), None) = (masses.next(), masses.next()) {
            found.push((stiffness, *mass));
        }
    }
    found
}

/// Name of the mass that goes with a stiffness of this name.
fn mass_name(stiffness: &str) -> Option<String> {
    let (group, own) = match stiffness.rfind('/') {
        Some(at) => stiffness.split_at(at + 1),
        None => ("", stiffness),
    };
    let lower = own.to_ascii_lowercase();
    let mass = if let Some(rest) = lower.strip_prefix("stiffness") {
        format!("mass{rest}")
    } else if let Some(rest) = lower.strip_prefix("stif") {
        format!("mass{}", rest.strip_prefix('f').unwrap_or(rest))
    } else {
        format!("m{}", lower.strip_prefix('k')?)
    };
    Some(format!("{group}{mass}"))
}

fn unclear(file: &MatrixFile) -> Error {
    let listed = file.listed();
    let message = match (listed.is_empty(), usable(listed).is_empty()) {
        (true, _) => "has no matrix in it".to_owned(),
        (_, true) => format!(
            "has no square real matrix in it, only {}; stiffness and mass are square and real",
            list(listed)
        ),
        _ => format!(
            "has several matrices; name the one that is meant, {}#NAME: {}",
            file.file_name(),
            list(listed)
        ),
    };
    file.refused(message)
}

/// Matrices in words: name, sizes, and why one can't be used.
pub(crate) fn list(listed: &[Listed]) -> String {
    let mut words: Vec<String> = listed
        .iter()
        .take(NAMED)
        .enumerate()
        .map(|(at, one)| {
            let name = match one.name.is_empty() {
                true => format!("#{}", at + 1),
                false => one.name.clone(),
            };
            let shape = (one.shape).map(|(rows, columns)| format!("{rows} x {columns}"));
            let about: Vec<String> = shape.into_iter().chain(one.obstacle.clone()).collect();
            match about.is_empty() {
                true => name,
                false => format!("{name} ({})", about.join(", ")),
            }
        })
        .collect();
    if listed.len() > NAMED {
        words.push(format!("and {} more", listed.len() - NAMED));
    }
    match words.is_empty() {
        true => "nothing".into(),
        false => words.join(", "),
    }
}
