//! Joints, drives, gears, springs and loads of a system.

use super::{BuiltJoint, SystemBuilder};
use crate::actuator::{Actuator, Controller, Sense, Source, Timing};
use crate::error::Error;
use crate::force_law::Law;
use crate::joint::{JointKind, JointRows, RestPlacement};
use crate::measure::{Displacement, Measure};
use crate::system::marker::{Elasticity, Marker};
use crate::system::{
    Connection, ConnectionKind, Demand, Load, LoadAxes, PartLoad, Row, Sensor, Term,
};
use dcb_formats::function::OutputFormula;
use nalgebra::Vector3;

impl SystemBuilder {
    /// A joint between two markers.
    ///
    /// # Errors
    /// Those of [`JointKind::rows`].
    pub fn joint(
        &mut self,
        name: &str,
        a: usize,
        b: usize,
        kind: &JointKind,
    ) -> Result<BuiltJoint, Error> {
        let rest = RestPlacement::of(&self.frame(a), &self.frame(b));
        let rows = kind.rows(self.system.dimension, &rest)?;
        Ok(self.joint_of(name, a, b, rows))
    }

    /// A joint between two markers that holds the measures in `rows`.
    pub fn joint_of(&mut self, name: &str, a: usize, b: usize, rows: JointRows) -> BuiltJoint {
        let connection = self.connect(name, ConnectionKind::Joint, a, b);
        for measure in &rows.held {
            if !self.leads_out_of_plane(a, b, measure) {
                self.row(connection, &[(1.0, a, b, *measure)], Demand::Hold(0.0));
            }
        }
        BuiltJoint {
            connection,
            a,
            b,
            rows,
        }
    }

    /// A joint coordinate that follows a function of time.
    pub fn drive(
        &mut self,
        name: &str,
        joint: &BuiltJoint,
        measure: Measure,
        signal: usize,
    ) -> usize {
        let connection = self.connect(name, ConnectionKind::Drive, joint.a, joint.b);
        let term = (1.0, joint.a, joint.b, measure);
        self.row(connection, &[term], Demand::Follow(signal));
        connection
    }

    /// Two joint coordinates in a fixed ratio, `second - ratio first = constant as drawn`.
    pub fn gear(
        &mut self,
        name: &str,
        (first, first_measure): (&BuiltJoint, Measure),
        (second, second_measure): (&BuiltJoint, Measure),
        ratio: f64,
    ) -> usize {
        let value = |joint: &BuiltJoint, measure: &Measure| {
            measure.value(&self.frame(joint.a), &self.frame(joint.b))
        };
        let constant = value(second, &second_measure) - ratio * value(first, &first_measure);
        let connection = self.connect(name, ConnectionKind::Joint, second.a, second.b);
        let terms = [
            (1.0, second.a, second.b, second_measure),
            (-ratio, first.a, first.b, first_measure),
        ];
        self.row(connection, &terms, Demand::Hold(constant));
        connection
    }

    /// Forces between two markers along measures: a spring, a torsion spring, a bushing.
    pub fn spring(
        &mut self,
        name: &str,
        a: usize,
        b: usize,
        laws: impl IntoIterator<Item = (Measure, Law)>,
    ) -> usize {
        let connection = self.connect(name, ConnectionKind::Spring, a, b);
        for (measure, law) in laws {
            self.system.is_damped |= law.is_damped();
            self.row(connection, &[(1.0, a, b, measure)], Demand::Answer(law));
        }
        connection
    }

    /// Dampers of amplitudes that bodies' coordinates y add up to, `e = length Σ aᵀ y`: aᵀ of each body, and the law of each amplitude.
    /// The forces act on deflections alone, in body axes: they are the same however the mechanism lies.
    pub fn damp_amplitudes(&mut self, name: &str, amplitudes: &[(Vec<Vec<f64>>, Law)]) {
        let places: Vec<Vec<(usize, usize)>> = (0..self.system.bodies.len())
            .map(|body| self.amplitude_markers(body, amplitudes))
            .collect();
        let Some(first) = places.iter().flatten().next().copied() else {
            return;
        };
        let connection = self.connect(name, ConnectionKind::AssembledModes, first.0, first.1);
        let axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
        for (index, (_, law)) in amplitudes.iter().enumerate() {
            self.system.is_damped |= law.is_damped();
            let direction = axes[index % 3];
            let measure = Measure::Displacement(Displacement { direction });
            let own = places.iter().filter(|own| !own.is_empty());
            let terms: Vec<_> = own
                .map(|own| (1.0, own[index / 3].0, own[index / 3].1, measure))
                .collect();
            self.row(connection, &terms, Demand::Answer(law.clone()));
        }
    }

    /// Pairs of the body's frame and a marker there that three amplitudes displace, one along each axis.
    fn amplitude_markers(
        &mut self,
        body: usize,
        amplitudes: &[(Vec<Vec<f64>>, Law)],
    ) -> Vec<(usize, usize)> {
        let n = self.system.bodies[body].flexible.coordinate_count();
        if n == 0 {
            return Vec::new();
        }
        let frame = self.body_frame(body);
        let of_three = amplitudes.chunks(3).map(|three| {
            let mut shapes = vec![0.0; 6 * n];
            for (column, (by_body, _)) in shapes.chunks_exact_mut(n).zip(three) {
                column.copy_from_slice(&by_body[body]);
            }
            self.system.bodies[body]
                .markers
                .push(self.system.markers.len());
            self.system.markers.push(Marker {
                shapes,
                elasticity: Elasticity::Place,
                ..Marker::on_body(body)
            });
            self.interfaces.push(None);
            (frame, self.system.markers.len() - 1)
        });
        of_three.collect()
    }

    /// An effort on the coordinate of a joint, which is zero where the measure has the value `zero`.
    pub fn actuator(
        &mut self,
        name: &str,
        joint: &BuiltJoint,
        measure: Measure,
        zero: f64,
        source: Source,
    ) -> usize {
        let connection = self.connect(name, ConnectionKind::Actuator, joint.a, joint.b);
        let system = &mut self.system;
        // Works and sensing need rates, whatever the effort depends on.
        system.is_damped = true;
        let memory = system.memory_count;
        system.memory_count += source.memory_count();
        system.actuators.push(Actuator {
            row: system.rows.len(),
            zero,
            source,
            memory,
        });
        let index = system.actuators.len() - 1;
        let term = (1.0, joint.a, joint.b, measure);
        self.row(connection, &[term], Demand::Actuate(index));
        connection
    }

    /// A coordinate of a joint that continuous controllers sense; the same one if it was asked for before.
    pub fn sensor(&mut self, joint: &BuiltJoint, measure: Measure, zero: f64) -> usize {
        let is_angle = matches!(measure, Measure::Angle(_));
        let sensor = Sensor {
            a: joint.a,
            b: joint.b,
            measure,
            angle: is_angle.then(|| self.watch(joint.a, joint.b, measure)),
            zero,
        };
        let sensors = &mut self.system.sensors;
        let known = sensors.iter().position(|one| *one == sensor);
        known.unwrap_or_else(|| {
            sensors.push(sensor);
            sensors.len() - 1
        })
    }

    /// A controller that always follows sensed coordinates.
    pub fn continuous_controller(
        &mut self,
        name: &str,
        formula: OutputFormula,
        senses: Vec<Sense>,
    ) -> usize {
        let first = self.system.slope_count;
        self.system.slope_count += senses.len();
        self.add_controller(name, formula, Timing::Continuous { senses, first })
    }

    /// A controller that is computed at all multiples of a period.
    pub fn sampled_controller(&mut self, name: &str, formula: OutputFormula, period: f64) -> usize {
        let first = self.system.argument_count;
        self.system.argument_count += formula.variables().len();
        let memory = self.system.memory_count;
        self.system.memory_count += 2;
        let timing = Timing::Sampled {
            period,
            arguments: first..self.system.argument_count,
            memory,
        };
        self.add_controller(name, formula, timing)
    }

    fn add_controller(&mut self, name: &str, formula: OutputFormula, timing: Timing) -> usize {
        self.system.controllers.push(Controller {
            name: name.to_owned(),
            formula,
            timing,
        });
        self.system.controllers.len() - 1
    }

    /// A force and a torque on a marker; components are functions of time by index.
    pub fn load(
        &mut self,
        name: &str,
        marker: usize,
        axes: LoadAxes,
        force: [Option<usize>; 3],
        torque: [Option<usize>; 3],
    ) -> usize {
        self.system.loads.push(Load {
            name: name.to_owned(),
            marker,
            axes,
            force,
            torque,
        });
        self.system.loads.len() - 1
    }

    /// A load on the inside of a body, by its index among the body's own; the factor is a function of time by index.
    pub fn part_load(&mut self, name: &str, body: usize, load: usize, factor: usize) -> usize {
        self.system.part_loads.push(PartLoad {
            name: name.to_owned(),
            body,
            load,
            factor,
        });
        self.system.part_loads.len() - 1
    }

    fn connect(&mut self, name: &str, kind: ConnectionKind, a: usize, b: usize) -> usize {
        let at = self.system.rows.len();
        self.system.connections.push(Connection {
            name: name.to_owned(),
            kind,
            a,
            b,
            rows: at..at,
        });
        self.system.connections.len() - 1
    }

    fn row(&mut self, connection: usize, terms: &[(f64, usize, usize, Measure)], demand: Demand) {
        let first = self.system.terms.len();
        for (weight, a, b, measure) in terms {
            let angle = matches!(measure, Measure::Angle(_)).then_some(self.system.angle_count);
            self.system.angle_count += usize::from(angle.is_some());
            self.system.terms.push(Term {
                weight: *weight,
                a: *a,
                b: *b,
                measure: *measure,
                angle,
            });
        }
        self.system.rows.push(Row {
            connection,
            terms: first..self.system.terms.len(),
            demand,
        });
        self.system.connections[connection].rows.end = self.system.rows.len();
    }
}
