//! Stress fields of a body as numbers at the nodes of its mesh.

use dcb_formats::component::{StressQuantity, have_von_mises, von_mises};

use crate::body::FlexibleBody;

/// Stress fields at nodes: name, numbers at each node, values. Components are in body axes; where a field has enough of them, von Mises' stress
/// too. Fields at other places than nodes aren't there.
pub fn nodal_stresses(
    body: &FlexibleBody,
    node_count: usize,
    y: &[f64],
    forces: &[f64],
) -> Vec<(String, usize, Vec<f64>)> {
    let dimension = body.inertia.dimension();
    let mut all = Vec::new();
    for field in &body.stresses {
        let nodes: Option<Vec<usize>> = (field.points.iter())
            .map(|point| Some(point.node? as usize).filter(|node| *node < node_count))
            .collect();
        let Some(nodes) = nodes else { continue };
        let has_equivalent = field.quantity == StressQuantity::Stress
            && have_von_mises(&field.components, dimension);
        let mut tensors = vec![f64::NAN; 6 * node_count];
        let mut equivalent = vec![f64::NAN; node_count];
        let mut values = Vec::new();
        for (place, node) in nodes.into_iter().enumerate() {
            values.clear();
            field.at(place, y, forces, &mut values);
            let tensor = &mut tensors[6 * node..6 * node + 6];
            tensor.fill(0.0);
            for (component, value) in field.components.iter().zip(&values) {
                tensor[component.index()] = *value;
            }
            equivalent[node] = von_mises(&field.components, &values);
        }
        all.push((field.name.clone(), 6, tensors));
        if has_equivalent {
            all.push((format!("{} von Mises", field.name), 1, equivalent));
        }
    }
    all
}
