//! The shared library with the functions of FMI: where it is, and whether it is the one that belongs to this program.

use std::path::{Path, PathBuf};

use dcb_cosimulation::MARK;
use dcb_runtime::error::Error;

use super::archive::Member;

/// The library's name without the platform's ending.
const NAME: &str = "libdcb_fmu.so";
/// What makes it.
const BUILD: &str = "build it with `.ci/setup build --release -p dcb-fmu`, which leaves it in target/release, or name it with --library";
/// A function without which nothing is an FMU.
const FUNCTION: &str = "fmi3InstantiateCoSimulation";

/// A shared library.
pub struct Library {
    /// The file.
    pub path: PathBuf,
    content: Vec<u8>,
    /// The folder of the archive: architecture and system.
    platform: &'static str,
}

impl Library {
    /// Those that are named, one for each platform, or the one that is where it belongs.
    pub fn find(named: &[PathBuf]) -> Result<Vec<Self>, Error> {
        if named.is_empty() {
            return Ok(vec![Self::beside_program()?]);
        }
        let mut found: Vec<Self> = Vec::new();
        for path in named {
            let library = Self::read(path)?;
            if let Some(other) = found.iter().find(|one| one.platform == library.platform) {
                let message = format!(
                    "is for {} as {} is; name one for each platform",
                    library.platform,
                    other.path.display()
                );
                return Err(refused(path, message));
            }
            found.push(library);
        }
        Ok(found)
    }

    fn beside_program() -> Result<Self, Error> {
        let program = std::env::current_exe().unwrap_or_default();
        let folder = program.parent().unwrap_or(Path::new("."));
        let places = [folder.join(NAME), folder.join("../lib").join(NAME)];
        match places.iter().find(|place| place.is_file()) {
            Some(path) => Self::read(path),
            None => Err(Error::described(
                "--library",
                format!(
                    "the shared library {NAME} is neither in {} nor in ../lib from there; {BUILD}",
                    folder.display()
                ),
            )),
        }
    }

    fn read(path: &Path) -> Result<Self, Error> {
        let content = std::fs::read(path)
            .map_err(|source| dcb_formats::Error::io(path, "cannot read", source))?;
        let platform = platform(&content).map_err(|message| refused(path, message))?;
        if !contains(&content, FUNCTION) {
            let message = format!("has no function {FUNCTION}; {BUILD}");
            return Err(refused(path, message));
        }
        if !contains(&content, MARK) {
            let message =
                format!("is of another version than this program ({MARK:?} isn't in it); {BUILD}");
            return Err(refused(path, message));
        }
        Ok(Self {
            path: path.to_owned(),
            content,
            platform,
        })
    }

    /// Its place in the archive.
    pub fn member(self, identifier: &str) -> Member {
        let name = format!("binaries/{}/{identifier}.so", self.platform);
        Member::executable(name, self.content)
    }
}

/// The platform of a shared library, as FMI names it.
fn platform(content: &[u8]) -> Result<&'static str, String> {
    let other = "isn't a shared library for Linux, 64 bits (ELF)";
    // Magic number, 64 bits, little-endian; shared object; machine.
    match content.get(..20) {
        Some([0x7f, b'E', b'L', b'F', 2, 1, .., 3, 0, 0x3e, 0]) => Ok("x86_64-linux"),
        Some([0x7f, b'E', b'L', b'F', 2, 1, .., 3, 0, 0xb7, 0]) => Ok("aarch64-linux"),
        _ => Err(format!("{other}; {BUILD}")),
    }
}

fn contains(content: &[u8], text: &str) -> bool {
    content
        .windows(text.len())
        .any(|window| window == text.as_bytes())
}

fn refused(path: &Path, message: String) -> Error {
    dcb_formats::Error::File {
        path: path.to_owned(),
        message,
    }
    .into()
}
