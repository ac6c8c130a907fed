//! Coordinate systems, each given in another one or by grid points, down to the basic one. Angles are in degrees.

use std::collections::HashMap;

use super::cards::Card;

/// How three coordinates name a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Rectangular,
    /// Radius, angle, height.
    Cylindrical,
    /// Radius, angle from the axis, angle about it.
    Spherical,
}

/// A system as a card defines it.
#[derive(Clone, Debug, PartialEq)]
struct Definition {
    kind: Kind,
    place: Place,
}

#[derive(Clone, Debug, PartialEq)]
enum Place {
    /// Origin, a point of the third axis, a point of the half plane of the first and third, in another system.
    In(i64, [[f64; 3]; 3]),
    /// The same points by the labels of grids.
    Grids([u32; 3]),
}

/// A system in basic axes.
#[derive(Clone, Debug)]
pub(super) struct System {
    kind: Kind,
    origin: [f64; 3],
    /// Unit vectors, one a row.
    axes: [[f64; 3]; 3],
}

/// The systems of a deck.
#[derive(Debug, Default)]
pub(super) struct Systems {
    definitions: HashMap<i64, Definition>,
    known: HashMap<i64, System>,
}

impl Systems {
    /// Takes a card `CORD1R` to `CORD2S`.
    pub fn take(&mut self, card: &Card) -> Result<(), String> {
        let kind = match card.name.as_bytes().last() {
            Some(b'R') => Kind::Rectangular,
            Some(b'C') => Kind::Cylindrical,
            _ => Kind::Spherical,
        };
        if card.name.starts_with("CORD2") {
            let points = [card.point(2)?, card.point(5)?, card.point(8)?];
            let reference = card.system(1)?.unwrap_or(0);
            return self.define(card.label(0)?, kind, Place::In(reference, points));
        }
        // Two systems a card.
        for first in [0, 4] {
            if !card.field(first).is_empty() {
                let grids = [
                    card.label(first + 1)?,
                    card.label(first + 2)?,
                    card.label(first + 3)?,
                ];
                self.define(card.label(first)?, kind, Place::Grids(grids))?;
            }
        }
        Ok(())
    }

    fn define(&mut self, label: u32, kind: Kind, place: Place) -> Result<(), String> {
        let definition = Definition { kind, place };
        match self
            .definitions
            .insert(i64::from(label), definition.clone())
        {
            Some(before) if before != definition => Err(format!(
                "coordinate system {label} stands twice, with different numbers"
            )),
            _ => Ok(()),
        }
    }

    /// Finds all systems in basic axes. `grid` gives the system and coordinates of a grid.
    ///
    /// # Errors
    /// A system that isn't there, that needs itself, or whose points are on a line.
    pub fn resolve(&mut self, grid: impl Fn(u32) -> Option<(i64, [f64; 3])>) -> Result<(), String> {
        let mut open = HashMap::new();
        let labels: Vec<i64> = self.definitions.keys().copied().collect();
        for label in labels {
            let mut stack = vec![label];
            while let Some(&at) = stack.last() {
                if self.known.contains_key(&at) {
                    stack.pop();
                    continue;
                }
                let definition = self.definition(at)?;
                let points = points_of(at, &definition.place, &grid)?;
                let missing: Vec<i64> = (points.iter().map(|(system, _)| *system))
                    .filter(|system| *system != 0 && !self.known.contains_key(system))
                    .collect();
                if missing.is_empty() {
                    let system = self.system(at, definition.kind, points)?;
                    self.known.insert(at, system);
                    stack.pop();
                } else if open.insert(at, ()).is_some() {
                    return Err(format!("coordinate system {at} is defined by itself"));
                } else {
                    stack.extend(missing);
                }
            }
        }
        Ok(())
    }

    fn definition(&self, label: i64) -> Result<&Definition, String> {
        (self.definitions.get(&label))
            .ok_or_else(|| format!("coordinate system {label} is named, but isn't there"))
    }

    fn system(
        &self,
        label: i64,
        kind: Kind,
        points: [(i64, [f64; 3]); 3],
    ) -> Result<System, String> {
        let mut basic = [[0.0; 3]; 3];
        for (point, (system, coordinates)) in basic.iter_mut().zip(points) {
            *point = self.point(system, coordinates)?;
        }
        let [origin, on_axis, in_plane] = basic;
        let z = unit(minus(on_axis, origin));
        let y = z.and_then(|z| unit(cross(z, minus(in_plane, origin))));
        let (Some(z), Some(y)) = (z, y) else {
            return Err(format!(
                "the three points of coordinate system {label} are on a line"
            ));
        };
        Ok(System {
            kind,
            origin,
            axes: [cross(y, z), y, z],
        })
    }

    /// A point in basic axes.
    ///
    /// # Errors
    /// A system that isn't there.
    pub fn point(&self, system: i64, coordinates: [f64; 3]) -> Result<[f64; 3], String> {
        match self.get(system)? {
            None => Ok(coordinates),
            Some(system) => Ok(system.point(coordinates)),
        }
    }

    /// Axes of displacements of a node at a point in basic axes; `None` for the basic axes.
    ///
    /// # Errors
    /// A system that isn't there.
    pub fn axes(&self, system: i64, point: [f64; 3]) -> Result<Option<[[f64; 3]; 3]>, String> {
        Ok(self.get(system)?.map(|system| system.axes_at(point)))
    }

    /// `None` is the basic one.
    fn get(&self, system: i64) -> Result<Option<&System>, String> {
        match (system, self.known.get(&system)) {
            (0, _) => Ok(None),
            (_, Some(known)) => Ok(Some(known)),
            _ => Err(format!(
                "coordinate system {system} is named, but isn't there"
            )),
        }
    }
}

/// The three points of a definition, each in its system.
fn points_of(
    label: i64,
    place: &Place,
    grid: impl Fn(u32) -> Option<(i64, [f64; 3])>,
) -> Result<[(i64, [f64; 3]); 3], String> {
    match place {
        Place::In(system, points) => Ok(points.map(|point| (*system, point))),
        Place::Grids(labels) => {
            let mut points = [(0, [0.0; 3]); 3];
            for (point, node) in points.iter_mut().zip(labels) {
                *point = grid(*node).ok_or_else(|| {
                    format!("coordinate system {label} names grid {node}, which isn't there")
                })?;
            }
            Ok(points)
        }
    }
}

impl System {
    fn point(&self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        let local = match self.kind {
            Kind::Rectangular => [a, b, c],
            Kind::Cylindrical => {
                let angle = b.to_radians();
                [a * angle.cos(), a * angle.sin(), c]
            }
            Kind::Spherical => {
                let (polar, around) = (b.to_radians(), c.to_radians());
                let [x, y] = [around.cos(), around.sin()].map(|part| a * polar.sin() * part);
                [x, y, a * polar.cos()]
            }
        };
        let along = combined(&self.axes, local);
        [0, 1, 2].map(|axis| self.origin[axis] + along[axis])
    }

    /// Directions in which the three coordinates grow, at a point. On the axis the angle about it counts as 0.
    fn axes_at(&self, point: [f64; 3]) -> [[f64; 3]; 3] {
        let from_origin = minus(point, self.origin);
        let [x, y, z] = self.axes.map(|axis| dot(axis, from_origin));
        let around = y.atan2(x);
        let (sin, cos) = around.sin_cos();
        let rows = match self.kind {
            Kind::Rectangular => return self.axes,
            Kind::Cylindrical => [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]],
            Kind::Spherical => {
                let (up, along) = x.hypot(y).atan2(z).sin_cos();
                [
                    [up * cos, up * sin, along],
                    [along * cos, along * sin, -up],
                    [-sin, cos, 0.0],
                ]
            }
        };
        rows.map(|row| combined(&self.axes, row))
    }
}

/// Axes, each so many times.
fn combined(axes: &[[f64; 3]; 3], times: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|at| axes[0][at] * times[0] + axes[1][at] * times[1] + axes[2][at] * times[2])
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `None` for nothing that has a direction.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|part| part / length))
}
