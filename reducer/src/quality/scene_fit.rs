//! Purpose of a superelement for a scene, contents left out of it and their effect: for people and in files.

use std::fmt::Write as _;

use dcb_demand::LeftOut;
use dcb_formats::superelement::Superelement;
use serde::{Deserialize, Serialize};

use crate::scientific::scientific;

/// How many of so many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Amounts {
    /// In the superelement.
    pub kept: usize,
    /// In the one that it was taken out of.
    pub of: usize,
}

impl Amounts {
    /// Counted in both.
    pub fn of(
        superelement: &Superelement,
        whole: &Superelement,
        count: impl Fn(&Superelement) -> usize,
    ) -> Self {
        Self {
            kept: count(superelement),
            of: count(whole),
        }
    }
}

/// Contents of the superelement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Kept {
    /// Elastic modes.
    pub modes: Amounts,
    /// Dynamic attachments.
    pub attachments: Amounts,
    /// Boundary rows.
    pub rows: Amounts,
    /// Nodes with fields.
    pub nodes: Amounts,
}

/// Something that was left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Omission {
    /// Contents.
    pub what: String,
    /// Why.
    pub why: String,
    /// Largest relative change of the responses up to here; absent where nothing changes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<f64>,
}

impl From<LeftOut> for Omission {
    fn from(left_out: LeftOut) -> Self {
        let LeftOut { what, why, cost } = left_out;
        Self { what, why, cost }
    }
}

/// A superelement and the scene that it was made for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneFit {
    /// The scene's file, without its folder.
    pub scene: String,
    /// Bodies that are made of the part.
    pub bodies: Vec<String>,
    /// Relative error that the part's responses may have.
    pub tolerance: f64,
    /// Demand of the scene, line by line.
    pub asked: Vec<String>,
    /// Further notes.
    pub notes: Vec<String>,
    /// Reductions that were made with their certified errors, the last one good enough.
    pub rounds: Vec<Round>,
    /// About columns for centrifugal forces.
    pub spin: String,
    /// Contents left out.
    pub left_out: Vec<Omission>,
    /// Contents.
    pub kept: Kept,
    /// Upper bound of what the reduction itself is off; absent without a band, or where no force acts.
    pub certified: Option<f64>,
    /// Effect of leaving out.
    pub left_out_error: f64,
    /// Both; absent without a band.
    pub total: Option<f64>,
}

/// One reduction of a search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// Elastic modes kept.
    pub modes: usize,
    /// The error of the responses is not below this.
    pub lower: f64,
    /// It is not above this; absent where the modes end below the scene's highest frequency.
    pub upper: Option<f64>,
}

impl SceneFit {
    /// One line: how far the part's responses may be off in its scene; `None` where that isn't known.
    pub fn verdict(&self) -> Option<String> {
        let total = self.total?;
        Some(format!(
            "in {} the part's responses are right within {} (allowed {})",
            self.scene,
            scientific(total, 2),
            scientific(self.tolerance, 1)
        ))
    }

    /// One line: what was kept for the scene.
    pub fn kept(&self) -> String {
        let Kept {
            modes,
            attachments,
            rows,
            nodes,
        } = self.kept;
        let of = |amounts: Amounts| format!("{} of {}", amounts.kept, amounts.of);
        format!(
            "kept: {} modes, {} dynamic attachments ({} beside all modes), {} rows, fields of {} nodes",
            of(modes),
            attachments.kept,
            attachments.of,
            of(rows),
            of(nodes)
        )
    }

    /// For people, in full.
    pub fn text(&self) -> String {
        let mut text = format!("made for {}, which asks\n", self.scene);
        for line in &self.asked {
            let _ = writeln!(text, "  {line}");
        }
        for note in &self.notes {
            let _ = writeln!(text, "note: {note}");
        }
        let _ = writeln!(text, "{}", self.kept());
        for Omission { what, why, cost } in &self.left_out {
            let cost = cost.map_or(String::new(), |cost| {
                format!(" (changes the responses by {})", scientific(cost, 1))
            });
            let _ = writeln!(text, "without {what}: {why}{cost}");
        }
        let _ = writeln!(text, "{}", self.spin);
        for round in &self.rounds {
            let found = match round.upper {
                Some(upper) => format!(
                    "certified between {} and {}",
                    scientific(round.lower, 1),
                    scientific(upper, 1)
                ),
                None => "not enough for the scene's highest frequency".to_owned(),
            };
            let _ = writeln!(
                text,
                "{} modes: error of the responses {found}",
                round.modes
            );
        }
        let left_out = scientific(self.left_out_error, 1);
        let tolerance = scientific(self.tolerance, 1);
        let total = match (self.total, self.certified) {
            (Some(total), Some(certified)) => format!(
                "{}: at most {} by the modes, {left_out} by what is left out",
                scientific(total, 1),
                scientific(certified, 1)
            ),
            (Some(total), None) => format!(
                "{} by what is left out; no force acts on an interface whose error could be certified",
                scientific(total, 1)
            ),
            (None, _) => "not known, without a limit of the scene's frequencies".to_owned(),
        };
        let _ = writeln!(
            text,
            "error of the part's responses: {total}; tolerance {tolerance}"
        );
        text
    }
}
