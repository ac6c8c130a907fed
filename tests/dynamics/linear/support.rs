//! Linear systems of scenes, and the linear algebra that checks them.

use dcb_runtime::{LinearRequest, LinearSystem, OperatingPoint, Scene, linearize};
use faer::Mat;
use faer::linalg::solvers::Solve;
use serde_json::{Value, json};

use crate::scenes::parts::{rigid_scene, scene_text};

/// About an operating point, with inputs and outputs by name; the scene's for none.
pub fn about(scene: &Scene, at: OperatingPoint, inputs: &[&str], outputs: &[&str]) -> LinearSystem {
    let names = |list: &[&str]| list.iter().map(|name| (*name).to_owned()).collect();
    let request = LinearRequest {
        inputs: names(inputs),
        outputs: names(outputs),
        order: None,
    };
    linearize(scene, at, &request, &mut ()).unwrap().unwrap()
}

/// Of a scene without superelements, at its start.
pub fn at_start(text: &Value) -> LinearSystem {
    about(&rigid_scene(text), OperatingPoint::Initial, &[], &[])
}

/// A uniform bar in the plane, 0.5 m from its pivot to its centre, at an angle from hanging; m, kg, s or lengths and masses in other units.
pub fn pendulum(angle: f64, length: f64, mass: f64) -> Value {
    scene_text(
        2,
        json!({
            "units": {"length": if length == 1.0 { "m" } else { "mm" }, "mass": if mass == 1.0 { "kg" } else { "t" }, "time": "s"},
            "gravity": [0.0, -9.81 * length],
            "bodies": {"bob": {
                "rigid": {"mass": 2.0 * mass, "inertia": 0.1 * mass * length * length, "points": {"pivot": [0.0, 0.5 * length], "tip": [0.0, -0.5 * length]}},
                "position": [0.5 * length * angle.sin(), -0.5 * length * angle.cos()], "orientation": angle
            }},
            "joints": {"pivot": {"revolute": {"a": "ground", "b": "bob/pivot"}}},
            "loads": {"motor": {"torque": {"at": "bob/pivot", "components": [{"input": {"initial": 0}}]}}},
            "outputs": {
                "angle": {"joint_coordinate": {"joint": "pivot"}}, "rate": {"joint_rate": {"joint": "pivot"}},
                "tip": {"acceleration": {"at": "bob/tip"}}, "pull": {"reaction": {"joint": "pivot"}}
            }
        }),
    )
}

/// Whether two numbers agree to a part of a scale.
pub fn close(found: f64, expected: f64, scale: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance * scale,
        "{found:e} against {expected:e}, allowed {:e}",
        tolerance * scale
    );
}

/// The index of a variable.
pub fn place(names: &[dcb_formats::linear_system::Variable], name: &str) -> usize {
    let found = names.iter().position(|variable| variable.name == name);
    found.unwrap_or_else(|| panic!("{name} is not in {names:?}"))
}

/// C (s - A)⁻¹ B + D at s = i ω: real and imaginary parts, by the real system of twice the size.
pub fn response(system: &LinearSystem, omega: f64) -> (Mat<f64>, Mat<f64>) {
    let n = system.order();
    let matrix = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => -system.a[(i, j)],
        (false, false) => -system.a[(i - n, j - n)],
        (true, false) if i == j - n => -omega,
        (false, true) if i - n == j => omega,
        _ => 0.0,
    });
    let m = system.b.ncols();
    let right = Mat::from_fn(2 * n, m, |i, j| if i < n { system.b[(i, j)] } else { 0.0 });
    let x = matrix.partial_piv_lu().solve(&right);
    let part = |first: usize| &system.c * x.as_ref().subrows(first, n);
    (part(0) + &system.d, part(n))
}

/// exp(M), by squaring a series.
pub fn exponential(matrix: &Mat<f64>) -> Mat<f64> {
    let n = matrix.nrows();
    let halvings = (matrix.norm_l2().max(1e-300).log2().ceil() as i32 + 4).max(0);
    let small = faer::Scale(0.5_f64.powi(halvings)) * matrix;
    let mut sum = Mat::<f64>::identity(n, n);
    let mut term = sum.clone();
    for k in 1..20 {
        term = &term * &small * faer::Scale(1.0 / f64::from(k));
        sum += &term;
    }
    for _ in 0..halvings {
        sum = &sum * &sum;
    }
    sum
}

/// y - y₀ after a step of unit size of one input, held for a time.
pub fn step_response(system: &LinearSystem, input: usize, time: f64) -> Vec<f64> {
    let n = system.order();
    let extended = Mat::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
        (true, true) => system.a[(i, j)] * time,
        (true, false) => system.b[(i, input)] * time,
        _ => 0.0,
    });
    let flow = exponential(&extended);
    (0..system.c.nrows())
        .map(|i| {
            let of_states: f64 = (0..n).map(|k| system.c[(i, k)] * flow[(k, n)]).sum();
            of_states + system.d[(i, input)]
        })
        .collect()
}

/// Eigenvalues of A by size, by way of a matrix whose rates are in units of the fastest pole.
pub fn eigenvalues(system: &LinearSystem) -> Vec<[f64; 2]> {
    let fastest = system.poles.last().map_or(1.0, |pole| pole.magnitude());
    let half = match system.truncation {
        None => system.order() / 2,
        Some(_) => system.order(),
    };
    let unit = |k: usize| if k < half { 1.0 } else { fastest };
    let scaled = Mat::from_fn(system.order(), system.order(), |i, j| {
        system.a[(i, j)] * unit(j) / (unit(i) * fastest)
    });
    let values = scaled.eigenvalues().unwrap();
    let mut values: Vec<[f64; 2]> = values
        .iter()
        .map(|s| [s.re * fastest, s.im * fastest])
        .collect();
    values.sort_by(|a, b| {
        let size = |s: &[f64; 2]| s[0].hypot(s[1]);
        size(a).total_cmp(&size(b))
    });
    values
}
