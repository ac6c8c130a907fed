//! Evaluating a body's inertia and forces takes no memory, and neither does a step.

use crate::support;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use std::sync::Arc;

use crate::support::Part;
use crate::support::mechanisms::{about_z, method};
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_runtime::integrator::radau::{Accuracy, Stages};
use dcb_runtime::integrator::{Formulation, Rule};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use dcb_runtime::{BodyAcceleration, BodyState, InertiaForces, InertiaTangent};
use dcb_samples::{SpatialBeam, spatial_beam};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn evaluation_does_not_allocate() {
    for (name, part) in support::parts() {
        let n = part.body.coordinate_count();
        let (y, rates) = (support::numbers(n, 1), support::numbers(n, 2));
        let (spin, still) = (part.spin(Vector3::new(1.0, 2.0, 3.0)), Vector3::zeros());
        let mut terms = part.terms();
        let mut forces = vec![0.0; n];
        let mut inertia_forces = InertiaForces::for_coordinates(n);
        let mut tangent = InertiaTangent::for_coordinates(n);
        let (mut damping, mut stiffness) = (Mat::zeros(n, n), Mat::zeros(n, n));
        let state = BodyState {
            y: &y,
            rates: &rates,
            spin,
        };
        let acceleration = BodyAcceleration {
            origin: still,
            spin_rate: spin,
            second_rates: &rates,
        };
        let inertia = &part.body.inertia;
        let attachment = part.body.attachment(0);
        let before = ALLOCATIONS.get();
        part.body.inertia.evaluate(&y, &spin, &rates, &mut terms);
        let energy = terms.kinetic_energy(part.body.inertia.mass(), &still, &spin, &rates)
            + part.body.strain_energy(&y);
        part.body.internal_forces(&y, &rates, &mut forces);
        inertia.evaluate_forces(&state, &acceleration, &mut terms, &mut inertia_forces);
        inertia.evaluate_tangent(&state, &acceleration, &terms, &mut tangent);
        inertia.write_elastic_tangent(&spin, &spin, damping.as_mut(), stiffness.as_mut());
        if let Ok(attachment) = &attachment {
            let (u, turn) = attachment.products(&y);
            attachment.add_forces(&u, &turn, &mut forces);
        }
        // Whether the inertia is positive at such a deflection doesn't matter here.
        let _ = terms.accelerations(part.body.inertia.dimension(), &still, &mut forces);
        assert_eq!(ALLOCATIONS.get(), before, "{name}");
        assert!(energy.is_finite());
    }
}

/// A chain of beams; three have a dense system of joints, eight a sparse one.
#[test]
fn steps_do_not_allocate() {
    let part = Part::reduced(spatial_beam(&SpatialBeam::default()), 6);
    let body = Arc::new(part.body);
    let [a, b] = [0, 1].map(|index| body.attachment(index).unwrap().position);
    let radau = Rule::from(Accuracy {
        tolerance: 1e-5,
        of_forces: 1e-4,
        stages: Stages::Three,
        longest: f64::INFINITY,
        horizon: 1.0,
    });
    for (count, rule) in [
        (3, method(Formulation::Index3, 0.8).into()),
        (8, method(Formulation::Index3, 0.8).into()),
        (3, method(Formulation::StabilizedIndex2, 0.8).into()),
        (3, radau),
        (8, radau),
    ] {
        let gravity = Vector3::new(0.0, -9.81, 0.0);
        let mut builder = SystemBuilder::new(Dimension::Spatial, gravity);
        let mut previous = builder.ground(Vector3::zeros(), Matrix3::identity());
        for link in 0..count {
            let position = (b - a) * f64::from(link) - a - Vector3::from(body.origin);
            let drawn = Drawn {
                position,
                ..Drawn::default()
            };
            let index = builder.body(&format!("link {link}"), body.clone(), &drawn);
            let first = builder.marker(index, 0, Turning::Interface).unwrap();
            let joint = format!("joint {link}");
            builder.joint(&joint, previous, first, &about_z()).unwrap();
            previous = builder.marker(index, 1, Turning::Interface).unwrap();
        }
        let (system, state) = builder.finish();
        let started = Simulation::start(system, state, rule, RedundantConstraints::MinimumNorm);
        let (mut simulation, _) = started.unwrap();
        // The first steps make room for what later factors fill in; a change of the step asks for a new factor.
        let step = |index: u32| {
            if (index / 10).is_multiple_of(2) {
                1e-4
            } else {
                0.8e-4
            }
        };
        for index in 0..40 {
            simulation.step(step(index)).unwrap();
        }
        let before = ALLOCATIONS.get();
        let (_, start) = simulation.effort();
        for index in 0..200 {
            simulation.step(step(index)).unwrap();
        }
        let (_, end) = simulation.effort();
        assert_eq!(ALLOCATIONS.get(), before, "{count} links");
        assert!(
            end.factorizations > start.factorizations,
            "{count} links: nothing was factored"
        );
    }
}
