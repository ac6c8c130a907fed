//! The options of one run of a study.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::fineness::Fineness;
use super::subject::Subject;
use dcb_formats::scene::{BodyKind, Compatibility, InertiaChange, Method, Scene};
use dcb_runtime::error::Error;

/// How many modes the superelements of a scene keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ModeCount {
    /// As many as the scene says, body by body.
    AsInScene,
    /// This many, the lowest; all of a superelement that has fewer.
    Lowest(u32),
    /// All that are in the files.
    All,
}

/// The options of one run: what a scene is changed in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// Modes of every superelement.
    pub modes: ModeCount,
    /// How interfaces follow the coordinates.
    pub compatibility: Compatibility,
    /// Step or accuracy of the integrator.
    #[serde(flatten)]
    pub fineness: Fineness,
    /// Spectral radius at infinite frequency; `None` where the scene integrates with HHT.
    pub rho_infinity: Option<f64>,
    /// How far the inertia of every superelement follows the deflection; `None`: as the scene says, body by body.
    pub inertia_change: Option<InertiaChange>,
}

/// Times at which motions are compared whose steps follow an accuracy.
const INTERVALS: f64 = 256.0;

/// Time between two of them, of a motion that ends at `end`.
pub fn interval(end: f64) -> f64 {
    end / INTERVALS
}

impl Setting {
    /// The scene's own.
    ///
    /// # Errors
    /// [`Error::Description`] for a scene without equal steps: a study can't be made of it.
    pub fn of(scene: &Scene) -> Result<Self, Error> {
        let integrator = scene
            .integrator
            .ok_or_else(|| Error::described("integrator", "is missing; a study needs it"))?;
        if integrator.adaptive.is_some() {
            return Err(Error::described(
                "integrator",
                "has `adaptive`, but motions are compared at the ends of equal steps; leave it out, or take radau for a preparation",
            ));
        }
        let superelements = || scene.superelements().map(|(_, body)| body);
        let mut changes = superelements().map(|body| body.inertia_change);
        let first = changes.next();
        Ok(Self {
            modes: match superelements().all(|body| body.modes.is_none()) {
                true => ModeCount::All,
                false => ModeCount::AsInScene,
            },
            compatibility: scene.compatibility,
            fineness: match integrator.is_radau() {
                true => Fineness::Accuracy(integrator.tolerance),
                false => Fineness::Step(integrator.step),
            },
            rho_infinity: match integrator.method {
                Method::GeneralizedAlpha { rho_infinity } => Some(rho_infinity),
                Method::Hht { .. } | Method::Radau { .. } => None,
            },
            inertia_change: first.filter(|first| changes.all(|other| other == *first)),
        })
    }

    /// The scene with these options, and without the fields that it writes.
    ///
    /// # Errors
    /// [`Error::Description`] if the scene doesn't allow them.
    pub fn applied_to(&self, subject: &Subject) -> Result<Scene, Error> {
        let mut changed = subject.scene.clone();
        changed.fields.clear();
        changed.compatibility = self.compatibility;
        for (name, body) in &mut changed.bodies {
            let BodyKind::Superelement(body) = &mut body.kind else {
                continue;
            };
            match self.modes {
                ModeCount::AsInScene => {}
                ModeCount::Lowest(wanted) => {
                    let available = subject.mode_counts.get(name).copied();
                    body.modes = Some(wanted.min(available.unwrap_or(wanted)));
                }
                ModeCount::All => body.modes = None,
            }
            if let Some(change) = self.inertia_change {
                body.inertia_change = change;
            }
        }
        if let Some(integrator) = changed.integrator.as_mut() {
            match self.fineness {
                Fineness::Step(step) => integrator.step = step,
                Fineness::Accuracy(accuracy) => integrator.tolerance = accuracy,
            }
            if let (Some(given), Method::GeneralizedAlpha { rho_infinity }) =
                (self.rho_infinity, &mut integrator.method)
            {
                *rho_infinity = given;
            }
        }
        changed.check()?;
        Ok(changed)
    }

    /// The options as they would stand in the scene: what of it they replace.
    pub fn in_scene(&self, subject: &Subject) -> Value {
        let mut bodies = Map::new();
        for name in subject.mode_counts.keys() {
            let mut keys = Map::new();
            if let ModeCount::Lowest(count) = self.modes {
                keys.insert("modes".into(), json!(count.min(subject.mode_counts[name])));
            }
            let changed = self.inertia_change != subject.own.inertia_change;
            if let Some(change) = self.inertia_change.filter(|_| changed) {
                keys.insert("inertia_change".into(), json!(change));
            }
            if !keys.is_empty() {
                bodies.insert(name.clone(), Value::Object(keys));
            }
        }
        let integrator = match (self.fineness, self.rho_infinity) {
            (Fineness::Accuracy(tolerance), _) => json!({"radau": {"tolerance": tolerance}}),
            (Fineness::Step(step), Some(rho_infinity)) => {
                json!({"generalized_alpha": {"step": step, "rho_infinity": rho_infinity}})
            }
            (Fineness::Step(step), None) => json!({"hht": {"step": step}}),
        };
        json!({"bodies": bodies, "compatibility": self.compatibility, "integrator": integrator})
    }

    /// Its name among the rows of a study, with every digit.
    pub fn key(&self) -> String {
        let rho = match (self.fineness, self.rho_infinity) {
            (Fineness::Accuracy(_), _) => "radau".to_owned(),
            (Fineness::Step(_), rho) => rho.map_or("hht".to_owned(), |rho| format!("{rho:?}")),
        };
        let (modes, inertia) = (self.modes_text(), self.inertia_text());
        let compatibility = self.compatibility.name();
        format!(
            "{modes}/{compatibility}/{:e}/{rho}/{inertia}",
            self.fineness.value()
        )
    }

    /// `5`, `all` or `scene`.
    pub fn modes_text(&self) -> String {
        match self.modes {
            ModeCount::AsInScene => "scene".to_owned(),
            ModeCount::Lowest(count) => count.to_string(),
            ModeCount::All => "all".to_owned(),
        }
    }

    /// As scenes name it, or `scene`.
    pub fn inertia_text(&self) -> &'static str {
        self.inertia_change.map_or("scene", InertiaChange::name)
    }
}
