//! The shaft of a rotor: example 5.9.1 of Friswell, Penny, Garvey and Lees, "Dynamics of Rotating Machines" (2010), without its disks and bearings.

use dcb_formats::Component;
use dcb_formats::component::{Interface, InterfaceKind};

use crate::component::changed;
use crate::material::Material;
use crate::spatial_beam::{BeamSection, SpatialBeam, spatial_beam};

/// Young's modulus 211 GPa, density 7810 kg/m³.
const MATERIAL: Material = Material {
    youngs_modulus: 211e9,
    poisson_ratio: 0.3,
    density: 7810.0,
};

/// 1.5 m along x, 50 mm thick, Euler-Bernoulli elements without rotary inertia. Bearings are at `left` and `right`, disks at one and two thirds, `disk-1` and `disk-2`.
pub fn shaft(elements: usize) -> Component {
    let elements = elements.max(1).next_multiple_of(3);
    let beam = spatial_beam(&SpatialBeam {
        elements,
        end: [1.5, 0.0, 0.0],
        section: BeamSection::round(0.05),
        material: MATERIAL,
        ..SpatialBeam::default()
    });
    changed(beam, |draft| {
        draft.name = "shaft".into();
        let last = elements as u32;
        let places = [
            ("left", 0),
            ("disk-1", last / 3),
            ("disk-2", 2 * last / 3),
            ("right", last),
        ];
        let template = draft.interfaces[0].clone();
        draft.interfaces = (places.into_iter())
            .map(|(name, node)| Interface {
                name: name.into(),
                kind: InterfaceKind::Nodes,
                nodes: vec![node],
                ..template.clone()
            })
            .collect();
    })
}
