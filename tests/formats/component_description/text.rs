//! Files as text: typing errors, broken JSON, damage, size.

use std::fmt::Write as _;
use std::path::Path;

use dcb_formats::mesh::Direction;
use dcb_formats::read_description;

use super::*;

#[test]
fn the_digest_is_that_of_the_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.json");
    std::fs::write(&path, documented("json")).unwrap();
    let digest = read_description(&path).unwrap().sha256;
    assert_eq!(digest.len(), 64);
    std::fs::write(&path, format!("{}\n", documented("json"))).unwrap();
    assert_ne!(
        read_description(&path).unwrap().sha256,
        digest,
        "one more byte"
    );
}

#[test]
fn a_typing_error_gives_line_column_and_the_nearest_name() {
    let text = "{\n  \"points\": [[0, 0]],\n  \"componnet\": {}\n}";
    assert_says(
        &refusal(text.as_bytes()),
        &["part.json:3: column 13: unknown field `componnet`; did you mean `component`?"],
    );
    let text = documented("json");
    for (right, wrong, parts) in [
        (
            "\"kind\": \"rigid\"",
            "\"knid\": \"rigid\"",
            ["unknown field `knid`; did you mean `kind`?", "point_set"],
        ),
        (
            "\"kind\": \"rigid\"",
            "\"kind\": \"rigit\"",
            ["unknown value `rigit`; did you mean `rigid`?", "average"],
        ),
        (
            "\"role\": \"output\"",
            "\"role\": \"ouput\"",
            [
                "unknown value `ouput`; did you mean `output`?",
                "attachment",
            ],
        ),
        (
            "\"mass\": \"kg\"",
            "\"Mass\": \"kg\"",
            ["unknown field `Mass`; did you mean `mass`?", "length"],
        ),
        (
            "\"modal\"",
            "\"model\"",
            ["unknown field `model`; did you mean `modal`?", "rayleigh"],
        ),
        (
            "\"weights\": [1, 1]",
            "\"weights\": \"aera\"",
            ["unknown value `aera`; did you mean `area`?", "uniform"],
        ),
        (
            "\"type\": \"quad\"",
            "\"typ\": \"quad\"",
            ["unknown field `typ`; did you mean `type`?", "data"],
        ),
        (
            "\"name\": \"plate\",",
            "",
            ["missing field `name`", "connecting-rod"],
        ),
        (
            "\"kind\": \"rigid\",",
            "",
            ["missing field `kind`", "average"],
        ),
    ] {
        let text = text.replacen(right, wrong, 1);
        let message = refusal(text.as_bytes());
        assert_says(&message, &parts);
        let line = message["part.json:".len()..]
            .split(':')
            .next()
            .unwrap()
            .parse::<usize>()
            .unwrap();
        assert!(
            wrong.is_empty() || text.lines().nth(line - 1).unwrap().contains(wrong),
            "{message}"
        );
        assert!(message.contains(": column "), "{message}");
    }
}

#[test]
fn text_that_is_no_json_is_refused_where_it_goes_wrong() {
    for literal in ["NaN", "Infinity", "-Infinity"] {
        let text = format!("{{\n\"points\": [[0, 0],\n [1, {literal}]]}}");
        assert_says(
            &refusal(text.as_bytes()),
            &[
                "part.json:3: column ",
                &format!("`{literal}` is not a number"),
                "finite",
            ],
        );
        let text = format!("{{\"point_data\": {{\"T\": [1.0, {literal}]}}}}");
        assert_says(
            &refusal(text.as_bytes()),
            &[&format!("`{literal}` is not a number")],
        );
    }
    assert_says(
        &refusal(b"{\"points\": [[0, 1e999]]}"),
        &["part.json:1: column 21", "number out of range"],
    );
    assert_says(
        &refusal(b"{\"points\": [[0, 0],]}"),
        &["part.json:1: column 20", "trailing comma"],
    );
    assert_says(&refusal(b"{\"points\": [[0, 0]"), &["EOF"]);
    assert_says(
        &refusal(b"{\"points\": [[0, \"0\"]]}"),
        &["point 0: ", "string \"0\"", "a finite number"],
    );
    assert_says(
        &refusal(b"{\"points\": [[0, 0], [null, 1]]}"),
        &["point 1: ", "null", "a finite number"],
    );
    assert_says(&refusal(b"[1, 2]"), &["expected an object"]);
    assert_says(
        &refusal(b"%%MatrixMarket matrix"),
        &["part.json:1: column 1: expected value"],
    );
    assert_says(&refusal(b"{\"points\": \"\xff\"}"), &["part.json:1: "]);
    let nested = [b"{\"field_data\": ".as_slice(), &[b'['; 100_000]].concat();
    assert_says(&refusal(&nested), &["part.json:1: "]);
}

#[test]
fn files_that_are_no_text_are_refused() {
    assert_says(&refusal(b""), &["part.json: is empty", "`points`"]);
    assert_says(&refusal(b" \n\t\n"), &["part.json: is empty"]);
    assert_says(&refusal(b"\xff\xfe{\0}\0"), &["UTF-16", "UTF-8"]);
    assert_says(&refusal(b"\x1f\x8b\x08"), &["gzip"]);
    let folder = tempfile::tempdir().unwrap();
    assert_says(
        &read_description(folder.path()).unwrap_err().to_string(),
        &["is a folder"],
    );
    let missing = folder.path().join("nothing.json");
    assert_says(
        &read_description(&missing).unwrap_err().to_string(),
        &["nothing.json: cannot read: No such file"],
    );
    let marked = [b"\xef\xbb\xbf", documented("json").as_bytes()].concat();
    assert_eq!(read_bytes(&marked).unwrap().name, "plate");
}

/// Whatever bytes come, there is an answer or an error that names the file.
#[test]
fn damaged_files_never_panic() {
    let seeds = [
        documented("json").as_bytes().to_vec(),
        pyramid().to_string().into_bytes(),
        triangle().to_string().into_bytes(),
    ];
    let tokens: [&[u8]; 12] = [
        b"-1",
        b"1e308",
        b"4294967295",
        b"[",
        b"]",
        b"{}",
        b"null",
        b"\"\"",
        b",",
        b"\\u0000",
        b"\xff",
        b"0.5",
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.json");
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    let mut accepted = 0;
    for round in 0..6000 {
        let mut bytes = seeds[round % seeds.len()].clone();
        for _ in 0..=random(3) {
            let at = random(bytes.len());
            match random(4) {
                0 => bytes[at] ^= 1 << random(8),
                1 => drop(bytes.drain(at..(at + 1 + random(6)).min(bytes.len()))),
                2 => drop(bytes.splice(at..at, tokens[random(tokens.len())].iter().copied())),
                _ if random(8) == 0 => bytes.truncate(at + 1),
                _ => bytes[at] = b"0123456789,:[]{}\"uxyz"[random(21)],
            }
            if bytes.is_empty() {
                break;
            }
        }
        std::fs::write(&path, &bytes).unwrap();
        match read_description(&path) {
            Ok(part) => {
                accepted += 1;
                let _ = part.dof_map(15, &path);
            }
            Err(error) => assert!(error.to_string().contains("part.json")),
        }
    }
    assert!(
        accepted > 100,
        "the damage is too coarse to reach the checks: {accepted} of 6000 files read"
    );
}

#[test]
fn a_hundred_thousand_nodes_are_read() {
    const NODES: usize = 100_000;
    let mut text = String::from("{\"points\": [[0.0, 0.0, 0.0]");
    for node in 1..NODES {
        write!(
            text,
            ", [{}, {}, {}]",
            node as f64 * 1e-3,
            (node % 317) as f64 / 7.0,
            0.25
        )
        .unwrap();
    }
    text += "], \"cells\": [{\"type\": \"tetra\", \"data\": [[0, 1, 2, 3]";
    for cell in 1..NODES - 3 {
        write!(
            text,
            ", [{}, {}, {}, {}]",
            cell,
            cell + 1,
            cell + 2,
            cell + 3
        )
        .unwrap();
    }
    write!(
        text,
        "]}}], \"component\": {}}}",
        without(pyramid(), "/component", "interfaces")["component"]
    )
    .unwrap();
    let part = read_bytes(text.as_bytes()).unwrap();
    assert_eq!(part.mesh.node_count(), NODES);
    assert_eq!(part.mesh.cells[0].cell_count(), NODES - 3);
    assert_eq!(part.mesh.position(317), [317.0 * 1e-3, 0.0, 0.25]);
    assert_eq!(
        part.dof_map(3 * NODES, Path::new("part.json"))
            .unwrap()
            .row(NODES as u32 - 1, Direction::Uz),
        Some(3 * NODES - 1)
    );
}
