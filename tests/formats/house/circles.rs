//! Modules of a crate look one way: none needs another that needs it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use super::{crates, program, root, sources};

/// For each module at the root of a crate those that it names.
type Needs = BTreeMap<String, BTreeSet<String>>;

#[test]
fn no_module_needs_one_that_needs_it() {
    for name in crates() {
        let needs = needs(&root().join(&name).join("src"));
        let circle = in_circles(needs);
        assert!(circle.is_empty(), "{name}: modules in a circle: {circle:?}");
    }
}

#[test]
fn a_circle_is_found_behind_braces_and_names_of_the_root() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write(
        "lib.rs",
        "mod a;\nmod b;\nmod c;\npub use b::{Kind, Made as Done};\n",
    );
    write(
        "a.rs",
        "//! Not crate::c::X.\nuse crate::{\n    Done,\n};\n",
    );
    write("b.rs", "fn f() { crate::c::g() }\n");
    write(
        "c.rs",
        "use crate::b::{self, Kind};\n#[cfg(test)]\nmod tests { use crate::a; }\n",
    );
    let needs = needs(folder.path());
    assert_eq!(needs["a"], BTreeSet::from(["b".to_owned()]));
    let circle = BTreeSet::from(["b".to_owned(), "c".to_owned()]);
    assert_eq!(in_circles(needs), circle);
}

/// Who names whom, by `crate::`; a name of the crate's root stands for the module that it comes from.
fn needs(src: &Path) -> Needs {
    let text = |path: &Path| -> String {
        let text = fs::read_to_string(path).unwrap();
        let lines = program(&text).into_iter().map(|(_, line)| line);
        lines.collect::<Vec<_>>().join(" ")
    };
    let module = |path: &Path| -> String {
        let inside = path.strip_prefix(src).unwrap();
        let first = inside.components().next().unwrap().as_os_str();
        let first = first.to_str().unwrap();
        first.strip_suffix(".rs").unwrap_or(first).to_owned()
    };
    let files = sources(src);
    let modules: BTreeSet<String> = files.iter().map(|path| module(path)).collect();
    let library = src.join("lib.rs");
    let from = match library.is_file() {
        true => reexported(&text(&library)),
        false => BTreeMap::new(),
    };
    let mut needs: Needs = modules
        .iter()
        .map(|name| (name.clone(), BTreeSet::new()))
        .collect();
    for path in files.iter().filter(|path| **path != library) {
        let own = module(path);
        let named = heads(&text(path), "crate::").into_iter();
        let named = named.map(|name| from.get(&name).cloned().unwrap_or(name));
        let others = named.filter(|name| modules.contains(name) && *name != own);
        needs.get_mut(&own).unwrap().extend(others);
    }
    needs
}

/// The first names of the paths that begin with `start`: one, or those within its braces.
fn heads(text: &str, start: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices(start) {
        let rest = &text[at + start.len()..];
        match rest.strip_prefix('{') {
            None => found.push(word(rest)),
            Some(list) => {
                let mut depth = 0;
                let mut is_first = true;
                for (place, character) in list.char_indices() {
                    match character {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => is_first = true,
                        _ if is_first && depth == 0 && !character.is_whitespace() => {
                            found.push(word(&list[place..]));
                            is_first = false;
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    found
}

fn word(text: &str) -> String {
    let is_of_word = |character: &char| character.is_alphanumeric() || *character == '_';
    text.chars().take_while(is_of_word).collect()
}

/// Names that the root re-exports, by the module that they come from.
fn reexported(library: &str) -> BTreeMap<String, String> {
    let mut from = BTreeMap::new();
    for (at, start) in library.match_indices("pub use ") {
        let path = library[at + start.len()..].split(';').next().unwrap();
        let path = path.trim_start_matches("crate::");
        let Some((module, _)) = path.split_once("::") else {
            continue;
        };
        let names = path.rsplit_once("::").unwrap().1;
        for name in names.trim_matches(['{', '}', ' ']).split(',') {
            let shown = name.rsplit(" as ").next().unwrap().trim();
            from.insert(shown.to_owned(), module.to_owned());
        }
    }
    from
}

/// What is left when modules that need nothing, or that nothing needs, are taken away again and again.
fn in_circles(mut needs: Needs) -> BTreeSet<String> {
    loop {
        let needed: BTreeSet<String> = needs.values().flatten().cloned().collect();
        let before = needs.len();
        needs.retain(|name, of| !of.is_empty() && needed.contains(name));
        let left: BTreeSet<String> = needs.keys().cloned().collect();
        for of in needs.values_mut() {
            of.retain(|name| left.contains(name));
        }
        if needs.len() == before {
            return left;
        }
    }
}
