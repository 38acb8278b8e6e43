//! Reads the JSON channels of a recording in Python, with the official MCAP library.

use mmsim_tests::output;

use crate::client;
use crate::harness::{Home, recorded};

/// Validates each JSON message of the recording, and prints the last message of each topic.
const READ: &str = r#"
import json, sys
from jsonschema import Draft202012Validator
from mcap.reader import make_reader

last, validators = {}, {}
with open(sys.argv[1], "rb") as file:
    for schema, channel, message in make_reader(file).iter_messages():
        if channel.message_encoding == "json":
            if channel.topic not in validators:
                parsed = json.loads(schema.data)
                Draft202012Validator.check_schema(parsed)
                validators[channel.topic] = Draft202012Validator(parsed)
            last[channel.topic] = json.loads(message.data)
            validators[channel.topic].validate(last[channel.topic])
print(sorted(last))
print(json.dumps(last["/mouse"]))
"#;

#[test]
fn python_reads_the_json_channels() {
    let Some(mut python) = client::python_with("jsonschema, mcap") else { return };
    let home = Home::new();
    let demo = ["demo", "hedgerow", "--once", "--port", "0", "--no-viewer"];
    assert_eq!(home.run(&[&demo[..], &["--record", "kept"]].concat()).code, Some(0));
    let path = recorded(&home.path().join("kept"));
    let read = output(python.args(["-c", READ]).arg(path));
    assert!(read.status.success(), "{read:?}");
    let printed = String::from_utf8(read.stdout).unwrap();
    insta::assert_snapshot!(printed.replace("\r\n", "\n"), @r#"
    ['/mouse', '/pose', '/scene']
    {"x": 8, "y": 7, "heading": "N", "heading_degrees": 0, "phase": "at_goal", "phase_number": 1, "steps": 191, "turns": 124, "visited_cells": 126, "optimistic_distance": 45, "pessimistic_distance": 59}
    "#);
}
