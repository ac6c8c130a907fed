//! Triangles of solids, for viewers that know nothing else.

use std::f64::consts::{PI, TAU};

use nalgebra::{Rotation3, Vector3};

use crate::arrays::Arrays;
use crate::description::Form;
use crate::triangles::Triangles;

/// Corners of a circle.
const ROUND: usize = 32;
/// Rings of a ball, with its poles.
const RINGS: usize = 16;
/// Radius of a ball that has none, over the size of the page.
const BALL: f64 = 0.02;
/// Radius of the balls at the ends of rods over that of the rods.
const JOINT: f64 = 1.25;

/// The triangles of a form in its own axes; `size` is that of the page.
pub fn triangles_of(form: &Form, size: f64, arrays: &Arrays) -> Triangles {
    match form {
        Form::Box { sides } => cuboid(*sides),
        Form::Cylinder { radius, length } => {
            let half = 0.5 * length;
            turned(&[(0.0, -half), (*radius, -half), (*radius, half), (0.0, half)])
        }
        Form::Sphere { radius } => ball(if *radius > 0.0 { *radius } else { BALL * size }),
        Form::Stick { ends, radius } => {
            let mut all = Triangles::default();
            for (index, end) in ends.iter().enumerate() {
                let at = Vector3::from(*end);
                join(&mut all, ball(JOINT * radius), |place| place + at);
                let from = Vector3::from(ends[0]);
                let along = at - from;
                if index == 0 || along.norm() == 0.0 {
                    continue;
                }
                let rod = [
                    (0.0, 0.0),
                    (*radius, 0.0),
                    (*radius, along.norm()),
                    (0.0, along.norm()),
                ];
                let turn = Rotation3::rotation_between(&Vector3::z(), &along)
                    .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), PI));
                join(&mut all, turned(&rod), |place| from + turn * place);
            }
            all
        }
        Form::Mesh { positions, cells } => Triangles {
            positions: arrays.vectors_of(*positions),
            cells: arrays.indices_of(*cells),
        },
    }
}

fn join(all: &mut Triangles, other: Triangles, moved: impl Fn(Vector3<f64>) -> Vector3<f64>) {
    let first = all.positions.len() as u32;
    let places = other.positions.into_iter().map(Vector3::from);
    all.positions
        .extend(places.map(|place| <[f64; 3]>::from(moved(place))));
    all.cells
        .extend(other.cells.iter().map(|cell| first + cell));
}

fn cuboid(sides: [f64; 3]) -> Triangles {
    let corner =
        |index: usize| [0, 1, 2].map(|axis| sides[axis] * (((index >> axis) & 1) as f64 - 0.5));
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    Triangles {
        positions: (0..8).map(corner).collect(),
        cells: faces
            .iter()
            .flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d])
            .collect(),
    }
}

fn ball(radius: f64) -> Triangles {
    let meridian = (0..=RINGS).map(|ring| {
        let (sin, cos) = (PI * ring as f64 / RINGS as f64).sin_cos();
        (radius * sin, -radius * cos)
    });
    turned(&meridian.collect::<Vec<_>>())
}

/// A line of radius and height, turned about z: from the bottom up, so that triangles are seen from outside against the clock.
fn turned(line: &[(f64, f64)]) -> Triangles {
    let mut found = Triangles::default();
    for (radius, height) in line {
        found.positions.extend((0..ROUND).map(|k| {
            let (sin, cos) = (TAU * k as f64 / ROUND as f64).sin_cos();
            [radius * cos, radius * sin, *height]
        }));
    }
    for ring in 1..line.len() {
        for k in 0..ROUND {
            let next = (k + 1) % ROUND;
            let [a, b] = [k, next].map(|k| ((ring - 1) * ROUND + k) as u32);
            let [c, d] = [next, k].map(|k| (ring * ROUND + k) as u32);
            // On the axis all corners of a ring are one place.
            if line[ring - 1].0 > 1e-9 * line[ring].0 {
                found.cells.extend([a, b, c]);
            }
            if line[ring].0 > 1e-9 * line[ring - 1].0 {
                found.cells.extend([a, c, d]);
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of what triangles enclose that are seen from outside against the clock.
    fn volume(of: &Triangles) -> f64 {
        let corner = |index: u32| Vector3::from(of.positions[index as usize]);
        let triangles = of
            .cells
            .chunks(3)
            .map(|cell| [0, 1, 2].map(|k| corner(cell[k])));
        triangles.map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
    }

    #[test]
    fn solids_enclose_their_volumes() {
        let volume_of = |form: Form| volume(&triangles_of(&form, 1.0, &Arrays::default()));
        let found = volume_of(Form::Box {
            sides: [2.0, 3.0, 4.0],
        });
        assert!((found - 24.0).abs() < 1e-12);
        let circle = 0.5 * ROUND as f64 * (TAU / ROUND as f64).sin();
        let found = volume_of(Form::Cylinder {
            radius: 2.0,
            length: 3.0,
        });
        assert!((found - 12.0 * circle).abs() < 1e-11, "{found}");
        let found = volume_of(Form::Sphere { radius: 1.0 });
        assert!((found / (4.0 * PI / 3.0) - 1.0).abs() < 0.03, "{found}");
        let ends = vec![[0.0; 3], [0.0, 0.0, -5.0], [4.0, 0.0, 3.0]];
        let found = volume_of(Form::Stick { ends, radius: 0.1 });
        let balls = 3.0 * volume(&ball(0.125));
        assert!(
            (found - balls - 10.0 * 0.01 * circle).abs() < 1e-11,
            "{found}"
        );
    }
}
