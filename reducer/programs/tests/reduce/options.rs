//! Effects of each option of a reduction.

use serde_json::{Value, json};

use crate::support::{Folder, list, number, says};

#[test]
fn modes_are_counted_and_never_cut_a_double_root() {
    let folder = Folder::rotor();
    let shown = folder.run("rotor.mtx --modes 7 -o seven.dcb.h5 -v");
    says!(
        shown.stdout,
        "modes added, so that a multiple root is whole  1"
    );
    assert!(!shown.stderr.contains("warning"), "{}", shown.stderr);
    // Modes 7 and 8 are a pair of one frequency.
    assert_eq!(folder.mode_count("seven.dcb.h5"), 8);
    folder.done("rotor.mtx --modes 3 -o three.dcb.h5");
    assert_eq!(
        folder.inspected("three.dcb.h5")["options"]["modes"],
        json!({"lowest": 3})
    );
    let shown = folder.run("rotor.mtx --modes 0 -o none.dcb.h5 -v").stdout;
    says!(
        shown,
        "no mode is kept",
        "104.637010551   the first left out"
    );
    folder.done("verify none.dcb.h5 --component rotor.mtx");
    folder.done("inspect none.dcb.h5");
}

#[test]
fn a_frequency_limit_keeps_what_is_below_it() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --max-frequency 230");
    let found = folder.inspected("rotor.dcb.h5");
    let frequencies: Vec<f64> = serde_json::from_value(found["frequencies_hz"].clone()).unwrap();
    assert_eq!(frequencies.len(), 5, "{frequencies:?}");
    assert!(frequencies.iter().all(|hertz| *hertz < 230.0));
    let omitted = number(&found["first_omitted_eigenvalue"]);
    assert!(omitted.sqrt() / (2.0 * std::f64::consts::PI) > 230.0);
}

#[test]
fn a_frequency_limit_below_the_first_mode_gets_a_warning() {
    let folder = Folder::rotor();
    let says = [
        "no elastic mode lies below --max-frequency 50 Hz",
        "104.637011 Hz",
        "--modes",
    ];
    folder.warned("rotor.mtx --max-frequency 50", &says);
    let found = folder.inspected("rotor.dcb.h5");
    assert_eq!(found["eigenvalues"], json!([]));
    says!(found["warnings"].to_string(), "no elastic mode");
    folder.done("verify rotor.dcb.h5 --component rotor.mtx");
}

#[test]
fn interface_modes_are_counted_and_what_they_lose_is_reported() {
    let folder = Folder::rotor();
    let shown = folder
        .run("rotor.mtx --modes 12 --interface-modes 7 -o seven.dcb.h5 -v")
        .stdout;
    says!(
        shown,
        "reduced to 12 modes and 12 attachment rows (rank 7)",
        "attachment coordinates: 7 for 12 rows",
        "interface modes                                7 of 12\n",
        "static flexibility lost at a row, up to",
        "at bearing-right/r",
        "static flexibility lost in any direction",
        "lowest frequency left out"
    );
    let inspected = folder.done("inspect seven.dcb.h5 -v");
    says!(inspected, "7 of 12\n");
    let found = folder.inspected("seven.dcb.h5");
    assert_eq!(found["options"]["interface_modes"], json!(7));
    assert_eq!(found["residual_rank"], json!(7));
    let reduction = &found["quality"]["interface_reduction"];
    let counts = ["wanted", "kept", "available"].map(|key| &reduction[key]);
    assert_eq!(counts, [7, 7, 12]);
    let error = number(&reduction["flexibility_error"]);
    assert!(0.0 < error && error < 1.0, "{reduction}");
    folder.done("rotor.mtx --modes 12 -o all.dcb.h5");
    let all = folder.inspected("all.dcb.h5");
    assert_eq!(all["options"]["interface_modes"], Value::Null);
    assert_eq!(all["quality"]["interface_reduction"], Value::Null);
    folder.done("compare seven.dcb.h5 all.dcb.h5");
}

#[test]
fn interface_modes_may_be_none_or_more_than_there_are() {
    let folder = Folder::rotor();
    let shown = folder
        .run("rotor.mtx --modes 12 --interface-modes 0 -o none.dcb.h5 -v")
        .stdout;
    says!(
        shown,
        "attachment coordinates: 0 for 12 rows; 12 direction(s) are left out",
        "interface modes                                0 of 12\n"
    );
    let shown = folder
        .run("rotor.mtx --modes 12 --interface-modes 40 -o many.dcb.h5 -v")
        .stdout;
    assert!(
        shown.contains(
            "interface modes                                12 of 12: all, 40 were asked for\n"
        ) && !shown.contains("lost"),
        "{shown}"
    );
    folder.done("rotor.mtx --modes 12 -o all.dcb.h5");
    assert_eq!(folder.digest("many.dcb.h5"), folder.digest("all.dcb.h5"));
    folder.set("rotor.json", "component/interfaces", json!([]));
    folder.warned(
        "rotor.mtx --modes 3 --interface-modes 5 -o bare.dcb.h5",
        &["no interface"],
    );
    let answer = folder.run("rotor.mtx --modes 3 --interface-modes 5 -o bare.dcb.h5 --force -v");
    says!(answer.stdout, "0 of 0: all, 5 were asked for");
}

#[test]
fn interface_modes_that_belong_together_are_not_cut() {
    let folder = Folder::rotor();
    // Both bearings bend alike about x and y.
    let shown = folder.done("rotor.mtx --modes 12 --interface-modes 4 -o four.dcb.h5");
    let kept = &folder.inspected("four.dcb.h5")["quality"]["interface_reduction"]["kept"];
    assert_eq!(
        shown.contains("4 were asked for, a multiple one is not cut"),
        *kept == json!(5),
        "{shown}"
    );
}

#[test]
fn a_frequency_limit_needs_a_known_unit_of_time() {
    let folder = Folder::rotor();
    folder.set("rotor.json", "component/units/time", "wink");
    folder.refused(
        "rotor.mtx --max-frequency 200",
        &["--max-frequency", "\"wink\"", "--modes"],
    );
}

#[test]
fn the_output_stands_beside_the_input_or_where_it_is_told() {
    let folder = Folder::rotor();
    std::fs::create_dir(folder.path("out")).unwrap();
    folder.done("rotor.mtx -o out/x.h5 --modes 3");
    assert!(!folder.path("rotor.dcb.h5").exists());
    let stdout = folder.done("./rotor.mtx --modes 3");
    says!(stdout, "wrote ./rotor.dcb.h5");
    assert_eq!(folder.digest("out/x.h5"), folder.digest("rotor.dcb.h5"));
}

#[test]
fn siblings_may_have_other_names() {
    let folder = Folder::rotor();
    for (from, to) in [
        ("rotor.mtx", "K.mtx"),
        ("rotor.mass.mtx", "M.txt"),
        ("rotor.json", "mesh.json"),
    ] {
        std::fs::rename(folder.path(from), folder.path(to)).unwrap();
    }
    folder.done("K.mtx --mass M.txt --mesh mesh.json --modes 3");
    let inputs = folder.inspected("K.dcb.h5")["inputs"].clone();
    let named: Vec<&Value> = list(&inputs).iter().map(|input| &input["file"]).collect();
    assert_eq!(named, ["K.mtx", "M.txt", "mesh.json"]);
}

#[test]
fn explicit_boundary_rows_follow_the_interfaces() {
    let folder = Folder::rotor();
    let matrix = "%%MatrixMarket matrix coordinate real general\n2 345 3\n1 1 1\n2 5 1\n2 8 -1\n";
    folder.write("rotor.boundary.mtx", matrix);
    folder.done("rotor.mtx --modes 3");
    let interfaces = folder.inspected("rotor.dcb.h5")["interfaces"].clone();
    assert_eq!(interfaces[2]["kind"], "boundary");
    assert_eq!(interfaces[2]["rows"], json!([null, null]));
    folder.done("verify rotor.dcb.h5 --component rotor.mtx");
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let digests = [1, 2, 4].map(|threads| {
        folder.done(&format!("part.mtx --threads {threads} -o {threads}.dcb.h5"));
        folder.digest(&format!("{threads}.dcb.h5"))
    });
    assert!(
        digests.iter().all(|digest| *digest == digests[0]),
        "{digests:?}"
    );
}

#[test]
fn quiet_says_nothing_and_verbose_lists_every_mode() {
    let folder = Folder::rotor();
    let is_mode = |line: &&str| line.split_whitespace().count() == 4 && line.starts_with("  ");
    let list = |stdout: &str| stdout.lines().filter(is_mode).count();
    let normal = folder.done("rotor.mtx --modes 20 --force");
    let verbose = folder.run("rotor.mtx --modes 20 --force -v").stdout;
    assert!(
        normal.lines().count() <= 6 && normal.contains("all checks hold"),
        "{normal}"
    );
    assert!(list(&verbose) >= list(&normal) + 20, "{verbose}");
    assert_eq!(folder.done("rotor.mtx --force --quiet"), "");
    assert_eq!(folder.done("verify -q rotor.dcb.h5"), "");
    // With a warning to suppress.
    assert_eq!(
        folder.done("rotor.mtx --force --quiet --max-frequency 50"),
        ""
    );
    // What was asked for is shown all the same.
    let shown = folder.done("inspect --quiet --json rotor.dcb.h5");
    assert!(shown.starts_with('{'), "{shown}");
    folder.refused("rotor.mtx --quiet", &["exists already"]);
}

#[test]
fn timings_name_every_stage_and_tell_how_much_was_computed() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --timings times.json");
    let times = folder.json("times.json");
    let stages = list(&times["stages"]).iter();
    let names = stages.clone().map(|stage| stage["stage"].as_str().unwrap());
    let names: Vec<&str> = names.collect();
    for stage in "read order factor modes attachments estimate invariants certificate quality write"
        .split(' ')
    {
        assert!(names.contains(&stage), "{stage} is missing: {names:?}");
    }
    let sum: f64 = stages.map(|stage| number(&stage["seconds"])).sum();
    assert!((sum - number(&times["total_seconds"])).abs() < 1e-9);
    let work = &times["work"];
    let count = |name: &str| work[name].as_u64().unwrap();
    for name in [
        "dofs",
        "factor_entries",
        "stored_bytes",
        "solve_columns",
        "lanczos_block_steps",
        "attachment_iterations",
        "threads",
    ] {
        assert!(count(name) > 0, "{name}: {work}");
    }
    assert!(number(&work["factor_flops"]) >= count("factor_entries") as f64);
    assert!(count("stored_bytes") >= 4 * count("factor_entries"));
    // A pass solves 1 to 16 columns.
    assert!(count("solve_passes") <= count("solve_columns"));
    assert!(32 * count("solve_passes") >= count("solve_columns"));
    for stage in list(&times["stages"]) {
        assert!(!cfg!(unix) || number(&stage["processor_seconds"]) >= 0.0);
    }
}

#[test]
fn the_same_run_twice_gives_the_same_digest() {
    let folder = Folder::rod();
    folder.done("rod.mtx");
    let first = folder.digest("rod.dcb.h5");
    folder.done("rod.mtx --force");
    assert_eq!(folder.digest("rod.dcb.h5"), first);
}

#[test]
fn fields_can_be_left_out_or_compressed_without_changing_the_rest() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx -o whole.dcb.h5");
    folder.done("rotor.mtx -o bare.dcb.h5 --without-fields");
    folder.done("rotor.mtx -o packed.dcb.h5 --compress");
    let [bare, packed, whole] =
        ["bare", "packed", "whole"].map(|name| folder.size(&format!("{name}.dcb.h5")));
    assert!(bare < packed && packed < whole);
    let found = |name: &str| folder.inspected(name);
    assert_eq!(found("bare.dcb.h5")["has_fields"], json!(false));
    assert_eq!(found("packed.dcb.h5")["has_fields"], json!(true));
    for key in [
        "eigenvalues",
        "mass",
        "residual_sigma_squared",
        "interfaces",
    ] {
        assert_eq!(found("whole.dcb.h5")[key], found("bare.dcb.h5")[key]);
        assert_eq!(found("whole.dcb.h5")[key], found("packed.dcb.h5")[key]);
    }
    for name in ["whole.dcb.h5", "bare.dcb.h5", "packed.dcb.h5"] {
        let shown = folder.done(&format!("verify {name} --component rotor.mtx -v"));
        assert_eq!(
            shown.contains("reduced anew"),
            name == "bare.dcb.h5",
            "{shown}"
        );
    }
}

#[test]
fn every_mode_can_be_kept() {
    let folder = Folder::rotor();
    // 345 dofs less 6 rigid motions.
    folder.done("rotor.mtx --modes 400");
    assert_eq!(folder.mode_count("rotor.dcb.h5"), 339);
    folder.done("verify rotor.dcb.h5 --component rotor.mtx");
}

/// More modes than one filling of the Lanczos basis finds.
#[test]
fn many_modes_converge() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    folder.done("part.mtx --modes 60");
    assert_eq!(folder.mode_count("part.dcb.h5"), 60);
}

/// Each of them can be read only once.
#[test]
#[cfg(unix)]
fn pipes_are_read() {
    let folder = Folder::rotor();
    for files in [
        "<(cat rotor.mtx) --mass <(cat rotor.mass.mtx) --mesh rotor.json",
        "rotor.mtx --mass rotor.mass.mtx --mesh <(cat rotor.json)",
    ] {
        let script = format!("\"$0\" {files} --modes 4 -o piped.dcb.h5 --force");
        let output = folder.shell(&script).output().unwrap();
        assert!(output.status.success(), "{files}: {output:?}");
    }
}
