//! Table of a batch's results, for people.

use std::fmt::Write as _;

use super::Fate;
use super::manifest::Part;
use super::results::{BatchRow, Status};

/// One line for each part.
pub fn table(parts: &[Part], fates: &[Fate]) -> String {
    let width = parts
        .iter()
        .map(|part| part.name.chars().count())
        .chain([4])
        .max()
        .unwrap_or(0);
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{:<width$}  {:<9}  {:>5}  {:>4}  {:>9}  {:>8}",
        "part", "", "modes", "rows", "time", "memory"
    );
    for (part, fate) in parts.iter().zip(fates) {
        let _ = write!(text, "{:<width$}  {:<9}", part.name, word(fate));
        if let Fate::Settled(row) | Fate::Unchanged(row) = fate {
            text += &numbers(row);
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    text
}

/// Outcome of a component, in a word.
pub fn word(fate: &Fate) -> &'static str {
    let row = match fate {
        Fate::Elsewhere => return "elsewhere",
        Fate::Unchanged(row) if row.status == Status::Done => return "unchanged",
        Fate::Settled(row) | Fate::Unchanged(row) => row,
    };
    match (&row.superelement, row.status) {
        (_, Status::Failed) => "failed",
        (Some(made), _) if made.from_cache => "cached",
        _ => "done",
    }
}

fn numbers(row: &BatchRow) -> String {
    let mut text = String::new();
    match (&row.superelement, &row.error) {
        (Some(made), _) => {
            let memory = row
                .peak_megabytes
                .map_or(String::new(), |mb| format!("{mb:.0} MB"));
            let _ = write!(
                text,
                "  {:>5}  {:>4}  {:>7.2} s  {memory:>8}",
                made.modes, made.rows, row.seconds
            );
        }
        (None, Some(error)) => {
            let _ = write!(text, "  {error}");
        }
        (None, None) => {}
    }
    text
}
