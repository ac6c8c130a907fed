//! What an exporter has made: files in memory, and what is said about them.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::output::{Replace, check_output, write_stream};

use crate::files::hdf5_tree::Hdf5Tree;

/// Contents of a file.
pub(crate) enum Content {
    Bytes(Vec<u8>),
    Hdf5(Hdf5Tree),
}

/// Files and words.
pub(crate) struct Product {
    /// The file that was asked for.
    pub content: Content,
    /// A file beside it, with this ending instead of its own.
    pub beside: Option<(&'static str, Vec<u8>)>,
    /// What is in it, in one line.
    pub summary: String,
    /// Facts that whoever uses the file has to know.
    pub notes: Vec<String>,
    /// What of the superelement isn't in it.
    pub left_out: Vec<String>,
    /// Text to paste into the other program's input.
    pub paste: Option<(&'static str, String)>,
}

impl Product {
    /// With nothing but contents.
    pub(crate) fn new(content: Content, summary: String) -> Self {
        Self {
            content,
            beside: None,
            summary,
            notes: Vec::new(),
            left_out: Vec::new(),
            paste: None,
        }
    }

    /// Writes all files. The one that was asked for comes last: where it is, all is.
    pub(crate) fn write(&self, output: &Path, replace: Replace) -> Result<Vec<PathBuf>, Error> {
        let mut files = vec![output.to_owned()];
        if let Some((ending, bytes)) = &self.beside {
            let path = output.with_extension(ending);
            if path == output {
                return Err(Error::File {
                    path,
                    message: format!(
                        "is the name of the matrices, which stand beside the bulk data; name an output that doesn't end in .{ending}"
                    ),
                });
            }
            check_output(&path, replace)?;
            write_stream(&path, replace, |out| out.write_all(bytes))?;
            files.push(path);
        }
        let written = match &self.content {
            Content::Bytes(bytes) => write_stream(output, replace, |out| out.write_all(bytes)),
            Content::Hdf5(tree) => tree.write(output, replace),
        };
        if let (Err(_), Some(path)) = (&written, files.get(1)) {
            // Alone it is of no use.
            let _ = fs::remove_file(path);
        }
        written.map(|()| files)
    }

    /// For people.
    pub(crate) fn text(&self, files: &[PathBuf]) -> String {
        let mut text = String::new();
        let names: Vec<String> = files
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        let _ = writeln!(text, "{}: {}", names.join(", "), self.summary);
        for note in &self.notes {
            let _ = writeln!(text, "note      {note}");
        }
        for left_out in &self.left_out {
            let _ = writeln!(text, "left out  {left_out}");
        }
        if let Some((title, paste)) = &self.paste {
            let _ = writeln!(text, "{title}\n\n{}", paste.trim_end());
        }
        text
    }
}
