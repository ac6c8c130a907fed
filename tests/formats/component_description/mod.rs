//! The component file: what is read from good ones, and what is said about bad ones.

mod documentation;
mod interfaces;
mod internal_rows;
mod mesh_and_dofs;
mod text;

use dcb_formats::{Description, Error, read_description};
use serde_json::{Value, json};

const DOCUMENTATION: &str = include_str!("../../../docs/component.md");

fn read_bytes(bytes: &[u8]) -> Result<Description, Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.json");
    std::fs::write(&path, bytes).unwrap();
    read_description(&path)
}

fn read(file: &Value) -> Result<Description, Error> {
    read_bytes(file.to_string().as_bytes())
}

/// The message for a file that must be refused, without its folder.
fn refusal(bytes: &[u8]) -> String {
    let message = read_bytes(bytes).expect_err("a refusal").to_string();
    let at = message.find("part.json").unwrap();
    message[at..].to_owned()
}

#[track_caller]
fn assert_refused(file: &Value, parts: &[&str]) {
    assert_says(&refusal(file.to_string().as_bytes()), parts);
}

#[track_caller]
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in: {message}");
    }
}

/// The fenced block of this language in the documentation.
fn documented(language: &str) -> &'static str {
    let (_, after) = DOCUMENTATION
        .split_once(&format!("```{language}\n"))
        .unwrap();
    after.split_once("```").unwrap().0
}

/// Five nodes in space, one pyramid, one interface of every kind.
fn pyramid() -> Value {
    json!({
        "points": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]],
        "cells": [{"type": "pyramid", "data": [[0, 1, 2, 3, 4]]}],
        "point_sets": {"base": [0, 1, 2, 3], "empty": [], "twice": [4, 3, 4]},
        "cell_sets": {"solid": [[0]]},
        "component": {
            "name": "pyramid",
            "units": {"length": "mm", "mass": "t", "time": "s"},
            "dofs": ["ux", "uy", "uz"],
            "interfaces": [
                {"name": "foot", "point_set": "base", "kind": "average"},
                {"name": "tip", "nodes": [4], "kind": "nodes"}
            ]
        }
    })
}

fn triangle() -> Value {
    json!({
        "points": [[0, 0], [1, 0], [0, 1]],
        "component": {
            "name": "plate", "units": {"length": "m", "mass": "kg", "time": "s"}, "dofs": ["ux", "uy"],
            "interfaces": [{"name": "edge", "nodes": [1, 2], "kind": "average"}]
        }
    })
}

fn with(mut file: Value, pointer: &str, value: Value) -> Value {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match file.pointer_mut(parent).unwrap() {
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        object => object[key] = value,
    }
    file
}

fn without(mut file: Value, parent: &str, key: &str) -> Value {
    let removed = file
        .pointer_mut(parent)
        .unwrap()
        .as_object_mut()
        .unwrap()
        .remove(key);
    removed.expect("the key to remove");
    file
}

/// The pyramid with a changed first interface, whose kind is `average`.
fn with_foot(key: &str, value: Value) -> Value {
    with(pyramid(), &format!("/component/interfaces/0/{key}"), value)
}
