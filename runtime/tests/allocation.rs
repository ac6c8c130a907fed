//! Evaluating a body's inertia and forces takes no memory.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use dcb_runtime::{BodyAcceleration, BodyState, InertiaForces, InertiaTangent};
use faer::Mat;
use nalgebra::Vector3;

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
    for (name, part) in common::parts() {
        let n = part.body.coordinate_count();
        let (y, rates) = (common::numbers(n, 1), common::numbers(n, 2));
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
