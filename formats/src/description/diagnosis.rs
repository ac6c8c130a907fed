//! Diagnosis of a JSON text: the place of the fault, what stands there and what would be right.

use std::path::Path;

use crate::Error;
use crate::terminal::{abridged, shortened};

/// Bytes of a name that is compared with others, at most: the comparison takes the product of both lengths.
const LONGEST_NAME: usize = 100;
/// Letters at the beginning of a name that tell which is meant, at least.
const SHORTEST_BEGINNING: usize = 3;
/// Characters of what a parser says before the name that it complains of.
const LONGEST_BEFORE: usize = 200;
/// Characters of a parser's complaint that are shown.
const LONGEST_COMPLAINT: usize = 1200;

/// The valid name that a misspelt one most likely means: at most half of its characters differ, case aside, or it begins with it. Names of more than 100 bytes are
/// near to none.
pub fn nearest_name<'a>(found: &str, valid: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if found.len() > LONGEST_NAME {
        return None;
    }
    let wanted = found.to_lowercase();
    let valid: Vec<&str> = valid.into_iter().collect();
    let begun = valid
        .iter()
        .copied()
        .filter(|name| {
            wanted.len() >= SHORTEST_BEGINNING && name.to_lowercase().starts_with(&wanted)
        })
        .min_by_key(|name| name.len());
    let (distance, name) = valid
        .into_iter()
        .filter(|name| name.len() <= LONGEST_NAME)
        .map(|name| {
            (
                strsim::damerau_levenshtein(&wanted, &name.to_lowercase()),
                name,
            )
        })
        .min()?;
    let length = wanted.chars().count().max(name.chars().count());
    match 2 * distance <= length {
        true => Some(name),
        false => begun,
    }
}

/// `; did you mean `x`?` for the nearest valid name, or nothing where none is near.
pub fn suggestion<'a>(found: &str, valid: impl IntoIterator<Item = &'a str>) -> String {
    match nearest_name(found, valid) {
        Some(name) => format!("; did you mean `{name}`?"),
        None => String::new(),
    }
}

/// The names of a list, shortened where it is long.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    let names: Vec<&str> = names.into_iter().collect();
    let shown: Vec<String> = names
        .iter()
        .take(SHOWN)
        .map(|name| shortened(name))
        .collect();
    let mut text = shown.join(", ");
    if names.len() > SHOWN {
        text += &format!(" and {} more", names.len() - SHOWN);
    }
    text
}

/// A failed `serde_json` parse of `text` as an [`Error::Line`] that starts with the column.
///
/// An unknown field or value comes with the nearest valid name, a missing field with an example where `example`
/// has one, and the numbers that JSON doesn't have (`NaN`, `Infinity`) are called by their name.
pub fn json_error(
    path: &Path,
    text: &[u8],
    error: &serde_json::Error,
    example: fn(&str) -> Option<&'static str>,
) -> Error {
    let (line, column) = (error.line(), error.column());
    let whole = error.to_string();
    let place = format!(" at line {line} column {column}");
    let said = whole.strip_suffix(&place).unwrap_or(&whole);
    let message = if let Some(literal) = non_finite_literal(text, line, column) {
        format!(
            "`{literal}` is not a number JSON can hold; every number must be finite \
             (in Python, json.dump(..., allow_nan=False) stops at the culprit)"
        )
    } else {
        let place = Place::of(text, line, column);
        abridged(&explained(said, &place, example), LONGEST_COMPLAINT).into_owned()
    };
    Error::Line {
        path: path.to_owned(),
        line: line as u64,
        message: format!("column {column}: {message}"),
    }
}

/// `NaN`, `Infinity` or `-Infinity` if one of them is what the parser stopped at.
fn non_finite_literal(text: &[u8], line: usize, column: usize) -> Option<&'static str> {
    let line = text
        .split(|&byte| byte == b'\n')
        .nth(line.checked_sub(1)?)?;
    // The parser has taken the offending character already, and perhaps the sign before it.
    (column.saturating_sub(2)..=column)
        .filter_map(|start| line.get(start..))
        .find_map(|rest| {
            ["NaN", "Infinity", "-Infinity"]
                .into_iter()
                .find(|literal| rest.starts_with(literal.as_bytes()))
        })
}

/// What stands before and behind the place where a parser stopped.
struct Place<'a> {
    before: &'a str,
    behind: &'a str,
}

impl<'a> Place<'a> {
    /// Of a line and a column, both from 1, the column in bytes.
    fn of(text: &'a [u8], line: usize, column: usize) -> Self {
        let text = std::str::from_utf8(text).unwrap_or_default();
        let start: usize = text
            .split_inclusive('\n')
            .take(line.saturating_sub(1))
            .map(str::len)
            .sum();
        let at = (start + column).min(text.len());
        let at = (at..=text.len()).find(|at| text.is_char_boundary(*at));
        let (before, behind) = text.split_at(at.unwrap_or(text.len()));
        Self { before, behind }
    }

    /// The key whose value begins or ends here: the last `"key":` before.
    fn key(&self) -> Option<&'a str> {
        let (before, _) = self.before.rsplit_once(':')?;
        last_quoted(before.trim_end())
    }

    /// The key of the innermost object that is open here, or of the one around it where that has a name of the user's.
    fn outer_key(&self) -> Option<&'a str> {
        const KNOWN: [&str; 2] = ["drives", "integrator"];
        let mut depth = 0_usize;
        let mut opened = self
            .before
            .char_indices()
            .rev()
            .filter(|(_, letter)| match letter {
                '}' | ']' => {
                    depth += 1;
                    false
                }
                '{' | '[' if depth == 0 => true,
                '{' | '[' => {
                    depth -= 1;
                    false
                }
                _ => false,
            });
        let keys: Vec<&str> = (opened.by_ref())
            .take(2)
            .filter_map(|(at, _)| {
                let before = self.before.get(..at)?.trim_end().strip_suffix(':')?;
                last_quoted(before.trim_end())
            })
            .collect();
        keys.into_iter().find(|key| KNOWN.contains(key))
    }

    /// The last text in quotes that ends here.
    fn last_text(&self) -> Option<&'a str> {
        let end = self.before.rfind('"')?;
        last_quoted(self.before.get(..=end)?)
    }

    /// The text that follows a colon here.
    fn value(&self) -> Option<&'a str> {
        let value = self.behind.trim_start().strip_prefix(':')?.trim_start();
        value.strip_prefix('"')?.split('"').next()
    }

    /// The first key of the object in which this is, and the key that follows a comma here.
    fn two_kinds(&self) -> Option<[&'a str; 2]> {
        let (before, behind) = match self.before.trim_end().strip_suffix(',') {
            Some(before) => (before, self.behind),
            None => (self.before, self.behind.trim_start().strip_prefix(',')?),
        };
        let mut depth = 0_usize;
        let open = before.char_indices().rev().find(|(_, letter)| {
            match letter {
                '}' | ']' => depth += 1,
                '{' | '[' if depth == 0 => return true,
                '{' | '[' => depth -= 1,
                _ => {}
            }
            false
        })?;
        let first = before.get(open.0 + 1..)?.trim_start().strip_prefix('"')?;
        let second = behind.trim_start().strip_prefix('"')?;
        Some([first.split('"').next()?, second.split('"').next()?])
    }
}

/// The text in quotes at the end of a text.
fn last_quoted(text: &str) -> Option<&str> {
    let inside = text.strip_suffix('"')?;
    let start = inside.rfind('"')?;
    inside.get(start + 1..)
}

fn explained(said: &str, place: &Place, example: fn(&str) -> Option<&'static str>) -> String {
    if let Some([first, second]) = place.two_kinds().filter(|_| said == "expected value") {
        return format!(
            "`{}` stands beside `{}`, but only one kind may be given: remove one of them",
            shortened(second),
            shortened(first)
        );
    }
    if said.ends_with("expected a sequence") {
        let key = place.key();
        let example = key.and_then(example);
        let example = example.map_or_else(|| "[1, 2]".to_owned(), str::to_owned);
        let said = said.trim_end_matches("a sequence");
        return format!("{said}a list in square brackets, for example {example}");
    }
    if said.contains("expected newtype variant")
        && let Some(kind) = place.last_text()
    {
        let of = match kind {
            "position" | "displacement" | "velocity" | "acceleration" | "orientation"
            | "angular_velocity" | "interface_force" => r#"{"at": "rod/a"}"#,
            _ => "{...}",
        };
        return format!(
            "`{0}` has to say of what: write {{\"{0}\": {of}}}",
            shortened(kind)
        );
    }
    let quoted: Vec<&str> = said.split('`').skip(1).step_by(2).collect();
    let Some((found, valid)) = quoted.split_first() else {
        return in_words(said);
    };
    if said.contains("missing field `") {
        return match example(found) {
            Some(example) => format!("{said}; add for example {example}"),
            None => said.to_owned(),
        };
    }
    for (serde_says, we_say) in [
        ("unknown field `", "unknown field"),
        ("unknown variant `", "unknown value"),
    ] {
        if let Some(at) = said.find(serde_says) {
            let before = &said[..at];
            let hint = suggestion(found, valid.iter().copied());
            // The names that a program knows are few enough to show them all.
            let valid: Vec<String> = valid.iter().map(|name| shortened(name)).collect();
            let valid = valid.join(", ");
            let before = abridged(before, LONGEST_BEFORE);
            if let ("type", Some(kind)) = (*found, place.value()) {
                return format!(
                    "{before}the kind is a key of its own: write {{\"{0}\": {{...}}}} in place of \"type\": \"{0}\" (kinds here: {valid})",
                    shortened(kind)
                );
            }
            if let Some(advice) = advice(found, place) {
                return format!("{before}{we_say} `{}`; {advice}", shortened(found));
            }
            let found = shortened(found);
            return format!("{before}{we_say} `{found}`{hint} (known here: {valid})");
        }
    }
    in_words(said)
}

/// What helps where a slip is frequent: the name that was found, and the key whose value it is in.
fn advice(found: &str, place: &Place) -> Option<String> {
    let key = place.outer_key()?;
    match (key, found) {
        ("drives", "torque" | "moment" | "force" | "effort") => Some(
            "a drive sets a motion; torques and forces along a joint are `actuators`, others `loads`".to_owned(),
        ),
        ("integrator", "step" | "end" | "rho_infinity") => Some(format!(
            "the method is a key of its own: write \"integrator\": {{\"generalized_alpha\": {{\"{found}\": ...}}}}"
        )),
        _ => None,
    }
}

/// The names of a program's types as what they are to the writer of a file.
fn in_words(said: &str) -> String {
    let types = [
        (
            ["u8", "u16", "u32", "u64", "usize"].as_slice(),
            "a whole number from 0",
        ),
        (["f64"].as_slice(), "a number"),
    ];
    for (names, words) in types {
        for name in names {
            if let Some(before) = said.strip_suffix(&format!("expected {name}")) {
                let without = match before.contains("string \"") {
                    true => ", without quotes and without a unit",
                    false => "",
                };
                return format!("{before}expected {words}{without}");
            }
        }
    }
    said.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_near_name_is_suggested_and_a_far_one_is_not() {
        assert_eq!(
            nearest_name("avrage", ["nodes", "average", "rigid"]),
            Some("average")
        );
        assert_eq!(nearest_name("UX", ["ux", "uy"]), Some("ux"));
        assert_eq!(nearest_name("temperature", ["ux", "uy"]), None);
        assert_eq!(nearest_name("a", []), None);
        assert_eq!(
            nearest_name("midpoint", ["midpoint_deflection", "tip"]),
            Some("midpoint_deflection")
        );
    }

    #[test]
    fn types_are_said_in_words() {
        assert_eq!(
            in_words("invalid value: integer `-1`, expected u32"),
            "invalid value: integer `-1`, expected a whole number from 0"
        );
        assert_eq!(in_words("expected value"), "expected value");
    }

    #[test]
    fn long_lists_are_shortened() {
        assert_eq!(listed(["a", "b"]), "a, b");
        assert!(listed(vec!["x"; 20]).ends_with("and 8 more"));
    }
}
