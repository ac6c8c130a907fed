//! Writes the frozen sample files of the current format version: `cargo run --release -p dcb-tests --example freeze`.
//!
//! A frozen file is written once per format version and then kept as it is: the test `frozen` reads it forever.
//! This program therefore refuses to replace one.

use std::path::Path;

use dcb_formats::dcb::{Compression, FORMAT_VERSION, SuperelementFile};
use dcb_formats::mesh::Dimension;
use dcb_tests::synthetic;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/frozen");
    for (name, dimension) in [
        ("planar", Dimension::Planar),
        ("spatial", Dimension::Spatial),
    ] {
        let superelement = synthetic::enriched(dimension);
        let path = folder.join(format!("{name}-{FORMAT_VERSION}.dcb.h5"));
        if path.exists() {
            return Err(format!("{}: is frozen", path.display()).into());
        }
        synthetic::write(&path, &superelement, Compression::None)?;
        let file = SuperelementFile::open(&path)?;
        let expected = synthetic::summary(&file)?;
        std::fs::write(
            path.with_extension("").with_extension("json"),
            format!("{expected:#}\n"),
        )?;
        println!("{}: {}", path.display(), file.digest());
    }
    Ok(())
}
