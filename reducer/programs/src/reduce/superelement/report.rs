//! The `reduce report` command: one HTML file with the modes of a superelement in motion and what its numbers are worth.

use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use dcb_formats::output::{Replace, check_output, is_same_file, write_stream};
use dcb_reducer::error::Error;
use dcb_workflow::part_page::part_page;

use crate::outcome::Outcome;
use crate::own_output::Made;

/// What the page is of.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// Superelement (.dcb.h5)
    file: PathBuf,
    /// The page [default: PART.html]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file that is no page of this program
    #[arg(long)]
    force: bool,
}

/// Writes the page of a superelement.
pub fn run(arguments: &ReportArguments) -> Result<Outcome, Error> {
    let path = &arguments.file;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let endings = [".dcb.h5", ".h5", ".hdf5"];
    let stem = endings.iter().find_map(|ending| name.strip_suffix(ending));
    let beside = path.with_file_name(format!("{}.html", stem.unwrap_or(&name)));
    let target = arguments.output.as_ref().unwrap_or(&beside);
    let replace = match arguments.force {
        true => Replace::Overwrite,
        false => Replace::Refuse,
    };
    let replace = Made::Page.replace(target, replace);
    check_output(target, replace)?;
    if is_same_file(path, target) {
        return Err(dcb_formats::Error::File {
            path: target.clone(),
            message: "is the superelement itself; name another page with --output".to_owned(),
        }
        .into());
    }
    let html = part_page(path)?
        .html()
        .map_err(|source| dcb_formats::Error::io(target, "cannot write", source))?;
    write_stream(target, replace, |out| out.write_all(html.as_bytes()))?;
    Ok(Outcome::done(format!(
        "{}: {:.1} MB; open it in a browser\n",
        target.display(),
        html.len() as f64 / 1e6
    )))
}
