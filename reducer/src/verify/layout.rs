//! `reduce verify --component`: what a superelement says about the component itself, its mass, interfaces and rows.

use dcb_formats::Superelement;
use dcb_formats::component::{Component, InterfaceKind};
use dcb_formats::mesh::{Dimension, Direction};

use super::findings::{AGREEMENT, Findings};
use crate::model::frame::{offset, part_size};
use crate::model::localization::Localization;
use crate::model::rigid_body::MassProperties;

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    offset(a, b).iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Mass, centre and inertia tensor.
pub fn check_mass_properties(
    element: &Superelement,
    component: &Component,
    properties: &MassProperties,
    findings: &mut Findings,
) {
    let mass_defect = (properties.mass - element.inertia.mass).abs() / properties.mass;
    findings.check("mass", mass_defect, AGREEMENT);
    findings.check(
        "centre of mass",
        distance(properties.centre, element.origin) / part_size(component),
        AGREEMENT,
    );
    let axes = match element.dimension {
        Dimension::Planar => 2..3,
        Dimension::Spatial => 0..3,
    };
    let pairs = || axes.clone().flat_map(|a| axes.clone().map(move |b| (a, b)));
    let largest = pairs()
        .map(|(a, b)| properties.tensor[a][b].abs())
        .fold(0.0, f64::max);
    let defect = pairs()
        .map(|(a, b)| (properties.tensor[a][b] - element.inertia.tensor[a][b]).abs())
        .fold(0.0, f64::max);
    findings.check(
        "inertia tensor",
        defect / largest.max(f64::MIN_POSITIVE),
        AGREEMENT,
    );
}

/// Interfaces and rows; where they differ, matrices over the rows can't be compared.
pub fn has_same_layout(
    element: &Superelement,
    component: &Component,
    localization: &Localization,
    centre: [f64; 3],
    findings: &mut Findings,
) -> bool {
    let same_interfaces = has_same_interfaces(element, localization, findings);
    let same_rows = has_same_rows(element, localization, findings);
    if same_interfaces && same_rows {
        check_places(element, component, localization, centre, findings);
    }
    same_interfaces && same_rows
}

fn has_same_interfaces(
    element: &Superelement,
    localization: &Localization,
    findings: &mut Findings,
) -> bool {
    let named = |name: &str, kind: InterfaceKind| format!("{name} ({})", kind.name());
    let stored = element.interfaces.iter();
    let stored: Vec<String> = stored.map(|it| named(&it.name, it.kind)).collect();
    let wanted = localization.interfaces.iter();
    let wanted: Vec<String> = wanted.map(|it| named(&it.name, it.kind)).collect();
    let mut pairs = element.interfaces.iter().zip(&localization.interfaces);
    let same_names = stored == wanted;
    let same = same_names && pairs.all(|(a, b)| a.role == b.role);
    let found = match (same, same_names) {
        (true, _) => format!("{}, the same", stored.len()),
        (false, true) => "roles differ".into(),
        (false, false) => format!(
            "{}, the component has {}",
            stored.join(", "),
            wanted.join(", ")
        ),
    };
    findings.require("interfaces: names, kinds and roles", same, &found);
    same
}

fn has_same_rows(
    element: &Superelement,
    localization: &Localization,
    findings: &mut Findings,
) -> bool {
    let row = |interface: &str, direction: i64, node: i64| {
        let direction = usize::try_from(direction)
            .ok()
            .and_then(|d| Direction::NAMES.get(d))
            .unwrap_or(&"explicit");
        match node {
            ..0 => format!("{interface} {direction}"),
            node => format!("{interface} node {node} {direction}"),
        }
    };
    let stored = element.rows.iter().map(|it| {
        let interface = &element.interfaces[it.interface].name;
        row(interface, it.direction, it.node)
    });
    let wanted = localization.rows.iter().map(|it| {
        let interface = &localization.interfaces[it.interface].name;
        let direction = it.direction.map_or(-1, |d| d.index() as i64);
        row(interface, direction, it.node.map_or(-1, i64::from))
    });
    let (stored, wanted): (Vec<String>, Vec<String>) = (stored.collect(), wanted.collect());
    let same = stored == wanted;
    let found = match stored.iter().zip(&wanted).position(|(a, b)| a != b) {
        _ if same => format!("{}, the same", stored.len()),
        Some(at) => format!(
            "row {at} is {}, the component has {}",
            stored[at], wanted[at]
        ),
        None => format!("{}, the component has {}", stored.len(), wanted.len()),
    };
    findings.require("rows: interface, direction and node", same, &found);
    same
}

fn check_places(
    element: &Superelement,
    component: &Component,
    localization: &Localization,
    centre: [f64; 3],
    findings: &mut Findings,
) {
    let frames = || element.interfaces.iter().zip(&localization.interfaces);
    let of_frames = frames().map(|(a, b)| distance(a.position, offset(b.position, centre)));
    let rows = element.rows.iter().zip(&localization.rows);
    let of_rows = rows.map(|(a, b)| distance(a.position, offset(b.position, centre)));
    let farthest = of_frames.chain(of_rows).fold(0.0, f64::max);
    findings.check(
        "positions of interfaces and rows",
        farthest / part_size(component),
        AGREEMENT,
    );
    let axes = frames().flat_map(|(a, b)| a.orientation.iter().zip(&b.orientation));
    let turned = axes.map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max);
    findings.check("axes of interfaces", turned, AGREEMENT);
}
