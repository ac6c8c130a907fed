//! Which options a study tries: lists, and how they are combined.

use clap::ValueEnum;

use super::fineness::Fineness;
use super::setting::{ModeCount, Setting};
use super::subject::Subject;
use dcb_formats::scene::{Compatibility, InertiaChange, Method};
use dcb_runtime::error::Error;

/// Combinations up to which all are tried unless something else is asked for.
pub const MOST_COMBINATIONS: usize = 60;
/// Step lengths that are tried by themselves, as multiples of the scene's,
const STEP_MULTIPLES: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 8.0];
/// and the shortest, with the scene's other options only: it would cost more than all others together.
const SHORTEST_MULTIPLE: f64 = 0.25;
/// Accuracies that are tried by themselves, as multiples of the scene's,
const ACCURACY_MULTIPLES: [f64; 5] = [0.01, 0.1, 1.0, 10.0, 100.0];
/// up to this one.
const COARSEST_ACCURACY: f64 = 1e-2;
/// Steps of a run, at least, where the study chooses them.
const FEWEST_STEPS: f64 = 50.0;

/// Values to try of each option; the scene's own where a list is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lists {
    /// Numbers of modes.
    pub modes: Vec<ModeCount>,
    /// Compatibilities.
    pub compatibilities: Vec<Compatibility>,
    /// Steps, or accuracies.
    pub fineness: Vec<Fineness>,
    /// Further ones, each tried with the scene's own other options only.
    pub further_fineness: Vec<Fineness>,
    /// Spectral radii.
    pub radii: Vec<f64>,
    /// Orders of the inertia.
    pub inertia_changes: Vec<InertiaChange>,
}

/// How lists are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Combination {
    /// Every entry with every entry of the other lists.
    Product,
    /// One list at a time, the other options as the scene has them.
    OneAtATime,
}

impl Lists {
    /// Default lists of a study: modes in steps of 1, 2, 5, strong and static compatibility, half the scene's step, the step
    /// itself and up to eight times as long ones; a quarter of it with the scene's own modes and compatibility.
    pub fn usual(subject: &Subject) -> Self {
        let most = subject.most_modes().unwrap_or(0);
        let ladder = (0..9).flat_map(|power| [1, 2, 5].map(|digit| digit * 10_u32.pow(power)));
        let modes = ladder
            .take_while(|count| *count < most)
            .map(ModeCount::Lowest);
        let own = subject.own;
        let mut compatibilities = match subject.most_modes() {
            None => Vec::new(),
            Some(_) => vec![Compatibility::Strong, Compatibility::Static],
        };
        if !compatibilities.is_empty() && own.compatibility == Compatibility::Weak {
            compatibilities.push(Compatibility::Weak);
        }
        let multiples = |all: &[f64]| -> Vec<Fineness> {
            let values = all.iter().map(|multiple| multiple * own.fineness.value());
            values.map(|value| own.fineness.with(value)).collect()
        };
        let (fineness, further_fineness) = match own.fineness {
            Fineness::Step(step) => {
                let longest = (subject.end / FEWEST_STEPS).max(step);
                let mut steps = multiples(&STEP_MULTIPLES);
                steps.retain(|step| step.value() <= longest);
                (steps, multiples(&[SHORTEST_MULTIPLE]))
            }
            Fineness::Accuracy(_) => {
                let mut accuracies = multiples(&ACCURACY_MULTIPLES);
                accuracies.retain(|accuracy| accuracy.value() <= COARSEST_ACCURACY);
                (accuracies, Vec::new())
            }
        };
        Self {
            modes: match most {
                0 => Vec::new(),
                _ => modes.chain([ModeCount::All]).collect(),
            },
            compatibilities,
            fineness,
            further_fineness,
            radii: Vec::new(),
            inertia_changes: Vec::new(),
        }
    }

    /// Whether anything is asked for.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether the subject can be run with what is asked for.
    ///
    /// # Errors
    /// [`Error::Description`] naming the option.
    pub fn check(&self, subject: &Subject) -> Result<(), Error> {
        let most = subject.most_modes();
        let of_superelements = [
            ("--modes", self.modes.is_empty()),
            ("--compatibility", self.compatibilities.is_empty()),
            ("--inertia", self.inertia_changes.is_empty()),
        ];
        if most.is_none()
            && let Some((option, _)) = of_superelements.iter().find(|(_, empty)| !empty)
        {
            return Err(Error::described(
                *option,
                "has nothing to change: the scene has no superelements",
            ));
        }
        for modes in &self.modes {
            if let (ModeCount::Lowest(count), Some(most)) = (modes, most)
                && *count > most
            {
                return Err(Error::described(
                    "--modes",
                    format!("names {count}, but no superelement of the scene has more than {most}"),
                ));
            }
        }
        if !self.radii.is_empty()
            && let Some(integrator) = subject.scene.integrator
            && subject.own.rho_infinity.is_none()
        {
            return Err(no_radius(integrator.method));
        }
        for asked in &self.fineness {
            match (asked, subject.own.fineness) {
                (Fineness::Step(step), Fineness::Step(_)) if *step > subject.end => {
                    return Err(Error::described(
                        "--step",
                        format!("names {step}, but the scene ends at {}", subject.end),
                    ));
                }
                (Fineness::Step(_), Fineness::Accuracy(_)) => {
                    return Err(Error::described(
                        "--step",
                        "has nothing to change: the scene integrates with radau, whose steps follow an accuracy; give --accuracy",
                    ));
                }
                (Fineness::Accuracy(_), Fineness::Step(_)) => {
                    return Err(Error::described(
                        "--accuracy",
                        "belongs to radau, but the scene integrates with equal steps; give --step, or change the scene's `integrator`",
                    ));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The settings, each once; all combinations of the lists if these are at most `MOST_COMBINATIONS` or `combination` says
    /// so.
    ///
    /// # Errors
    /// [`Error::Description`] where the scene doesn't allow one.
    pub fn settings(
        &self,
        subject: &Subject,
        combination: Option<Combination>,
    ) -> Result<Vec<Setting>, Error> {
        let own = subject.own;
        let all = self.product(&own);
        let is_small = all.len() <= MOST_COMBINATIONS;
        let chosen = match (combination, is_small) {
            (Some(Combination::Product), _) | (None, true) => all,
            (Some(Combination::OneAtATime), _) | (None, false) => self.one_at_a_time(&own),
        };
        let further = self.further_fineness.iter().map(|fineness| Setting {
            fineness: *fineness,
            ..own
        });
        let mut settings: Vec<Setting> = Vec::new();
        for setting in chosen.into_iter().chain(further) {
            if !settings.contains(&setting) {
                setting.applied_to(subject).map_err(by_command_line)?;
                settings.push(setting);
            }
        }
        Ok(settings)
    }

    fn product(&self, own: &Setting) -> Vec<Setting> {
        let mut all = Vec::new();
        for modes in or_own(&self.modes, own.modes) {
            for compatibility in or_own(&self.compatibilities, own.compatibility) {
                for inertia_change in self.inertia_or_own(own) {
                    for rho_infinity in self.radii_or_own(own) {
                        for fineness in or_own(&self.fineness, own.fineness) {
                            all.push(Setting {
                                modes,
                                compatibility,
                                fineness,
                                rho_infinity,
                                inertia_change,
                            });
                        }
                    }
                }
            }
        }
        all
    }

    fn one_at_a_time(&self, own: &Setting) -> Vec<Setting> {
        let own = *own;
        let modes = self.modes.iter().map(|modes| Setting {
            modes: *modes,
            ..own
        });
        let compatibilities = self.compatibilities.iter().map(|choice| Setting {
            compatibility: *choice,
            ..own
        });
        let inertia = self.inertia_or_own(&own);
        let inertia = inertia.into_iter().map(|inertia_change| Setting {
            inertia_change,
            ..own
        });
        let radii = self.radii_or_own(&own);
        let radii = radii.into_iter().map(|rho_infinity| Setting {
            rho_infinity,
            ..own
        });
        let fineness = self.fineness.iter().map(|fineness| Setting {
            fineness: *fineness,
            ..own
        });
        let varied = modes.chain(compatibilities).chain(inertia).chain(radii);
        [own].into_iter().chain(varied).chain(fineness).collect()
    }

    fn inertia_or_own(&self, own: &Setting) -> Vec<Option<InertiaChange>> {
        let given: Vec<_> = self.inertia_changes.iter().copied().map(Some).collect();
        or_own(&given, own.inertia_change)
    }

    fn radii_or_own(&self, own: &Setting) -> Vec<Option<f64>> {
        let given: Vec<_> = self.radii.iter().copied().map(Some).collect();
        or_own(&given, own.rho_infinity)
    }
}

/// A fault of a scene that the command line has changed; the scene by itself was found good.
pub fn by_command_line(error: Error) -> Error {
    match error {
        Error::Description { location, message } => Error::described(
            format!("{location} as changed by the command line"),
            message,
        ),
        other => other,
    }
}

/// `--rho-infinity` for a scene that has no spectral radius.
pub fn no_radius(method: Method) -> Error {
    Error::described(
        "--rho-infinity",
        format!(
            "belongs to generalized_alpha, but the scene integrates with {}; change the scene's `integrator`",
            method.name()
        ),
    )
}

fn or_own<T: Copy>(list: &[T], own: T) -> Vec<T> {
    match list {
        [] => vec![own],
        given => given.to_vec(),
    }
}
