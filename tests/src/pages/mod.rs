//! Pages of `docs/` with parts that are rendered from the raw lines of measurements, which stand in `docs/data`.

pub mod accuracy;
pub mod campbell;
pub mod damping;
pub mod error_estimate;
pub mod exchange;
pub mod fuzzing;
pub mod hard_cases;
pub mod html_pages;
pub mod large_file;
pub mod machine;
pub mod motion;
pub mod python;
pub mod random_response;
pub mod read_matrices;
pub mod scene_driven;
pub mod scene_reduction;
pub mod speed_against_error;
pub mod stability;
pub mod stress;

use std::path::{Path, PathBuf};

use dcb_formats::output::Replace;
use dcb_report::{Chart, write_svg};
use serde_json::Value;

/// A file in `docs/pictures/`, and the charts in it.
pub type Picture = (String, Vec<Chart>);

/// A part of a page that is rendered from raw lines.
pub struct Page {
    /// File in `docs/`.
    pub page: &'static str,
    /// File in `docs/data/`, without its ending.
    pub data: &'static str,
    /// The part stands between these lines.
    pub markers: [&'static str; 2],
    /// The part, from the raw lines.
    pub render: fn(&str) -> String,
    /// The pictures, from the raw lines.
    pub pictures: fn(&str) -> Vec<Picture>,
}

impl Page {
    /// Where the raw lines stand.
    pub fn data_path(&self) -> PathBuf {
        docs().join(format!("data/{}.jsonl", self.data))
    }

    /// The raw lines as they stand.
    ///
    /// # Panics
    /// The file can't be read.
    pub fn raw(&self) -> String {
        read(&self.data_path())
    }

    /// The raw lines, one value each.
    ///
    /// # Panics
    /// The file can't be read, or a line isn't JSON.
    pub fn lines(&self) -> Vec<Value> {
        raw_lines(&self.raw())
    }

    /// The part as the raw lines say.
    ///
    /// # Panics
    /// The raw lines can't be read.
    pub fn rendered(&self) -> String {
        (self.render)(&self.raw())
    }

    /// Puts the part into the page.
    ///
    /// # Panics
    /// The raw lines or the page can't be read, or the page not be written.
    pub fn write(&self) {
        let path = docs().join(self.page);
        let before = between(self.page, self.markers);
        let [first, last] = self.markers;
        let page = read(&path).replace(
            &format!("{first}{before}{last}"),
            &format!("{first}{}{last}", self.rendered()),
        );
        std::fs::write(&path, page).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }

    /// Draws the pictures into a folder.
    ///
    /// # Panics
    /// The raw lines can't be read, or a picture can't be written.
    pub fn draw(&self, folder: &Path) {
        for (name, charts) in (self.pictures)(&self.raw()) {
            write_svg(&charts, &folder.join(name), Replace::Overwrite).expect("a picture");
        }
    }

    /// Asserts that the page shows what the raw lines render to.
    ///
    /// # Panics
    /// It doesn't.
    pub fn assert_shown(&self) {
        let expected = self.rendered();
        assert!(
            between(self.page, self.markers) == expected,
            "docs/{}: between the lines {:?} belongs\n{expected}",
            self.page,
            self.markers
        );
    }

    /// Asserts that the pictures are what the raw lines draw, and that the page names them.
    ///
    /// # Panics
    /// It isn't so.
    pub fn assert_drawn(&self) {
        let folder = tempfile::tempdir().expect("a folder");
        self.draw(folder.path());
        let page = read(&docs().join(self.page));
        let pictures = (self.pictures)(&self.raw());
        assert!(!pictures.is_empty());
        for (name, _) in pictures {
            let drawn = read(&folder.path().join(&name));
            assert!(drawn == read(&pictures_folder().join(&name)), "{name}");
            assert!(page.contains(&format!("(pictures/{name})")), "{name}");
        }
    }
}

/// The text between two lines of a file in `docs/`.
///
/// # Panics
/// The file or one of the lines is missing.
pub fn between(page: &str, markers: [&str; 2]) -> String {
    let text = read(&docs().join(page));
    let (_, rest) = text.split_once(markers[0]).expect("the first marker");
    let (between, _) = rest.split_once(markers[1]).expect("the second marker");
    between.to_owned()
}

/// Where the pictures of the pages stand.
pub fn pictures_folder() -> PathBuf {
    docs().join("pictures")
}

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

pub(crate) fn raw_lines(raw: &str) -> Vec<Value> {
    let value = |line| serde_json::from_str(line).expect("a line of JSON");
    raw.lines().map(value).collect()
}

/// On what the lines were measured.
pub(crate) fn machine(line: &Value) -> String {
    format!(
        "`{}`, commit {}, {}, {} cores, {}.\n",
        text(line, "command"),
        text(line, "commit"),
        text(line, "cpu"),
        line["cores"],
        text(line, "rustc")
    )
}

pub(crate) fn text(line: &Value, key: &str) -> String {
    line[key].as_str().expect(key).to_owned()
}

pub(crate) fn rows(lines: &[&Value], row: impl Fn(&Value) -> Vec<String>) -> Vec<Vec<String>> {
    lines.iter().map(|line| row(line)).collect()
}

pub(crate) fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let mut page = format!(
        "| {} |\n|{}\n",
        header.join(" | "),
        " --- |".repeat(header.len())
    );
    for row in rows {
        page += &format!("| {} |\n", row.join(" | "));
    }
    page
}
