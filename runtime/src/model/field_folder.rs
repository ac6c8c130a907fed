//! Where a scene may write fields, and over what: a scene may come from a stranger.

use std::path::{Component, Path, PathBuf};

use dcb_formats::output::{Replace, is_same_file};

use super::fields::FieldPlan;
use crate::error::Error;
use crate::export::vtu::FieldSeries;

/// Rules for the fields of a run.
#[derive(Debug)]
pub struct FieldFolders<'a> {
    /// Folders in which they may be.
    pub within: Vec<&'a Path>,
    /// Treatment of files that exist.
    pub replace: Replace,
    /// Files that this run reads or writes.
    pub others: Vec<&'a Path>,
}

impl FieldFolders<'_> {
    /// Makes the folders of the fields; returns where they are, links resolved.
    ///
    /// # Errors
    /// [`Error::Description`] for a folder outside those that are allowed, and for two fields that would write the same files;
    /// [`Error::File`] for files that are there and stay without `--force`; [`Error::WouldDestroyInput`]; [`Error::CannotWrite`].
    pub fn make(&self, plans: &[FieldPlan]) -> Result<Vec<PathBuf>, Error> {
        let mut folders: Vec<PathBuf> = Vec::new();
        for (index, plan) in plans.iter().enumerate() {
            let location = format!("fields[{index}].directory");
            let folder = self.make_one(plan.directory(), &location)?;
            let earlier = folders.iter().zip(plans);
            let is_same = |(other, of): &(&PathBuf, &FieldPlan)| {
                **other == folder && of.body_name() == plan.body_name()
            };
            if let Some(other) = earlier.clone().position(|pair| is_same(&pair)) {
                return Err(Error::described(
                    location,
                    format!(
                        "is that of fields[{other}], of the same body; name another folder, or put all times into one entry"
                    ),
                ));
            }
            let list = FieldSeries::list_path(&folder, plan.body_name());
            let there = FieldSeries::existing(&folder, plan.body_name());
            for written in there.iter().chain([&list]) {
                if self.others.iter().any(|other| is_same_file(other, written)) {
                    return Err(Error::WouldDestroyInput {
                        path: written.clone(),
                        role: "a file that this run reads or writes otherwise",
                    });
                }
            }
            if let (Some(path), Replace::Refuse) = (there.into_iter().next(), self.replace) {
                return Err(Error::File(dcb_formats::Error::OutputExists { path }));
            }
            folders.push(folder);
        }
        Ok(folders)
    }

    fn make_one(&self, folder: &Path, location: &str) -> Result<PathBuf, Error> {
        let outside = |place: &Path| {
            Error::described(
                location,
                format!(
                    "leads to {}, outside the folders of the scene and of the results; name a folder inside, or allow it with --fields-in FOLDER",
                    place.display()
                ),
            )
        };
        let place = resolved(folder).ok_or_else(|| outside(folder))?;
        if !self.allows(&place) {
            return Err(outside(&place));
        }
        let told = |source| Error::CannotWrite {
            path: folder.to_owned(),
            source,
        };
        std::fs::create_dir_all(&place).map_err(told)?;
        // A link that was put there meanwhile leads elsewhere.
        let made = place.canonicalize().map_err(told)?;
        match self.allows(&made) {
            true => Ok(made),
            false => Err(outside(&made)),
        }
    }

    fn allows(&self, place: &Path) -> bool {
        self.within
            .iter()
            .any(|folder| resolved(folder).is_some_and(|folder| place.starts_with(folder)))
    }
}

/// Where a folder is, or would be: links and `..` followed as far as it is there; what isn't there may have none.
fn resolved(folder: &Path) -> Option<PathBuf> {
    for there in folder.ancestors() {
        let named = match there.as_os_str().is_empty() {
            true => Path::new("."),
            false => there,
        };
        if let Ok(place) = named.canonicalize() {
            let rest = folder.strip_prefix(there).ok()?;
            let is_plain =
                |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
            return rest.components().all(is_plain).then(|| place.join(rest));
        }
    }
    None
}

#[cfg(all(test, unix))]
#[expect(clippy::unwrap_used, reason = "a test says what went wrong by failing")]
mod tests {
    use super::*;

    #[test]
    fn folders_outside_are_refused_however_they_are_named() {
        let place = tempfile::tempdir().unwrap();
        let (scene, other) = (place.path().join("scene"), place.path().join("other"));
        for folder in [&scene, &other] {
            std::fs::create_dir(folder).unwrap();
        }
        std::os::unix::fs::symlink(&other, scene.join("link")).unwrap();
        std::os::unix::fs::symlink("nowhere", scene.join("dangling")).unwrap();
        let mut folders = FieldFolders {
            within: vec![&scene],
            replace: Replace::Refuse,
            others: Vec::new(),
        };
        let make = |folders: &FieldFolders, name: &str| folders.make_one(&scene.join(name), "here");
        for name in ["", "fields", "./a/b", "fields/../c"] {
            let made = make(&folders, name).unwrap();
            assert!(made.is_dir() && made.starts_with(scene.canonicalize().unwrap()));
        }
        let absolute = other.join("fields");
        let outside = [
            "../other",
            "..",
            "link",
            "link/new",
            "new/../../other",
            absolute.to_str().unwrap(),
        ];
        for name in outside {
            let told = make(&folders, name).unwrap_err().to_string();
            assert!(
                told.contains("here: leads to") && told.contains("--fields-in"),
                "{told}"
            );
        }
        assert!(make(&folders, "dangling").is_err());
        assert_eq!(std::fs::read_dir(&other).unwrap().count(), 0);
        folders.within.push(&other);
        for name in ["../other", "link", "link/new", absolute.to_str().unwrap()] {
            make(&folders, name).unwrap();
        }
    }
}
