//! Interfaces as other programs see them: frames, or nodes, with up to six displacements each.

use std::collections::{BTreeSet, HashMap};

use dcb_formats::Superelement;
use dcb_formats::component::Role;
use dcb_formats::mesh::Direction;
use nalgebra::{Matrix3, Vector3};

use crate::Axes;
use crate::part::basis::matrix3;

/// One point of an interface that has displacements.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    /// The interface's name, with the node's number where the interface has several.
    pub name: String,
    /// The same in letters, digits, `_`, `-` and `.` alone; unique.
    pub safe_name: String,
    /// Whether forces act on it.
    pub role: Role,
    /// Reference position, seen from the origin that was asked for.
    pub position: Vector3<f64>,
    /// Reference position seen from the centre of mass.
    pub arm: Vector3<f64>,
    /// Rest axes, one a column.
    pub orientation: Matrix3<f64>,
    /// Rows of ux, uy, uz, rx, ry, rz among those of the superelement.
    pub rows: [Option<usize>; 6],
    /// Node of the mesh, where the interface is one.
    pub node: Option<u32>,
}

impl Frame {
    /// Names of the directions that it lacks.
    pub(crate) fn missing(&self) -> Vec<&'static str> {
        let all = self.rows.iter().zip(Direction::NAMES);
        all.filter(|(row, _)| row.is_none())
            .map(|(_, name)| name)
            .collect()
    }

    /// Whether it has all three displacements.
    pub(crate) fn has_translations(&self) -> bool {
        self.rows[..3].iter().all(Option::is_some)
    }

    /// Whether it has all three rotations.
    pub(crate) fn has_rotations(&self) -> bool {
        self.rows[3..].iter().all(Option::is_some)
    }

    /// Displacements and rotations for one column of values over the superelement's rows; zero where it has no row.
    pub(crate) fn motion(&self, of: impl Fn(usize) -> f64) -> [f64; 6] {
        self.rows.map(|row| row.map_or(0.0, &of))
    }
}

/// All of a superelement, and the rows that belong to none because they have no place.
pub(crate) fn frames(superelement: &Superelement, axes: Axes) -> (Vec<Frame>, Vec<usize>) {
    let offset = match axes {
        Axes::Body => Vector3::zeros(),
        Axes::Component => Vector3::from(superelement.origin),
    };
    let mut found: Vec<(usize, i64, Frame)> = Vec::new();
    let mut places: HashMap<(usize, i64), usize> = HashMap::new();
    let mut placeless = Vec::new();
    for (index, row) in superelement.rows.iter().enumerate() {
        let direction = usize::try_from(row.direction).ok();
        let Some(direction) = direction.filter(|direction| *direction < 6) else {
            placeless.push(index);
            continue;
        };
        let place = *places.entry((row.interface, row.node)).or_insert_with(|| {
            let interface = &superelement.interfaces[row.interface];
            let arm = match row.node {
                0.. => Vector3::from(row.position),
                _ => Vector3::from(interface.position),
            };
            let frame = Frame {
                name: interface.name.clone(),
                safe_name: String::new(),
                role: interface.role,
                position: arm + offset,
                arm,
                orientation: matrix3(&interface.orientation),
                rows: [None; 6],
                node: u32::try_from(row.node).ok(),
            };
            found.push((row.interface, row.node, frame));
            found.len() - 1
        });
        found[place].2.rows[direction] = Some(index);
    }
    let mut count = vec![0; superelement.interfaces.len()];
    for (interface, ..) in &found {
        count[*interface] += 1;
    }
    let mut used = BTreeSet::new();
    let named = found.into_iter().map(|(interface, node, mut frame)| {
        if count[interface] > 1 {
            frame.name = format!("{}.{node}", frame.name);
        }
        frame.safe_name = safe_name(&frame.name, &mut used);
        frame
    });
    (named.collect(), placeless)
}

/// A name that no program's syntax trips over, and that wasn't used yet.
fn safe_name(name: &str, used: &mut BTreeSet<String>) -> String {
    let plain = |character: char| match character {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '_' | '-' | '.' => character,
        _ => '_',
    };
    let mut base: String = name.chars().map(plain).collect();
    if base.is_empty() {
        base.push('_');
    }
    let candidates = std::iter::once(base.clone()).chain((2..).map(|n| format!("{base}_{n}")));
    let mut free = candidates.filter(|candidate| !used.contains(candidate));
    let chosen = free.next().unwrap_or(base);
    used.insert(chosen.clone());
    chosen
}
