//! Does `docs/format.md` say truly which changes of which dataset are noticed, and is nothing noticed where nothing is wrong?

mod table;

use crate::contradictions::table::table;
use dcb_formats::component::{ComponentDraft, InterfaceKind, NamedLoad, Role};
use dcb_formats::identities::{at_load, in_full};
use dcb_formats::{Component, Superelement};
use dcb_reducer::{EnrichmentSource, EstimateChoice, Grounding, InterfaceModes, Reduction};
use dcb_samples::hard::grounded_block;
use dcb_samples::{RodSection, SolidElement, axial_prestress, planar_rod};
use dcb_superelement::selection::{InterfaceSelection, Selection};
use dcb_tests::pages::between;
use dcb_tests::parts::{beam, interface, rod, steel_box, with_interfaces};
use dcb_tests::with;

const MARKERS: [&str; 2] = [
    "<!-- what is noticed -->\n",
    "<!-- end of what is noticed -->\n",
];

fn enriched(count: usize) -> Reduction {
    Reduction {
        enrichment: vec![EnrichmentSource::Spin, EnrichmentSource::Krylov],
        ..Reduction::lowest(count)
    }
}

/// A box held by two frames, with a node that is watched.
fn block() -> Component {
    let part = steel_box([4, 2, 2], SolidElement::Hexahedron);
    let mut interfaces = part.interfaces.clone();
    let mut watched = interface("watched", InterfaceKind::Nodes, vec![17]);
    watched.role = Role::Output;
    interfaces.push(watched);
    interfaces.push(interface("node", InterfaceKind::Nodes, vec![22]));
    with_interfaces(&part, interfaces)
}

/// A planar rod with a load on its inside, geometric stiffness and component masses.
fn loaded_rod() -> Component {
    let section = RodSection {
        angle: 0.4,
        ..RodSection::default()
    };
    let rod = planar_rod(6, &section);
    let forces = (0..rod.dofs.len()).map(|dof| ((dof * dof) % 7) as f64 - 2.0);
    Component::checked(ComponentDraft {
        loads: vec![NamedLoad {
            name: "push".into(),
            forces: forces.collect(),
        }],
        geometric_stiffness: Some(axial_prestress(&rod, section.density * section.area)),
        ..rod.into_draft()
    })
    .unwrap()
}

/// As `reduce` makes them from solids and from beams with component masses.
fn complete() -> Vec<Superelement> {
    let all = Reduction {
        enrichment: EnrichmentSource::ALL.to_vec(),
        ..Reduction::lowest(3)
    };
    vec![
        with(&block(), &enriched(5)).superelement,
        with(&block(), &Reduction::lowest(8)).superelement,
        with(&loaded_rod(), &all).superelement,
    ]
}

/// Beams without component masses, without the error estimate, and without a word of where they come from.
fn bare() -> Vec<Superelement> {
    use dcb_samples::spatial_beam::{BeamMass, BeamTheory};
    let nodal = |part: Component| {
        Component::checked(ComponentDraft {
            component_masses: None,
            ..part.into_draft()
        })
        .unwrap()
    };
    let without = |count: usize| Reduction {
        estimate: EstimateChoice::LeftOut,
        ..Reduction::lowest(count)
    };
    let spatial = nodal(beam(6, BeamTheory::Timoshenko, BeamMass::Consistent));
    [(spatial, 4), (nodal(rod(6)), 3)]
        .into_iter()
        .map(|(part, count)| {
            let mut element = with(&part, &without(count)).superelement;
            element.provenance = Default::default();
            element.derivation = None;
            element
        })
        .collect()
}

#[test]
fn the_page_says_what_is_noticed() {
    let said = between("format.md", MARKERS);
    let expected = format!(
        "Files as `reduce` writes them:\n\n{}\nBeams without component masses, error estimate and provenance:\n\n{}",
        table(&complete()),
        table(&bare())
    );
    assert!(said == expected, "paste this:\n{expected}");
}

#[test]
fn nothing_is_noticed_where_nothing_is_wrong() {
    let mut all = complete();
    all.extend(bare());
    let held = Reduction {
        grounding: Grounding::Allow,
        ..enriched(4)
    };
    all.push(with(&grounded_block(), &held).superelement);
    for count in [2, 5] {
        let fewer = Reduction {
            interface_modes: InterfaceModes::Softest(count),
            ..enriched(3)
        };
        all.push(with(&block(), &fewer).superelement);
    }
    // Selections: fewer modes, interfaces watched instead of loaded, or dropped.
    let whole = all[1].clone();
    let names: Vec<String> = whole
        .interfaces
        .iter()
        .map(|frame| frame.name.clone())
        .collect();
    let everything = || Selection::everything(&whole);
    for selection in [
        everything().with_modes([0, 2, 3]).unwrap(),
        everything()
            .with_interface(&names[1], InterfaceSelection::Observed)
            .unwrap(),
        everything()
            .with_modes([1, 4])
            .unwrap()
            .with_interface(&names[3], InterfaceSelection::Dropped)
            .unwrap(),
        everything()
            .with_enrichment(&[])
            .unwrap()
            .with_attachments(4),
    ] {
        all.push(selection.superelement(&whole).unwrap());
    }
    for (case, element) in all.iter().enumerate() {
        for identity in at_load(element).into_iter().chain(in_full(element)) {
            // An order of magnitude is left everywhere but where nodes stand for integrals.
            let margin = if identity.limit > 1.0 { 1.0 } else { 0.1 };
            assert!(
                identity.defect <= margin * identity.limit,
                "case {case}, {}: {identity:?}",
                element.name
            );
        }
    }
}
