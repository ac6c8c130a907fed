//! The `simulate animate` and `simulate report` commands: one HTML file in which the mechanism moves.

use std::io::Write as _;
use std::path::{Component, Path, PathBuf};

use clap::Args;
use dcb_formats::output::{check_output, write_stream};
use dcb_runtime::error::Error;
use dcb_runtime::run::refuse_inputs;
use dcb_workflow::scene_page::{Contents, scene_page};

use crate::outcome::Outcome;
use crate::own_output::Made;
use crate::simulate::{refuse_others, replace};

/// What the page is of.
#[derive(Debug, Args)]
pub(crate) struct PageArguments {
    /// Results of a run (.h5)
    results: PathBuf,
    /// The page [default: RESULTS.html, of a report RESULTS.report.html]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The scene's file, from which the superelements are found [default: where the run found it]
    #[arg(long, value_name = "SCENE.json")]
    scene: Option<PathBuf>,
    /// Replace an existing file that is no page of this program
    #[arg(long)]
    force: bool,
}

/// What `simulate animate` makes.
#[derive(Debug, Args)]
pub(crate) struct AnimateArguments {
    #[command(flatten)]
    page: PageArguments,
    /// Write the motion as binary glTF for slides and other viewers, in place of the page
    #[arg(long, value_name = "FILE.glb", conflicts_with = "output")]
    gltf: Option<PathBuf>,
}

/// Writes the page of a run, or its motion as glTF.
pub(crate) fn animate(arguments: &AnimateArguments) -> Result<Outcome, Error> {
    let Some(target) = &arguments.gltf else {
        return run(&arguments.page, Contents::Motion);
    };
    let page = &arguments.page;
    let (path, replace) = (&page.results, replace(page.force));
    refuse_others(path)?;
    check_output(target, replace)?;
    refuse_inputs(target, [path.as_path()], "the file of the results")?;
    let found = scene_page(path, page.scene.as_deref(), Contents::Motion)?;
    let bytes = found.glb().map_err(|message| dcb_formats::Error::File {
        path: target.clone(),
        message,
    })?;
    write_stream(target, replace, |out| out.write_all(&bytes))?;
    Ok(Outcome::done(format!(
        "{}: {:.1} MB\n",
        target.display(),
        bytes.len() as f64 / 1e6
    )))
}

/// Writes the page of a run.
pub(crate) fn run(arguments: &PageArguments, contents: Contents) -> Result<Outcome, Error> {
    let (path, replace) = (&arguments.results, replace(arguments.force));
    refuse_others(path)?;
    let beside = path.with_extension(match contents {
        Contents::Motion => "html",
        Contents::Report => "report.html",
    });
    let target = arguments.output.as_ref().unwrap_or(&beside);
    let replace = Made::Page.replace(target, replace);
    check_output(target, replace)?;
    refuse_inputs(target, [path.as_path()], "the file of the results")?;
    let page = scene_page(path, arguments.scene.as_deref(), contents)?;
    let html = page.html().map_err(|source| Error::CannotWrite {
        path: target.clone(),
        source,
    })?;
    write_stream(target, replace, |out| out.write_all(html.as_bytes()))?;
    Ok(Outcome::done(format!(
        "{}: {:.1} MB; open it in a browser\n",
        target.display(),
        html.len() as f64 / 1e6
    )))
}

/// The way from the folder of one file to another file, so that both can move together; none where the system doesn't tell.
pub(crate) fn way_between(from: &Path, to: &Path) -> Option<String> {
    let folder = |path: &Path| match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Path::new(".").canonicalize(),
        Some(parent) => parent.canonicalize(),
        None => Path::new(".").canonicalize(),
    };
    let (start, end) = (folder(from).ok()?, folder(to).ok()?);
    let start: Vec<Component> = start.components().collect();
    let end: Vec<Component> = end.components().collect();
    let same = start.iter().zip(&end).take_while(|(a, b)| a == b).count();
    let up = start[same..].iter().map(|_| Component::ParentDir);
    let way: PathBuf = up.chain(end[same..].iter().copied()).collect();
    let way = way.join(to.file_name()?);
    way.to_str().map(|way| way.replace('\\', "/"))
}
