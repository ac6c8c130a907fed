//! Controllers of a scene: formulas of outputs, to sensors of joints or to probes.

use super::Names;
use super::library::Library;
use super::moment::Moment;
use super::outputs::OutputBuilder;
use super::probe::Probe;
use super::quantities::Quantities;
use crate::actuator::Sense;
use crate::error::Error;
use crate::simulation::{Senses, Sight};
use crate::system::builder::{JointCoordinate, SystemBuilder};
use dcb_formats::function::OutputComponent;
use dcb_formats::results::Channel;
use dcb_formats::scene::{Controller, OfJoint, Output, Scene};

/// Collects what sampled controllers see.
pub(super) struct SensesBuilder {
    quantities: Quantities,
    /// The outputs that they use, and how many numbers each has.
    probes: Vec<(String, Channel, Probe)>,
    /// For each argument where it is in the row of all probes.
    places: Vec<usize>,
}

impl SensesBuilder {
    pub(super) fn of(scene: &Scene) -> Self {
        Self {
            quantities: Quantities::of(&scene.units),
            probes: Vec::new(),
            places: Vec::new(),
        }
    }

    /// Adds a controller to the system.
    pub(super) fn add(
        &mut self,
        scene: &Scene,
        builder: &mut SystemBuilder,
        names: &Names,
        library: &mut Library,
        name: &str,
        controller: &Controller,
    ) -> Result<(), Error> {
        let location = format!("controllers.{name}");
        let formula = controller
            .parsed(scene.outputs.keys().map(String::as_str))
            .map_err(|error| error.within(&location))?;
        let at = format!("{location}.formula");
        let Some(period) = controller.period else {
            let senses: Result<Vec<Sense>, Error> = formula
                .variables()
                .iter()
                .map(|variable| sense(scene, builder, names, &at, variable))
                .collect();
            builder.continuous_controller(name, formula, senses?);
            return Ok(());
        };
        for variable in formula.variables() {
            if !self
                .probes
                .iter()
                .any(|(known, ..)| *known == variable.output)
            {
                let mut outputs = OutputBuilder {
                    scene,
                    builder: &mut *builder,
                    names,
                    library: &mut *library,
                    quantities: &self.quantities,
                };
                let output = &scene.outputs[variable.output.as_str()];
                let (channel, probe) = outputs.output(&variable.output, output)?;
                self.probes.push((variable.output.clone(), channel, probe));
            }
            let place = self.place(&at, variable)?;
            self.places.push(place);
        }
        builder.sampled_controller(name, formula, period);
        Ok(())
    }

    /// Where a number is in the row of all probes.
    fn place(&self, at: &str, variable: &OutputComponent) -> Result<usize, Error> {
        let mut before = 0;
        for (name, channel, _) in &self.probes {
            if *name == variable.output {
                return Ok(before + component(at, channel, variable)?);
            }
            before += channel.columns.len();
        }
        Err(Error::described(at, "names no output of the scene"))
    }

    /// What sampled controllers see; `None` without them.
    pub(super) fn finish(self) -> Option<Senses> {
        if self.places.is_empty() {
            return None;
        }
        let Self {
            mut probes, places, ..
        } = self;
        let mut row = Vec::new();
        Some(Box::new(move |sight: &Sight, arguments: &mut [f64]| {
            let moment = Moment {
                system: sight.system,
                state: sight.state,
                evaluation: sight.evaluation,
                energy: &sight.energy,
                works: &sight.works,
                defect: sight.defect,
                step: (0.0, 0),
            };
            row.clear();
            for (_, _, probe) in &mut probes {
                probe.write(&moment, &mut row);
            }
            for (argument, place) in arguments.iter_mut().zip(&places) {
                *argument = row[*place];
            }
        }))
    }
}

/// Which number of an output is meant.
fn component(at: &str, channel: &Channel, variable: &OutputComponent) -> Result<usize, Error> {
    let names = || channel.columns.iter().map(|column| column.name.as_str());
    let output = &variable.output;
    match &variable.component {
        None if channel.columns.len() == 1 => Ok(0),
        None => {
            let first = names().next().unwrap_or_default();
            Err(Error::described(
                at,
                format!(
                    "output {output:?} has the components {}; write one of them, for example {output}.{first}",
                    names().collect::<Vec<_>>().join(", ")
                ),
            ))
        }
        Some(component) => names().position(|name| name == component).ok_or_else(|| {
            let there = match channel.columns.len() {
                1 => "it is one number and has no components".to_owned(),
                _ => format!("it has {}", names().collect::<Vec<_>>().join(", ")),
            };
            Error::described(
                at,
                format!("output {output:?} has no component {component:?}: {there}"),
            )
        }),
    }
}

/// The sensor of a continuous controller's argument.
fn sense(
    scene: &Scene,
    builder: &mut SystemBuilder,
    names: &Names,
    at: &str,
    variable: &OutputComponent,
) -> Result<Sense, Error> {
    if let Some(component) = &variable.component {
        return Err(Error::described(
            at,
            format!(
                "output {:?} is one number and has no component {component:?}",
                variable.output
            ),
        ));
    }
    let missing = || {
        Error::described(
            at,
            format!("output {:?} has no coordinate", variable.output),
        )
    };
    let (Output::JointCoordinate(OfJoint { joint }) | Output::JointRate(OfJoint { joint })) =
        &scene.outputs[variable.output.as_str()]
    else {
        return Err(missing());
    };
    let named = names.joints.get(joint).ok_or_else(missing)?;
    let built = named.built.clone().ok_or_else(missing)?;
    // That of the output: the angle of a cylindrical joint.
    let found = [JointCoordinate::Rotation, JointCoordinate::Translation]
        .into_iter()
        .find_map(|which| Some((which, built.coordinate(which)?)));
    let (which, measure) = found.ok_or_else(missing)?;
    let sensor = builder.sensor(&built, measure, named.zero(which));
    Ok(match &scene.outputs[variable.output.as_str()] {
        Output::JointRate(_) => Sense::Rate(sensor),
        _ => Sense::Value(sensor),
    })
}
