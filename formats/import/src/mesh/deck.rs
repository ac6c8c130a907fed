//! Text decks that include other files.
//!
//! Only files below the deck's own folder are opened, each once: a deck from a stranger must not read what else is on the disk.

use std::path::{Component, Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::terminal::shortened;

use crate::text::lines::Lines;

/// Files that are open together, at most.
const DEPTH: usize = 32;

/// Lines of a deck and of the files that it includes.
pub(super) struct Deck {
    /// The innermost file last.
    open: Vec<(String, Lines)>,
    folder: PathBuf,
    opened: Vec<PathBuf>,
    included: Vec<(String, String)>,
    line: Vec<u8>,
    bytes: u64,
}

impl Deck {
    /// Opens a deck.
    ///
    /// # Errors
    /// As [`Lines::open`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        let lines = Lines::open(path)?;
        let whole = path.canonicalize().unwrap_or_else(|_| path.into());
        Ok(Self {
            open: vec![(String::new(), lines)],
            folder: whole.parent().map(Path::to_owned).unwrap_or_default(),
            opened: vec![whole],
            included: Vec::new(),
            line: Vec::new(),
            bytes: 0,
        })
    }

    /// Refuses a last line without an end.
    ///
    /// # Errors
    /// As [`Lines::refuse_open_end`].
    pub fn refuse_open_end(&self) -> Result<(), Error> {
        match self.open.last() {
            Some((_, lines)) => lines.refuse_open_end(),
            None => Ok(()),
        }
    }

    /// Goes to the next line, of the included file first; whether there is one.
    ///
    /// # Errors
    /// As [`Lines::next_line`].
    pub fn advance(&mut self) -> Result<bool, Error> {
        while let Some((_, lines)) = self.open.last_mut() {
            if let Some(line) = lines.next_line()? {
                self.bytes += line.len() as u64 + 1;
                self.line.clear();
                self.line.extend_from_slice(line);
                return Ok(true);
            }
            if self.open.len() == 1 {
                break;
            }
            self.close_included()?;
        }
        Ok(false)
    }

    /// This line, without its end.
    pub fn line(&self) -> &[u8] {
        &self.line
    }

    fn close_included(&mut self) -> Result<(), Error> {
        if let Some((name, lines)) = self.open.pop() {
            self.included.push((name, lines.finish()?));
        }
        Ok(())
    }

    /// Goes on with another file, then with the rest of this one.
    ///
    /// # Errors
    /// [`Error::Line`] for a file that isn't below the deck's folder, that was included before, or can't be opened.
    pub fn include(&mut self, name: &str) -> Result<(), Error> {
        let shown = shortened(name);
        // Decks written on Windows.
        let relative = PathBuf::from(name.replace('\\', "/"));
        let is_below = relative
            .components()
            .all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !is_below || name.contains(':') {
            return Err(self.refused(format!(
                "includes `{shown}`; only files in or below the folder of the deck are read, named from there without `..`"
            )));
        }
        let path = self.folder.join(relative);
        let whole = path.canonicalize().map_err(|error| {
            self.refused(format!("includes `{shown}`, which can't be read: {error}"))
        })?;
        if !whole.starts_with(&self.folder) {
            return Err(self.refused(format!(
                "includes `{shown}`, a link that leads out of the folder of the deck"
            )));
        }
        if self.opened.contains(&whole) {
            return Err(self.refused(format!(
                "includes `{shown}` a second time; each file is read once"
            )));
        }
        if self.open.len() == DEPTH {
            return Err(self.refused(format!("includes a file {DEPTH} files deep")));
        }
        let lines = Lines::open(&path)?;
        self.opened.push(whole);
        self.open.push((name.to_owned(), lines));
        Ok(())
    }

    /// Bytes of text so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// An error in the line that was given out last.
    pub fn refused(&self, message: impl Into<String>) -> Error {
        match self.open.last() {
            Some((_, lines)) => lines.refused(message),
            None => Error::File {
                path: self.folder.clone(),
                message: message.into(),
            },
        }
    }

    /// SHA-256 of the deck, and of what it includes by name.
    ///
    /// # Errors
    /// As [`Lines::finish`].
    pub fn finish(mut self) -> Result<(String, Vec<(String, String)>), Error> {
        while self.open.len() > 1 {
            self.close_included()?;
        }
        let mut sha256 = String::new();
        for (_, lines) in self.open {
            sha256 = lines.finish()?;
        }
        Ok((sha256, self.included))
    }
}
