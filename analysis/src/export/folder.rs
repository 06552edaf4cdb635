//! Putting an export in place: all of its files or none, and never over something else.

use super::Export;
use shutterlab_data_schema::files::{create_folder, named};
use std::io;
use std::path::Path;
use tempfile::TempDir;

impl Export {
    /// Makes `folder` hold the files of this export and nothing else. They are written into a folder
    /// beside it, which then takes its name.
    ///
    /// # Errors
    /// `folder` holds something else than an earlier export of the same study in the same format; a file
    /// cannot be written. What was there still is.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        let there = self.check(folder)?;
        let parent =
            folder.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        create_folder(parent)?;
        let new = temporary(parent)?;
        for (path, bytes) in &self.files {
            let path = new.path().join(path);
            create_folder(path.parent().unwrap_or(new.path()))?;
            std::fs::write(&path, bytes).map_err(|e| named(&path, &e))?;
        }
        let old = temporary(parent)?;
        let aside = old.path().join("old");
        if there {
            std::fs::rename(folder, &aside).map_err(|e| named(folder, &e))?;
        }
        if let Err(error) = std::fs::rename(new.path(), folder) {
            if there {
                std::fs::rename(&aside, folder).map_err(|e| named(&aside, &e))?;
            }
            return Err(named(folder, &error));
        }
        // It has another name now.
        let _ = new.keep();
        Ok(())
    }

    /// Whether there is a folder to be replaced.
    fn check(&self, folder: &Path) -> io::Result<bool> {
        if !folder.exists() {
            return Ok(false);
        }
        let there = files_below(folder)?;
        let refuse = |what: String| {
            let what = format!("{}: {what}; choose another folder", folder.display());
            Err(io::Error::new(io::ErrorKind::AlreadyExists, what))
        };
        let readme = std::fs::read_to_string(folder.join("README.md")).unwrap_or_default();
        if !there.is_empty() && !readme.lines().any(|line| line.starts_with(&self.mark)) {
            return refuse("not empty, and no earlier export of this study in this format".into());
        }
        // Participants may have been withdrawn since, and Python keeps what it has compiled.
        let left = |path: &str| {
            ["_data.csv", "_beh.tsv", ".pyc"].iter().any(|ending| path.ends_with(ending))
        };
        let mine = |path: &str| left(path) || self.files.iter().any(|(name, _)| name == path);
        match there.iter().find(|path| !mine(path)) {
            Some(other) => refuse(format!("{other}: not of the export")),
            None => Ok(true),
        }
    }
}

/// The files in `folder` and its folders, by path in it.
fn files_below(folder: &Path) -> io::Result<Vec<String>> {
    let (mut files, mut folders) = (Vec::new(), vec![folder.to_path_buf()]);
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).map_err(|e| named(&next, &e))? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let parts = path.strip_prefix(folder).unwrap_or(&path).components();
                let parts: Vec<_> = parts.map(|part| part.as_os_str().to_string_lossy()).collect();
                files.push(parts.join("/"));
            }
        }
    }
    files.sort();
    Ok(files)
}

/// A folder in `parent` that is removed unless it is kept, and that others may read.
fn temporary(parent: &Path) -> io::Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".").suffix(".partial");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
    builder.tempdir_in(parent).map_err(|e| named(parent, &e))
}
