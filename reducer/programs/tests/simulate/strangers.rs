//! Text from files that a stranger made.

use dcb_formats::component::Units;
use dcb_formats::output::Replace;
use dcb_formats::results::{Channel, Column, Header, Outcome, ResultsWriter};
use serde_json::{Value, json};

use crate::scene_folder::pendulum;
use crate::support::{COMMANDS, Folder, commands_a_terminal, says};

#[test]
fn no_command_lets_the_text_of_results_reach_the_terminal() {
    let folder = Folder::empty();
    let unit = || COMMANDS.to_owned();
    let header = Header {
        units: Units {
            length: unit(),
            mass: unit(),
            time: unit(),
        },
        generator: unit(),
        scene: json!({}),
        inputs: Vec::new(),
        options: json!({}),
        warnings: vec![unit()],
    };
    let channel = Channel {
        path: format!("outputs/{COMMANDS}"),
        columns: vec![Column {
            name: unit(),
            unit: unit(),
        }],
        description: format!("{COMMANDS}\nerror: a line of its own"),
    };
    let path = folder.path("results.h5");
    let mut writer = ResultsWriter::create(&path, &[channel], &header, Replace::Refuse).unwrap();
    writer.append(0.0, &[1.0]).unwrap();
    writer.note(0.0, &format!("{COMMANDS}\nerror: a line of its own"));
    let outcome = Outcome::Stopped {
        reason: format!("{COMMANDS}\nerror: a line of its own"),
        time: None,
    };
    writer.finish(&outcome, &json!({})).unwrap();
    for words in [
        "show results.h5",
        "csv results.h5",
        "csv results.h5 nothing -o b.csv",
        "plot results.h5",
    ] {
        let said = folder.run(words);
        for text in [&said.stdout, &said.stderr] {
            assert!(!commands_a_terminal(text), "{words}: {text:?}");
            assert!(!text.contains("\nerror: a line"), "{words}: {text:?}");
        }
    }
    says!(folder.done("show results.h5").stdout, "\\u001b[2J");
}

#[test]
fn what_messages_quote_is_printable_and_short() {
    let refused = |keys: Value, most: usize| {
        let said = Folder::with(&pendulum(keys)).run("scene.json");
        let length = said.stderr.len();
        assert_eq!(said.code, Some(2), "{length} bytes");
        assert!(
            length < most && !commands_a_terminal(&said.stderr),
            "{length} bytes"
        );
        said
    };
    for key in [COMMANDS, &"ab".repeat(5_000_000)] {
        refused(json!({ key: 1 }), 2000).is_error(2, &["scene.json", "unknown field"]);
        let body = json!({"rigid": {"mass": 1, "inertia": 0.01, "points": {"pin": [-0.5, 0]}}, "position": [0.5, 0]});
        refused(json!({ "bodies": {key: body} }), 6000);
        let formula = json!({"motor": {"angle": {"joint": "hinge", "formula": key}}});
        refused(json!({ "drives": formula }), 6000);
    }
}

#[test]
fn numbers_in_messages_have_no_hundreds_of_digits() {
    let folder = Folder::with(&pendulum(json!({
        "bodies": {"bob": {"rigid": {"mass": -1e300, "inertia": 0.01, "points": {"pin": [-0.5, 0]}}, "position": [0.5, 0]}}
    })));
    let said = folder.run("scene.json");
    said.is_error(2, &["-1e300"]);
    assert!(!said.stderr.contains(&"0".repeat(20)), "{said:?}");
}
