//! Options of a reduction. Options of the command line, keys of a manifest, the cache's key and the provenance in the file are all of this
//! type: an option is a field here, with the text that help and schema show.

use std::collections::BTreeMap;

use clap::builder::{BoolValueParser, TypedValueParser};
use clap::{ArgAction, Args};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::attachments::enrichment_source::EnrichmentSource;
use crate::attachments::interface_reduction::InterfaceModes;
use crate::mode_selection::ModeSelection;
use crate::modes::certificate::ProofChoice;
use crate::pipeline::diagnosis::{Grounding, LoosePieces};
use crate::resources::forecast::EstimateChoice;
use crate::resources::memory_limit::{FactorChoice, MemoryLimit};

/// Options of a reduction. Modes and memory have options of their own ([`crate::mode_selection::ModeRequest`], [`MemoryLimit`]), since what they mean
/// depends on the part's units and on the machine.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Reduction {
    /// Modes to keep.
    #[arg(skip)]
    #[serde(skip)]
    pub modes: ModeSelection,
    /// Keep this many directions of residual flexibility, the softest [default: all].
    #[arg(id = "interface_modes", long = "interface-modes", value_name = "N", allow_negative_numbers = true, default_value = "all", hide_default_value = true, value_parser = InterfaceModes::parse)]
    #[schemars(with = "Option<usize>")]
    pub interface_modes: InterfaceModes,
    /// Add responses to spins, loads or a Krylov block.
    ///
    /// Static responses to centrifugal forces, to loads PART.load.NAME.mtx, or the interfaces' second block.
    #[arg(
        id = "enrich",
        long = "enrich",
        value_name = "WHAT",
        value_enum,
        value_delimiter = ','
    )]
    #[serde(rename = "enrich")]
    pub enrichment: Vec<EnrichmentSource>,
    /// Leave out the bounds of the file's errors.
    #[arg(id = "without_estimate", long = "without-estimate", action = ArgAction::SetTrue, value_parser = flag::<EstimateChoice>())]
    #[serde(rename = "without_estimate", with = "as_flag")]
    #[schemars(with = "bool")]
    pub estimate: EstimateChoice,
    /// Accept a part that is held; its frame is then not on mean axes.
    #[arg(id = "allow_grounded", long = "allow-grounded", action = ArgAction::SetTrue, value_parser = flag::<Grounding>())]
    #[serde(rename = "allow_grounded", with = "as_flag")]
    #[schemars(with = "bool")]
    pub grounding: Grounding,
    /// Accept loose pieces and mechanisms; their motions become modes of frequency zero.
    #[arg(id = "allow_loose", long = "allow-loose", action = ArgAction::SetTrue, value_parser = flag::<LoosePieces>())]
    #[serde(rename = "allow_loose", with = "as_flag")]
    #[schemars(with = "bool")]
    pub loose_pieces: LoosePieces,
    /// Prove by a Sturm sequence check that no mode is missing.
    ///
    /// A second factorization counts the eigenvalues; without it that is proven but for a chance of 1e-12.
    #[arg(id = "sturm_check", long = "sturm-check", action = ArgAction::SetTrue, value_parser = flag::<ProofChoice>())]
    #[serde(rename = "sturm_check", with = "as_flag")]
    #[schemars(with = "bool")]
    pub proof: ProofChoice,
    /// How much memory may be taken, and where the factor is kept.
    #[arg(skip)]
    #[serde(skip)]
    pub memory: MemoryLimit,
}

impl Default for Reduction {
    /// The usual number of modes of a free part in one piece.
    fn default() -> Self {
        Self {
            modes: ModeSelection::default(),
            interface_modes: InterfaceModes::All,
            enrichment: Vec::new(),
            estimate: EstimateChoice::Computed,
            grounding: Grounding::Refuse,
            loose_pieces: LoosePieces::Refuse,
            proof: ProofChoice::Any,
            memory: MemoryLimit::default(),
        }
    }
}

impl Reduction {
    /// The `count` lowest modes of a free part in one piece.
    pub fn lowest(count: usize) -> Self {
        Self {
            modes: ModeSelection::Lowest(count),
            ..Self::default()
        }
    }

    /// All that decides the result but the modes; what is as usual is left out. On how many ranks doesn't matter.
    pub fn decisive(&self) -> BTreeMap<String, Value> {
        let mut options: BTreeMap<String, Value> =
            serde_json::from_value(serde_json::to_value(self).unwrap_or_default())
                .unwrap_or_default();
        options.retain(|_, value| match value {
            Value::Null | Value::Bool(false) => false,
            Value::Array(list) => !list.is_empty(),
            _ => true,
        });
        if self.memory.is_on_ranks() {
            options.insert("factor".into(), "ranks".into());
        }
        if self.memory.factor == FactorChoice::Single {
            options.insert("factor".into(), "single".into());
        }
        options
    }
}

/// An option without value for a choice of two.
fn flag<T: From<bool> + Clone + Send + Sync + 'static>() -> impl TypedValueParser<Value = T> {
    BoolValueParser::new().map(T::from)
}

/// The same choice as true or false in files.
mod as_flag {
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<T: Clone + Into<bool>, S: Serializer>(
        of: &T,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        to.serialize_bool(of.clone().into())
    }

    pub fn deserialize<'de, T: From<bool>, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
        bool::deserialize(from).map(T::from)
    }
}

/// Choices of two, of which the second is asked for by a flag.
macro_rules! flags {
    ($($choice:ident: $usual:ident or $asked:ident;)*) => {$(
        impl From<bool> for $choice {
            fn from(is_asked: bool) -> Self {
                match is_asked {
                    true => Self::$asked,
                    false => Self::$usual,
                }
            }
        }

        impl From<$choice> for bool {
            fn from(choice: $choice) -> Self {
                choice == $choice::$asked
            }
        }
    )*};
}

flags! {
    EstimateChoice: Computed or LeftOut;
    Grounding: Refuse or Allow;
    LoosePieces: Refuse or Allow;
    ProofChoice: Any or Count;
}
