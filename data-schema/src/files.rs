//! Writing a whole file or nothing: the bytes go to a temporary file in the same folder, are
//! synced, and take the file's name by rename. A reader never sees half a file.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// Writes `bytes` to `path` so that either the whole file is there or the old one still is.
///
/// # Errors
/// Any failure to create, write, sync or rename; it names the file. The temporary file is removed.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_atomically_with(path, |file| file.write_all(bytes))
}

/// As [`write_atomically`], with the bytes coming from `write`.
///
/// # Errors
/// As [`write_atomically`], and whatever `write` fails with.
pub fn write_atomically_with(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    (|| {
        let mut file = builder().tempfile_in(folder_of(path))?;
        write(file.as_file_mut())?;
        file.as_file().sync_all()?;
        file.persist(path).map_err(|error| error.error)?;
        sync_folder(folder_of(path))
    })()
    .map_err(|error| named(path, &error))
}

/// As [`write_atomically`], but without waiting for the disk: a power cut may take the bytes away.
///
/// # Errors
/// As [`write_atomically`].
pub fn write_unsynced(path: &Path, bytes: &[u8]) -> io::Result<()> {
    (|| {
        let mut file = builder().tempfile_in(folder_of(path))?;
        file.write_all(bytes)?;
        file.persist(path).map_err(|error| error.error)?;
        Ok(())
    })()
    .map_err(|error| named(path, &error))
}

/// Writes `bytes` to `path` unless there is a file already, and says whether it did. Of several who
/// try it at once, on one computer or on a network share, exactly one does.
///
/// # Errors
/// As [`write_atomically`].
pub fn create_atomically(path: &Path, bytes: &[u8]) -> io::Result<bool> {
    let created = create_unsynced(path, bytes)?;
    if created {
        let file = File::options().write(true).open(path);
        file.and_then(|file| file.sync_all())
            .and_then(|()| sync_folder(folder_of(path)))
            .map_err(|error| named(path, &error))?;
    }
    Ok(created)
}

/// As [`create_atomically`], but without waiting for the disk: a power cut may take the bytes away.
///
/// # Errors
/// As [`write_atomically`].
pub fn create_unsynced(path: &Path, bytes: &[u8]) -> io::Result<bool> {
    (|| {
        let mut file = builder().tempfile_in(folder_of(path))?;
        file.write_all(bytes)?;
        match file.persist_noclobber(path) {
            Ok(_) => Ok(true),
            Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => Ok(false),
            Err(error) => Err(error.error),
        }
    })()
    .map_err(|error| named(path, &error))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Syncs the names in `folder`, where the system lets a folder be opened: without it a power cut can
/// take away the name of a file whose bytes are safe.
///
/// # Errors
/// The folder cannot be synced.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    #[cfg(unix)]
    File::open(folder)?.sync_all()?;
    #[cfg(not(unix))]
    let _ = folder;
    Ok(())
}

/// Temporary files that others may read like any file of this user.
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".").suffix(".partial");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

/// Creates `folder` and its parents.
///
/// # Errors
/// Names the folder; among them that a regular file is in its place.
pub fn create_folder(folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder).map_err(|error| named(folder, &error))
}

/// `error` with the name of the file it happened to.
pub fn named(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("votes.csv");
        write_atomically(&path, b"old").unwrap();
        let error = write_atomically_with(&path, |file| {
            file.write_all(b"half of the ne")?;
            Err(io::Error::new(io::ErrorKind::StorageFull, "no space left on device"))
        })
        .unwrap_err();
        assert!(error.to_string().contains("votes.csv: no space left"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn of_many_who_create_a_file_one_does() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("1.json");
        let create =
            |text: String| create_atomically(&path, text.as_bytes()).unwrap().then_some(text);
        let created: Vec<Option<String>> = std::thread::scope(|scope| {
            let threads: Vec<_> =
                (0..16).map(|n| scope.spawn(move || create(format!("{n}")))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        let winners: Vec<String> = created.into_iter().flatten().collect();
        assert_eq!(winners, [std::fs::read_to_string(&path).unwrap()]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_under_a_regular_file_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plain");
        std::fs::write(&file, b"").unwrap();
        let out = file.join("out");
        let error = create_folder(&out).unwrap_err().to_string();
        assert!(error.contains(&out.display().to_string()), "{error}");
    }
}
