//! Quadrature on the reference hexahedron (-1, 1)³ and tetrahedron (volume 1/6).

/// A point of the reference element and its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraturePoint {
    /// Reference coordinates.
    pub at: [f64; 3],
    /// Weight; the weights sum to the reference volume.
    pub weight: f64,
}

/// 2 × 2 × 2 Gauss points: degree 3 in each coordinate.
pub(crate) fn hexahedron_8() -> Vec<QuadraturePoint> {
    let x = (1.0_f64 / 3.0).sqrt();
    tensor(&[(-x, 1.0), (x, 1.0)])
}

/// 3 × 3 × 3 Gauss points: degree 5 in each coordinate.
pub(crate) fn hexahedron_27() -> Vec<QuadraturePoint> {
    let x = 0.6_f64.sqrt();
    tensor(&[(-x, 5.0 / 9.0), (0.0, 8.0 / 9.0), (x, 5.0 / 9.0)])
}

fn tensor(line: &[(f64, f64)]) -> Vec<QuadraturePoint> {
    let mut points = Vec::with_capacity(line.len().pow(3));
    for &(z, wz) in line {
        for &(y, wy) in line {
            points.extend(line.iter().map(|&(x, wx)| QuadraturePoint {
                at: [x, y, z],
                weight: wx * wy * wz,
            }));
        }
    }
    points
}

/// Four points, degree 2.
pub(crate) fn tetrahedron_4() -> Vec<QuadraturePoint> {
    let mut points = Vec::with_capacity(4);
    vertex_orbit(&mut points, (5.0 - 5.0_f64.sqrt()) / 20.0, 1.0 / 24.0);
    points
}

/// Fourteen points, degree 5, all weights positive (Walkington).
pub(crate) fn tetrahedron_14() -> Vec<QuadraturePoint> {
    let mut points = Vec::with_capacity(14);
    vertex_orbit(
        &mut points,
        0.310_885_919_263_300_6,
        0.112_687_925_718_015_85 / 6.0,
    );
    vertex_orbit(
        &mut points,
        0.092_735_250_310_891_23,
        0.073_493_043_116_361_95 / 6.0,
    );
    let (near, weight) = (0.045_503_704_125_649_65, 0.042_546_020_777_081_47 / 6.0);
    let far = 0.5 - near;
    for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
        let mut l = [near; 4];
        l[i] = far;
        l[j] = far;
        points.push(QuadraturePoint {
            at: [l[1], l[2], l[3]],
            weight,
        });
    }
    points
}

/// The four points with three barycentric coordinates equal to `a`.
fn vertex_orbit(points: &mut Vec<QuadraturePoint>, a: f64, weight: f64) {
    for i in 0..4 {
        let mut l = [a; 4];
        l[i] = 1.0 - 3.0 * a;
        points.push(QuadraturePoint {
            at: [l[1], l[2], l[3]],
            weight,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: u32) -> f64 {
        (1..=n).map(f64::from).product()
    }

    #[test]
    fn tetrahedron_rules_integrate_monomials_of_their_degree() {
        for (rule, degree) in [(tetrahedron_4(), 2), (tetrahedron_14(), 5)] {
            for a in 0..=degree {
                for b in 0..=degree - a {
                    for c in 0..=degree - a - b {
                        let sum: f64 = rule
                            .iter()
                            .map(|p| {
                                p.weight
                                    * p.at[0].powi(a as i32)
                                    * p.at[1].powi(b as i32)
                                    * p.at[2].powi(c as i32)
                            })
                            .sum();
                        let exact =
                            factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3);
                        assert!(
                            (sum - exact).abs() < 1e-15,
                            "x^{a} y^{b} z^{c}: {sum} against {exact}"
                        );
                    }
                }
            }
        }
    }
}
