//! Text from files that a stranger made, and names that aren't UTF-8.

use std::ffi::OsString;
use std::fs;
use std::os::unix::ffi::OsStringExt;

use dcb_formats::dcb::read_superelement;

use crate::support::{COMMANDS, Folder, answer, commands_a_terminal, says};

#[test]
fn no_command_lets_a_superelements_text_reach_the_terminal() {
    let folder = Folder::rod();
    folder.done("rod.mtx --modes 2 -o plain.dcb.h5");
    let mut element = read_superelement(&folder.path("plain.dcb.h5")).unwrap();
    element.name = COMMANDS.to_owned();
    element.units.length = COMMANDS.to_owned();
    for interface in &mut element.interfaces {
        interface.name += COMMANDS;
    }
    let provenance = &mut element.provenance;
    provenance.generator = format!("{COMMANDS}\nerror: a line of its own");
    provenance.warnings = vec![format!("{COMMANDS}\ndigest   0000")];
    provenance.inputs[0].file_name = COMMANDS.to_owned();
    folder.store_superelement("part.dcb.h5", &element);
    for arguments in [
        "inspect part.dcb.h5",
        "inspect part.dcb.h5 --json",
        "verify part.dcb.h5",
        "compare part.dcb.h5 plain.dcb.h5",
        "compare plain.dcb.h5 part.dcb.h5",
    ] {
        let said = folder.run(arguments);
        for text in [&said.stdout, &said.stderr] {
            assert!(!commands_a_terminal(text), "{arguments}: {text:?}");
            assert!(!text.contains("\nerror: a line"), "{arguments}: {text:?}");
            assert!(!text.contains("\ndigest   0000"), "{arguments}: {text:?}");
        }
    }
    says!(
        folder.done("inspect part.dcb.h5"),
        "x\\u001b[2J\\u009b31m\\u000d\\u202ey"
    );
    assert_eq!(folder.inspected("part.dcb.h5")["name"], COMMANDS);
}

#[test]
fn what_messages_quote_is_printable_and_short() {
    let folder = Folder::rod();
    let description = folder.read("rod.json");
    let long = "ab".repeat(5_000_000);
    for (file, arguments, key) in [
        ("rod.json", "rod.mtx", COMMANDS),
        ("rod.json", "rod.mtx", &long),
        ("batch.json", "batch batch.json", COMMANDS),
        ("batch.json", "batch batch.json", &long),
    ] {
        let key = serde_json::to_string(key).unwrap();
        match file {
            "rod.json" => {
                folder.write(file, description.replacen('{', &format!("{{{key}: 1, "), 1))
            }
            _ => folder.write(
                file,
                format!("{{\"parts\": [{{\"part\": \"rod.mtx\", {key}: 1}}]}}"),
            ),
        }
        let message = folder.refused(arguments, &[file, "unknown field"]);
        assert!(message.len() < 2000, "{} bytes", message.len());
        assert!(!commands_a_terminal(&message), "{message:?}");
    }
    folder.write("rod.json", &description);
    let matrix = folder.read("rod.mtx");
    folder.write("rod.mtx", matrix.replacen("symmetric", COMMANDS, 1));
    let message = folder.refused("rod.mtx", &["rod.mtx:1"]);
    assert!(!commands_a_terminal(&message), "{message:?}");
}

#[test]
fn misused_arguments_are_shown_printable() {
    let folder = Folder::empty();
    let mut command = folder.command("");
    let said = answer(command.args(["a.mtx", COMMANDS]));
    assert_eq!(said.code, Some(2));
    assert!(!commands_a_terminal(&said.stderr), "{said:?}");
    says!(said.stderr, "one argument too many");
}

#[test]
fn names_that_are_not_utf8_are_names() {
    let folder = Folder::rod();
    let renamed = |name: &str| {
        let mut bytes = b"r\xf6d".to_vec();
        bytes.extend(name.strip_prefix("rod").unwrap().bytes());
        folder.path("").join(OsString::from_vec(bytes))
    };
    for name in [
        "rod.mtx",
        "rod.mass.mtx",
        "rod.json",
        "rod.mass.xx.mtx",
        "rod.mass.yy.mtx",
        "rod.mass.xy.mtx",
    ] {
        fs::rename(folder.path(name), renamed(name)).unwrap();
    }
    fs::write(
        renamed("rod.load.pull.mtx"),
        "%%MatrixMarket matrix array real general\n15 1\n".to_owned() + &"1\n".repeat(15),
    )
    .unwrap();
    let said = answer(folder.command("--modes 2").arg(renamed("rod.mtx")));
    assert_eq!((said.code, said.stderr.as_str()), (Some(0), ""), "{said:?}");
    let element = read_superelement(&renamed("rod.dcb.h5")).unwrap();
    assert_eq!(element.loads[0].name, "pull");
    let said = answer(
        folder
            .command("verify")
            .arg(renamed("rod.dcb.h5"))
            .arg("--component")
            .arg(renamed("rod.mtx")),
    );
    assert_eq!(said.code, Some(0), "{said:?}");
    let mut odd = renamed("rod.load.").into_os_string();
    odd.push(OsString::from_vec(b"\xff.mtx".to_vec()));
    fs::write(&odd, "").unwrap();
    let said = answer(folder.command("--modes 2 --force").arg(renamed("rod.mtx")));
    said.is_error(2, &[".load.", "isn't UTF-8"]);
}
