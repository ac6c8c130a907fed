//! Inputs and options that decide a reduction's result, and their digest.

use std::collections::BTreeMap;
use std::fmt;

use dcb_formats::component::Source;
use dcb_formats::dcb::FORMAT_VERSION;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use dcb_reducer::mode_selection::ModeRequest;
use dcb_reducer::pipeline::reduction::Reduction;

/// Counts the changes of this program that change what a reduction gives, or how a request is written; entries of another number are never
/// found.
const RESULTS: u32 = 3;

/// A file that the part is made of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Input {
    /// Name without folder: messages and provenance have it.
    pub file_name: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
}

/// A part and how it is reduced. Where and with how much memory or how many threads doesn't matter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Version of the program, the file format and the results.
    pub program: String,
    /// The part's files by their role.
    pub inputs: BTreeMap<String, Input>,
    /// Modes.
    pub modes: ModeRequest,
    /// Everything else that the result depends on.
    pub options: BTreeMap<String, serde_json::Value>,
}

/// The digest of a [`Request`], 64 hexadecimal digits.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Key(String);

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Key {
    /// As many digits as people need.
    pub fn short(&self) -> &str {
        &self.0[..12]
    }

    /// A key that a file is named after.
    pub fn parse(text: &str) -> Option<Self> {
        let is_key = text.len() == 64
            && text
                .bytes()
                .all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
        is_key.then(|| Self(text.to_owned()))
    }
}

impl Request {
    /// The reduction of a part by this version of the program.
    pub fn new(sources: &[Source], modes: ModeRequest, reduction: &Reduction) -> Self {
        let inputs = sources.iter().map(|source| {
            let input = Input {
                file_name: source.file_name.clone(),
                sha256: source.sha256.clone(),
            };
            (source.role.clone(), input)
        });
        Self {
            program: format!(
                "reduce {}, format {FORMAT_VERSION}, results {RESULTS}",
                env!("CARGO_PKG_VERSION")
            ),
            inputs: inputs.collect(),
            modes,
            options: reduction.decisive(),
        }
    }

    /// Its key.
    pub fn key(&self) -> Key {
        digest_of(self)
    }

    /// Whether a component was read from these files as they were when they were hashed.
    pub fn is_of(&self, sources: &[Source]) -> bool {
        sources.iter().all(|source| {
            self.inputs
                .get(&source.role)
                .is_some_and(|input| input.sha256 == source.sha256)
        })
    }

    /// Whether both are of the same part, reduced alike but for the number of modes.
    pub fn differs_in_modes_alone(&self, other: &Self) -> bool {
        (&self.program, &self.inputs, &self.options)
            == (&other.program, &other.inputs, &other.options)
    }
}

/// SHA-256 of the JSON of something whose maps are sorted.
pub fn digest_of(what: &impl Serialize) -> Key {
    let json = serde_json::to_vec(what).unwrap_or_default();
    let digest = Sha256::digest(&json);
    Key(digest.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcb_reducer::EnrichmentSource;
    use dcb_reducer::EstimateChoice;

    fn source(role: &str, name: &str, digit: char) -> Source {
        Source {
            role: role.into(),
            file_name: name.into(),
            sha256: digit.to_string().repeat(64),
        }
    }

    #[test]
    fn whatever_decides_the_result_decides_the_key() {
        let sources = [
            source("stiffness", "a.mtx", '1'),
            source("mass", "a.mass.mtx", '2'),
        ];
        let spinning = Reduction {
            enrichment: vec![EnrichmentSource::Spin],
            ..Reduction::default()
        };
        let one = Request::new(&sources, ModeRequest::Lowest(20), &spinning);
        let without_estimate = Reduction {
            estimate: EstimateChoice::LeftOut,
            ..spinning.clone()
        };
        let mut swapped = sources.clone();
        swapped.reverse();
        let same = Request::new(&swapped, ModeRequest::Lowest(20), &spinning);
        assert_eq!(one.key(), same.key());
        let mut renamed = sources.clone();
        renamed[0].file_name = "b.mtx".into();
        let mut changed = sources.clone();
        changed[1].sha256 = "3".repeat(64);
        let others = [
            Request::new(&sources, ModeRequest::Lowest(21), &spinning),
            Request::new(&sources, ModeRequest::BelowHertz(20.0), &spinning),
            Request::new(&sources, ModeRequest::Lowest(20), &Reduction::default()),
            Request::new(&renamed, ModeRequest::Lowest(20), &spinning),
            Request::new(&changed, ModeRequest::Lowest(20), &spinning),
            Request::new(&sources, ModeRequest::Lowest(20), &without_estimate),
            Request::new(&sources[..1], ModeRequest::Lowest(20), &spinning),
        ];
        for other in &others {
            assert_ne!(one.key(), other.key(), "{other:?}");
        }
        assert!(others[0].differs_in_modes_alone(&one));
        assert!(
            others[2..]
                .iter()
                .all(|other| !other.differs_in_modes_alone(&one))
        );
        assert!(one.is_of(&swapped) && one.is_of(&sources[..1]) && !one.is_of(&changed));
        assert_eq!(Key::parse(&one.key().to_string()), Some(one.key()));
    }
}
