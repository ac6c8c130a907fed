//! Damaged files: an error or a mesh, soon, and never a panic.

use std::path::Path;

use dcb_import::mesh::read_mesh;

use crate::samples::sample;

const SAMPLES: [&str; 17] = [
    "mesh/bracket_zlib.vtu",
    "mesh/cells/edges_appended_raw_zlib.vtu",
    "mesh/cells/edges_appended_base64.vtu",
    "mesh/bracket.unv",
    "mesh/bracket_gmsh.unv",
    "mesh/bracket_v22.msh",
    "mesh/cells/edges_22_binary.msh",
    "mesh/cells/edges_41.msh",
    "mesh/cells/edges_41_binary.msh",
    "mesh/cells/edges_41_big.msh",
    "mesh/cells/curved_41_binary_partitioned.msh",
    "mesh/bracket.bdf",
    "nastran/ugly.bdf",
    "nastran/pyyeti/outboard.pch",
    "calculix/bracket_rigid.inp",
    "calculix/plate_incompatible.inp",
    "calculix/plate_shell.inp",
];

fn reads(path: &Path, content: &[u8]) -> bool {
    std::fs::write(path, content).unwrap();
    read_mesh(path).is_ok()
}

#[test]
fn files_cut_off_at_every_64th_byte() {
    let folder = tempfile::tempdir().unwrap();
    for name in SAMPLES {
        let path = folder.path().join("part");
        let whole = std::fs::read(sample(name)).unwrap();
        for length in (0..whole.len()).step_by(64) {
            reads(&path, &whole[..length]);
        }
        assert!(reads(&path, &whole), "{name}");
    }
}

#[test]
fn files_with_changed_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    for name in SAMPLES {
        let path = folder.path().join("part");
        let whole = std::fs::read(sample(name)).unwrap();
        for _ in 0..300 {
            let mut changed = whole.clone();
            for _ in 0..=random() % 4 {
                let at = random() as usize % changed.len();
                changed[at] = random() as u8;
            }
            reads(&path, &changed);
        }
    }
}
