//! `docs/messages.md`: every message on the page is one that a program gives, and every case here is on the page.

use std::fs;

use crate::printed::{blocks, folder_with_samples, shell};
use crate::support::stored;

/// `edit FILE STATEMENT` changes the value `d` of a JSON file, in Python.
const EDIT: &str = r#"edit() { python3 -c 'import json, sys
name, statement = sys.argv[1:]
d = json.load(open(name)); exec(statement); json.dump(d, open(name, "w"))' "$@"; }"#;

/// The shipped rotor's files, to be changed.
const ROTOR: &str =
    "cp samples/data/rotor/rotor.* samples/data/rotor/rotor.mass.mtx .; chmod u+w *;";
const ROTOR_CASES: &[&str] = &[
    "rm rotor.json; reduce rotor.mtx",
    "rm rotor.mass.mtx; reduce rotor.mtx",
    "mv rotor.mtx a; mv rotor.mass.mtx rotor.mtx; mv a rotor.mass.mtx; reduce rotor.mtx",
    "head -c 20000 rotor.mtx > a; mv a rotor.mtx; reduce rotor.mtx",
    "sed -i 1s/symmetric/general/ rotor.mtx; reduce rotor.mtx",
    "sed -i -E 's/([0-9]\\.[0-9]{4})[0-9]*/\\1/' rotor.mtx; reduce rotor.mtx",
    "edit rotor.json 'd[\"points\"].reverse()'; reduce rotor.mtx",
    "edit rotor.json 'd[\"component\"][\"interfaces\"][0][\"point_set\"] = \"bearing\"'; reduce rotor.mtx",
    "edit rotor.json 'd[\"point_sets\"][\"bearing_left\"] = [1]'; reduce rotor.mtx",
    "reduce rotor.mtx --modes 4 -q; reduce rotor.mtx",
    "reduce rotor.mtx --modes 4 -q; reduce inspect rotor.dcb.h5 --band 1:5000",
    "reduce rotor.mtx --modes 4 -q; head -c 3000 rotor.dcb.h5 > a.dcb.h5; reduce inspect a.dcb.h5",
    "reduce rotor.mtx --modes 4 -q
     python3 -c 'b = bytearray(open(\"rotor.dcb.h5\", \"rb\").read()); b[len(b) // 2] ^= 255; open(\"rotor.dcb.h5\", \"wb\").write(b)'
     reduce inspect rotor.dcb.h5",
    "edit rotor.json 'd[\"component\"][\"interfaces\"][0] = {\"name\": \"bearing-left\", \"kind\": \"nodes\", \"nodes\": [1]}'
     reduce rotor.mtx --modes 4 -q
     echo '{\"dimension\": 3, \"units\": {\"length\": \"m\", \"mass\": \"kg\", \"time\": \"s\"}, \"bodies\": {\"rotor\": {\"superelement\": \"rotor.dcb.h5\"}},
       \"joints\": {\"end\": {\"fixed\": {\"a\": \"ground\", \"b\": \"rotor/bearing-left\"}}}, \"outputs\": {\"energy\": \"energy\"},
       \"integrator\": {\"generalized_alpha\": {\"step\": 1e-4, \"end\": 0.01}}}' > scene.json
     simulate scene.json",
    "reduce rotor.mtx --step 3",
    "reduce rotor.mtx --memory 1M",
    "echo 1 > part.op2; reduce part.op2 --units mm,t,s",
];

/// Generated parts that can't be reduced, and files of other programs.
const OTHER_CASES: &[&str] = &[
    "samples write grounded-block --out .; reduce grounded-block.mtx",
    "samples write two-loose-blocks --out .; reduce two-loose-blocks.mtx",
    "samples write edge-hinge --out .; reduce edge-hinge.mtx",
    "samples write orphan-dof-block --out .; reduce orphan-dof-block.mtx",
    "reduce exchange/calculix/bracket.sti -o a.dcb.h5",
    "reduce exchange/nastran/bracket_bigmat_be.op4 --mesh exchange/mesh/bracket.bdf --units mm,t,s -o a.dcb.h5",
];

/// The slider-crank, to be changed.
const CRANK: &str = "cp samples/slider-crank/* .; chmod u+w *;";
const CRANK_CASES: &[&str] = &[
    "edit scene.json 'd[\"drives\"][\"motor\"] = {\"angle\": {\"joint\": \"axle\", \"formula\": \"mini(t, 1)\"}}'; simulate scene.json",
    "edit scene.json 'd[\"output\"] = d.pop(\"outputs\")'; simulate scene.json",
    "edit scene.json 'd[\"gravity\"] = -9.81'; simulate scene.json",
    "edit scene.json 'd[\"joints\"][\"axle\"] = {\"type\": \"revolute\", **d[\"joints\"][\"axle\"][\"revolute\"]}'; simulate scene.json",
    "edit scene.json 'd[\"integrator\"][\"hht\"] = {\"step\": 1e-5, \"end\": 0.01}'; simulate scene.json",
    "edit scene.json 'd[\"joints\"][\"wrist\"][\"revolute\"][\"b\"] = \"rod/left\"'; simulate scene.json",
    "edit scene.json 'd[\"units\"][\"length\"] = \"mm\"'; simulate scene.json",
    "edit scene.json 'd[\"drives\"][\"motor\"][\"angle\"][\"joint\"] = \"guide\"'; simulate scene.json",
    "edit scene.json 'd[\"bodies\"][\"slider\"][\"position\"] = [0.95, 0]'; simulate scene.json",
    "edit scene.json 'd[\"joints\"][\"guide\"] = {\"fixed\": {\"a\": \"ground\", \"b\": \"slider/pin\"}}'; simulate scene.json",
    "edit scene.json 'd[\"drives\"][\"push\"] = {\"position\": {\"joint\": \"guide\", \"polynomial\": [0, 5]}}'; simulate scene.json",
    "edit scene.json 'del d[\"drives\"]; d[\"analysis\"] = \"kinematic\"'; simulate scene.json",
    "simulate scene.json --end 1e-6",
    "simulate scene.json --step 5e-3",
    "simulate scene.json --compatibility weak",
    "simulate scene.json -q; simulate plot scene.h5 crank_angel",
    "simulate scene.json -q; mv rod.dcb.h5 elsewhere; simulate animate scene.h5",
    "echo '{\"dimension\": 2, \"units\": {\"length\": \"m\", \"mass\": \"kg\", \"time\": \"s\"}, \"gravity\": [0, -9.81],
       \"bodies\": {\"free\": {\"rigid\": {\"mass\": 1, \"inertia\": 1}}}, \"analysis\": \"static\", \"outputs\": {\"energy\": \"energy\"}}' > free.json
     simulate free.json",
    "sed -i 's/150\\]/600]/; s/: 150/: 600/; s/-75/-300/; s/22.5/90/' scene.json; simulate scene.json --end 0.01",
    "simulate init samples/gallery/parts/upper-arm.dcb.h5 samples/gallery/parts/forearm.dcb.h5 -o arm.json -q; simulate arm.json --step 5e-3",
];

/// Scenes of other pages.
fn pages() -> Vec<String> {
    let first = |page: &str, file: &str| {
        let page = fs::read_to_string(stored(page)).unwrap();
        let mut blocks = blocks(&page).into_iter();
        let block = blocks.find(|block| block.text.contains(file)).unwrap();
        block.text.replace("../samples", "samples")
    };
    let door = first("docs/redundant-joints.md", "door.json");
    let refused = format!(
        "{door} edit door.json 'd[\"redundant_constraints\"] = \"refuse\"'; simulate door.json --force"
    );
    vec![door, refused, first("docs/damping.md", "clamped.json")]
}

/// The messages of a page: what stands in bold code, up to what depends on files.
fn messages(page: &str) -> Vec<Vec<&str>> {
    let lines = page.lines().filter_map(|line| line.strip_prefix("**`"));
    lines
        .map(|line| line.split("`**").next().unwrap().split('…').collect())
        .collect()
}

/// Are all pieces in a text, one behind the other?
fn holds(text: &str, pieces: &[&str]) -> bool {
    let mut rest = Some(text);
    for piece in pieces {
        rest = rest.and_then(|rest| rest.split_once(piece.trim()).map(|(_, after)| after));
    }
    rest.is_some()
}

#[test]
fn the_messages_of_the_page_are_those_of_the_programs() {
    let page = fs::read_to_string(stored("docs/messages.md")).unwrap();
    let messages = messages(&page);
    assert!(messages.len() >= 40, "{}", messages.len());
    let of = |begin: &str, cases: &[&str]| -> Vec<String> {
        cases
            .iter()
            .map(|case| format!("{begin}\n{case}"))
            .collect()
    };
    let cases = [
        of(ROTOR, ROTOR_CASES),
        of("", OTHER_CASES),
        of(CRANK, CRANK_CASES),
        pages(),
    ];
    let mut given = vec![false; messages.len()];
    for case in cases.concat() {
        let folder = folder_with_samples();
        std::os::unix::fs::symlink(stored("tests/data/exchange"), folder.path("exchange")).unwrap();
        let said = shell(&folder.path(""), &format!("{EDIT}\n{case}")).text;
        let mut is_known = false;
        for (message, given) in messages.iter().zip(&mut given) {
            if holds(&said, message) {
                (is_known, *given) = (true, true);
            }
        }
        assert!(is_known, "not in docs/messages.md: {case}\n{said}");
    }
    for (message, given) in messages.iter().zip(given) {
        assert!(given, "nothing says so any more: {}", message.join("…"));
    }
}
