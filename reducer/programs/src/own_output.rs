//! Files that the programs made themselves and can make again, so that the next ones may replace them without being asked to.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use dcb_formats::output::Replace;
use dcb_report::PAGE_GENERATOR;

/// So much of a file tells what it is.
const BEGINNING: u64 = 1024;

/// What may be made again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Made {
    /// An SVG picture, whoever drew it.
    Picture,
    /// A page of this project.
    Page,
}

impl Made {
    /// Overwrites a file of this kind, and treats others as asked.
    pub(crate) fn replace(self, target: &Path, asked: Replace) -> Replace {
        match self.is(target) {
            true => Replace::Overwrite,
            false => asked,
        }
    }

    fn is(self, path: &Path) -> bool {
        let mut start = Vec::new();
        let read = File::open(path).and_then(|file| file.take(BEGINNING).read_to_end(&mut start));
        let mark = match self {
            Self::Picture => "<svg",
            Self::Page => PAGE_GENERATOR,
        };
        read.is_ok() && String::from_utf8_lossy(&start).contains(mark)
    }
}
