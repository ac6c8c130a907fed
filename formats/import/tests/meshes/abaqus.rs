//! Decks of Abaqus and CalculiX.

use crate::samples::{labels, read, read_text, set};

const NODES: &str =
    "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n";

#[test]
fn a_rigid_body_names_its_nodes_and_they_are_dependent() {
    let mesh = read("calculix/bracket_rigid.inp").mesh;
    let body = &mesh.rigid_bodies[0];
    assert_eq!(mesh.rigid_bodies.len(), 1);
    assert_eq!(
        labels(&mesh, &[body.reference, body.rotation.unwrap()]),
        [9001, 9002]
    );
    assert_eq!(labels(&mesh, &body.nodes), set(&mesh, "TIP"));
    assert_eq!(mesh.dependent, body.nodes);
    assert_eq!(labels(&mesh, &mesh.nodes_without_cells()), [9001, 9002]);
    assert_eq!(mesh.points[body.reference as usize], [66.0, 14.3, 48.0]);
}

#[test]
fn held_nodes_are_told_and_transforms_noted() {
    let mesh = read("calculix/bracket_held.inp").mesh;
    assert_eq!(labels(&mesh, &mesh.held), set(&mesh, "FOOT"));
    let mesh = read("calculix/bracket_transform.inp").mesh;
    assert!(
        mesh.notes[0].contains("*TRANSFORM turns axes of `TIP`"),
        "{:?}",
        mesh.notes
    );
    let mesh = read("calculix/plate_shell.inp").mesh;
    assert_eq!(mesh.cells[0].cell_type, "quad");
    assert_eq!(
        read("calculix/plate_incompatible.inp").mesh.cells[0].cell_type,
        "hexahedron"
    );
}

#[test]
fn keys_in_any_spelling_sets_of_sets_and_generated_ones() {
    let text = "** a comment\n*heading\nanything, at * all\n* Node , n set = All\n 1, 0., .5 , 1.5D+0\n 2 ,1.5-1\n\n3,1,0,0, 0,0,1\n** between\n4,1E0,1,0\n\
        *element, type=c3d4 , ELSET=\"my part\"\n7, 1,2,\n 3,4\n*NSET,NSET=odd,GENERATE\n1,2147483647,2\n*Nset, nset=both\nodd, 4\n2,1\n\
        *nset, nset=of elements, elset=\"MY PART\"\n*ELSET, ELSET=again\nmy part\n*SURFACE, NAME=flat, TYPE=NODE\nodd, 1.\n*STEP\n*STATIC\n1.,1.\n*END STEP\n";
    let mesh = read_text(text).unwrap();
    assert_eq!(mesh.labels.as_deref(), Some(&[1, 2, 3, 4][..]));
    assert_eq!(
        mesh.points,
        [
            [0.0, 0.5, 1.5],
            [0.15, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0]
        ]
    );
    assert_eq!(mesh.cells[0].cell_type, "tetra");
    assert_eq!(set(&mesh, "All"), [1, 2, 3, 4]);
    assert_eq!(set(&mesh, "odd"), [1, 3]);
    assert_eq!(set(&mesh, "both"), [1, 3, 4, 2]);
    assert_eq!(set(&mesh, "of elements"), [1, 2, 3, 4]);
    assert_eq!(set(&mesh, "flat"), [1, 3]);
    assert_eq!(set(&mesh, "my part"), [1, 2, 3, 4]);
    assert_eq!(set(&mesh, "again"), [1, 2, 3, 4]);
}

#[test]
fn one_part_with_one_instance_is_read_with_both_scopes_of_sets() {
    let deck = |instance: &str, more: &str| {
        format!(
            "*Heading\n*Part, name=Rod\n{NODES}*Element, type=C3D8R\n1,1,2,3,4,5,6,7,8\n*Nset, nset=Set-1\n1,2\n*Nset, nset=_Picked, internal\n3\n*End Part\n\
             *Assembly, name=A\n*Instance, name=Rod-1, part=Rod\n{instance}*End Instance\n*Nset, nset=Set-1, instance=Rod-1\n3,4\n\
             *Nset, nset=Set-2\nRod-1.Set-1\n{more}*End Assembly\n*Boundary\nSet-1, ENCASTRE\n"
        )
    };
    let mesh = read_text(deck("", "")).unwrap();
    assert_eq!(set(&mesh, "Rod.Set-1"), [1, 2]);
    assert_eq!(set(&mesh, "Set-1"), [3, 4]);
    assert_eq!(mesh.sets.len(), 3, "{:?}", mesh.sets);
    assert!(mesh.notes[0].contains("numbers its nodes anew"));
    read_text(deck("0., 0., 0.\n", "")).unwrap();
    for (instance, more, said) in [
        ("1., 0., 0.\n", "", "*INSTANCE moves its part"),
        ("0,0,0\n0,0,0,1,0,0,90\n", "", "*INSTANCE moves its part"),
        (
            "",
            "*Instance, name=Rod-2, part=Rod\n*End Instance\n",
            "a second *INSTANCE",
        ),
        ("", "*Part, name=Other\n", "a second *PART"),
    ] {
        let error = read_text(deck(instance, more)).unwrap_err();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn unknown_types_keep_their_nodes_and_beams_lose_their_orientation() {
    let text = format!(
        "{NODES}*ELEMENT, TYPE=U5\n1, 1,2,3,\n4,5\n2, 8,7,6,5,4\n*ELEMENT, TYPE=B32\n3, 1,2,3,8\n*ELEMENT,TYPE=MASS\n4,1\n"
    );
    let mesh = read_text(text).unwrap();
    let cells: Vec<_> = mesh
        .cells
        .iter()
        .map(|cells| (cells.cell_type.as_str(), cells.nodes.as_slice()))
        .collect();
    assert_eq!(
        cells,
        [
            ("U5", &[0, 1, 2, 3, 4, 7, 6, 5, 4, 3][..]),
            ("line3", &[0, 2, 1]),
            ("vertex", &[0])
        ]
    );
}

#[test]
fn equations_and_mpcs_name_their_dependent_nodes() {
    let text = format!(
        "{NODES}*NSET,NSET=S\n6,7\n*EQUATION\n3\n2,1,1.,3,1,-1.,4,1,.5\n2\nS,2,1.,1,2,-1.\n*MPC\nTIE,8,1\n*TIE, NAME=T\na,b\n"
    );
    let mesh = read_text(text).unwrap();
    assert_eq!(labels(&mesh, &mesh.dependent), [2, 6, 7, 8]);
    assert!(
        mesh.notes[0].starts_with("*TIE ties nodes to others"),
        "{:?}",
        mesh.notes
    );
}

#[test]
fn what_cannot_be_right_is_refused_with_its_line() {
    for (text, said) in [
        (
            "*NODE\n1,0,0,0\n2147483648,0,0,0\n",
            "part:3: node: 2147483648 is no label",
        ),
        (
            "*NODE\n1,0,0,0\n1,0,0,1\n",
            "part: node 1: stands twice, at [0.0, 0.0, 0.0] and at [0.0, 0.0, 1.0]",
        ),
        (
            "*NODE\n1,0,0,0\n*ELEMENT,TYPE=MASS\n1,2\n",
            "part: element 1: of type vertex names node 2, which isn't there",
        ),
        (
            "*NODE\n1, 0,5, 1,5, 2,5\n",
            "part:2: has 6 numbers behind the label that are no coordinates and unit normal",
        ),
        ("*NODE\n1,x,0,0\n", "part:2: `x` is no number"),
        ("*NODE\n1,nan,0,0\n", "part:2: `nan` is not finite"),
        (
            "*NODE, SYSTEM=C\n1,0,0,0\n",
            "part:1: *NODE, SYSTEM=C has cylindrical",
        ),
        ("*NODE\n1,0,0,0\n*NGEN\n1,2\n", "part:3: *NGEN makes nodes"),
        (
            "*NODE\n1,0,0,0\n*ELEMENT,TYPE=C3D4\n1,1,1,1\n2,1,1,1,1\n",
            "part:4: element 1 of type C3D4 has 3 nodes, expected 4",
        ),
        (
            "*NODE\n1,0,0,0\n*ELEMENT,TYPE=C3D4\n1,1,1,1,1,1\n",
            "part:4: element 1 of type C3D4 has 5 nodes, expected 4",
        ),
        (
            "*NODE\n1,0,0,0\n*ELEMENT,TYPE=MASS\n1,1\n1,1\n",
            "part: element 1: stands twice",
        ),
        (
            "*NODE\n1,0,0,0\n*NSET,NSET=A\nB\n",
            "part: set A names the set `B`, which isn't there",
        ),
        (
            "*NODE\n1,0,0,0\n*NSET,NSET=A\nB\n*NSET,NSET=B\nA\n",
            "part: set B holds itself",
        ),
        (
            "*NODE\n1,0,0,0\n*NSET,NSET=A,GENERATE\n3,1\n",
            "part:4: goes from 3 to 1",
        ),
        (
            "*NODE\n1,0,0,0\n*INCLUDE,INPUT=../secret\n",
            "part:3: includes `../secret`; only files in or below",
        ),
        (
            "*NODE\n1,0,0,0\n*INCLUDE,INPUT=/etc/passwd\n",
            "part:3: includes `/etc/passwd`; only files in or below",
        ),
        (
            "*NODE\n1,0,0,0\n*INCLUDE,INPUT=part\n",
            "part:3: includes `part` a second time",
        ),
        (
            "*NODE\n1,0,0,0\n*INCLUDE,INPUT=nothing\n",
            "part:3: includes `nothing`, which can't be read",
        ),
        (
            "*NODE\n1,0,0,0\n*RIGID BODY, NSET=A, REF NODE=1\n",
            "part: *RIGID BODY: names the set A",
        ),
        (
            "*NODE\r1,0,0,0\r2,0,0,0\r",
            "part: has line ends of a carriage return alone",
        ),
        (
            "*HEADING\nold\r\nand\rolder\n",
            "part:3: has a carriage return that no line feed follows",
        ),
        ("*HEADING\n", "part: has no nodes"),
    ] {
        let error = read_text(text).unwrap_err();
        assert!(error.starts_with(said), "{error}\nexpected {said}");
    }
}

#[test]
fn labels_that_no_node_has_are_left_out_of_sets_with_a_note() {
    let mesh = read_text(format!("{NODES}*NSET,NSET=A\n1,100,2,101\n")).unwrap();
    assert_eq!(set(&mesh, "A"), [1, 2]);
    assert_eq!(
        mesh.notes,
        ["node set A: 2 labels that no node has are left out, the first is 100"]
    );
}

#[test]
fn included_files_below_the_folder_are_read_and_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    std::fs::write(folder.path().join("sub/nodes.inc"), "2,1,0,0\n").unwrap();
    std::fs::write(
        folder.path().join("sub/sets.inp"),
        "*NSET,NSET=S\n2\n*INCLUDE, INPUT=more.inp\n",
    )
    .unwrap();
    std::fs::write(folder.path().join("more.inp"), "1\n").unwrap();
    let path = folder.path().join("part.inp");
    std::fs::write(
        &path,
        "*NODE, INPUT=sub\\nodes.inc\n1,0,0,0\n*INCLUDE,INPUT=\"sub/sets.inp\"\n",
    )
    .unwrap();
    let mesh = dcb_import::mesh::read_mesh(&path).unwrap().mesh;
    assert_eq!(mesh.labels.as_deref(), Some(&[2, 1][..]));
    let names: Vec<&str> = mesh
        .included
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    assert_eq!(names, ["sub\\nodes.inc", "more.inp", "sub/sets.inp"]);
    // A link out of the folder.
    #[cfg(unix)]
    {
        let outside = tempfile::NamedTempFile::new().unwrap();
        std::os::unix::fs::symlink(outside.path(), folder.path().join("link")).unwrap();
        std::fs::write(&path, "*INCLUDE,INPUT=link\n").unwrap();
        let error = dcb_import::mesh::read_mesh(&path).unwrap_err().to_string();
        assert!(
            error.contains("a link that leads out of the folder"),
            "{error}"
        );
    }
}

#[test]
fn sets_that_repeat_each_other_end_soon() {
    // A thousand sets, each with the one before it a thousand times; ranges of all labels there could be.
    let mut text = String::from("*NODE\n");
    for node in 1..2000 {
        text += &format!("{},0,0,0\n", 1000 * node);
    }
    text += "*NSET,NSET=S0,GENERATE\n1,2147483647,1\n";
    for set in 1..1000 {
        text += &format!(
            "*NSET,NSET=S{set}\n{}",
            format!("S{}\n", set - 1).repeat(1000)
        );
        text += &format!(
            "*NSET,NSET=G{set},GENERATE\n{}",
            "1,2147483647,3\n".repeat(1000)
        );
    }
    let start = std::time::Instant::now();
    let error = read_text(text).unwrap_err();
    assert!(error.contains("far more nodes together"), "{error}");
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}
