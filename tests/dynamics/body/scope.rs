//! Whether the energy above the frequency that a superelement was made for is found as it is.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::support::Part;
use crate::support::mechanisms::method;
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_runtime::integrator::Formulation;
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, SystemBuilder};
use dcb_runtime::watch::applicability::{BeyondScope, Scope};
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::{RodSection, planar_rod};
use dcb_superelement::LeftOutBy;
use dcb_superelement::selection::{InterfaceSelection, Selection};
use nalgebra::Vector3;

/// A free rod of three modes and its attachments.
fn rod() -> Part {
    Part::reduced(planar_rod(8, &RodSection::default()), 3)
}

/// What is told of a free body whose coordinates start with these rates, each vibrating by itself.
fn vibrating(body: &FlexibleBody, rates: &[(usize, f64)]) -> Vec<BeyondScope> {
    let fastest = rates.iter().map(|(k, _)| body.stiffness[*k].sqrt());
    let fastest = fastest.fold(0.0, f64::max);
    let slowest = body.stiffness[0].sqrt();
    let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::zeros());
    builder.body("rod", Arc::new(body.clone()), &Drawn::default());
    let (system, mut state) = builder.finish();
    for (k, rate) in rates {
        state.velocities[6 + k] = *rate;
    }
    let method = method(Formulation::Index3, 0.9);
    let (mut simulation, _) =
        Simulation::start(system, state, method, RedundantConstraints::MinimumNorm).unwrap();
    let mut scope = Scope::of(simulation.system());
    let (end, step) = (20.0 * TAU / slowest, TAU / fastest / 60.0);
    for _ in 0..(end / step) as usize {
        simulation.refresh();
        scope.observe_motion(simulation.system(), simulation.state());
        simulation.step(step).unwrap();
    }
    scope.found(simulation.system())
}

/// The number of per cent that a message begins with.
fn percent(found: &[BeyondScope]) -> f64 {
    assert_eq!(found.len(), 1, "{found:?}");
    let number = found[0].message.split(' ').next().unwrap();
    number.parse().unwrap()
}

#[test]
fn the_energy_of_free_vibrations_is_shared_as_it_was_given() {
    let mut body = rod().body;
    body.damping.fill(0.0);
    let limit = body.made_for.frequency.unwrap();
    assert_eq!(limit.by, LeftOutBy::Reduction);
    let omitted = (TAU * limit.frequency).powi(2);
    assert!((omitted / body.first_omitted_eigenvalue - 1.0).abs() < 1e-12);
    // Three modes below, the softest attachment above.
    let attached = body.mode_count;
    assert!(body.stiffness[attached - 1] < omitted && body.stiffness[attached] > omitted);
    let small = 1e-5 * body.inertia.mass().sqrt() * body.stiffness[0].sqrt();
    assert!(vibrating(&body, &[(0, small), (1, small)]).is_empty());
    // Energies as 9 to 1, 1 to 1, and 100 to 1.
    let found = vibrating(&body, &[(0, 3.0 * small), (attached, small)]);
    assert!((percent(&found) - 10.0).abs() <= 1.0, "{found:?}");
    assert!(found[0].message.contains("reduce the part with more modes"));
    let found = vibrating(&body, &[(1, small), (attached, small)]);
    assert!((percent(&found) - 50.0).abs() <= 1.0, "{found:?}");
    assert!(vibrating(&body, &[(0, 10.0 * small), (attached, small)]).is_empty());
}

/// A selection for a band says so, and modes that it leaves out because they don't take part are no limit.
#[test]
fn selections_say_up_to_which_frequency_they_are_good() {
    let part = rod();
    let whole = &part.reduced.superelement;
    let made = |selection: Selection| {
        let small = selection.superelement(whole).unwrap();
        let body = FlexibleBody::from_superelement(&small, Compatibility::Strong).unwrap();
        body.made_for
    };
    let lowest = |modes: &[usize]| {
        let all = Selection::everything(whole);
        all.with_modes(modes.iter().copied()).unwrap()
    };
    let limit = |selection: Selection| made(selection).frequency.unwrap();
    let cycles = |square: f64| square.sqrt() / TAU;
    let squares = &whole.modes.eigenvalues;
    let zero = squares.iter().take_while(|square| **square <= 0.0).count();
    assert_eq!(zero, 0, "free modes aren't among them");
    // Nobody said for what the second mode was left out.
    let without = limit(lowest(&[0, 2]));
    assert_eq!(without.by, LeftOutBy::Reduction);
    assert!((without.frequency / cycles(squares[1]) - 1.0).abs() < 1e-12);
    // It doesn't take part up to here.
    let band = 0.5 * cycles(squares[2]);
    let for_band = limit(lowest(&[0, 2]).up_to(Some(band)));
    assert_eq!(
        (for_band.by, for_band.frequency),
        (LeftOutBy::Selection, band)
    );
    let beyond = limit(lowest(&[0, 2]).up_to(Some(1e9)));
    assert_eq!(beyond.by, LeftOutBy::Reduction);
    let omitted = cycles(whole.modes.first_omitted_eigenvalue);
    assert!((beyond.frequency / omitted - 1.0).abs() < 1e-12);
    // Directions of force are listed for the interface that has them.
    let along = InterfaceSelection::along(whole, 1, &[dcb_formats::mesh::Direction::Ux]);
    let name = whole.interfaces[1].name.clone();
    let directions = made(lowest(&[0, 1, 2]).with_interface(&name, along).unwrap()).directions;
    assert_eq!(directions.len(), 1);
    assert_eq!(directions[0].interface, 1);
    assert_eq!(directions[0].forces[(0, 0)], 1.0);
}

/// A slow vibration looked at where it passes through zero has nothing but kinetic energy there, as something infinitely fast has. Four such
/// states of eighty periods tell nothing.
#[test]
fn a_few_states_tell_nothing() {
    let body = rod().body;
    let limit = body.made_for.frequency.unwrap();
    let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::zeros());
    builder.body("rod", Arc::new(body.clone()), &Drawn::default());
    let (system, mut state) = builder.finish();
    let period = TAU / body.stiffness[0].sqrt();
    state.velocities[6] = 1.0;
    let mut scope = Scope::of(&system);
    for index in 0..5 {
        state.time = 20.0 * period * f64::from(index);
        scope.observe_motion(&system, &state);
    }
    assert!(state.time * limit.frequency > 100.0);
    assert!(
        scope.found(&system).is_empty(),
        "{:?}",
        scope.found(&system)
    );
}
