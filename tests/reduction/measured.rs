//! Measured modes beside computed ones: pairs, MAC, and superelements that take over what was measured.

use dcb_formats::component::Source;
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::measured::{MeasuredMode, MeasuredModes, MeasuredPlace};
use dcb_formats::mesh::Direction;
use dcb_reducer::{EnrichmentSource, Reduced, Reduction};
use dcb_samples::{PseudoRandom, bracket};
use dcb_superelement::measured::{Correlation, Measured};
use dcb_tests::{assert_says, lowest, with};

/// What a hammer test would find: all modes but some, with noise on the shapes, all frequencies `factor` times as high, in another order and with any sign.
fn measurement(reduced: &Reduced, nodes: &[u32], modes: &[usize], factor: f64) -> MeasuredModes {
    let fields = &reduced.recovery;
    let mut random = PseudoRandom::new(7);
    let directions = [Direction::Ux, Direction::Uy, Direction::Uz];
    let places: Vec<MeasuredPlace> = (nodes.iter())
        .flat_map(|node| directions.map(|direction| (node, direction)))
        .map(|(node, direction)| MeasuredPlace {
            at: node.to_string(),
            direction,
        })
        .collect();
    let mut mode = |k: usize| {
        let shape: Vec<f64> = places
            .iter()
            .map(|place| {
                let row = (fields.dofs.iter())
                    .position(|dof| {
                        dof.node.to_string() == place.at && dof.direction == place.direction
                    })
                    .unwrap();
                fields.modes[(row, k)]
            })
            .collect();
        let largest = shape
            .iter()
            .fold(0.0_f64, |most, entry| most.max(entry.abs()));
        let sign = if k.is_multiple_of(2) { -3.0 } else { 0.2 };
        MeasuredMode {
            frequency: factor * reduced.superelement.modes.eigenvalues[k].sqrt()
                / std::f64::consts::TAU,
            damping: Some(0.001 * (k + 1) as f64),
            shape: (shape.iter())
                .map(|entry| sign * (entry + 0.02 * largest * random.number()))
                .collect(),
        }
    };
    MeasuredModes {
        modes: modes.iter().map(|k| mode(*k)).collect(),
        places,
        source: Source {
            role: "measured".into(),
            file_name: "modes.csv".into(),
            sha256: "00".repeat(32),
        },
    }
}

#[test]
fn noisy_shapes_find_their_modes() {
    let component = bracket(1);
    let reduced = lowest(&component, 9);
    let nodes: Vec<u32> = (0..component.mesh.node_count() as u32)
        .step_by(37)
        .collect();
    let measured = measurement(&reduced, &nodes, &[0, 1, 3, 4, 7], 1.03);
    let found = Correlation::of(&reduced.superelement, Some(&reduced.recovery), &measured).unwrap();
    assert_eq!(found.pairs, [0, 1, 3, 4, 7].map(Some));
    let mac = found.mac.as_ref().unwrap();
    for (m, k) in [0, 1, 3, 4, 7].into_iter().enumerate() {
        assert!(mac[(m, k)] > 0.99, "{}", mac[(m, k)]);
        assert!((0..9).all(|other| other == k || mac[(m, other)] < 0.5));
    }
    // Without shapes it is the nearest frequency.
    let bare = MeasuredModes {
        places: Vec::new(),
        ..measured.clone()
    };
    let near = Correlation::of(&reduced.superelement, None, &bare).unwrap();
    assert_eq!(near.pairs.len(), 5);
    assert_eq!((near.mac, near.pairs[0]), (None, Some(0)));
    // A shape that is none of them.
    let mut strange = measured;
    let mut random = PseudoRandom::new(3);
    strange.modes[2].shape = (0..strange.places.len()).map(|_| random.number()).collect();
    let found = Correlation::of(&reduced.superelement, Some(&reduced.recovery), &strange).unwrap();
    assert_eq!(found.pairs[2], None);
}

#[test]
fn damping_and_frequencies_are_taken_over() {
    let component = bracket(1);
    let options = Reduction {
        enrichment: vec![EnrichmentSource::Spin],
        ..Reduction::lowest(6)
    };
    let reduced = with(&component, &options);
    let element = &reduced.superelement;
    let nodes: Vec<u32> = (0..component.mesh.node_count() as u32)
        .step_by(29)
        .collect();
    let measured = measurement(&reduced, &nodes, &[0, 1, 2, 3, 4, 5], 1.05);
    let found = Correlation::of(element, Some(&reduced.recovery), &measured).unwrap();
    let damped = found
        .applied(element, &measured, &[Measured::Damping])
        .unwrap();
    assert_eq!(damped.modes.eigenvalues, element.modes.eigenvalues);
    assert!(damped.moments.is_some());
    for (k, damping) in damped.modes.damping.iter().enumerate() {
        assert!((damping - 0.001 * (k + 1) as f64).abs() < 1e-15);
    }
    let both = found
        .applied(
            element,
            &measured,
            &[Measured::Damping, Measured::Frequencies],
        )
        .unwrap();
    for (new, old) in both
        .modes
        .eigenvalues
        .iter()
        .zip(&element.modes.eigenvalues)
    {
        assert!((new / old / 1.05_f64.powi(2) - 1.0).abs() < 1e-12);
    }
    // Bounds of errors are those of what was computed.
    assert!(both.moments.is_none() && both.stresses[0].omitted.is_none());
    // Its numbers don't contradict each other, further columns included.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bracket.dcb.h5");
    dcb_tests::write_bare(&path, &both);
    let read = SuperelementFile::open(&path)
        .unwrap()
        .for_dynamics()
        .unwrap();
    assert_eq!(read.modes.eigenvalues, both.modes.eigenvalues);
}

#[test]
fn what_cannot_be_is_refused() {
    let component = bracket(1);
    let reduced = lowest(&component, 5);
    let element = &reduced.superelement;
    let nodes = [0, 50, 100, 150];
    let good = measurement(&reduced, &nodes, &[0, 1, 2], 1.0);
    let refused = |measured: &MeasuredModes| {
        Correlation::of(element, Some(&reduced.recovery), measured)
            .unwrap_err()
            .to_string()
    };
    let mut far = good.clone();
    far.places[0].at = "100000".into();
    assert_says(&refused(&far), &["node 100000 has no field ux"]);
    far.places[0].at = "tipp".into();
    assert_says(
        &refused(&far),
        &["neither a node's number nor an interface", "`tip`"],
    );
    far.places[0].at = "tip".into();
    Correlation::of(element, Some(&reduced.recovery), &far).unwrap();
    let bare = Correlation::of(element, None, &good)
        .unwrap_err()
        .to_string();
    assert_says(&bare, &["the file has no nodal fields"]);
    // A measured frequency above those that weren't measured.
    let mut high = measurement(&reduced, &nodes, &[0], 1.0);
    high.modes[0].frequency *= 10.0;
    let found = Correlation::of(element, Some(&reduced.recovery), &high).unwrap();
    let error = found
        .applied(element, &high, &[Measured::Frequencies])
        .unwrap_err();
    assert_says(&error.to_string(), &["would put mode 2 below mode 1"]);
    // Nothing to take over.
    let mut undamped = good;
    for mode in &mut undamped.modes {
        mode.damping = None;
    }
    let found = Correlation::of(element, Some(&reduced.recovery), &undamped).unwrap();
    let error = found
        .applied(element, &undamped, &[Measured::Damping])
        .unwrap_err();
    assert_says(
        &error.to_string(),
        &["no mode that was paired has a measured damping"],
    );
}
