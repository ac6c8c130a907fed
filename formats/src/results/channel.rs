//! Channels of a recording: their places in the file, their columns and units.

use std::collections::BTreeSet;

use super::scales::SINGLE;

/// Segments of a path, at most: deeper groups aren't read.
const DEEPEST: usize = 5;

/// A quantity recorded at every accepted step, as one number or several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Group and name without a leading slash, for example `outputs/midpoint_deflection` or `interface_forces/rod/a`.
    pub path: String,
    /// Meaning of each number of a row; at least one.
    pub columns: Vec<Column>,
    /// One sentence for people.
    pub description: String,
}

/// One number of a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name, for example `fx`; empty where the channel's own name says everything.
    pub name: String,
    /// Unit, for example `N`; `1` where it has none.
    pub unit: String,
}

impl Channel {
    /// A channel of one number.
    pub fn scalar(path: &str, unit: &str, description: &str) -> Self {
        Self::vector(path, &[""], unit, description)
    }

    /// A channel of several numbers of the same unit.
    pub fn vector(path: &str, names: &[&str], unit: &str, description: &str) -> Self {
        let column = |name: &&str| Column {
            name: (*name).to_owned(),
            unit: unit.to_owned(),
        };
        Self {
            path: path.to_owned(),
            columns: names.iter().map(column).collect(),
            description: description.to_owned(),
        }
    }

    /// The last name of the path.
    pub fn name(&self) -> &str {
        self.path
            .rsplit_once('/')
            .map_or(&self.path, |(_, name)| name)
    }

    /// Name of a column for people: the channel's path, without `outputs/`, and behind a dot the column's name, if it
    /// has one.
    pub fn label(&self, column: &Column) -> String {
        let path = self.path.strip_prefix("outputs/").unwrap_or(&self.path);
        match column.name.as_str() {
            "" => path.to_owned(),
            name => format!("{path}.{name}"),
        }
    }

    /// The unit of all columns, or `None` where they differ.
    pub fn common_unit(&self) -> Option<&str> {
        let first = self.columns.first()?.unit.as_str();
        let same = self.columns.iter().all(|column| column.unit == first);
        same.then_some(first)
    }
}

/// Whether all channels can be in one file together.
///
/// # Errors
/// The first that can't, and why.
pub(super) fn check(channels: &[Channel]) -> Result<(), (String, String)> {
    let mut taken = BTreeSet::new();
    for channel in channels {
        let path = channel.path.as_str();
        let refused = |message: String| Err((path.to_owned(), message));
        let segments: Vec<&str> = path.split('/').collect();
        let impossible =
            |segment: &&str| matches!(*segment, "" | "." | "..") || segment.contains(['\0', '\n']);
        if segments.len() < 2 || segments.len() > DEEPEST || segments.iter().any(impossible) {
            return refused(format!(
                "isn't a channel's path; write GROUP/NAME with at most {DEEPEST} parts, none of them empty or dots"
            ));
        }
        if ["time", "provenance", SINGLE].contains(&segments[0]) {
            return refused("is a place with a meaning of its own; use another group".to_owned());
        }
        if channel.columns.is_empty() {
            return refused("has no columns".to_owned());
        }
        if !taken.insert(path) {
            return refused("is there twice".to_owned());
        }
    }
    for path in &taken {
        let groups = path.match_indices('/').map(|(at, _)| &path[..at]);
        if let Some(channel) = groups.into_iter().find(|group| taken.contains(group)) {
            let message = format!("is inside {channel}, which is a channel, not a group");
            return Err(((*path).to_owned(), message));
        }
    }
    Ok(())
}
