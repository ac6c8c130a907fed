//! The page that an archive has for people: what the unit is, and its variables.

use std::io;

use quick_xml::Writer;
use quick_xml::events::BytesText;

use crate::model_description::Named;
use crate::unit::CoSimulation;
use crate::variable::Source;

/// The text of `documentation/index.html`.
///
/// # Errors
/// None but those of writing to memory.
pub fn documentation(unit: &CoSimulation, named: Named<'_>) -> io::Result<String> {
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 1);
    let units = &unit.scene().units;
    let about = format!(
        "A mechanism of rigid and flexible bodies for co-simulation (FMI 3.0), made by dcb simulate {} of a scene in {}, {}, {}.",
        env!("CARGO_PKG_VERSION"),
        units.length,
        units.mass,
        units.time
    );
    let heads = [
        "name",
        "value reference",
        "what",
        "unit",
        "start",
        "meaning",
    ];
    writer.create_element("html").write_inner_content(|page| {
        page.create_element("head").write_inner_content(|head| {
            let meta = head.create_element("meta");
            meta.with_attribute(("charset", "utf-8")).write_empty()?;
            text(head, "title", named.model)
        })?;
        let body = page.create_element("body");
        body.write_inner_content(|body| {
            text(body, "h1", named.model)?;
            text(body, "p", &about)?;
            let table = body.create_element("table").with_attribute(("border", "1"));
            table.write_inner_content(|table| {
                row(table, "th", &heads)?;
                for variable in unit.variables() {
                    let what = match variable.source {
                        Source::Time => "independent",
                        Source::Parameter(_) => "parameter",
                        Source::Input(_) => "input",
                        Source::Output { .. } => "output",
                    };
                    let start = variable
                        .start
                        .map_or_else(String::new, |start| format!("{start:?}"));
                    let reference = variable.reference.to_string();
                    let cells = [
                        variable.name.as_str(),
                        &reference,
                        what,
                        &variable.unit,
                        &start,
                        &variable.description,
                    ];
                    row(table, "td", &cells)?;
                }
                Ok(())
            })?;
            Ok(())
        })?;
        Ok(())
    })?;
    let page = String::from_utf8(writer.into_inner()).map_err(io::Error::other)?;
    Ok(format!("<!DOCTYPE html>\n{page}\n"))
}

type Page = Writer<Vec<u8>>;

fn text(page: &mut Page, element: &str, content: &str) -> io::Result<()> {
    page.create_element(element)
        .write_text_content(BytesText::new(content))?;
    Ok(())
}

fn row(page: &mut Page, element: &str, cells: &[&str]) -> io::Result<()> {
    page.create_element("tr").write_inner_content(|row| {
        for cell in cells {
            text(row, element, cell)?;
        }
        Ok(())
    })?;
    Ok(())
}
