//! Which reductions a study makes, and which rows each of them serves.

use super::sources::Sources;
use super::variant::Variant;
use dcb_reducer::InterfaceModes;

/// Options that are varied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sweep {
    /// Numbers of modes.
    pub modes: Vec<usize>,
    /// Forms of use.
    pub variants: Vec<Variant>,
    /// Numbers of interface modes, beside all of them.
    pub interface_modes: Vec<usize>,
    /// Further columns, beside none.
    pub enrichments: Vec<Sources>,
}

/// One reduction: its options, and the forms that its superelement is studied in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReductionRun {
    /// Modes asked for.
    pub modes: usize,
    /// Interface modes asked for.
    pub interface_modes: InterfaceModes,
    /// Further columns.
    pub enrichment: Sources,
    /// Rows that it serves. Forms with attachments share a superelement; modes alone are a superelement with no interface modes.
    /// Further columns are coordinates of the strong form only.
    pub variants: Vec<Variant>,
}

impl Sweep {
    /// 5, 10, 20, 40 modes, as far as the part has them, and all it has if these are fewer.
    pub fn default_modes(available: usize) -> Vec<usize> {
        let mut modes = [5, 10, 20, 40]
            .map(|count: usize| count.min(available))
            .to_vec();
        modes.dedup();
        modes
    }

    /// The largest number of modes.
    pub fn most_modes(&self) -> usize {
        self.modes.iter().copied().max().unwrap_or(0)
    }

    /// All reductions, few modes first, each once.
    pub fn runs(&self) -> Vec<ReductionRun> {
        let (attached, alone): (Vec<Variant>, Vec<Variant>) = Variant::ALL
            .into_iter()
            .filter(|variant| self.variants.contains(variant))
            .partition(|variant| *variant != Variant::Free);
        let mut interface_modes = vec![InterfaceModes::All];
        let reduced = sorted(&self.interface_modes).into_iter();
        interface_modes.extend(reduced.map(InterfaceModes::Softest));
        let strong: Vec<Variant> = (attached.iter().copied())
            .filter(|variant| *variant == Variant::Strong)
            .collect();
        let mut enrichments = sorted(&self.enrichments);
        enrichments.retain(|enrichment| !enrichment.is_empty());
        let mut runs = Vec::new();
        for modes in sorted(&self.modes) {
            let mut add = |interface_modes, enrichment: &Sources, variants: &[Variant]| {
                if !variants.is_empty() {
                    runs.push(ReductionRun {
                        modes,
                        interface_modes,
                        enrichment: enrichment.clone(),
                        variants: variants.to_vec(),
                    });
                }
            };
            let none = Sources::default();
            for interface_modes in &interface_modes {
                add(*interface_modes, &none, &attached);
                for enrichment in &enrichments {
                    add(*interface_modes, enrichment, &strong);
                }
            }
            add(InterfaceModes::Softest(0), &none, &alone);
        }
        runs
    }
}

/// In order, each once.
fn sorted<T: Clone + Ord>(values: &[T]) -> Vec<T> {
    let mut values = values.to_vec();
    values.sort_unstable();
    values.dedup();
    values
}

impl ReductionRun {
    /// Name of a row of it, for example `strong/20`, or `strong/20/8+krylov` with eight interface modes and further columns.
    pub fn key(&self, variant: Variant) -> String {
        let mut key = format!("{}/{}", variant.name(), self.modes);
        if let (true, InterfaceModes::Softest(count)) =
            (variant != Variant::Free, self.interface_modes)
        {
            key += &format!("/{count}");
        }
        if !self.enrichment.is_empty() {
            key += &format!("+{}", self.enrichment);
        }
        key
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcb_reducer::EnrichmentSource::{Krylov, Spin};

    fn keys(sweep: &Sweep) -> Vec<String> {
        let runs = sweep.runs();
        (runs.iter())
            .flat_map(|run| run.variants.iter().map(|variant| run.key(*variant)))
            .collect()
    }

    #[test]
    fn every_row_is_served_once() {
        let sweep = Sweep {
            modes: vec![20, 5, 20],
            variants: vec![Variant::Free, Variant::Strong, Variant::Static],
            interface_modes: vec![4],
            enrichments: Vec::new(),
        };
        let expected = [
            "strong/5",
            "static/5",
            "strong/5/4",
            "static/5/4",
            "free/5",
            "strong/20",
            "static/20",
            "strong/20/4",
            "static/20/4",
            "free/20",
        ];
        assert_eq!(keys(&sweep), expected);
        assert_eq!(Sweep::default_modes(12), [5, 10, 12]);
        assert_eq!(Sweep::default_modes(3), [3]);
    }

    #[test]
    fn further_columns_are_for_the_strong_form() {
        let mut sweep = Sweep {
            modes: vec![5],
            variants: Variant::ALL.to_vec(),
            interface_modes: vec![4],
            enrichments: vec![
                Sources::of(&[Krylov]),
                Sources::default(),
                Sources::of(&[Krylov, Spin]),
                Sources::of(&[Krylov]),
            ],
        };
        let expected = [
            "strong/5",
            "static/5",
            "weak/5",
            "strong/5+spin+krylov",
            "strong/5+krylov",
            "strong/5/4",
            "static/5/4",
            "weak/5/4",
            "strong/5/4+spin+krylov",
            "strong/5/4+krylov",
            "free/5",
        ];
        assert_eq!(keys(&sweep), expected);
        sweep.variants = vec![Variant::Static, Variant::Free];
        assert_eq!(keys(&sweep), ["static/5", "static/5/4", "free/5"]);
    }
}
