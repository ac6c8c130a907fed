//! The published rotor, and reference values of an independent prototype, one line of JSON per measurement.

use std::f64::consts::PI;

use dcb_formats::Component;
use dcb_samples::{reference_hexahedra, reference_tetrahedra};
use faer::Mat;
use serde_json::{Value, json};

use crate::accuracy::sections::{frequencies, roots};
use crate::dense::{diagonal_roots, relative, scaled_difference};
use crate::reference::{matrix, numbers, reference};
use crate::{lowest, parts};

/// First elastic frequency that the rotor was published with, in Hz.
const PUBLISHED: f64 = 104.637011;
/// The spatial reference holds twelve digits.
const DIGITS: f64 = 1e-11;

/// Largest |a - b| as a fraction of this size.
fn apart(a: &[f64], b: &[f64], size: f64) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs() / size)
        .fold(0.0, f64::max)
}

/// The rotor against its published frequency and against dense algebra of another program.
pub fn published_rotor() -> Vec<Value> {
    let file = reference("reference.json");
    let named = |case: &&Value| {
        case["name"]
            .as_str()
            .is_some_and(|name| name.starts_with("rotorAnsys"))
    };
    let expected = file
        .as_array()
        .and_then(|list| list.iter().find(named))
        .expect("the rotor");
    let reduced = lowest(&parts::rotor(), 10);
    let element = &reduced.superelement;
    let line = |quantity: &str, value: Value, reference: Value, error: f64, bound: f64| {
        json!({
            "kind": "published rotor", "quantity": quantity, "value": value, "reference": reference,
            "relative_error": error, "bound": bound,
        })
    };
    let hertz: Vec<f64> = frequencies(&reduced)
        .iter()
        .map(|omega| omega / (2.0 * PI))
        .collect();
    let dense = numbers(&expected["freq_first10_elastic"]);
    let (pair, pair_dense, next, next_dense) =
        (&hertz[..2], &dense[..2], &hertz[2..10], &dense[2..10]);
    let confirmed = reduced.quality.mode_count.counted - element.mode_count();
    let defect = reduced
        .quality
        .rigid_defects
        .iter()
        .copied()
        .fold(0.0, f64::max);
    let mass = expected["mass"].as_f64().expect("the mass");
    let com = numbers(&expected["com"]);
    let about_origin = matrix(&expected["RtMR_origin"], 6);
    // Steiner: I = I_origin - m (|c|² 1 - c cᵀ).
    let square: f64 = com.iter().map(|c| c * c).sum();
    let steiner = |i: usize, j: usize| mass * (if i == j { square } else { 0.0 } - com[i] * com[j]);
    let tensor: Vec<f64> = (0..9)
        .map(|at| about_origin[(3 + at / 3, 3 + at % 3)] - steiner(at / 3, at % 3))
        .collect();
    let found = element.inertia.tensor.concat();
    let diagonal = |tensor: &[f64]| json!([tensor[0], tensor[4], tensor[8]]);
    vec![
        line(
            "first pair, Hz, as published",
            json!(pair),
            json!(PUBLISHED),
            relative(pair, &[PUBLISHED; 2]),
            1e-8,
        ),
        line(
            "first pair, Hz, all digits",
            json!(pair),
            json!(pair_dense),
            relative(pair, pair_dense),
            1e-8,
        ),
        line(
            "next 8, Hz",
            json!(next),
            json!(next_dense),
            relative(next, next_dense),
            1e-9,
        ),
        line(
            "rigid motions confirmed; their defect in K",
            json!(confirmed),
            expected["rigid"].clone(),
            defect,
            1e-11,
        ),
        line(
            "mass, kg",
            json!(element.inertia.mass),
            json!(mass),
            (element.inertia.mass / mass - 1.0).abs(),
            1e-12,
        ),
        line(
            "centre of mass, m",
            json!(element.origin),
            json!(com),
            apart(&element.origin, &com, com[2]),
            1e-10,
        ),
        line(
            "inertia about it, kg m²",
            diagonal(&found),
            diagonal(&tensor),
            apart(&found, &tensor, tensor[0]),
            1e-9,
        ),
    ]
}

/// Collects lines of one kind: file, part, quantity, error, bound.
struct Lines {
    file: &'static str,
    part: String,
    lines: Vec<Value>,
}

impl Lines {
    fn add(&mut self, quantity: &str, kept: usize, error: f64, bound: f64) {
        self.lines.push(json!({
            "kind": "reference values", "file": self.file, "part": self.part, "quantity": quantity, "n_k": kept,
            "relative_error": error, "bound": bound,
        }));
    }
}

/// The planar rod and the boxes against an independent prototype.
pub fn reference_values() -> Vec<Value> {
    let mut lines = planar_reference();
    lines.extend(spatial_reference(
        "hex",
        "hexahedra",
        &reference_hexahedra(),
        1.0,
    ));
    // The reference cuts its boxes along the mirrored diagonal: z points the other way.
    let mut mirrored = reference_tetrahedra().into_draft();
    (mirrored.interfaces[0].nodes, mirrored.interfaces[1].nodes) = (vec![1], vec![14]);
    let mirrored = Component::checked(mirrored).expect("a component");
    lines.extend(spatial_reference("tet", "tetrahedra", &mirrored, -1.0));
    lines
}

fn planar_reference() -> Vec<Value> {
    let file = reference("ref_planar.json");
    let mut sheet = Lines {
        file: "ref_planar.json",
        part: String::new(),
        lines: Vec::new(),
    };
    for elements in [1, 2, 4, 8, 16] {
        let expected = &file["invariants"][elements.to_string()];
        sheet.part = format!("{elements} element(s)");
        let omega = numbers(&expected["omega"]);
        let all = lowest(&parts::rod(elements), omega.len());
        let inertia = &all.superelement.inertia;
        let count = omega.len();
        let (mass, moment) = (
            expected["m"].as_f64().expect("m"),
            expected["Iz"].as_f64().expect("Iz"),
        );
        sheet.add("mass", count, (inertia.mass / mass - 1.0).abs(), 1e-12);
        sheet.add(
            "inertia tensor",
            count,
            (inertia.tensor[2][2] / moment - 1.0).abs(),
            1e-12,
        );
        sheet.add("ω", count, relative(&frequencies(&all), &omega), 2e-10);
        let first = numbers(&expected["I1Phi_abs_first8"]);
        let found: Vec<f64> = (0..first.len())
            .map(|k| inertia.i1[k][2][2].abs())
            .collect();
        sheet.add(
            "I1 or J1",
            count,
            apart(&found, &first, moment.sqrt()),
            1e-9,
        );
        let l3 = matrix(&expected["L3modal_abs_first8"], first.len());
        let found = Mat::from_fn(first.len(), first.len(), |i, j| inertia.l3[0][(i, j)].abs());
        sheet.add(
            "L3",
            count,
            scaled_difference(&found, &l3, &vec![1.0; first.len()]),
            1e-9,
        );
        let none = lowest(&parts::rod(elements), 0).superelement.residual;
        let (f, m) = (
            matrix(&expected["F_full"], 4),
            matrix(&expected["Mres_nk0"], 4),
        );
        let (scale_f, scale_m) = (diagonal_roots(&f), diagonal_roots(&m));
        sheet.add(
            "F_res",
            0,
            scaled_difference(&none.flexibility, &f, &scale_f),
            1e-10,
        );
        sheet.add(
            "M_res",
            0,
            scaled_difference(&none.mass, &m, &scale_m),
            1e-10,
        );
        for (kept, here) in expected["residual"].as_object().into_iter().flatten() {
            let kept: usize = kept.parse().expect("a number of modes");
            let residual = lowest(&parts::rod(elements), kept).superelement.residual;
            // The reference subtracts modes from the whole, so it is as accurate as the whole is large.
            let (f, m) = (matrix(&here["F_res"], 4), matrix(&here["M_res"], 4));
            sheet.add(
                "F_res",
                kept,
                scaled_difference(&residual.flexibility, &f, &scale_f),
                1e-10,
            );
            sheet.add(
                "M_res",
                kept,
                scaled_difference(&residual.mass, &m, &scale_m),
                1e-10,
            );
            sheet.add(
                "σ",
                kept,
                relative(&roots(&residual.sigma_squared), &numbers(&here["sigma"])),
                1e-8,
            );
        }
    }
    sheet.lines
}

fn spatial_reference(name: &str, part: &str, component: &Component, z: f64) -> Vec<Value> {
    let file = reference("ref_spatial.json");
    let expected = &file[name];
    let mut sheet = Lines {
        file: "ref_spatial.json",
        part: part.to_owned(),
        lines: Vec::new(),
    };
    let element = lowest(component, 6).superelement;
    let (residual, inertia) = (&element.residual, &element.inertia);
    let sign = |row: usize| if row % 3 == 2 { z } else { 1.0 };
    let flipped = |m: Mat<f64>| Mat::from_fn(6, 6, |i, j| sign(i) * m[(i, j)] * sign(j));
    let mass = expected["m"].as_f64().expect("m");
    sheet.add("mass", 6, (inertia.mass / mass - 1.0).abs(), 1e-12);
    let tensor = numbers(&expected["I0"]);
    sheet.add(
        "inertia tensor",
        6,
        apart(&inertia.tensor.concat(), &tensor, tensor[8]),
        DIGITS,
    );
    let omega = numbers(&expected["omega_first12"]);
    sheet.add(
        "ω",
        12,
        relative(&frequencies(&lowest(component, 12)), &omega),
        DIGITS,
    );
    sheet.add(
        "σ",
        6,
        relative(
            &roots(&residual.sigma_squared),
            &numbers(&expected["sigma_residual"]),
        ),
        1e-10,
    );
    let (f, m) = (
        flipped(matrix(&expected["F_res"], 6)),
        flipped(matrix(&expected["M_res"], 6)),
    );
    sheet.add(
        "F_res",
        6,
        scaled_difference(&residual.flexibility, &f, &diagonal_roots(&f)),
        1e-10,
    );
    sheet.add(
        "M_res",
        6,
        scaled_difference(&residual.mass, &m, &diagonal_roots(&m)),
        1e-10,
    );
    // The reference basis is [Φ, G_res L_bᵀ T_r], so every column has mass norm 1.
    let to_reference = Mat::from_fn(12, 12, |i, j| match (i < 6, j < 6) {
        (true, true) if i == j => 1.0,
        (false, false) => residual.transform[(i - 6, j - 6)],
        _ => 0.0,
    });
    let j1 = |a: usize, b: usize, k: usize| -> f64 {
        (0..12)
            .map(|i| inertia.i1[i][a][b] * to_reference[(i, k)])
            .sum()
    };
    let norms: Vec<f64> = (0..12)
        .map(|k| {
            (0..9)
                .map(|at| j1(at / 3, at % 3, k).powi(2))
                .sum::<f64>()
                .sqrt()
        })
        .collect();
    let traces: Vec<f64> = (0..12)
        .map(|k| (j1(0, 0, k) + j1(1, 1, k) + j1(2, 2, k)).abs())
        .collect();
    let expected_norms = numbers(&expected["J1_first3_frob"]);
    let expected_traces: Vec<f64> = numbers(&expected["J1_trace"])
        .iter()
        .map(|trace| trace.abs())
        .collect();
    let of_norms = apart(
        &norms[..expected_norms.len()],
        &expected_norms,
        tensor[8].sqrt(),
    );
    sheet.add(
        "I1 or J1",
        6,
        of_norms.max(apart(&traces, &expected_traces, tensor[8].sqrt())),
        1e-10,
    );
    let l3 = numbers(&expected["L3_abs"]);
    let found: Vec<f64> = (0..l3.len())
        .map(|at| inertia.l3[at / 16][(at / 4 % 4, at % 4)].abs())
        .collect();
    sheet.add("L3", 6, apart(&found, &l3, 1.0), 1e-10);
    let square = |pair: usize| {
        (to_reference.transpose() * &inertia.i2[pair] * &to_reference)
            .norm_l2()
            .powi(2)
    };
    let j2: f64 = (0..6)
        .map(|pair| square(pair) * if pair < 3 { 1.0 } else { 2.0 })
        .sum();
    let expected_j2 = expected["J2_frob"].as_f64().expect("J2");
    sheet.add("J2", 6, (j2.sqrt() / expected_j2 - 1.0).abs(), 1e-10);
    sheet.lines
}
