//! Displacement fields of the beam samples at quadrature points, from their shape functions: the exact integrals that
//! element-integrated component masses stand for.

use dcb_samples::planar_rod::RodSection;
use dcb_samples::spatial_beam::{BeamTheory, SpatialBeam};
use faer::{Mat, MatRef};
use nalgebra::{DMatrix, Vector3};

use crate::nodal::{Invariants, PAIRS};

/// A point that carries mass.
pub struct Point {
    /// Its mass.
    pub mass: f64,
    /// Position.
    pub position: Vector3<f64>,
    /// Displacement as rows over the dofs, (3, n).
    pub displacement: DMatrix<f64>,
}

const GAUSS_5: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

fn hermite(h: f64, s: f64) -> [f64; 4] {
    [
        1.0 - 3.0 * s * s + 2.0 * s * s * s,
        h * s * (1.0 - s) * (1.0 - s),
        s * s * (3.0 - 2.0 * s),
        h * s * s * (s - 1.0),
    ]
}

/// The planar rod with `elements` elements, along `rod.angle`.
pub fn rod_points(elements: usize, rod: &RodSection) -> Vec<Point> {
    let h = rod.length / elements as f64;
    let (along, across) = (
        Vector3::new(rod.angle.cos(), rod.angle.sin(), 0.0),
        Vector3::new(-rod.angle.sin(), rod.angle.cos(), 0.0),
    );
    let mut points = Vec::new();
    for element in 0..elements {
        for (t, weight) in GAUSS_5 {
            let s = 0.5 * (1.0 + t);
            let mut displacement = DMatrix::zeros(3, 3 * (elements + 1));
            let v = hermite(h, s);
            for (local, node) in [element, element + 1].into_iter().enumerate() {
                let axial = if local == 0 { 1.0 - s } else { s };
                for axis in 0..2 {
                    for i in 0..2 {
                        displacement[(i, 3 * node + axis)] += along[i] * axial * along[axis]
                            + across[i] * v[2 * local] * across[axis];
                    }
                }
                for i in 0..2 {
                    displacement[(i, 3 * node + 2)] += across[i] * v[2 * local + 1];
                }
            }
            points.push(Point {
                mass: 0.5 * weight * h * rod.area * rod.density,
                position: along * (h * (element as f64 + s)),
                displacement,
            });
        }
    }
    points
}

/// The Euler–Bernoulli beam along x from the origin; its section turns about the axis but carries no rotary inertia of bending.
pub fn beam_points(beam: &SpatialBeam) -> Vec<Point> {
    assert!(
        beam.theory == BeamTheory::EulerBernoulli && beam.roll == 0.0 && beam.start == [0.0; 3]
    );
    let (n, h) = (beam.elements, beam.end[0] / beam.elements as f64);
    let section = &beam.section;
    // Four points that have the section's area and second moments.
    let y = (section.second_moment_z / section.area).sqrt();
    let z = (section.second_moment_y / section.area).sqrt();
    let mut points = Vec::new();
    for element in 0..n {
        for (t, weight) in GAUSS_5 {
            let s = 0.5 * (1.0 + t);
            let v = hermite(h, s);
            for (dy, dz) in [(y, z), (y, -z), (-y, z), (-y, -z)] {
                let mut displacement = DMatrix::zeros(3, 6 * (n + 1));
                for (local, node) in [element, element + 1].into_iter().enumerate() {
                    let linear = if local == 0 { 1.0 - s } else { s };
                    displacement[(0, 6 * node)] = linear;
                    displacement[(1, 6 * node + 1)] = v[2 * local];
                    displacement[(1, 6 * node + 5)] = v[2 * local + 1];
                    displacement[(2, 6 * node + 2)] = v[2 * local];
                    displacement[(2, 6 * node + 4)] = -v[2 * local + 1];
                    displacement[(1, 6 * node + 3)] = -dz * linear;
                    displacement[(2, 6 * node + 3)] = dy * linear;
                }
                points.push(Point {
                    mass: 0.125 * weight * h * section.area * beam.material.density,
                    position: Vector3::new(h * (element as f64 + s), 0.0, 0.0),
                    displacement,
                });
            }
        }
    }
    points
}

/// Displacements of a point under each column of a basis.
pub fn displacements(point: &Point, basis: MatRef<'_, f64>) -> Vec<Vector3<f64>> {
    (0..basis.ncols())
        .map(|k| {
            Vector3::from_fn(|i, _| {
                (0..basis.nrows())
                    .map(|j| point.displacement[(i, j)] * basis[(j, k)])
                    .sum()
            })
        })
        .collect()
}

/// Invariants as sums over the points.
pub fn invariants(points: &[Point], centre: [f64; 3], basis: MatRef<'_, f64>) -> Invariants {
    let n = basis.ncols();
    let mut all = Invariants {
        l1: Mat::zeros(3, n),
        i3: Mat::zeros(3, n),
        stretch: vec![0.0; n],
        j1: vec![[[0.0; 3]; 3]; n],
        l3: vec![Mat::zeros(n, n); 3],
        j2: vec![Mat::zeros(n, n); 6],
    };
    for point in points {
        let r = point.position - Vector3::from(centre);
        let psi = displacements(point, basis);
        for k in 0..n {
            all.stretch[k] += point.mass * r.dot(&psi[k]);
            for a in 0..3 {
                all.l1[(a, k)] += point.mass * psi[k][a];
                all.i3[(a, k)] += point.mass * r.cross(&psi[k])[a];
                for b in 0..3 {
                    let e = |axis: usize| Vector3::ith(axis, 1.0);
                    all.j1[k][a][b] += point.mass
                        * (e(a).cross(&r).dot(&e(b).cross(&psi[k]))
                            + e(b).cross(&r).dot(&e(a).cross(&psi[k])));
                }
            }
            for l in 0..n {
                for a in 0..3 {
                    all.l3[a][(k, l)] += point.mass * psi[k].cross(&psi[l])[a];
                }
                for (pair, (a, b)) in PAIRS.iter().enumerate() {
                    let crossed = 0.5 * (psi[k][*a] * psi[l][*b] + psi[k][*b] * psi[l][*a]);
                    let whole = if a == b { psi[k].dot(&psi[l]) } else { 0.0 };
                    all.j2[pair][(k, l)] += point.mass * (whole - crossed);
                }
            }
        }
    }
    all
}
