//! `reduce verify --component`: what a superelement says about the component itself, its mass, interfaces and rows.

use dcb_formats::Superelement;
use dcb_formats::component::Component;
use dcb_formats::mesh::{Dimension, Direction};

use crate::frame::{offset, part_size};
use crate::localization::Localization;
use crate::rigid_body::MassProperties;
use crate::verify::{AGREEMENT, Findings};

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
    let stored: Vec<String> = element
        .interfaces
        .iter()
        .map(|it| format!("{} ({})", it.name, it.kind.name()))
        .collect();
    let wanted: Vec<String> = localization
        .interfaces
        .iter()
        .map(|it| format!("{} ({})", it.name, it.kind.name()))
        .collect();
    let roles = || {
        element
            .interfaces
            .iter()
            .zip(&localization.interfaces)
            .all(|(a, b)| a.role == b.role)
    };
    let same_interfaces = stored == wanted && roles();
    let found = match (same_interfaces, stored == wanted) {
        (true, _) => format!("{}, the same", stored.len()),
        (false, true) => "roles differ".into(),
        (false, false) => format!(
            "{}, the component has {}",
            stored.join(", "),
            wanted.join(", ")
        ),
    };
    findings.require(
        "interfaces: names, kinds and roles",
        same_interfaces,
        &found,
    );

    let row = |interface: &str, direction: i64, node: i64| {
        let direction = usize::try_from(direction)
            .ok()
            .and_then(|d| Direction::NAMES.get(d))
            .unwrap_or(&"explicit");
        if node < 0 {
            format!("{interface} {direction}")
        } else {
            format!("{interface} node {node} {direction}")
        }
    };
    let stored: Vec<String> = element
        .rows
        .iter()
        .map(|it| {
            row(
                &element.interfaces[it.interface].name,
                it.direction,
                it.node,
            )
        })
        .collect();
    let wanted: Vec<String> = localization
        .rows
        .iter()
        .map(|it| {
            let direction = it
                .direction
                .map_or(-1, |direction| direction.index() as i64);
            row(
                &localization.interfaces[it.interface].name,
                direction,
                it.node.map_or(-1, i64::from),
            )
        })
        .collect();
    let same_rows = stored == wanted;
    let found = match stored.iter().zip(&wanted).position(|(a, b)| a != b) {
        _ if same_rows => format!("{}, the same", stored.len()),
        Some(at) => format!(
            "row {at} is {}, the component has {}",
            stored[at], wanted[at]
        ),
        None => format!("{}, the component has {}", stored.len(), wanted.len()),
    };
    findings.require("rows: interface, direction and node", same_rows, &found);
    if !(same_interfaces && same_rows) {
        return false;
    }
    let frames = element.interfaces.iter().zip(&localization.interfaces);
    let farthest = frames
        .clone()
        .map(|(a, b)| distance(a.position, offset(b.position, centre)));
    let rows = element
        .rows
        .iter()
        .zip(&localization.rows)
        .map(|(a, b)| distance(a.position, offset(b.position, centre)));
    let farthest = farthest.chain(rows).fold(0.0, f64::max);
    findings.check(
        "positions of interfaces and rows",
        farthest / part_size(component),
        AGREEMENT,
    );
    let turned = frames
        .map(|(a, b)| {
            (0..3)
                .map(|axis| distance(a.orientation[axis], b.orientation[axis]))
                .fold(0.0, f64::max)
        })
        .fold(0.0, f64::max);
    findings.check("axes of interfaces", turned, AGREEMENT);
    true
}
