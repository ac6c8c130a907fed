//! What a mesh of another tool has, and how long reading takes: `cargo run --release -p dcb-import --example read_mesh FILE...`

use std::path::Path;
use std::time::Instant;

use dcb_import::mesh::read_mesh;

fn main() {
    for name in std::env::args().skip(1) {
        let start = Instant::now();
        match read_mesh(Path::new(&name)) {
            Ok(read) => println!(
                "{name}: {}, {} nodes, {} cells, {} sets, {:.2} s",
                read.format,
                read.mesh.points.len(),
                read.mesh
                    .cells
                    .iter()
                    .map(|cells| cells.cell_count())
                    .sum::<usize>(),
                read.mesh.sets.len() + read.mesh.cell_sets.len(),
                start.elapsed().as_secs_f64()
            ),
            Err(error) => println!("{error}"),
        }
    }
}
