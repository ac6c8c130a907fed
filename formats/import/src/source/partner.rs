//! Files that belong to a stiffness file by its name: the mass, the table of dofs, the mesh.

use std::path::{Path, PathBuf};

/// Parts of names of stiffness files and what stands there in the name of the mass file.
const MASS_NAMES: [(&str, &str); 6] = [
    ("stiffness", "mass"),
    ("stiff", "mass"),
    ("stif", "mass"),
    (".sti", ".mas"),
    ("_k", "_m"),
    ("k", "m"),
];

/// The mass file beside a stiffness file: `job.mas` of `job.sti`, `job_MASS1.mtx` of `job_STIF1.mtx`, `part.mass.mtx` of `part.mtx`,
/// `M.mmf` of `K.mmf`; `None` where there is none, or more than one.
pub(crate) fn mass_file(stiffness: &Path) -> Option<PathBuf> {
    let name = stiffness.file_name()?.to_str()?;
    let mut names: Vec<String> = Vec::new();
    let (stem, ending) = name.split_once('.').unwrap_or((name, ""));
    names.push(format!("{stem}.mass.{ending}"));
    let lower = name.to_ascii_lowercase();
    // A letter has to stand as a word: `K.npz`, `part_K_csr.npz`.
    let is_word = |at: usize, length: usize| {
        let bytes = lower.as_bytes();
        let is_letter = |byte: Option<&u8>| byte.is_some_and(u8::is_ascii_alphanumeric);
        let before = at.checked_sub(1).and_then(|before| bytes.get(before));
        !is_letter(before) && !is_letter(bytes.get(at + length))
    };
    for (stiff, mass) in MASS_NAMES {
        let Some(at) = lower.rfind(stiff) else {
            continue;
        };
        if stiff.trim_start_matches('_').len() == 1 && !is_word(at + stiff.len() - 1, 1) {
            continue;
        }
        let is_upper =
            name[at..at + stiff.len()].contains(|letter: char| letter.is_ascii_uppercase());
        let mass = match is_upper {
            true => mass.to_ascii_uppercase(),
            false => mass.to_owned(),
        };
        names.push(format!(
            "{}{mass}{}",
            &name[..at],
            &name[at + stiff.len()..]
        ));
        if stiff.len() > 4 {
            break;
        }
    }
    let mut found = names
        .iter()
        .map(|name| stiffness.with_file_name(name))
        .filter(|path| path.as_path() != stiffness && path.exists())
        .collect::<Vec<_>>();
    found.dedup();
    match found.len() {
        1 => found.pop(),
        _ => None,
    }
}

/// CalculiX's table of dofs beside `job.sti`, if it is there.
pub(crate) fn dof_file(stiffness: &Path) -> Option<PathBuf> {
    let path = stiffness.with_extension("dof");
    (path.exists() && path != stiffness).then_some(path)
}
