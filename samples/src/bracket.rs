//! An angle bracket of steel: two legs and a quarter of a ring between them, with the stress at the nodes of its fillet.

use std::f64::consts::FRAC_PI_2;

use dcb_formats::Component;

use crate::component::{average_interface, changed};
use crate::material::Material;
use crate::planform::{Planform, on_circle};
use crate::solid::{SolidElement, nodal_stress, solid_component};

/// Lengths of the legs, m.
const LEGS: [f64; 2] = [0.080, 0.060];
/// Thickness of the legs and of the corner, m.
const THICKNESS: f64 = 0.012;
/// Radius of the fillet, m.
const FILLET: f64 = 0.008;
/// Extent along z, m.
const WIDTH: f64 = 0.030;

/// Quadratic hexahedra, `cells` across the thickness. Averaged interfaces `wall` and `tip` are the ends of the legs; the stress field `fillet` has all six
/// components at the nodes of the inner corner. 2 cells have 6 thousand dofs, 4 have 37, 8 have 256.
pub fn bracket(cells: usize) -> Component {
    let cells = cells.max(1);
    let size = THICKNESS / cells as f64;
    let count = |length: f64| (length / size).round().max(1.0) as usize;
    let [first_leg, second_leg] = LEGS.map(count);
    let corner = 3 * cells;
    let steps = [0, first_leg, corner, second_leg].map(|cells| 2 * cells);
    let ends: Vec<usize> = (steps.iter())
        .scan(0, |sum, step| {
            *sum += step;
            Some(*sum)
        })
        .collect();
    let across = 2 * cells + 1;

    let mut planform = Planform::default();
    for i in 0..=ends[3] {
        for j in 0..across {
            let out = THICKNESS * j as f64 / (across - 1) as f64;
            let share = |part: usize| (i - ends[part]) as f64 / steps[part + 1] as f64;
            planform.add_point(if i <= ends[1] {
                [LEGS[0] * (share(0) - 1.0), out]
            } else if i <= ends[2] {
                let angle = FRAC_PI_2 * (1.0 - share(1));
                on_circle([0.0, -FILLET], FILLET + out, angle)
            } else {
                [FILLET + out, -FILLET - LEGS[1] * share(2)]
            });
        }
    }
    let layers = count(WIDTH);
    planform.add_grid([ends[3] / 2, cells], 0..layers, |i, j| {
        (i * across + j) as u32
    });
    let heights: Vec<f64> = (0..=layers)
        .map(|layer| WIDTH * (layer as f64 / layers as f64 - 0.5))
        .collect();
    let extrusion = planform.extrude(&heights, SolidElement::Hexahedron20);
    let end = |i: usize| -> Vec<u32> { (0..across).map(|j| (i * across + j) as u32).collect() };
    let wall = extrusion.nodes_over(&end(0));
    let tip = extrusion.nodes_over(&end(ends[3]));
    let inner: Vec<u32> = (ends[1]..=ends[2]).map(|i| (i * across) as u32).collect();
    let fillet = extrusion.nodes_over(&inner);

    let mut mesh = extrusion.mesh;
    for (name, nodes) in [("wall", &wall), ("tip", &tip), ("fillet", &fillet)] {
        mesh.point_sets.insert(name.into(), nodes.clone());
    }
    let middle = 0.5 * THICKNESS;
    let interfaces = vec![
        average_interface("wall", wall, [-LEGS[0], middle, 0.0]),
        average_interface("tip", tip, [FILLET + middle, -FILLET - LEGS[1], 0.0]),
    ];
    let stress = nodal_stress("fillet", &mesh, &Material::STEEL, &fillet);
    let component = solid_component("bracket", mesh, &Material::STEEL, interfaces);
    changed(component, |draft| draft.stresses.push(stress))
}
