//! Writes one superelement twice: `small.dcb.h5` as `reduce` makes it, and `large.dcb.h5` with the nodal fields of a mesh of many nodes
//! (about 2 GB unless a number of nodes is given). What a simulation computes with is the same in both. `tests/benches/large_file.py` uses it.
//!
//! `cargo run --release -p dcb-tests --example large_file -- FOLDER [NODES]`
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::collections::BTreeMap;
use std::path::Path;

use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};

use dcb_formats::mesh::{Direction, Dof, Mesh};
use dcb_formats::output::Replace;
use dcb_formats::superelement::RecoveryBasis;
use dcb_samples::connecting_rod;
use dcb_tests::lowest;
use faer::Mat;

const MODES: usize = 100;
const NODES: usize = 800_000;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().expect("a folder");
    let nodes: usize =
        (arguments.next()).map_or(NODES, |count| count.parse().expect("a number of nodes"));
    let component = connecting_rod(0);
    let reduced = lowest(&component, MODES);
    let write = |name: &str, recovery: &RecoveryBasis, mesh: &Mesh| {
        let contents = Contents {
            superelement: &reduced.superelement,
            recovery: Some(recovery),
            mesh: Some(mesh),
        };
        let options = WriteOptions {
            replace_existing: Replace::Overwrite,
            ..WriteOptions::default()
        };
        write_superelement(&Path::new(&folder).join(name), &contents, &options).unwrap();
    };
    write("small.dcb.h5", &reduced.recovery, &component.mesh);

    // The part's own nodes again and again, so that a node has the fields that it has in the small file.
    let own = component.mesh.node_count();
    let dofs: Vec<Dof> = (0..nodes as u32)
        .flat_map(|node| {
            Direction::ALL[..3].iter().map(move |direction| Dof {
                node,
                direction: *direction,
            })
        })
        .collect();
    let rows: BTreeMap<Dof, usize> = (reduced.recovery.dofs.iter().enumerate())
        .map(|(row, dof)| (*dof, row))
        .collect();
    let row_of: Vec<usize> = (dofs.iter())
        .map(|dof| {
            rows[&Dof {
                node: dof.node % own as u32,
                ..*dof
            }]
        })
        .collect();
    let repeated =
        |fields: &Mat<f64>| Mat::from_fn(dofs.len(), fields.ncols(), |i, j| fields[(row_of[i], j)]);
    let recovery = RecoveryBasis {
        modes: repeated(&reduced.recovery.modes),
        residual: repeated(&reduced.recovery.residual),
        enrichment: None,
        dofs,
    };
    let coordinates = (0..nodes).flat_map(|node| component.mesh.position((node % own) as u32));
    let mesh = Mesh {
        dimension: component.mesh.dimension,
        coordinates: coordinates.collect(),
        cells: Vec::new(),
        point_sets: BTreeMap::new(),
    };
    write("large.dcb.h5", &recovery, &mesh);
}
