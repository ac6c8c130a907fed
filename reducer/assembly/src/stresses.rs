//! Stress fields of the parts in the whole, under the names BODY: FIELD, in axes of the assembly.

use dcb_formats::component::StressPoint;
use dcb_formats::superelement::StressField;
use nalgebra::Vector3;

use crate::inertia::PartColumns;
use crate::part::Part;

/// Components that can't be turned into the assembly's axes, because others are missing, are left out. `first_nodes` are the numbers of each part's
/// first node in the mesh of the whole.
pub(crate) fn stresses(
    parts: &[Part],
    columns: &[PartColumns],
    centre: Vector3<f64>,
    first_nodes: &[Option<u32>],
) -> Vec<StressField> {
    let mut all = Vec::new();
    for ((part, columns), first) in parts.iter().zip(columns).zip(first_nodes) {
        let Some(flexible) = part.flexible() else {
            continue;
        };
        let axes = std::array::from_fn(|i| std::array::from_fn(|j| part.axes[(i, j)]));
        let place = |point: &StressPoint| StressPoint {
            position: (part.centre + part.axes * Vector3::from(point.position) - centre).into(),
            node: first.zip(point.node).map(|(first, node)| first + node),
        };
        let in_whole = |field: &StressField| {
            let turned = field.turned(axes)?;
            Some(StressField {
                name: format!("{}: {}", part.name, field.name),
                points: field.points.iter().map(place).collect(),
                ..turned.over(columns.deformation.as_ref())
            })
        };
        all.extend(flexible.element.stresses.iter().filter_map(in_whole));
    }
    all
}
