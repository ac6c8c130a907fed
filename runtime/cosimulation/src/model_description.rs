//! The `modelDescription.xml` of FMI 3.0.
//!
//! Written with quick-xml, which the workspace has: of the standard's elements a dozen are needed, and a crate with types for all of them brings two XML
//! libraries more.

use std::collections::BTreeSet;
use std::io;

use crate::si_unit::SiUnit;
use crate::unit::CoSimulation;
use crate::variable::{Source, Variable};
use crate::xml::Document;

/// What a model description says that isn't in the unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Named<'a> {
    /// Name for people.
    pub model: &'a str,
    /// Name of the library without its ending: letters, digits and underscores.
    pub identifier: &'a str,
}

/// What the unit can do, as attributes of `CoSimulation`. What is not there is false.
const ABILITIES: [(&str, &str); 3] = [
    ("canHandleVariableCommunicationStepSize", "true"),
    ("canGetAndSetFMUState", "true"),
    ("canSerializeFMUState", "true"),
];

/// Categories of messages.
const CATEGORIES: [(&str, &str); 3] = [
    (
        "logStatusWarning",
        "what the motion may be too large, too fast or too coarse for",
    ),
    ("logStatusError", "why a call failed"),
    ("logStatusFatal", "defects of the unit"),
];

/// The text of `modelDescription.xml`.
///
/// # Errors
/// None but those of writing to memory.
pub fn model_description(unit: &CoSimulation, named: Named<'_>) -> io::Result<String> {
    let mut document = Document::new()?;
    document.open(
        "fmiModelDescription",
        &[
            ("fmiVersion", "3.0"),
            ("modelName", named.model),
            ("instantiationToken", unit.token()),
            (
                "generationTool",
                concat!("dcb simulate ", env!("CARGO_PKG_VERSION")),
            ),
            ("variableNamingConvention", "flat"),
        ],
    )?;
    let mut abilities = vec![("modelIdentifier", named.identifier)];
    abilities.extend(ABILITIES);
    document.empty("CoSimulation", &abilities)?;
    document.units(unit)?;
    document.open("LogCategories", &[])?;
    for (name, description) in CATEGORIES {
        document.empty("Category", &[("name", name), ("description", description)])?;
    }
    document.close("LogCategories")?;
    if let Some(integrator) = unit.scene().integrator {
        let mut experiment = vec![("startTime", 0.0), ("stopTime", integrator.end)];
        // Steps that follow an accuracy suggest no communication step.
        if !integrator.is_radau() {
            experiment.push(("stepSize", integrator.step));
        }
        let experiment = experiment
            .into_iter()
            .map(|(name, value)| (name, number(value)));
        let experiment: Vec<(&str, String)> = experiment.collect();
        let experiment: Vec<_> = experiment
            .iter()
            .map(|(name, value)| (*name, value.as_str()))
            .collect();
        document.empty("DefaultExperiment", &experiment)?;
    }
    document.open("ModelVariables", &[])?;
    for variable in unit.variables() {
        document.variable(variable)?;
    }
    document.close("ModelVariables")?;
    document.open("ModelStructure", &[])?;
    for element in ["Output", "InitialUnknown"] {
        for variable in unit.variables() {
            if let Source::Output { .. } = variable.source {
                let reference = variable.reference.to_string();
                document.empty(element, &[("valueReference", &reference)])?;
            }
        }
    }
    document.close("ModelStructure")?;
    document.close("fmiModelDescription")?;
    document.text()
}

impl Document {
    fn units(&mut self, unit: &CoSimulation) -> io::Result<()> {
        let names = unit
            .variables()
            .iter()
            .map(|variable| variable.unit.as_str());
        let names: BTreeSet<&str> = names.filter(|name| *name != "1").collect();
        self.open("UnitDefinitions", &[])?;
        for name in names {
            let Some(si) = SiUnit::of(name, &unit.scene().units) else {
                self.empty("Unit", &[("name", name)])?;
                continue;
            };
            self.open("Unit", &[("name", name)])?;
            let powers = [
                ("kg", si.kilogram),
                ("m", si.metre),
                ("s", si.second),
                ("rad", si.radian),
            ];
            let powers = powers.map(|(name, power)| (name, power.to_string()));
            let factor = number(si.factor);
            let mut attributes: Vec<_> = powers
                .iter()
                .map(|(name, power)| (*name, power.as_str()))
                .filter(|(_, power)| *power != "0")
                .collect();
            if si.factor != 1.0 {
                attributes.push(("factor", &factor));
            }
            self.empty("BaseUnit", &attributes)?;
            self.close("Unit")?;
        }
        self.close("UnitDefinitions")
    }

    fn variable(&mut self, variable: &Variable) -> io::Result<()> {
        let (causality, variability) = match variable.source {
            Source::Time => ("independent", "continuous"),
            Source::Parameter(_) => ("parameter", "fixed"),
            Source::Input(_) => ("input", "continuous"),
            Source::Output { .. } => ("output", "continuous"),
        };
        let reference = variable.reference.to_string();
        let start = variable.start.map(number);
        let mut attributes = vec![
            ("name", variable.name.as_str()),
            ("valueReference", &reference),
            ("causality", causality),
            ("variability", variability),
        ];
        if let Source::Output { .. } = variable.source {
            attributes.push(("initial", "calculated"));
        }
        if variable.unit != "1" {
            attributes.push(("unit", &variable.unit));
        }
        if let Some(start) = &start {
            attributes.push(("start", start));
        }
        if !variable.description.is_empty() {
            attributes.push(("description", &variable.description));
        }
        self.empty("Float64", &attributes)
    }
}

/// A number that is read back as the same.
fn number(value: f64) -> String {
    format!("{value:?}")
}
