//! The texts of a file about its making, for people.

use crate::component::Source;
use crate::dcb::read::SuperelementFile;
use crate::hdf5_files::attributes::Value;
use crate::hdf5_files::inventory::Finding;
use crate::superelement::Provenance;

/// The texts that the digest doesn't cover: each may be missing, none may be malformed.
pub(super) fn provenance(file: &SuperelementFile) -> Result<Provenance, Finding> {
    let text = |path: &str, name: &str| match file.inventory().attribute(path, name) {
        Some(Value::Text(text)) => Ok(text.as_str()),
        Some(other) => Err(Finding::at(
            path,
            format!("attribute {name} is {other:?}; it must be a string"),
        )),
        None => Ok(""),
    };
    let json = |name: &str| {
        let text = text("/provenance", name)?;
        if text.is_empty() {
            return Ok(serde_json::Value::Null);
        }
        serde_json::from_str(text).map_err(|error| {
            Finding::at(
                "/provenance",
                format!("attribute {name} isn't JSON: {error}"),
            )
        })
    };
    let list = |name: &str| json(name).map(|value| value.as_array().cloned().unwrap_or_default());
    let word = |value: &serde_json::Value, name: &str| {
        value
            .get(name)
            .and_then(serde_json::Value::as_str)
            .unwrap_or("")
            .to_owned()
    };
    let source = |value| Source {
        role: word(value, "role"),
        file_name: word(value, "file_name"),
        sha256: word(value, "sha256"),
    };
    Ok(Provenance {
        generator: text("/", "generator")?.to_owned(),
        inputs: list("inputs")?.iter().map(source).collect(),
        options: json("options")?,
        quality: json("quality")?,
        warnings: list("warnings")?
            .iter()
            .map(|warning| warning.as_str().unwrap_or("").to_owned())
            .collect(),
    })
}
