//! Is no mode missing, whichever way that is known: by the search's random start, by a Sturm sequence check, by dense algebra?

use dcb_formats::Component;
use dcb_reducer::{Grounding, LoosePieces, Proof, ProofChoice, Reduction};
use dcb_samples::spatial_beam::{BeamMass, BeamTheory};
use dcb_samples::{SolidElement, bracket, connecting_rod, hard};
use dcb_tests::oracle::Oracle;
use dcb_tests::{parts, with};

fn counted(component: &Component, options: Reduction) {
    let options = Reduction {
        proof: ProofChoice::Count,
        ..options
    };
    let count = with(component, &options).quality.mode_count;
    assert_eq!(count.proof, Proof::Inertia, "{}", component.name);
    assert_eq!(count.counted, count.found, "{}", component.name);
}

#[test]
fn the_random_start_proves_what_a_count_finds() {
    let solid = SolidElement::Hexahedron20;
    let parts = [
        (parts::steel_box([8, 3, 2], solid), 12),
        (parts::steel_box([10, 3, 2], SolidElement::Hexahedron), 20),
        (
            parts::moved(&parts::steel_box([8, 3, 2], solid), [1e3; 3]),
            9,
        ),
        (hard::thin_plate(), 10),
        (hard::slender_block(), 8),
        (hard::square_block(), 12),
        (hard::symmetric_ring(8), 9),
        (connecting_rod(1), 30),
        (bracket(4), 20),
        (parts::rotor(), 10),
        (
            parts::beam(40, BeamTheory::Timoshenko, BeamMass::Consistent),
            10,
        ),
    ];
    let mut proven = 0;
    for (component, modes) in parts {
        let options = Reduction::lowest(modes);
        let count = with(&component, &options).quality.mode_count;
        println!("{}: {count:?}", component.name);
        assert_eq!(count.counted, count.found, "{}", component.name);
        proven += usize::from(count.proof == Proof::RandomStart);
        if component.dofs.len() < 1500 {
            let (oracle, limit) = (Oracle::of(&component), count.limit.unwrap());
            let below = oracle.eigenvalues.iter().filter(|value| **value < limit);
            assert_eq!(count.found - 6, below.count(), "{}", component.name);
        }
        counted(&component, options);
    }
    assert!(proven >= 8, "{proven}");
    let held = Reduction {
        grounding: Grounding::Allow,
        ..Reduction::lowest(8)
    };
    let count = with(&hard::grounded_block(), &held).quality.mode_count;
    assert_eq!((count.counted, count.proof), (8, Proof::RandomStart));
    counted(&hard::grounded_block(), held);
}

/// A search can't prove that a root has no more copies than its block has columns, nor anything where motions have no mass or a basis was started anew. Then it is counted.
#[test]
fn where_the_random_start_proves_nothing_modes_are_counted() {
    let (oscillators, root) = parts::with_oscillators(18);
    let few = SolidElement::Hexahedron;
    let loose = parts::side_by_side(&[
        parts::steel_box([3, 1, 1], few),
        parts::steel_box([3, 1, 1], few),
    ]);
    let massless = parts::beam(12, BeamTheory::EulerBernoulli, BeamMass::LumpedWithRoll);
    for (component, modes) in [(oscillators, 60), (loose, 6), (massless, 500)] {
        let options = Reduction {
            loose_pieces: LoosePieces::Allow,
            ..Reduction::lowest(modes)
        };
        let count = with(&component, &options).quality.mode_count;
        println!("{}: {count:?}", component.name);
        assert_eq!(count.counted, count.found, "{}", component.name);
        assert_eq!(count.proof, Proof::Inertia, "{}", component.name);
        // All copies of the oscillators' root are among them.
        assert!(modes != 60 || count.limit.unwrap() > root);
    }
}
