//! The forecast, and what happens where memory is short.

use dcb_samples::{Material, SolidElement, box_block};
use serde_json::Value;

use crate::support::{Folder, says};

fn planned(folder: &Folder, arguments: &str) -> Value {
    serde_json::from_str(&folder.done(&format!("plan --json {arguments}"))).unwrap()
}

/// Memory of the reduction with the factor on disk, KiB: too little for the factor in memory, even if the error estimate is left out.
fn too_little_for_memory(folder: &Folder) -> u64 {
    let plan = planned(folder, "part.mtx --factor disk");
    let needed = plan["choices"][0]["peak_bytes"].as_u64().unwrap();
    needed.div_ceil(1024)
}

#[test]
fn a_plan_writes_nothing_and_tells_sizes_memory_and_time() {
    let folder = Folder::rotor();
    let before = folder.names();
    let shown = folder.done("plan rotor.mtx --modes 12 --memory 8G -v");
    says!(
        shown,
        "degrees of freedom                 345",
        "entries of the factor",
        "operations of a factorization",
        "largest memory",
        "time after the ordering",
        "memory allowed                     8.0 GB",
        "the factor will be kept            in memory"
    );
    assert_eq!(folder.names(), before);
    let plan = planned(&folder, "rotor.mtx --modes 12");
    assert_eq!(plan["sizes"]["dofs"], 345);
    assert_eq!(plan["sizes"]["modes"], 12);
    assert_eq!(plan["sizes"]["attachment_columns"], 12);
    assert_eq!(plan["chosen"], "in memory");
    let assumed = planned(&folder, "rotor.mtx --max-frequency 500");
    assert_eq!(assumed["sizes"]["modes_are_assumed"], true);
    let refused = folder.done("plan rotor.mtx --memory 1M -v");
    says!(refused, "will be refused");
}

#[test]
fn verbose_says_the_forecast_before_the_work() {
    let folder = Folder::rotor();
    let answer = folder.run("rotor.mtx -v");
    says!(answer.stderr, "forecast:");
    let answer = folder.run("rotor.mtx -v --quiet --force");
    assert_eq!(answer.stderr, "");
}

#[test]
fn too_little_memory_is_refused_before_any_work() {
    let folder = Folder::rotor();
    folder.refused(
        "rotor.mtx --memory 1M",
        &["not enough memory", "1 MB may be taken", "fewer --modes"],
    );
    assert!(!folder.names().contains(&"rotor.dcb.h5".to_owned()));
}

#[test]
fn sizes_without_sense_are_refused() {
    let folder = Folder::rotor();
    for size in ["12x", "8", "-1G", "0G", "G", "nanG"] {
        folder.refused_each(&[
            (&format!("rotor.mtx --memory {size}"), &["8G or 512M"]),
            (&format!("plan rotor.mtx --memory {size}"), &["8G or 512M"]),
        ]);
    }
    folder.refused_each(&[
        ("rotor.mtx --factor tape", &["possible values"]),
        (
            "rotor.mtx --factor disk --scratch nowhere",
            &["nowhere", "cannot keep the factor here", "--scratch"],
        ),
    ]);
}

#[test]
fn a_factor_on_disk_gives_the_same_numbers() {
    // Its factor is larger than what a short Krylov basis saves.
    let block = box_block(
        [8; 3],
        [1.0; 3],
        SolidElement::Hexahedron20,
        &Material::STEEL,
    );
    let folder = Folder::with(&block);
    folder.done("part.mtx -o memory.dcb.h5 --factor memory");
    folder.done("part.mtx -o disk.dcb.h5 --factor disk");
    let digits = |file: &str| {
        let found = folder.inspected(file);
        [
            found["eigenvalues"].clone(),
            found["quality"]["mode_residuals"].clone(),
            found["quality"]["attachment_residual"].clone(),
        ]
    };
    assert_eq!(digits("memory.dcb.h5"), digits("disk.dcb.h5"));
    // Unasked, with a word about it.
    let little = too_little_for_memory(&folder);
    let says = ["was kept on disk in", "results are the same"];
    folder.warned(
        &format!("part.mtx -o short.dcb.h5 --memory {little}K"),
        &says,
    );
    assert_eq!(digits("short.dcb.h5"), digits("memory.dcb.h5"));
    folder.refused(
        &format!("part.mtx -o none.dcb.h5 --factor memory --memory {little}K"),
        &["not enough memory", "--factor disk"],
    );
}

#[test]
fn single_precision_is_refined_to_the_same_modes() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx -o double.dcb.h5");
    folder.done("rotor.mtx -o single.dcb.h5 --factor single");
    let values = |file: &str| -> Vec<f64> {
        serde_json::from_value(folder.inspected(file)["eigenvalues"].clone()).unwrap()
    };
    for (a, b) in values("double.dcb.h5").iter().zip(values("single.dcb.h5")) {
        assert!((a - b).abs() < 1e-9 * a, "{a} {b}");
    }
}
