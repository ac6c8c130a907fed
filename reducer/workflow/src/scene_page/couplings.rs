//! Joints and loads of a page.

use dcb_formats::scene::Joint as SceneJoint;
use dcb_runtime::system::{ConnectionKind, LoadAxes};
use dcb_view::{Array, Arrays, End, Joint, Load};
use nalgebra::Vector3;
use serde_json::Value;

use super::Run;

/// Where joints hold.
pub fn joints(run: &Run) -> Vec<Joint> {
    let system = &run.model.system;
    let is_joint = system.connections.iter();
    let is_joint = is_joint.filter(|connection| connection.kind == ConnectionKind::Joint);
    is_joint
        .map(|connection| {
            let (kind, axis) = described(run.scene.joints.get(&connection.name));
            let end = |marker: usize, axis: Option<Vector3<f64>>| {
                let marker = &system.markers[marker];
                End {
                    body: marker.body,
                    position: marker.position.into(),
                    axis: axis.map(|axis| (marker.axes * axis).into()),
                }
            };
            Joint {
                name: connection.name.clone(),
                kind,
                a: end(connection.a, axis),
                b: end(connection.b, None),
            }
        })
        .collect()
}

/// Kind of a joint and its axis, as the scene writes them.
fn described(joint: Option<&SceneJoint>) -> (String, Option<Vector3<f64>>) {
    let written = joint.and_then(|joint| serde_json::to_value(joint).ok());
    let Some(Value::Object(written)) = written else {
        return (String::new(), None);
    };
    let Some((kind, of_kind)) = written.iter().next() else {
        return (String::new(), None);
    };
    let axis = of_kind["axis"].as_array().map(|axis| {
        Vector3::from_fn(|i, _| axis.get(i).and_then(Value::as_f64).unwrap_or_default())
    });
    (kind.clone(), axis)
}

/// Forces and moments on frames whose functions of time are known beforehand.
pub fn loads(run: &Run, rows: &[usize], time: &[f64], arrays: &mut Arrays) -> Vec<Load> {
    let system = &run.model.system;
    let mut drawn = Vec::new();
    for load in &system.loads {
        let marker = &system.markers[load.marker];
        for (signals, moment) in [(load.force, false), (load.torque, true)] {
            if signals.iter().all(Option::is_none) {
                continue;
            }
            let Some(components) = components(run, signals, rows, time, arrays) else {
                continue;
            };
            drawn.push(Load {
                name: load.name.clone(),
                body: marker.body,
                position: marker.position.into(),
                moment,
                components,
                world: load.axes == LoadAxes::World,
            });
        }
    }
    drawn
}

fn components(
    run: &Run,
    signals: [Option<usize>; 3],
    rows: &[usize],
    time: &[f64],
    arrays: &mut Arrays,
) -> Option<Array> {
    let known = &run.model.system.signals;
    let signals = signals.map(|signal| signal.and_then(|signal| known.get(signal)));
    if signals
        .iter()
        .flatten()
        .any(|signal| signal.input.is_some())
    {
        return None;
    }
    let values = rows.iter().flat_map(|row| {
        signals.map(|signal| {
            signal.map_or(0.0, |signal| {
                signal.offset + signal.function.evaluate(time[*row], 0.0).value
            })
        })
    });
    Some(arrays.reals(values.collect::<Vec<_>>()))
}
