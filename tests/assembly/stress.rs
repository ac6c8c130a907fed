//! Stress fields of turned and mirrored parts in an assembly, against dense algebra over the part with what it is joined to.

use dcb_formats::Component;
use dcb_formats::SparseMatrix;
use dcb_samples::bracket;
use dcb_tests::dense::{dense, sparse};
use dcb_tests::localization::localization;
use dcb_tests::lowest;
use dcb_tests::oracle::Oracle;
use faer::Mat;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::{loaded, put_together};

const MASS: f64 = 0.3;
const INERTIA: f64 = 2e-4;
const TURN: [f64; 4] = [0.7, 0.1, -0.5, 0.5];
const PLACE: [f64; 3] = [0.3, -0.2, 0.5];
/// Modes of the part, far more than are compared.
const PARTS: usize = 150;
const COMPARED: usize = 4;

/// The bracket with a rigid mass on its tip: its first interface is the wall, the next the tip.
fn weighted(component: &Component) -> Component {
    let rows = localization(component);
    let mass = dense(&component.mass);
    let weight = |row: usize| match row {
        6..9 => MASS,
        9..12 => INERTIA,
        _ => 0.0,
    };
    let n = mass.nrows();
    let added = Mat::from_fn(n, n, |i, j| {
        let of_rows = (6..12).map(|row| weight(row) * rows[(row, i)] * rows[(row, j)]);
        mass[(i, j)] + of_rows.sum::<f64>()
    });
    let mass: SparseMatrix = sparse(&added);
    component
        .clone()
        .changed(|draft| draft.mass = mass)
        .unwrap()
}

fn tensor(values: &[f64]) -> Matrix3<f64> {
    let [xx, yy, zz, xy, yz, zx] = std::array::from_fn(|i| values[i]);
    Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz)
}

#[test]
fn turned_and_mirrored_parts_keep_their_stress() {
    let component = bracket(1);
    let whole = weighted(&component);
    let oracle = Oracle::of(&whole);
    let rows = dense(&component.stresses[0].matrix);
    let expected = &rows * &oracle.shapes;
    let [w, x, y, z] = TURN;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let tip = Vector3::from(component.interfaces[1].position.unwrap());
    for (mirror, reflection) in [
        ("", Matrix3::identity()),
        (
            r#""mirror": "y", "#,
            Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0)),
        ),
    ] {
        let axes = turn.to_rotation_matrix().matrix() * reflection;
        let joined = Vector3::from(PLACE) + axes * tip;
        let text = format!(
            r#"{{"dimension": 3, "units": {{"length": "m", "mass": "kg", "time": "s"}},
              "bodies": {{"part": {{"superelement": "part.dcb.h5", {mirror}"position": {PLACE:?}, "orientation": {TURN:?}}},
                          "weight": {{"rigid": {{"mass": {MASS}, "inertia": [{INERTIA}, {INERTIA}, {INERTIA}], "points": {{"p": [0, 0, 0]}}}}, "position": {:?}}}}},
              "joints": {{"bolt": {{"fixed": {{"a": "part/tip", "b": "weight/p"}}}}}},
              "interfaces": {{"wall": "part/wall"}}}}"#,
            <[f64; 3]>::from(joined)
        );
        let part = loaded(&component, lowest(&component, PARTS), "part");
        let found = put_together(&text, vec![part, None], 8).unwrap();
        let field = &found.superelement.stresses[0];
        assert_eq!(field.name, "part: fillet");
        assert_eq!(6 * field.points.len(), expected.nrows());
        // Places, in the body frame of the whole.
        let node = component.stresses[0].points[0].node.unwrap();
        let place = Vector3::from(PLACE) + axes * Vector3::from(component.mesh.position(node));
        let told =
            Vector3::from(field.points[0].position) + Vector3::from(found.superelement.origin);
        assert!((told - place).norm() < 1e-12, "{told} {place}");
        for k in 0..COMPARED {
            let (mut product, mut own, mut other) = (0.0, 0.0, 0.0);
            let mut pairs = Vec::new();
            for p in 0..field.points.len() {
                let of =
                    |all: &Mat<f64>| -> Vec<f64> { (0..6).map(|c| all[(6 * p + c, k)]).collect() };
                let exact = axes * tensor(&of(&expected)) * axes.transpose();
                let here = tensor(&of(&field.shapes));
                product += exact.dot(&here);
                own += here.norm_squared();
                other += exact.norm_squared();
                pairs.push((exact, here));
            }
            assert!(
                (own / other - 1.0).abs() < 1e-4,
                "mode {k}: {own:e} and {other:e}"
            );
            let sign = product.signum();
            let largest = pairs
                .iter()
                .map(|(exact, _)| exact.norm())
                .fold(0.0, f64::max);
            for (exact, here) in pairs {
                let off = (here * sign - exact).norm() / largest;
                assert!(off < 1e-4, "mode {k}, mirror {mirror:?}: {off:e}");
            }
        }
    }
}
