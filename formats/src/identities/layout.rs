//! Where interfaces and their rows are.

use super::scaled::larger;
use super::{AGREEMENT, Identity};
use crate::component::InterfaceKind;
use crate::superelement::Superelement;

pub(super) fn in_full(of: &Superelement) -> Vec<Identity> {
    let size = of
        .rows
        .iter()
        .flat_map(|row| row.position)
        .chain(of.interfaces.iter().flat_map(|frame| frame.position))
        .fold(f64::MIN_POSITIVE, |most, place| most.max(place.abs()));
    let distance = |a: &[f64; 3], b: &[f64; 3]| {
        (0..3).fold(0.0, |most, axis| {
            larger(most, (a[axis] - b[axis]).abs() / size)
        })
    };
    let mut of_frames = 0.0;
    let mut of_nodes = 0.0;
    for (index, row) in of.rows.iter().enumerate() {
        let frame = &of.interfaces[row.interface];
        let is_one_node = || {
            let mut rows = of
                .rows
                .iter()
                .filter(|other| other.interface == row.interface);
            frame.kind == InterfaceKind::Nodes && rows.all(|other| other.node == row.node)
        };
        if matches!(frame.kind, InterfaceKind::Average | InterfaceKind::Rigid) || is_one_node() {
            of_frames = larger(of_frames, distance(&row.position, &frame.position));
        }
        let same = of.rows[..index]
            .iter()
            .rev()
            .find(|other| row.node >= 0 && other.node == row.node);
        if let Some(other) = same {
            of_nodes = larger(of_nodes, distance(&row.position, &other.position));
        }
    }
    vec![
        Identity {
            path: "/interfaces/positions",
            what: "rows of frames and of single nodes are where their interface is",
            defect: of_frames,
            limit: AGREEMENT,
        },
        Identity {
            path: "/interfaces/row_positions",
            what: "rows of one node are at one place",
            defect: of_nodes,
            limit: AGREEMENT,
        },
    ]
}
