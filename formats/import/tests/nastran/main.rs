//! Nastran's matrices: OUTPUT4 in every layout, DMIG in every form of field.
#![allow(clippy::unwrap_used, clippy::float_cmp)]

mod dmig;
mod op4;
mod support;

/// Every file of the samples is Nastran's, and of the one format that its name says.
#[test]
fn files_are_told_by_their_content() {
    let mut seen = [0; 3];
    for folder in ["nastran", "nastran/pyyeti"] {
        for file in std::fs::read_dir(support::sample(folder)).unwrap() {
            let path = file.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            let format = match name {
                _ if name.ends_with(".op4") && name.contains("ascii") => 1,
                _ if name.ends_with(".op4") => 0,
                _ if name.ends_with(".pch") && !name.starts_with("outboard") => 2,
                _ => continue,
            };
            seen[format] += 1;
            let expected = ["OUTPUT4, binary", "OUTPUT4, ASCII", "DMIG"][format];
            let found = dcb_import::MatrixFile::open(&path).unwrap();
            assert_eq!(found.format_name(), format!("Nastran {expected}"), "{name}");
            assert!(!found.listed().is_empty(), "{name}");
        }
    }
    assert!(seen.iter().all(|count| *count >= 5), "{seen:?}");
}
