//! Loads and geometric stiffness beside the matrices, and the columns of `--enrich`.

use dcb_formats::Component;
use dcb_formats::component::{ComponentDraft, NamedLoad};
use dcb_formats::dcb::SuperelementFile;
use dcb_samples::{RodSection, SolidElement, axial_prestress, planar_rod};

use crate::support::{Folder, says};

fn solid_with_load() -> Component {
    let material = dcb_samples::Material::STEEL;
    let mut part = dcb_samples::box_block(
        [4, 2, 1],
        [0.4, 0.1, 0.05],
        SolidElement::Tetra10,
        &material,
    )
    .into_draft();
    part.loads = vec![NamedLoad {
        name: "wind".into(),
        forces: (0..part.dofs.len()).map(|i| (i as f64).sin()).collect(),
    }];
    Component::checked(part).unwrap()
}

fn stiffened_rod() -> Component {
    let section = RodSection::default();
    let rod = planar_rod(6, &section);
    Component::checked(ComponentDraft {
        geometric_stiffness: Some(axial_prestress(&rod, section.density * section.area)),
        ..rod.into_draft()
    })
    .unwrap()
}

#[test]
fn further_columns_are_written_named_and_verified() {
    let folder = Folder::with(&solid_with_load());
    let shown = folder.done("part.mtx --modes 6 --enrich spin,loads,krylov -o part.dcb.h5");
    says!(
        shown,
        "19 further columns (spin xx, spin yy",
        "load wind, krylov left/ux"
    );
    let element = SuperelementFile::open(folder.path("part.dcb.h5")).unwrap();
    assert_eq!(element.format_version().to_string(), "1.6");
    assert_eq!(
        element
            .recovery()
            .unwrap()
            .unwrap()
            .enrichment
            .unwrap()
            .ncols(),
        19
    );
    let shown = folder.done("verify part.dcb.h5 --component part.mtx -v");
    for what in [
        "load.wind (part.load.wind.mtx)",
        "further columns answer to their loads",
        "L_b X",
        "reduced mass",
        "reduced stiffness",
        "I1",
    ] {
        says!(shown, format!("ok   {what}"));
    }
    let shown = folder.done("inspect part.dcb.h5 -v");
    says!(shown, "19 further columns");
}

#[test]
fn geometric_stiffness_is_projected_and_verified() {
    let folder = Folder::with(&stiffened_rod());
    let shown = folder.done("part.mtx --modes 4");
    says!(shown, "geometric stiffening");
    let element = SuperelementFile::open(folder.path("part.dcb.h5")).unwrap();
    let stiffening = element.superelement().unwrap().stiffening;
    // Rows a/ux, a/uy, b/ux, b/uy; only those along the rod stiffen it, one pushing and one pulling.
    assert_eq!(
        (stiffening.centrifugal.len(), stiffening.interface.len()),
        (1, 4)
    );
    let first = |row: usize| stiffening.interface[row][(0, 0)];
    assert!(stiffening.centrifugal[0][(0, 0)] > 0.0);
    assert!(first(0) < 0.0 && first(2) > 0.0 && first(1) == 0.0 && first(3) == 0.0);
    assert!((first(0) / first(2) + 1.0).abs() < 1e-9);
    let shown = folder.done("verify part.dcb.h5 --component part.mtx -v");
    for what in ["centrifugal stiffening", "interface stiffening"] {
        says!(shown, format!("ok   {what}"));
    }
    // Another part's matrix doesn't pass for it.
    let text = folder.read("part.stiffening.zz.mtx");
    let doubled: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(number, line)| match (number, line.rsplit_once(' ')) {
            (2.., Some((place, value))) => {
                format!("{place} {:e}", 2.0 * value.parse::<f64>().unwrap())
            }
            _ => line.to_owned(),
        })
        .collect();
    folder.write("part.stiffening.zz.mtx", doubled.join("\n") + "\n");
    let shown = folder.failed(
        1,
        "verify part.dcb.h5 --component part.mtx",
        &["centrifugal stiffening"],
    );
    says!(shown, "not verified");
}

#[test]
fn files_that_do_not_fit_are_refused_by_name() {
    let folder = Folder::rod();
    folder.refused_each(&[
        ("rod.mtx --enrich loads", &["rod.mtx", "PART.load.NAME.mtx"]),
        (
            "rod.mtx --enrich gravity",
            &["gravity", "spin, loads, krylov"],
        ),
    ]);
    folder.write(
        "rod.load.wind.mtx",
        "%%MatrixMarket matrix array real general\n3 1\n1\n2\n3\n",
    );
    folder.refused("rod.mtx", &["rod.load.wind.mtx", "3 x 1", "15 entries"]);
    let zeros = format!(
        "%%MatrixMarket matrix array real general\n15 1\n{}",
        "0\n".repeat(15)
    );
    folder.write("rod.load.wind.mtx", &zeros);
    folder.refused("rod.mtx", &["rod.load.wind.mtx", "isn't zero"]);
    folder.remove("rod.load.wind.mtx");
    let matrix = "%%MatrixMarket matrix coordinate real symmetric\n15 15 1\n2 2 1.0\n";
    folder.write("rod.stiffening.sideways.mtx", matrix);
    folder.refused("rod.mtx", &["rod.stiffening.sideways.mtx", "zz", "a, b"]);
    folder.remove("rod.stiffening.sideways.mtx");
    folder.write("rod.stiffening.a.uq.mtx", matrix);
    folder.refused("rod.mtx", &["rod.stiffening.a.uq.mtx", "INTERFACE.ux"]);
    folder.remove("rod.stiffening.a.uq.mtx");
    folder.write("rod.stiffening.zz.mtx", matrix.replace("15 15", "14 14"));
    folder.refused("rod.mtx", &["rod.stiffening.zz.mtx", "14 x 14", "15 dofs"]);
    folder.write("rod.stiffening.zz.mtx", matrix);
    folder.write("rod.stiffening.zz.mtx.gz", "");
    folder.refused("rod.mtx", &["rod.stiffening.zz.mtx.gz", "as well"]);
}
