//! The pages of `docs` are a book: each has its place in it, and links of pages lead somewhere, in the repository and in the book.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

use super::{files, root};

/// What a page shows of itself, and what it looks at.
#[derive(Default)]
struct Page {
    /// Ids of its headings, as mdBook and code hosts make them.
    anchors: BTreeSet<String>,
    /// Targets of links and pictures, as written.
    links: Vec<String>,
}

impl Page {
    fn of(text: &str) -> Self {
        let options = Options::ENABLE_TABLES | Options::ENABLE_FOOTNOTES;
        let mut page = Self::default();
        let mut heading: Option<String> = None;
        let mut counts = BTreeMap::new();
        for event in Parser::new_ext(text, options) {
            match event {
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    let name = anchor(&heading.take().unwrap());
                    let count = counts.entry(name.clone()).or_insert(0_usize);
                    page.anchors.insert(match count {
                        0 => name,
                        _ => format!("{name}-{count}"),
                    });
                    *count += 1;
                }
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links.push(dest_url.into_string());
                }
                Event::Text(part) | Event::Code(part) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&part);
                    }
                }
                _ => {}
            }
        }
        page
    }
}

/// The id of a heading.
fn anchor(heading: &str) -> String {
    heading
        .trim()
        .chars()
        .filter_map(|letter| match letter {
            ' ' => Some('-'),
            '-' | '_' => Some(letter),
            _ => letter.is_alphanumeric().then_some(letter),
        })
        .flat_map(char::to_lowercase)
        .collect()
}

/// Pages below a folder.
fn pages(folder: &Path) -> Vec<PathBuf> {
    files(folder, "md")
}

fn read(path: &Path) -> Page {
    Page::of(&fs::read_to_string(path).unwrap())
}

/// A path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                assert!(plain.pop(), "{}", path.display());
            }
            part => plain.push(part),
        }
    }
    plain
}

/// Is there no protocol, such as `https:`?
fn is_relative(link: &str) -> bool {
    !link
        .split('/')
        .next()
        .is_some_and(|begin| begin.contains(':'))
}

#[test]
fn every_page_has_one_place_in_the_book() {
    let docs = root().join("docs").canonicalize().unwrap();
    let mut listed = BTreeMap::new();
    for link in read(&docs.join("SUMMARY.md")).links {
        *listed.entry(docs.join(link)).or_insert(0) += 1;
    }
    let mut expected: BTreeMap<_, _> = pages(&docs).into_iter().map(|page| (page, 1)).collect();
    assert!(expected.remove(&docs.join("SUMMARY.md")).is_some());
    assert!(expected.len() > 40, "{expected:?}");
    let differing: Vec<_> = listed
        .keys()
        .chain(expected.keys())
        .filter(|page| listed.get(*page) != expected.get(*page))
        .collect();
    assert!(
        differing.is_empty(),
        "not once in docs/SUMMARY.md, or not there: {differing:?}"
    );
}

#[test]
fn links_of_pages_lead_somewhere() {
    let root = root().canonicalize().unwrap();
    let docs = root.join("docs");
    let mut looked_at = pages(&docs);
    looked_at.push(root.join("README.md"));
    looked_at.extend(pages(&root.join("samples")));
    let mut known: BTreeMap<PathBuf, Page> = BTreeMap::new();
    let mut wrong = Vec::new();
    let mut followed = 0;
    for path in &looked_at {
        for link in read(path).links {
            if !is_relative(&link) {
                continue;
            }
            followed += 1;
            let (file, fragment) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => path.clone(),
                file => plain(&path.parent().unwrap().join(file)),
            };
            let said = match () {
                () if !target.exists() => "is not there",
                () if path.starts_with(&docs) && !target.starts_with(&docs) => {
                    "is not in the book: name the file as `code`"
                }
                () if path.starts_with(&docs) && target.is_dir() => "is a folder",
                () if fragment.is_empty() => continue,
                () => {
                    let page = known.entry(target.clone()).or_insert_with(|| read(&target));
                    match page.anchors.contains(fragment) {
                        true => continue,
                        false => "has no such heading",
                    }
                }
            };
            let page = path.strip_prefix(&root).unwrap().display();
            wrong.push(format!("{page}: {link} {said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(followed > 300, "only {followed} links found");
}

#[test]
fn headings_have_the_ids_of_code_hosts() {
    let page = Page::of("# Of a scene\n\n## What `reduce` says: K R, 1e-9\n\n## Of a scene\n");
    let ids: Vec<&str> = page.anchors.iter().map(String::as_str).collect();
    assert_eq!(
        ids,
        ["of-a-scene", "of-a-scene-1", "what-reduce-says-k-r-1e-9"]
    );
}
