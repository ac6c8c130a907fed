//! Other programs' files, from the command line to the superelement.

use std::fs;

use dcb_formats::dcb::SuperelementFile;

use crate::support::{Folder, has_all, stored};

impl Folder {
    /// With files of `tests/data/exchange`.
    pub fn exchange(names: &[&str]) -> Self {
        let folder = Self::empty();
        for name in names {
            let from = stored("tests/data/exchange").join(name);
            let own = from.file_name().unwrap().to_str().unwrap().to_owned();
            fs::copy(&from, folder.path(&own)).unwrap_or_else(|error| panic!("{name}: {error}"));
        }
        folder
    }

    fn frequency(&self, name: &str, nth: usize) -> f64 {
        let file = SuperelementFile::open(self.path(name)).unwrap();
        file.superelement().unwrap().modes.eigenvalues[nth].sqrt() / std::f64::consts::TAU
    }
}

const CALCULIX: [&str; 4] = [
    "calculix/bracket.sti",
    "calculix/bracket.mas",
    "calculix/bracket.dof",
    "calculix/bracket.inp",
];

/// Everything beside the stiffness is found, and the frequencies are those of CalculiX (its `.dat` has 7 digits).
#[test]
fn one_command_is_enough() {
    let folder = Folder::exchange(&CALCULIX);
    let answer = folder.run("bracket.sti --units mm,t,s --modes 8");
    assert_eq!(answer.code, Some(0), "{answer:?}");
    has_all(
        &answer.stdout,
        &["240 degrees of freedom reduced to", "wrote bracket.dcb.h5"],
    );
    for (nth, expected) in [531_961_600.0_f64, 3_619_629_000.0].into_iter().enumerate() {
        let expected = expected.sqrt() / std::f64::consts::TAU;
        let found = folder.frequency("bracket.dcb.h5", nth);
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    }
}

/// The files of a component, or none of them; the same superelement from them as from the files of the other program.
#[test]
fn an_import_writes_the_files_of_a_component() {
    let folder = Folder::exchange(&CALCULIX);
    let answer =
        folder.run("import bracket.sti --units mm,t,s --interfaces foot:rigid,tip -o part.mtx");
    assert_eq!(answer.code, Some(0), "{answer:?}");
    has_all(
        &answer.stdout,
        &[
            "CalculiX",
            "240",
            "wrote part.mtx",
            "wrote part.mass.mtx",
            "wrote part.json",
        ],
    );
    folder.refused(
        "import bracket.sti --units mm,t,s -o part.mtx",
        &["part.mtx", "--force"],
    );
    let own = folder.run("part.mtx --modes 8");
    let at_once = folder.run("bracket.sti --units mm,t,s --interfaces foot:rigid,tip --modes 8");
    assert_eq!(
        (own.code, at_once.code),
        (Some(0), Some(0)),
        "{own:?} {at_once:?}"
    );
    for nth in 0..8 {
        let (a, b) = (
            folder.frequency("part.dcb.h5", nth),
            folder.frequency("bracket.dcb.h5", nth),
        );
        assert_eq!(a.to_bits(), b.to_bits());
    }
}

#[test]
fn nothing_is_guessed() {
    let folder = Folder::exchange(&[
        "calculix/bracket.sti",
        "calculix/bracket.mas",
        "calculix/bracket.dof",
        "calculix/bracket.inp",
        "calculix/bracket_held.sti",
        "calculix/bracket_held.mas",
        "calculix/bracket_held.dof",
        "calculix/bracket_held.inp",
        "calculix/plate_shell.sti",
        "calculix/plate_shell.mas",
        "calculix/plate_shell.dof",
        "calculix/plate_shell.inp",
        "ansys/bracket_stiff_5digits.matrix",
        "ansys/bracket_mass.matrix",
        "scipy/pickled.npz",
        "matlab/bracket_v4.mat",
    ]);
    folder.refused("import bracket.sti -o part.mtx", &["--units m,kg,s"]);
    folder.refused("bracket.sti", &["--units m,kg,s"]);
    folder.refused(
        "bracket_held.sti --units mm,t,s",
        &[
            "K R",
            "8 nodes of the mesh have no rows",
            "without supports",
        ],
    );
    folder.refused(
        "plate_shell.sti --units mm,t,s",
        &["plate_shell.dof", "solid"],
    );
    folder.refused(
        "bracket_stiff_5digits.matrix --mass bracket_mass.matrix --mesh bracket.inp --node-order label --units mm,t,s",
        &["5 significant digits", "export more digits"],
    );
    folder.refused(
        "pickled.npz --mesh bracket.inp --units mm,t,s",
        &["pickled"],
    );
    folder.refused("bracket_v4.mat --mesh bracket.inp --units mm,t,s", &["-v7"]);
    folder.refused(
        "bracket.sti --units mm,t,s --interfaces tipp",
        &["no node set is named \"tipp\"", "did you mean"],
    );
    folder.refused(
        "bracket.sti --units mm,t",
        &["expected length, mass and time"],
    );
    folder.refused(
        "bracket.sti --mass bracket.sti --units mm,t,s",
        &["the same matrix"],
    );
}

/// The public rotor of Ansys: its rows are in the solver's order. Its map says which; without it, the stiffness does. The frequency is published.
#[test]
fn an_unknown_order_is_told_and_repaired() {
    let folder = Folder::exchange(&[
        "ansys/rotor_stiffness.txt",
        "ansys/rotor_mass.txt",
        "ansys/rotor_map.txt",
        "ansys/rotor_nodes.txt",
    ]);
    let import =
        "rotor_stiffness.txt --mass rotor_mass.txt --mesh rotor_nodes.txt --units m,kg,s --modes 4";
    folder.refused(import, &["K R = ", "--repair-order"]);
    for more in ["--dofs rotor_map.txt", "--repair-order --force"] {
        let answer = folder.run(&format!("{import} {more}"));
        assert_eq!(answer.code, Some(0), "{answer:?}");
        let is_repaired = answer
            .stderr
            .contains("was found from the stiffness (--repair-order): K R was ");
        assert_eq!(is_repaired, more.starts_with("--repair"), "{answer:?}");
        let found = folder.frequency("rotor_stiffness.dcb.h5", 0);
        assert!((found - 104.637_010_551).abs() < 1e-6, "{found}");
    }
}

#[test]
fn a_description_is_drafted_from_a_mesh() {
    let folder = Folder::exchange(&["mesh/bracket_ascii.msh", "bracket.mtx", "bracket.mass.mtx"]);
    let answer = folder.run("init bracket_ascii.msh --units mm,t,s --node-order label --interfaces foot:rigid,tip -o bracket.json");
    assert_eq!(answer.code, Some(0), "{answer:?}");
    has_all(
        &answer.stdout,
        &["240 rows", "foot (8 nodes)", "wrote bracket.json"],
    );
    let answer = folder.run("bracket.mtx --modes 8");
    assert_eq!(answer.code, Some(0), "{answer:?}");
}

#[test]
fn inspect_lists_the_matrices_of_a_file() {
    let folder = Folder::exchange(&["matlab/bracket_v5.mat", "nastran/bracket_double.pch"]);
    has_all(
        &folder.done("inspect bracket_v5.mat"),
        &["MATLAB 5", "K", "M", "240 x 240"],
    );
    has_all(
        &folder.done("inspect bracket_double.pch --json"),
        &["\"KAAX\"", "\"MAAX\""],
    );
}

/// What decides the component beside the files decides the key too.
#[test]
fn a_cache_tells_imports_apart() {
    let folder = Folder::exchange(&CALCULIX);
    let reduce = "bracket.sti --units mm,t,s --modes 4 --cache=c";
    let first = folder.run(&format!("{reduce} --interfaces foot -o one.dcb.h5"));
    let other = folder.run(&format!("{reduce} --interfaces tip:rigid -o two.dcb.h5"));
    let again = folder.run(&format!("{reduce} --interfaces tip:rigid -o three.dcb.h5"));
    for answer in [&first, &other, &again] {
        assert_eq!(answer.code, Some(0), "{answer:?}");
    }
    assert!(!other.stdout.contains("from the cache"), "{other:?}");
    assert!(again.stdout.contains("from the cache"), "{again:?}");
    let interface = |name: &str| {
        let file = SuperelementFile::open(folder.path(name)).unwrap();
        file.superelement().unwrap().interfaces[0].name.clone()
    };
    assert_eq!(interface("one.dcb.h5"), "FOOT");
    assert_eq!(interface("two.dcb.h5"), "TIP");
    assert_eq!(interface("three.dcb.h5"), "TIP");
}

/// Files that are cut off inside a number, orders that nobody said, units that contradict each other: nothing wrong comes out of them in silence.
#[test]
fn damage_that_leaves_a_readable_file_is_refused() {
    let folder = Folder::exchange(&[
        "bracket.mtx",
        "bracket.mass.mtx",
        "bracket.json",
        "mesh/bracket.bdf",
        "scipy/bracket_dof_ref.npz",
        "scipy/bracket_M_csr.npz",
        "calculix/bracket.inp",
        "calculix/bracket_rigid.sti",
        "calculix/bracket_rigid.mas",
        "calculix/bracket_rigid.dof",
        "calculix/bracket_rigid.inp",
        "nastran/variants_double.pch",
    ]);
    let cut = |from: &str, to: &str, missing: usize| {
        let bytes = folder.bytes(from);
        folder.write(to, &bytes[..bytes.len() - missing]);
    };
    // Its exponent, its last digits, or its line end alone.
    for missing in [1, 2, 9] {
        cut("bracket.mass.mtx", "cut.mass.mtx", missing);
        folder.refused(
            "import bracket.mtx cut.mass.mtx --mesh bracket.json -o part.mtx",
            &["cut.mass.mtx:3242", "ends within this line"],
        );
    }
    let deck = String::from_utf8(folder.bytes("bracket.inp")).unwrap();
    let set = deck.to_ascii_uppercase().rfind("*NSET").unwrap();
    let end = set + deck[set..].find(',').unwrap() + 20;
    folder.write("cut.inp", &deck[..end]);
    folder.refused("init cut.inp --units mm,t,s", &["cut.inp", "line end"]);
    folder.refused(
        "import bracket_dof_ref.npz#K bracket_M_csr.npz --mesh bracket.bdf --units mm,t,s -o part.mtx",
        &["bracket_M_csr.npz", "rigid body", "--dofs"],
    );
    folder.refused(
        "import bracket.mtx --mesh bracket.json --units m,kg,s -o part.mtx",
        &["mm,t,s", "m,kg,s"],
    );
    folder.refused(
        "import bracket_rigid.sti --units mm,t,s --interfaces tip -o part.mtx",
        &["TIP", "without rows"],
    );
    let minus = String::from_utf8(folder.bytes("bracket.mtx")).unwrap();
    let minus = minus.replacen("1 1 ", "1 1 -", 1);
    folder.write("minus.mtx", minus);
    folder.refused(
        "import minus.mtx bracket.mass.mtx --mesh bracket.json -o part.mtx",
        &["minus.mtx", "K R"],
    );
    folder.refused(
        "init bracket.inp --units mm,t,s -o bracket.inp --force",
        &["can't be an output"],
    );
    assert!(!folder.path("part.mtx").exists());
}

/// A mark in front of a text means nothing; what is packed is read or refused by that.
#[test]
fn marks_and_packings_of_files_are_told() {
    let folder = Folder::exchange(&[
        "bracket.json",
        "matlab/bracket_v5.mat",
        "calculix/bracket.inp",
        "mesh/bracket_ascii.msh",
        "mesh/bracket.unv",
        "nastran/variants_double.pch",
    ]);
    let marked = |name: &str| {
        let marked = [b"\xef\xbb\xbf".as_slice(), &folder.bytes(name)].concat();
        folder.write(&format!("marked_{name}"), marked);
    };
    for mesh in ["bracket.inp", "bracket_ascii.msh", "bracket.unv"] {
        marked(mesh);
        let answer = folder.run(&format!(
            "import bracket_v5.mat --mesh marked_{mesh} --node-order label --units mm,t,s -o part.mtx --force"
        ));
        assert_eq!(answer.code, Some(0), "{mesh}: {answer:?}");
    }
    let packed = |name: &str, to: &str| {
        let script = format!("gzip -c {name} > {to}");
        assert!(folder.shell(&script).status().unwrap().success());
    };
    packed("bracket_v5.mat", "packed.mat");
    packed("bracket_ascii.msh", "packed.msh");
    folder.refused(
        "import packed.mat --mesh bracket.json -o p.mtx",
        &["gunzip"],
    );
    folder.refused("init packed.msh --units mm,t,s", &["gunzip"]);
    let old = String::from_utf8(folder.bytes("variants_double.pch")).unwrap();
    folder.write("old.pch", old.replace('\n', "\r"));
    folder.refused("inspect old.pch", &["old.pch", "CR alone"]);
}

/// What `reduce init` drafts from a deck has lost the labels of the nodes: the deck stays the mesh, and which one is read is said.
#[test]
fn a_draft_beside_the_deck_changes_nothing() {
    let folder = Folder::exchange(&CALCULIX);
    let drafted = folder.run("init bracket.inp --units mm,t,s");
    assert_eq!(drafted.code, Some(0), "{drafted:?}");
    let answer = folder.run("bracket.sti --units mm,t,s --modes 8");
    assert_eq!(answer.code, Some(0), "{answer:?}");
    has_all(
        &answer.stderr,
        &[
            "the mesh is bracket.inp",
            "bracket.json beside it is not read",
        ],
    );
    let expected = 531_961_600.0_f64.sqrt() / std::f64::consts::TAU;
    let found = folder.frequency("bracket.dcb.h5", 0);
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    folder.refused(
        "bracket.sti --mesh bracket.json -o other.dcb.h5",
        &["rigid motions of the mesh bracket.json are resisted"],
    );
    folder.refused(
        "init bracket.sti --units mm,t,s --force",
        &["bracket.sti: is a matrix", "name bracket.inp"],
    );
}

/// Of a matrix alone: what isn't known is a text that says what goes there, and is refused until it is replaced.
#[test]
fn a_matrix_alone_makes_a_template() {
    let folder = Folder::exchange(&["bracket.mtx", "bracket.mass.mtx"]);
    let answer = folder.run("init bracket.mtx --units mm,t,s");
    assert_eq!(answer.code, Some(0), "{answer:?}");
    has_all(
        &answer.stdout,
        &[
            "240 rows: 80 nodes with ux uy uz",
            "wrote bracket.json, a template",
            "reduce bracket.mtx",
        ],
    );
    folder.refused("bracket.mtx", &["bracket.json", "Replace this text"]);
    folder.refused("init bracket.mtx --units mm,t,s", &["bracket.json", "mesh"]);
    folder.refused(
        "init bracket.mass.mtx --units mm,t,s --dofs ux,uy,uz,rx,ry,rz,p",
        &["--dofs"],
    );
    let text = fs::read_to_string(folder.path("bracket.json")).unwrap();
    let whole = fs::read_to_string(stored("tests/data/exchange/bracket.json")).unwrap();
    let mut filled: serde_json::Value = serde_json::from_str(&text).unwrap();
    let known: serde_json::Value = serde_json::from_str(&whole).unwrap();
    filled["points"] = known["points"].clone();
    for (interface, nodes) in [(0, [0, 21, 25, 28]), (1, [3, 10, 17, 24])] {
        filled["component"]["interfaces"][interface]["nodes"] = nodes.into_iter().collect();
    }
    fs::write(folder.path("bracket.json"), filled.to_string()).unwrap();
    let answer = folder.run("bracket.mtx --modes 4");
    assert_eq!(answer.code, Some(0), "{answer:?}");
}
