//! Outputs of stress: components, or von Mises' equivalent of what all coordinates make together.

use dcb_formats::component::{StressComponent, StressQuantity, have_von_mises, von_mises};
use dcb_formats::description::{listed, suggestion};
use dcb_formats::results::Channel;
use dcb_formats::scene::{Analysis, StressMeasure, StressOutput};

use super::moment::Moment;
use super::outputs::OutputBuilder;
use super::probe::Probe;
use super::quantities::column;
use crate::body::BodyStress;
use crate::error::Error;

/// Stress at places of a body.
pub(super) struct StressProbe {
    body: usize,
    field: BodyStress,
    places: std::ops::Range<usize>,
    measure: StressMeasure,
    /// Room for interface forces and components.
    forces: Vec<f64>,
    values: Vec<f64>,
}

impl StressProbe {
    /// Whether the numbers are linear in the coordinates.
    pub fn is_smooth(&self) -> bool {
        self.measure == StressMeasure::Components
    }

    /// Appends the numbers.
    pub fn write(&mut self, at: &Moment, row: &mut Vec<f64>) {
        let body = &at.system.bodies[self.body];
        let y = &at.state.coordinates[body.coordinates.clone()];
        if self.field.needs_forces() {
            self.forces.resize(body.flexible.rows.len(), 0.0);
            at.evaluation
                .write_interface_forces(at.system, self.body, &mut self.forces);
        }
        let mut largest = (0.0, self.places.start);
        for place in self.places.clone() {
            self.values.clear();
            self.field.at(place, y, &self.forces, &mut self.values);
            let equivalent = || von_mises(&self.field.components, &self.values);
            match self.measure {
                StressMeasure::Components => row.extend(&self.values),
                StressMeasure::VonMises => row.push(equivalent()),
                StressMeasure::LargestVonMises => {
                    let value = equivalent();
                    if value > largest.0 {
                        largest = (value, place);
                    }
                }
            }
        }
        if self.measure == StressMeasure::LargestVonMises {
            row.extend([largest.0, largest.1 as f64]);
        }
    }
}

impl OutputBuilder<'_> {
    pub(super) fn stress(
        &self,
        path: &str,
        at: &str,
        of: &StressOutput,
    ) -> Result<(Channel, Probe), Error> {
        if self.scene.analysis == Analysis::Kinematic {
            return Err(Error::described(
                at,
                "a kinematic analysis takes flexible bodies as rigid, so that they have no stress; take \"static\" or a motion",
            ));
        }
        let body = self.body(&of.body);
        let field = self.stress_field(at, of, body)?;
        let count = field.points.len();
        let places = match of.place {
            None => 0..count,
            Some(place) if place < count => place..place + 1,
            Some(place) => {
                return Err(Error::described(
                    format!("{at}.place"),
                    format!(
                        "is {place}, but {:?} has {count} places, counted from 0",
                        of.field
                    ),
                ));
            }
        };
        if of.measure != StressMeasure::Components {
            self.refuse_without_equivalent(at, of, field)?;
        }
        let channel = self.stress_channel(path, of.measure, field, places.clone());
        let probe = StressProbe {
            body,
            field: field.clone(),
            places,
            measure: of.measure,
            forces: Vec::new(),
            values: Vec::new(),
        };
        Ok((channel, Probe::Stress(Box::new(probe))))
    }

    fn stress_field(&self, at: &str, of: &StressOutput, body: usize) -> Result<&BodyStress, Error> {
        let fields = &self.builder.system().bodies[body].flexible.stresses;
        if let Some(found) = fields.iter().find(|field| field.name == of.field) {
            return Ok(found);
        }
        let names = || fields.iter().map(|field| field.name.as_str());
        let message = if fields.is_empty() {
            format!(
                "the superelement of body {:?} has no stress field; reduce the part with PART.stress.{}.mtx beside its matrices",
                of.body, of.field
            )
        } else {
            format!(
                "is {:?}, which the superelement of body {:?} doesn't have{} (it has: {})",
                of.field,
                of.body,
                suggestion(&of.field, names()),
                listed(names())
            )
        };
        Err(Error::described(format!("{at}.field"), message))
    }

    fn refuse_without_equivalent(
        &self,
        at: &str,
        of: &StressOutput,
        field: &BodyStress,
    ) -> Result<(), Error> {
        let refused = |message: String| Err(Error::described(format!("{at}.measure"), message));
        if field.quantity == StressQuantity::Strain {
            return refused(format!(
                "{:?} is a strain, but von Mises' measure is one of stress; take its components",
                of.field
            ));
        }
        if !have_von_mises(&field.components, self.scene.dimension) {
            let needed = StressComponent::usual(self.scene.dimension);
            let named = |of: &[StressComponent]| {
                let names: Vec<&str> = of.iter().map(|one| one.name()).collect();
                names.join(" ")
            };
            return refused(format!(
                "von Mises' stress needs {}, but {:?} has {}",
                named(needed),
                of.field,
                named(&field.components)
            ));
        }
        Ok(())
    }

    fn stress_channel(
        &self,
        path: &str,
        measure: StressMeasure,
        field: &BodyStress,
        places: std::ops::Range<usize>,
    ) -> Channel {
        let unit = match field.quantity {
            StressQuantity::Stress => self.quantities.stress.as_str(),
            StressQuantity::Strain => "1",
        };
        let is_one = places.len() == 1;
        let columns = match measure {
            StressMeasure::Components => places
                .flat_map(|place| {
                    field.components.iter().map(move |component| match is_one {
                        true => component.name().to_owned(),
                        false => format!("{place}.{}", component.name()),
                    })
                })
                .map(|name| column(&name, unit))
                .collect(),
            StressMeasure::VonMises => places
                .map(|place| match is_one {
                    true => String::new(),
                    false => place.to_string(),
                })
                .map(|name| column(&name, unit))
                .collect(),
            StressMeasure::LargestVonMises => vec![column("value", unit), column("place", "1")],
        };
        let what = match (field.quantity, measure) {
            (StressQuantity::Strain, _) => "strain, components of the tensor, body axes",
            (_, StressMeasure::Components) => "stress, body axes",
            (_, StressMeasure::VonMises) => "von Mises' equivalent stress",
            (_, StressMeasure::LargestVonMises) => {
                "largest equivalent stress of all places, and its place"
            }
        };
        Channel {
            path: path.to_owned(),
            columns,
            description: what.to_owned(),
        }
    }
}
