//! Warnings for numbers that hint at mixed units. Nothing here refuses anything: exotic parts exist.

use dcb_formats::component::{Component, Units};
use dcb_formats::mesh::Dimension;

use crate::frame::part_size;
use crate::rigid_body::MassProperties;

/// Densities of what parts are made of lie in here, kg/m³ (foams to osmium), over the part's bounding box.
const DENSITY: (f64, f64) = (0.05, 23_000.0);
/// Twice the first frequency times the part's length is a wave speed: below that of sound in diamond, m/s.
const FASTEST_WAVE: f64 = 20_000.0;
/// And above that of the most slender structures, m/s.
const SLOWEST_WAVE: f64 = 1e-3;

/// A unit's size in metres, kilograms or seconds, if its name is known.
pub fn si_factor(unit: &str) -> Option<f64> {
    Some(match unit {
        "m" | "kg" | "s" => 1.0,
        "mm" | "g" | "ms" => 1e-3,
        "cm" => 1e-2,
        "um" | "µm" | "us" | "µs" | "mg" => 1e-6,
        "km" | "t" | "tonne" | "Mg" => 1e3,
        "in" => 0.0254,
        "ft" => 0.3048,
        "lb" | "lbm" => 0.453_592_37,
        "slug" => 14.593_902_937_206_364,
        "slinch" | "blob" | "lbf*s^2/in" => 175.126_835_246_476_37,
        _ => return None,
    })
}

/// What looks wrong about mass, size and first frequency together.
pub fn unit_warnings(
    component: &Component,
    properties: &MassProperties,
    first_eigenvalue: Option<f64>,
) -> Vec<String> {
    let Units { length, mass, time } = &component.units;
    let (Some(metre), Some(kilogram), Some(second)) =
        (si_factor(length), si_factor(mass), si_factor(time))
    else {
        return vec![format!(
            "units {length}, {mass}, {time} are not all known by name, so they were not checked for plausibility"
        )];
    };
    let mut warnings = Vec::new();
    if component.dimension() == Dimension::Spatial {
        let volume = bounding_volume(component) * metre.powi(3);
        let density = properties.mass * kilogram / volume;
        // Parts without thickness (beams, flat shells) have no box to compare with.
        if volume > 0.0 && density > DENSITY.1 {
            warnings.push(format!(
                "a mass of {:.4e} {mass} in a box of {volume:.3e} m³ is {density:.1e} kg/m³, denser than any material: mixed units?",
                properties.mass
            ));
        } else if volume > 0.0 && density < DENSITY.0 {
            warnings.push(format!(
                "a mass of {:.4e} {mass} in a box of {volume:.3e} m³ is {density:.1e} kg/m³, lighter than a foam: mixed units?",
                properties.mass
            ));
        }
    }
    if let Some(eigenvalue) = first_eigenvalue.filter(|value| *value > 0.0) {
        let hertz = eigenvalue.sqrt() / (2.0 * std::f64::consts::PI * second);
        let wave = 2.0 * hertz * part_size(component) * metre;
        if !(SLOWEST_WAVE..=FASTEST_WAVE).contains(&wave) {
            warnings.push(format!(
                "a first frequency of {hertz:.3e} Hz for a part of {:.3e} m is a wave speed of {wave:.1e} m/s, which no material has: mixed units?",
                part_size(component) * metre
            ));
        }
    }
    warnings
}

fn bounding_volume(component: &Component) -> f64 {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for node in 0..component.mesh.node_count() as u32 {
        for (axis, x) in component.mesh.position(node).into_iter().enumerate() {
            low[axis] = low[axis].min(x);
            high[axis] = high[axis].max(x);
        }
    }
    let sides: [f64; 3] = std::array::from_fn(|axis| high[axis] - low[axis]);
    let longest = sides.iter().copied().fold(0.0, f64::max);
    if sides.iter().any(|side| *side < 1e-6 * longest) {
        0.0
    } else {
        sides.iter().product()
    }
}
