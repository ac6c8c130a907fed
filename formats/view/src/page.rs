//! The page: a report that carries a view.

use std::io;

use dcb_report::Page;

use crate::arrays::Arrays;
use crate::description::Description;

/// The script that draws the view, made from `formats/view/web`.
const SCRIPT: &str = include_str!("../bundle/viewer.js");
/// Its style.
const STYLE: &str = include_str!("../bundle/viewer.css");

/// A report with a view in it.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingPage {
    /// Text, tables and pictures, which are there without the script too.
    pub report: Page,
    /// What the view shows.
    pub description: Description,
    /// Its numbers.
    pub arrays: Arrays,
}

impl MovingPage {
    /// All of it as HTML. Names from files can't end the description: every `<` in it is written as an escape.
    ///
    /// # Errors
    /// Of the compression.
    pub fn html(&self) -> io::Result<String> {
        let description = serde_json::to_string(&self.description)
            .map_err(io::Error::other)?
            .replace('<', "\\u003c");
        let mut page = self.report.clone();
        page.style(STYLE);
        page.markup(&format!(
            "<script type=\"application/json\" id=\"description\">{description}</script>\n<script type=\"text/plain\" id=\"arrays\">{}</script>\n<script type=\"module\">{SCRIPT}</script>\n",
            self.arrays.encoded()?
        ));
        Ok(page.html())
    }
}
