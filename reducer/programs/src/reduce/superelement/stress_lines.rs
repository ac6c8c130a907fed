//! Stress fields of a superelement for people.

use std::fmt::Write as _;

use dcb_formats::Superelement;
use dcb_formats::scene::Compatibility;
use dcb_formats::terminal::one_line;
use dcb_formats::units::written_frequency;
use dcb_superelement::{ErrorBounds, stress_errors};

/// A part of the first omitted frequency at which errors of stresses are told.
const STRESS_BAND: f64 = 0.25;

/// Stress fields, and how far they are off at a quarter of the first omitted frequency.
pub fn stress_lines(element: &Superelement) -> String {
    if element.stresses.is_empty() {
        return String::new();
    }
    let bounds = ErrorBounds::of(element, Compatibility::Strong)
        .ok()
        .flatten();
    let square = bounds
        .as_ref()
        .map(|bounds| STRESS_BAND.powi(2) * bounds.eigenvalue_bound());
    let errors = bounds
        .zip(square.filter(|square| square.is_finite()))
        .and_then(|(bounds, square)| Some((stress_errors(element, &bounds, square).ok()?, square)));
    let mut text = String::new();
    for (index, field) in element.stresses.iter().enumerate() {
        let components: Vec<&str> = field.components.iter().map(|one| one.name()).collect();
        let places = match field.points.len() {
            1 => "1 place".to_owned(),
            count => format!("{count} places"),
        };
        let error = errors.as_ref().and_then(|(errors, square)| {
            let frequency =
                written_frequency(square.sqrt() / std::f64::consts::TAU, &element.units.time);
            Some(format!(
                "; off by at most {:.1e} of its largest static value at {frequency}",
                errors[index]?
            ))
        });
        let _ = writeln!(
            text,
            "stress   {}: {} at {places}, {}{}",
            one_line(&field.name),
            field.quantity.name(),
            components.join(" "),
            error.unwrap_or_default()
        );
    }
    text
}
