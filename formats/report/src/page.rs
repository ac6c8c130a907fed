//! A report as one HTML page: text, tables and pictures in a single file that needs no other and no network.

use std::path::Path;

use crate::html::escaped;
use crate::table::Table;
use dcb_formats::Error;
use dcb_formats::output::write_text;

/// How it looks: plain, dark on light whatever the system prefers, wide tables scroll by themselves, pictures shrink with the
/// window, and it prints.
const STYLE: &str = ":root{color-scheme:light}body{font:16px/1.45 sans-serif;color:#222;background:#fff;max-width:72rem;margin:2rem auto;padding:0 1rem}\
h1{font-size:1.6rem}h2{font-size:1.25rem;margin-top:2.2rem;border-bottom:1px solid #ddd}\
table{border-collapse:collapse;font-size:.85rem}th,td{padding:.25rem .45rem;border-bottom:1px solid #ddd;text-align:left}\
th{vertical-align:bottom}td.number{text-align:right;font-variant-numeric:tabular-nums}td.number,td.word{white-space:nowrap}\
tr.marked td{background:#fff3cd}details{margin:1rem 0}summary{cursor:pointer;font-weight:600;padding:.3rem 0}.wide{overflow-x:auto}figure{margin:1rem 0}figure svg{max-width:100%;height:auto}\
figcaption{font-size:.9rem;color:#555}.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,21rem),1fr));gap:1rem}\
.pictures figure{margin:0}@media print{.wide{overflow:visible}table{font-size:.6rem}}";

/// How a page says at its beginning that it was made here and can be made again.
pub const PAGE_GENERATOR: &str = "<meta name=\"generator\" content=\"Tisserand\">";

/// A page that grows from top to bottom. All text is escaped; pictures are SVG and taken as they are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    title: String,
    further_style: String,
    body: String,
}

impl Page {
    /// A page with its title as heading.
    pub fn new(title: &str) -> Self {
        Self {
            title: title.to_owned(),
            further_style: String::new(),
            body: format!("<h1>{}</h1>\n", escaped(title)),
        }
    }

    /// Style besides the usual one.
    pub fn style(&mut self, style: &str) {
        self.further_style += style;
    }

    /// HTML that is taken as it is: nothing of it may come from a file.
    pub fn markup(&mut self, html: &str) {
        self.body += html;
    }

    /// A section begins.
    pub fn heading(&mut self, text: &str) {
        self.body += &format!("<h2>{}</h2>\n", escaped(text));
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.body += &format!("<p>{}</p>\n", escaped(text));
    }

    /// A list of points.
    pub fn list<T: AsRef<str>>(&mut self, points: &[T]) {
        self.body += "<ul>\n";
        for point in points {
            self.body += &format!("<li>{}</li>\n", escaped(point.as_ref()));
        }
        self.body += "</ul>\n";
    }

    /// A table, in which the rows at `marked` stand out.
    pub fn table(&mut self, table: &Table, marked: &[usize]) {
        self.body += &table.html(marked);
    }

    /// A table under a line that opens and closes it; closed at first.
    pub fn folded_table(&mut self, summary: &str, table: &Table, marked: &[usize]) {
        self.body += &format!(
            "<details>\n<summary>{}</summary>\n{}</details>\n",
            escaped(summary),
            table.html(marked)
        );
    }

    /// A picture with its caption.
    pub fn picture(&mut self, svg: &str, caption: &str) {
        self.body += &figure(svg, caption);
    }

    /// Small pictures side by side, each with its caption.
    pub fn pictures(&mut self, pictures: &[(String, String)]) {
        self.body += "<div class=\"pictures\">\n";
        for (svg, caption) in pictures {
            self.body += &figure(svg, caption);
        }
        self.body += "</div>\n";
    }

    /// All of it.
    pub fn html(&self) -> String {
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n{PAGE_GENERATOR}\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n<style>{STYLE}{}</style>\n</head>\n<body>\n<main>\n{}</main>\n</body>\n</html>\n",
            escaped(&self.title),
            self.further_style,
            self.body
        )
    }

    /// Writes it, whole or not at all; an existing file is replaced.
    ///
    /// # Errors
    /// As [`write_text`].
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        write_text(path, &self.html())
    }
}

fn figure(svg: &str, caption: &str) -> String {
    format!(
        "<figure>\n{}\n<figcaption>{}</figcaption>\n</figure>\n",
        svg.trim(),
        escaped(caption)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_self_contained_and_escapes_names() {
        let mut page = Page::new("<rod> & \"co\"");
        page.paragraph("1 < 2");
        page.picture("<svg></svg>", "a > b");
        let html = page.html();
        assert!(html.contains("<title>&lt;rod&gt; &amp; &quot;co&quot;</title>"));
        assert!(
            html.contains("1 &lt; 2") && html.contains("a &gt; b") && html.contains("<svg></svg>")
        );
        assert!(!html.contains("http") && !html.contains("<script"));
    }
}
