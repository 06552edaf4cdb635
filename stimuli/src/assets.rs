//! Files that stimuli are made with besides their definitions, such as light maps. They are kept beside
//! the sequences by what they hold, so a folder of sequences can be moved, checked and rendered again
//! with nothing else at hand.

use crate::frames::hex;
use sha2::{Digest, Sha256};
use shutterlab_data_schema::files::{create_folder, named, write_atomically};
use std::io;
use std::path::{Path, PathBuf};

/// Name of the folder of assets beside the sequences.
const FOLDER: &str = "assets";

/// A file as it was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asset {
    /// Where.
    pub source: PathBuf,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

impl Asset {
    /// Reads and hashes the file at `source`.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn open(source: &Path) -> io::Result<Self> {
        Ok(Self { source: source.into(), sha256: sha256(source)? })
    }

    /// Copies the file to the assets of the sequences in `out`, unless it is there.
    ///
    /// # Errors
    /// It cannot be read or written, or has changed since it was opened.
    pub fn keep(&self, out: &Path) -> io::Result<()> {
        let file = path(out, &self.source, &self.sha256);
        if file.exists() {
            return Ok(());
        }
        let bytes = std::fs::read(&self.source).map_err(|e| named(&self.source, &e))?;
        if hex(&Sha256::digest(&bytes)) != self.sha256 {
            return Err(named(&self.source, &io::Error::other("has changed meanwhile")));
        }
        create_folder(&out.join(FOLDER))?;
        write_atomically(&file, &bytes)
    }
}

/// SHA-256 of the bytes of the file at `path`, in hexadecimal.
pub(crate) fn sha256(path: &Path) -> io::Result<String> {
    let bytes = std::fs::read(path).map_err(|e| named(path, &e))?;
    Ok(hex(&Sha256::digest(bytes)))
}

/// Where the file called `name` with this hash is kept beside the sequences in `out`.
pub fn path(out: &Path, name: &Path, sha256: &str) -> PathBuf {
    let kept = out.join(FOLDER).join(sha256);
    name.extension().map_or(kept.clone(), |ending| kept.with_extension(ending))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_kept_by_what_it_holds() {
        let folder = tempfile::tempdir().unwrap();
        let source = folder.path().join("sky.hdr");
        std::fs::write(&source, "abc").unwrap();
        let asset = Asset::open(&source).unwrap();
        // The hash of "abc" in FIPS 180-2.
        assert!(asset.sha256.starts_with("ba7816bf8f01cfea414140de5dae2223"));
        asset.keep(folder.path()).unwrap();
        let kept = path(folder.path(), Path::new("sky.hdr"), &asset.sha256);
        assert_eq!(std::fs::read(&kept).unwrap(), b"abc");
        std::fs::write(&source, "abd").unwrap();
        asset.keep(folder.path()).unwrap();
        std::fs::remove_file(&kept).unwrap();
        let error = asset.keep(folder.path()).unwrap_err().to_string();
        assert!(error.contains("sky.hdr: has changed meanwhile"), "{error}");
    }
}
