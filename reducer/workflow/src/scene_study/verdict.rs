//! Verdicts of a study in words: how good the reference is, which row to take, and under which conditions it was measured.

use std::fmt::Write as _;

use super::fineness::Fineness;
use super::reference::AGREEMENT;
use super::setting::{ModeCount, Setting};
use super::{SceneRow, SceneStudy};

impl Setting {
    /// `1 mode`, `5 modes`, `all modes`, or `modes as in the scene`.
    pub fn modes_told(&self) -> String {
        match self.modes {
            ModeCount::AsInScene => "modes as in the scene".to_owned(),
            ModeCount::Lowest(1) => "1 mode".to_owned(),
            ModeCount::Lowest(count) => format!("{count} modes"),
            ModeCount::All => "all modes".to_owned(),
        }
    }

    /// For people; `time` is the unit of the step.
    pub fn told(&self, time: &str) -> String {
        let (compatibility, inertia) = (self.compatibility.name(), self.inertia_text());
        let mut text = format!(
            "{}, {compatibility}, {}",
            self.modes_told(),
            self.fineness.told(time)
        );
        // Writing to a string doesn't fail.
        if let Some(rho) = self.rho_infinity {
            let _ = write!(text, ", ρ∞ {rho}");
        }
        if self.inertia_change.is_some() {
            let _ = write!(text, ", inertia {inertia}");
        }
        text
    }
}

impl SceneStudy {
    /// Label of a row in the picture: its number, and what the study varies of its options; `h` is the scene's step, `e` its accuracy.
    pub(super) fn label(&self, row: &SceneRow) -> String {
        let setting = &row.setting;
        let varies = |of: fn(&Setting) -> String| {
            let mut all = self.rows.iter().map(|row| of(&row.setting));
            let first = all.next();
            all.any(|other| Some(other) != first)
        };
        let mut parts = Vec::new();
        if varies(Setting::modes_text) {
            parts.push(setting.modes_told());
        }
        if varies(|setting| setting.compatibility.name().to_owned()) {
            parts.push(setting.compatibility.name().to_owned());
        }
        if varies(|setting| setting.inertia_text().to_owned()) {
            parts.push(setting.inertia_text().to_owned());
        }
        if varies(|setting| format!("{:?}", setting.rho_infinity)) {
            parts.push(format!("ρ∞ {}", setting.rho_infinity.unwrap_or(f64::NAN)));
        }
        parts.push(row.multiple(&self.subject));
        parts.join(", ")
    }

    /// A row in words: its options, what it costs and how far it is off.
    pub(super) fn told(&self, index: usize, row: &SceneRow) -> String {
        let time = &self.subject.scene.units.time;
        format!(
            "row {}: {} ({}); {} elastic coordinates; {} s of wall time for 1 {time} of motion; error {} of the range",
            index + 1,
            self.label(row),
            row.setting.fineness.told(time),
            row.course.elastic,
            row.cost(self.subject.end)
                .map_or_else(|| "-".to_owned(), |cost| format!("{cost:.3}")),
            row.claim(&self.reference),
        )
    }

    /// Which row is the fastest for an error, or how near the rows come.
    pub fn verdict(&self, tolerance: f64) -> String {
        let time = &self.subject.scene.units.time;
        let limit = self.reference.uncertainty();
        if let Some(index) = self.best(tolerance) {
            let row = &self.rows[index];
            return format!(
                "Fastest with an error up to {tolerance:e} of each output's range: row {}, {}; error {} of the range, {:.3} s of wall time for 1 {time} of motion, {:.0} steps/s.",
                index + 1,
                row.setting.told(time),
                row.claim(&self.reference),
                row.cost(self.subject.end).unwrap_or(f64::NAN),
                row.speed().unwrap_or(f64::NAN),
            );
        }
        let mut text = format!("No row has an error up to {tolerance:e} of each output's range");
        let stable = self.rows.iter().filter(|row| row.is_stable());
        match stable.map(SceneRow::error).min_by(f64::total_cmp) {
            // Writing to a string doesn't fail.
            None => text += ": none came to its end.",
            Some(_) if limit > tolerance => {
                let _ = write!(
                    text,
                    " that can be told: the reference itself is known to {limit:.1e} only; study {} too.",
                    self.finer_told()
                );
            }
            Some(least) => {
                let _ = write!(
                    text,
                    "; the smallest is {least:.1e}. Study {} or more modes.",
                    self.finer_told()
                );
            }
        }
        text
    }

    /// The fastest row for errors of 0.1, 0.01 and so on, down to what the reference can tell; a row that serves several of them is told for
    /// the smallest.
    pub fn decades(&self) -> Vec<String> {
        let time = &self.subject.scene.units.time;
        let rows = (1..12)
            .map(|power| 10.0_f64.powi(-power))
            .map_while(|tolerance| self.best(tolerance).map(|index| (tolerance, index)));
        let found: Vec<(f64, usize)> = rows.collect();
        (found.chunk_by(|(_, row), (_, next)| row == next))
            .filter_map(|same| same.last())
            .map(|(tolerance, index)| {
                let row = &self.rows[*index];
                format!(
                    "error up to {tolerance:.0e}: row {}, {} ({}); {:.3} s of wall time for 1 {time} of motion",
                    index + 1,
                    self.label(row),
                    row.setting.fineness.told(time),
                    row.cost(self.subject.end).unwrap_or(f64::NAN),
                )
            })
            .collect()
    }

    /// Reference of the rows, and how well converged it is.
    pub fn reference_told(&self) -> String {
        let time = &self.subject.scene.units.time;
        let steps: Vec<String> = self
            .reference
            .steps
            .iter()
            .map(|h| format!("{h:.3e}"))
            .collect();
        let limit = self.reference.uncertainty();
        let (runs, unit) = match self.subject.own.fineness {
            Fineness::Step(_) => ("steps", format!(" {time}")),
            Fineness::Accuracy(_) => ("accuracies", String::new()),
        };
        let convergence = match self.reference.is_converged() {
            true => format!(
                "converged: its error is estimated as {limit:.1e} of an output's range at most"
            ),
            false => format!(
                "not converged to {AGREEMENT:e}: its error is estimated as {limit:.1e} of an output's range at most"
            ),
        };
        format!(
            "Reference: {}; {runs} {}{unit}; {convergence}.",
            self.reference.setting.told(time),
            steps.join(", ")
        )
    }

    fn finer_told(&self) -> &'static str {
        match self.subject.own.fineness {
            Fineness::Step(_) => "shorter steps",
            Fineness::Accuracy(_) => "finer accuracies",
        }
    }

    /// How the numbers came about.
    pub fn conditions(&self) -> Vec<String> {
        let time = &self.subject.scene.units.time;
        vec![
            format!(
                "Errors: at {} times from 0 to {:.6e} {time}, {:.4e} {time} apart; {}.",
                self.grid.count,
                self.grid.time(self.grid.count - 1),
                self.grid.spacing,
                match self.subject.own.fineness {
                    Fineness::Step(_) => "steps that end elsewhere are interpolated by a cubic",
                    Fineness::Accuracy(_) => "steps end there, in the runs that are timed too",
                }
            ),
            "A maximum is over these times; of a vector, it is that of its length. Relative errors are by the output's range in the \
             reference, the diagonal of the box that it stays in."
                .to_owned(),
            "Errors are those of the step and of the options that were varied. The reference has the modes of the superelements' files; \
             what these leave out is no part of them."
                .to_owned(),
            "Times: steps alone, without reading, start and recording; the shortest of up to five runs, made one after the other \
             with nothing beside them in this program."
                .to_owned(),
            format!(
                "Errors come from separate, untimed runs, up to {} in parallel.",
                self.threads
            ),
        ]
    }
}
