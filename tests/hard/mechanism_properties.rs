//! Do mechanisms conserve what they must, whatever they are made of? Chains of rigid and flexible bodies on random joints, the same ones
//! every time; momenta and energy are summed over the nodes of the finite elements.

use crate::random_chain::{Chain, Link, LinkBody, LinkJoint, Sums};
use dcb_formats::mesh::Dimension;
use dcb_runtime::integrator::Method;
use dcb_tests::mechanism::{method, stabilized};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Duration of a run, s.
const DURATION: f64 = 0.4;
/// Steps of the coarse run; the fine one has twice as many.
const STEPS: usize = 160;

/// The same chains every time, and no file about the last failure.
fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(20_260_702),
        max_shrink_iters: 64,
        ..ProptestConfig::default()
    }
}

fn bodies() -> impl Strategy<Value = LinkBody> {
    let radii = prop::array::uniform3(0.1..0.4_f64);
    prop_oneof![
        (2.0..20.0_f64, radii).prop_map(|(mass, radii)| LinkBody::Rigid(mass, radii)),
        (0..=4_usize).prop_map(LinkBody::Flexible),
    ]
}

fn joints() -> impl Strategy<Value = LinkJoint> {
    prop::sample::select(vec![
        LinkJoint::Ball,
        LinkJoint::Hinge,
        LinkJoint::Sleeve,
        LinkJoint::Weld,
    ])
}

fn links() -> impl Strategy<Value = Link> {
    let vector = |size: f64| prop::array::uniform3(-size..size);
    // Some component of the axis is always there.
    let axis = vector(1.0).prop_map(|[x, y, z]| [x, y, z + 2.0_f64.copysign(z)]);
    (bodies(), vector(1.5), vector(4.0), joints(), axis).prop_map(
        |(body, turn, spin, joint, axis)| Link {
            body,
            turn,
            spin,
            joint,
            axis,
        },
    )
}

/// Planar ones turn about z and are rigid.
fn flattened(link: Link) -> Link {
    let about_z = |v: [f64; 3]| [0.0, 0.0, v[2]];
    let body = match link.body {
        LinkBody::Flexible(modes) => LinkBody::Rigid(3.0 + modes as f64, [0.1, 0.3, 0.2]),
        rigid => rigid,
    };
    Link {
        body,
        turn: about_z(link.turn),
        spin: about_z(link.spin),
        ..link
    }
}

fn chains() -> impl Strategy<Value = Chain> {
    let spring = prop::option::of((50.0..400.0_f64, 0.6..1.2_f64));
    (any::<bool>(), prop::collection::vec(links(), 1..=4), spring).prop_map(
        |(planar, links, spring)| Chain {
            dimension: match planar {
                true => Dimension::Planar,
                false => Dimension::Spatial,
            },
            links: match planar {
                true => links.into_iter().map(flattened).collect(),
                false => links,
            },
            spring,
            gravity: None,
        },
    )
}

fn methods() -> impl Strategy<Value = Method> {
    prop::sample::select(vec![method(0.9), stabilized(0.9)])
}

/// Largest changes over a run: of the linear momentum, of the angular momentum by axes, of the energy; without unit.
struct Drift {
    linear: f64,
    angular: [f64; 3],
    energy: f64,
}

fn drift(chain: &Chain, method: Method, steps: usize) -> Drift {
    let mut moving = chain.start(method);
    let start = moving.sums();
    let energy = |sums: &Sums| sums.kinetic + sums.potential;
    // A chain that hangs falls a metre or so.
    let fall = chain.gravity.unwrap_or(0.0) * moving.mass();
    let scale = start.kinetic + fall + 1.0;
    let momentum = (2.0 * scale * moving.mass()).sqrt();
    let mut drift = Drift {
        linear: 0.0,
        angular: [0.0; 3],
        energy: 0.0,
    };
    for step in 0..steps {
        let stepped = moving.simulation.step(DURATION / steps as f64);
        stepped.unwrap_or_else(|error| panic!("step {step}: {error}"));
        let now = moving.sums();
        drift.linear = drift
            .linear
            .max((now.linear - start.linear).norm() / momentum);
        for axis in 0..3 {
            let change = (now.angular - start.angular)[axis].abs() / momentum;
            drift.angular[axis] = drift.angular[axis].max(change);
        }
        drift.energy = drift
            .energy
            .max((energy(&now) - energy(&start)).abs() / scale);
    }
    drift
}

/// Of second order: a quarter of it, within what higher orders leave, with half the step. What isn't conserved stays as large.
fn is_of_second_order(coarse: f64, fine: f64) -> bool {
    coarse < 0.5 && (fine < 0.4 * coarse || fine < 1e-8)
}

proptest! {
    #![proptest_config(config(48))]

    #[test]
    fn a_floating_chain_conserves_momenta_and_energy(chain in chains(), method in methods()) {
        let (coarse, fine) = (drift(&chain, method, STEPS), drift(&chain, method, 2 * STEPS));
        prop_assert!(coarse.linear < 1e-8, "linear momentum drifts by {:e}", coarse.linear);
        for (a, b) in coarse.angular.into_iter().zip(fine.angular) {
            prop_assert!(is_of_second_order(a, b), "angular momentum drifts by {:e}, {:e}", a, b);
        }
        let (a, b) = (coarse.energy, fine.energy);
        prop_assert!(is_of_second_order(a, b), "energy drifts by {:e}, {:e}", a, b);
    }

    /// Gravity is along y: it has no moment about the vertical through the ball that the chain hangs on.
    #[test]
    fn a_hung_chain_conserves_energy_and_its_spin_about_the_vertical(
        chain in chains(),
        method in methods(),
        gravity in 1.0..10.0_f64,
    ) {
        let chain = Chain { gravity: Some(gravity), ..chain };
        let (coarse, fine) = (drift(&chain, method, STEPS), drift(&chain, method, 2 * STEPS));
        let (a, b) = (coarse.energy, fine.energy);
        prop_assert!(is_of_second_order(a, b), "energy drifts by {:e}, {:e}", a, b);
        let (a, b) = (coarse.angular[1], fine.angular[1]);
        prop_assert!(is_of_second_order(a, b), "the spin about the vertical drifts by {:e}, {:e}", a, b);
    }
}
