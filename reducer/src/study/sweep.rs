//! Which reductions a study makes, and which rows each of them serves.

use super::variant::Variant;
use crate::InterfaceModes;

/// What is varied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sweep {
    /// Numbers of modes.
    pub modes: Vec<usize>,
    /// Forms of use.
    pub variants: Vec<Variant>,
    /// Numbers of interface modes, beside all of them.
    pub interface_modes: Vec<usize>,
}

/// One reduction: its options, and the forms that its superelement is studied in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// Modes asked for.
    pub modes: usize,
    /// Interface modes asked for.
    pub interface_modes: InterfaceModes,
    /// Rows that it serves. Forms with attachments share a superelement; modes alone are a superelement with no interface modes.
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
    pub fn runs(&self) -> Vec<Run> {
        let sorted = |values: &[usize]| {
            let mut values = values.to_vec();
            values.sort_unstable();
            values.dedup();
            values
        };
        let (attached, alone): (Vec<Variant>, Vec<Variant>) = Variant::ALL
            .into_iter()
            .filter(|variant| self.variants.contains(variant))
            .partition(|variant| *variant != Variant::Free);
        let mut kinds = vec![(InterfaceModes::All, attached.clone())];
        let reduced = sorted(&self.interface_modes).into_iter();
        kinds.extend(reduced.map(|count| (InterfaceModes::Softest(count), attached.clone())));
        kinds.push((InterfaceModes::Softest(0), alone));
        let mut runs = Vec::new();
        for modes in sorted(&self.modes) {
            for (interface_modes, variants) in &kinds {
                if !variants.is_empty() {
                    runs.push(Run {
                        modes,
                        interface_modes: *interface_modes,
                        variants: variants.clone(),
                    });
                }
            }
        }
        runs
    }
}

impl Run {
    /// What a row of it is called, for example `strong/20`, or `strong/20/8` with eight interface modes.
    pub fn key(&self, variant: Variant) -> String {
        match (variant, self.interface_modes) {
            (Variant::Free, _) | (_, InterfaceModes::All) => {
                format!("{}/{}", variant.name(), self.modes)
            }
            (_, InterfaceModes::Softest(count)) => {
                format!("{}/{}/{count}", variant.name(), self.modes)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_served_once() {
        let sweep = Sweep {
            modes: vec![20, 5, 20],
            variants: vec![Variant::Free, Variant::Strong, Variant::Static],
            interface_modes: vec![4],
        };
        let runs = sweep.runs();
        let keys: Vec<String> = (runs.iter())
            .flat_map(|run| run.variants.iter().map(|variant| run.key(*variant)))
            .collect();
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
        assert_eq!(keys, expected);
        assert_eq!(Sweep::default_modes(12), [5, 10, 12]);
        assert_eq!(Sweep::default_modes(3), [3]);
    }
}
