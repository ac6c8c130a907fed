//! `reduce verify`: intact and honest files pass, damaged ones are refused, altered ones don't verify.

use dcb_formats::Superelement;
use dcb_formats::dcb::{Contents, SuperelementFile, read_superelement};
use dcb_superelement::selection::{InPlane, Normal, SYMMETRIC};

use crate::support::{Folder, says};

/// Writes an altered copy whose digests are right again.
#[track_caller]
fn altered(folder: &Folder, change: impl FnOnce(&mut Superelement)) {
    let file = SuperelementFile::open(folder.path("rotor.dcb.h5")).unwrap();
    let mut superelement = file.superelement().unwrap();
    change(&mut superelement);
    let (recovery, mesh) = (file.recovery().unwrap(), file.mesh().unwrap());
    let contents = Contents {
        superelement: &superelement,
        recovery: recovery.as_ref(),
        mesh: mesh.as_ref(),
    };
    folder.store_contents("altered.dcb.h5", &contents);
}

/// With this change it isn't verified, and this is said about it.
#[track_caller]
fn refuted(folder: &Folder, says: &[&str], change: impl FnOnce(&mut Superelement)) {
    altered(folder, change);
    folder.failed(1, "verify altered.dcb.h5", says);
}

/// The same with the component.
#[track_caller]
fn refuted_by_component(folder: &Folder, says: &[&str], change: impl FnOnce(&mut Superelement)) {
    altered(folder, change);
    folder.failed(1, "verify altered.dcb.h5 --component rotor.mtx", says);
}

/// A change of a superelement.
type Change = fn(&mut Superelement);

#[test]
fn an_honest_superelement_is_verified_against_everything() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx");
    let shown = folder.done("verify rotor.dcb.h5 -v");
    assert!(
        shown.contains(": verified") && !shown.contains("FAIL"),
        "{shown}"
    );
    let shown = folder.done("verify rotor.dcb.h5 --component rotor.mtx -v");
    for what in [
        "stiffness (rotor.mtx)",
        "mass (rotor.mass.mtx)",
        "mesh (rotor.json)",
        "centre of mass",
        "inertia tensor",
        "interfaces: names, kinds and roles",
        "rows: interface, direction and node",
        "positions of interfaces and rows",
        "axes of interfaces",
        "identities recomputed with K and M",
        "L_b Φ",
        "F_res",
        "M_res",
        "no eigenvalue left out is below the stored bound",
        "M_1 of the error estimate",
        "M_4 of the error estimate",
        "I1",
        "L3",
        "I2",
    ] {
        says!(shown, format!("ok   {what}"));
    }
    assert!(shown.contains(": verified"), "{shown}");
}

#[test]
fn every_kind_of_interface_is_verified() {
    let folder = Folder::rotor();
    let interfaces = serde_json::json!([
        {"name": "a", "point_set": "bearing_left", "kind": "rigid"},
        {"name": "b", "point_set": "bearing_right", "kind": "average", "weights": "mass",
         "axes": [[0, 1, 0], [0, 0, 1], [1, 0, 0]], "position": [0.01, 0.02, 0.5]},
        {"name": "c", "nodes": [50, 20], "kind": "nodes", "dofs": ["ux", "uz"], "role": "output"}
    ]);
    folder.set("rotor.json", "component/interfaces", interfaces);
    folder.done("rotor.mtx --modes 6");
    folder.done("verify rotor.dcb.h5 --component rotor.mtx");
}

#[test]
fn an_interface_reduction_is_verified_and_made_anew() {
    let folder = Folder::rotor();
    for (options, made_anew) in [("", false), ("--without-fields", true)] {
        folder.done(&format!(
            "rotor.mtx --modes 8 --interface-modes 5 --force {options}"
        ));
        let shown = folder.done("verify rotor.dcb.h5 -v");
        says!(
            shown,
            "interface reduction: 5 of 12 directions of F_res are kept",
            "rank of the residual transform                             5 stored, 5 found"
        );
        let shown = folder.done("verify rotor.dcb.h5 --component rotor.mtx -v");
        assert_eq!(shown.contains("reduced anew"), made_anew, "{shown}");
        for what in ["directions", "errors"].iter().filter(|_| !made_anew) {
            let line = format!("ok   {what} of the interface reduction");
            assert!(shown.contains(&line), "{shown}");
        }
    }
}

/// More is left out than the transform says, or less, or something else than the softest.
#[test]
fn an_altered_interface_reduction_does_not_verify() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 8 --interface-modes 5");
    refuted(
        &folder,
        &["rank of the residual transform: 4 stored, 5 found"],
        |it| {
            let residual = &mut it.residual;
            residual.transform = residual.transform.as_ref().subcols(0, 4).to_owned();
            residual.sigma_squared.truncate(4);
        },
    );
    refuted(&folder, &["T_rᵀ F_res T_r"], |it| {
        it.residual.flexibility[(2, 2)] *= 1.01
    });
    refuted_by_component(&folder, &["errors of the interface reduction: "], |it| {
        let report = &mut it.provenance.quality["interface_reduction"];
        report["flexibility_error"] = serde_json::json!(1e-3);
    });
    // Said to be whole.
    refuted(&folder, &["/error/moment_1: M_1 is F_res"], |it| {
        let quality = it.provenance.quality.as_object_mut().unwrap();
        quality.remove("interface_reduction");
        it.derivation.as_mut().unwrap().interface_directions = None;
    });
    let shown = folder.run("verify altered.dcb.h5 --component rotor.mtx");
    assert_eq!(shown.code, Some(1), "{shown:?}");
    says!(shown.stdout, "FAIL identities recomputed with K and M");
}

#[test]
fn another_component_does_not_verify() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    let rod = Folder::rod();
    let path = rod.path("rod.mtx");
    folder.failed(
        1,
        &format!("verify rotor.dcb.h5 --component {}", path.display()),
        &[
            "rotor.dcb.h5: not verified",
            "stiffness (rod.mtx): rotor.mtx had other contents then",
        ],
    );
    // The same sizes, one entry different.
    folder.set_diagonal("rotor.mass.mtx", 3, |value| format!("{:?}", 1.001 * value));
    let message = folder.failed(
        1,
        "verify rotor.dcb.h5 --component rotor.mtx",
        &[
            "mass (rotor.mass.mtx): rotor.mass.mtx had other contents then",
            "mass: ",
        ],
    );
    says!(message, "centre of mass");
    folder.refused(
        "verify rotor.dcb.h5 --component nowhere.mtx",
        &["nowhere.mtx", "is not there"],
    );
}

#[test]
fn a_flipped_byte_is_found_with_its_dataset() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    let file = SuperelementFile::open(folder.path("rotor.dcb.h5")).unwrap();
    let superelement = file.superelement().unwrap();
    let fields = file.recovery().unwrap().unwrap();
    for (path, value) in [
        ("/modes/eigenvalues", superelement.modes.eigenvalues[2]),
        ("/residual/sigma2", superelement.residual.sigma_squared[5]),
        ("/modes/shapes", fields.modes[(200, 1)]),
        ("/residual/shapes", fields.residual[(200, 7)]),
    ] {
        let mut bytes = folder.bytes("rotor.dcb.h5");
        let mut numbers = bytes.windows(8);
        let at = numbers.position(|number| number == value.to_le_bytes());
        let at = at.unwrap();
        bytes[at] ^= 1; // the last bit of the number
        folder.write("flipped.dcb.h5", &bytes);
        folder.refused("verify flipped.dcb.h5", &["flipped.dcb.h5", path, "sha256"]);
        folder.remove("flipped.dcb.h5");
    }
}

#[test]
fn altered_matrices_break_an_identity_of_the_file_itself() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    refuted(
        &folder,
        &[
            "altered.dcb.h5: not verified: /residual/flexibility: T_rᵀ F_res T_r",
            "above its limit 1e-4",
        ],
        |it| {
            let f = &mut it.residual.flexibility;
            *f *= faer::Scale(1.01);
        },
    );
    refuted(
        &folder,
        &["T_rᵀ M_res T_r = I", "diag(M_res) with no mode kept"],
        |it| it.residual.mass[(2, 2)] *= 1.01,
    );
    refuted(&folder, &["diag(M_res) with no mode kept"], |it| {
        it.modes.interface_shapes[(1, 0)] *= 1.01
    });
    refuted(
        &folder,
        &["L1 Ψ = 0", "the inertia tensor is that of a body"],
        |it| {
            it.inertia.l1[(0, 3)] = 1e-3;
            it.inertia.tensor[0][0] *= 5.0;
        },
    );
}

/// Mass, tensor and places belong together with the rigid motions at the rows.
#[test]
fn altered_rigid_motions_are_found_without_the_component() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    let cases: [(&str, &str, Change); 4] = [
        ("/error/rigid_shapes", "mass: ", |it| {
            it.inertia.mass *= 1.0 + 1e-6
        }),
        ("/error/rigid_shapes", "inertia tensor: ", |it| {
            it.inertia.tensor[2][2] *= 1.0 + 1e-6;
        }),
        (
            "/interfaces/positions",
            "positions of interfaces and rows: ",
            |it| {
                it.interfaces[1].position[2] += 1e-6;
            },
        ),
        (
            "/error/rigid_shapes",
            "positions of interfaces and rows: ",
            |it| {
                it.interfaces[1].position[2] += 1e-6;
                it.rows
                    .iter_mut()
                    .filter(|row| row.interface == 1)
                    .for_each(|row| row.position[2] += 1e-6);
            },
        ),
    ];
    for (path, says, change) in cases {
        refuted(&folder, &["not verified", path], change);
        refuted_by_component(&folder, &[path, says], change);
    }
}

/// Rows of a matrix L_b may be as different in size as anybody likes: each is measured by itself.
#[test]
fn boundary_rows_of_any_size_verify_and_are_told_nothing_false() {
    let folder = Folder::rotor();
    let verified = |size: f64| {
        let matrix = format!(
            "%%MatrixMarket matrix coordinate real general\n4 345 6\n1 1 1\n1 4 0.3\n2 5 {size:e}\n3 20 {size:e}\n3 26 {:e}\n4 200 {:e}\n",
            -0.5 * size,
            1.0 / size
        );
        folder.write("rotor.boundary.mtx", matrix);
        let said = folder.done("rotor.mtx --modes 4 --force");
        assert!(
            !said.contains("does not move with any deflection"),
            "{size:e}: {said}"
        );
        let shown = folder.done("verify rotor.dcb.h5 --component rotor.mtx -v");
        assert!(shown.contains(": verified"), "{size:e}: {shown}");
    };
    for size in [1e3, 1e6, 1e9, 1e12] {
        verified(size);
    }
}

/// Defects that no identity of the file shows, the component shows.
#[test]
fn altered_descriptions_are_found_with_the_component() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    let cases: [(&str, Change); 5] = [
        ("centre of mass: ", |it| it.origin[2] += 1e-6),
        (
            "interfaces: names, kinds and roles: bearing-right (average), bearing-left (average), the component has",
            |it| {
                let [first, second] = [0, 1].map(|k| it.interfaces[k].name.clone());
                (it.interfaces[0].name, it.interfaces[1].name) = (second, first);
            },
        ),
        ("axes of interfaces: ", |it| {
            it.interfaces[1].orientation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
        }),
        ("I1: ", |it| it.inertia.i1[2][0][0] += 1e-3),
        ("dimension and units: the component has others", |it| {
            it.units.length = "mm".into()
        }),
    ];
    for (says, change) in cases {
        let says = ["altered.dcb.h5: not verified", says];
        refuted_by_component(&folder, &says, change);
        folder.done("verify altered.dcb.h5");
    }
}

/// Without fields the component is reduced again; what was altered shows as well.
#[test]
fn a_file_without_fields_is_checked_by_another_reduction() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4 --without-fields");
    let shown = folder.done("verify rotor.dcb.h5 --component rotor.mtx -v");
    says!(
        shown,
        "no nodal fields are stored: the component was reduced anew"
    );
    refuted_by_component(&folder, &["L_b Φ Φᵀ L_bᵀ: "], |it| {
        it.modes.interface_shapes *= faer::Scale(1.001)
    });
    refuted_by_component(&folder, &["eigenvalues: "], |it| {
        it.modes.eigenvalues[3] *= 1.0 + 1e-6
    });
}

#[test]
fn the_component_may_have_its_parts_elsewhere() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    for name in ["rotor.mass.mtx", "rotor.json"] {
        let moved = folder.path(&name.replace("rotor", "elsewhere"));
        std::fs::rename(folder.path(name), moved).unwrap();
    }
    let shown = folder.done(
        "verify rotor.dcb.h5 --component rotor.mtx --mass elsewhere.mass.mtx --mesh elsewhere.json -v",
    );
    assert!(shown.contains(": verified"), "{shown}");
    for (options, says) in [
        ("--mass nowhere", ["nowhere", "is not there", "--mass"]),
        (
            "--mass elsewhere.mass.mtx --boundary nowhere",
            ["nowhere", "is not there", "--boundary"],
        ),
    ] {
        let verify = "verify rotor.dcb.h5 --component rotor.mtx --mesh elsewhere.json";
        folder.refused(&format!("{verify} {options}"), &says);
    }
}

#[test]
fn a_better_error_than_the_true_one_is_found() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4");
    type Change = fn(&mut dcb_formats::superelement::Moments);
    let changes: [(&str, Change); 3] = [
        ("M_3 of the error estimate", |moments| {
            moments.third[(0, 0)] *= 0.9;
        }),
        ("no eigenvalue left out is below", |moments| {
            moments.eigenvalue_bound *= 2.0;
        }),
        ("rounding and eigenvalue errors", |moments| {
            moments.rounding[2] = 0.0;
        }),
    ];
    for (says, change) in changes {
        let change = |it: &mut Superelement| change(it.moments.as_mut().unwrap());
        refuted_by_component(&folder, &["not verified", says], change);
    }
}

#[test]
fn a_planar_superelement_of_a_spatial_part_is_checked_by_itself() {
    let folder = Folder::with(&dcb_samples::spatial_beam(&dcb_samples::SpatialBeam {
        elements: 4,
        ..dcb_samples::SpatialBeam::default()
    }));
    folder.done("part.mtx --modes 6");
    let whole = read_superelement(&folder.path("part.dcb.h5")).unwrap();
    let in_plane = InPlane::of(&whole, Normal::Z, SYMMETRIC).unwrap();
    folder.store_superelement("planar.dcb.h5", &in_plane.superelement(&whole).unwrap());
    folder.done("inspect planar.dcb.h5");
    let shown = folder.done("verify planar.dcb.h5 --component part.mtx -v");
    says!(shown, "what moves in a plane of a spatial superelement");
    assert!(shown.contains(": verified"), "{shown}");
}
