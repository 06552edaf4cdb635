//! Files that stimuli are made with besides their definitions: light maps, pictures and models. They are
//! kept beside the sequences by what they hold, so a folder of sequences can be moved, checked and
//! rendered again with nothing else at hand.

use crate::frames::hex;
use percent_encoding::percent_decode_str;
use sha2::{Digest, Sha256};
use shutterlab_data_schema::definition::{DefinitionError, nearest};
use shutterlab_data_schema::files::{create_folder, named, write_atomically};
use std::io;
use std::path::{Component, Path, PathBuf};

/// Where a model's file is named, this before one of [`MADE`] names a model that is made instead.
const MADE_PREFIX: &str = "made:";

/// The models that Shutterlab makes itself: sixteen for experiments, and five to hold what was found against.
pub const MADE: [&str; 21] = [
    "knot23",
    "knot34",
    "knot52",
    "bumps",
    "spikes",
    "fractal",
    "rings",
    "meridians",
    "gear12",
    "gear40",
    "screw",
    "hills",
    "dunes",
    "comb",
    "brush",
    "fringe",
    "knot37",
    "asteroid",
    "gear25",
    "ridge",
    "hedgehog",
];

/// The name of the model that is made where `file` names a model's file, if it is no file.
pub fn made(file: &str) -> Option<&str> {
    file.strip_prefix(MADE_PREFIX)
}

/// Name of the folder of assets beside the sequences.
const FOLDER: &str = "assets";

/// A file as it was found, with the files that it names in turn, as models do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asset {
    /// Where.
    pub source: PathBuf,
    /// SHA-256 of its bytes, in hexadecimal. With companions, that of a list: its own hash, then names and
    /// hashes of theirs.
    pub sha256: String,
    /// What it has to be.
    pub kind: Kind,
    /// Paths of the files it names, from its folder.
    companions: Vec<PathBuf>,
}

/// What a file is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The light from all around.
    LightMap,
    /// A pattern of a surface.
    Picture,
    /// A mesh.
    Model,
}

impl Asset {
    /// Reads and hashes the file at `source`, which is to be used as `kind`, and its companions.
    ///
    /// # Errors
    /// One of them cannot be read, or a companion lies neither beside the file nor below.
    pub fn open(source: &Path, kind: Kind) -> io::Result<Self> {
        let mut companions = if kind == Kind::Model { companions(source)? } else { vec![] };
        companions.sort();
        companions.dedup();
        let below = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
        let apart = |path: &&PathBuf| !path.components().all(below);
        if let Some(path) = companions.iter().find(apart) {
            let what = format!("names {}, which is neither beside nor below it", path.display());
            return Err(named(source, &io::Error::other(what)));
        }
        let sha256 = hash(source, &companions)?;
        Ok(Self { source: source.into(), sha256, kind, companions })
    }

    /// Copies the file and its companions to the assets of the sequences in `out`, unless they are there and
    /// whole.
    ///
    /// # Errors
    /// One of them cannot be read or written, or has changed since it was opened.
    pub fn keep(&self, out: &Path) -> io::Result<()> {
        let kept = path(out, &self.source, &self.sha256);
        if hash(&kept, &self.companions).is_ok_and(|found| found == self.sha256) {
            return Ok(());
        }
        if hash(&self.source, &self.companions)? != self.sha256 {
            return Err(named(&self.source, &io::Error::other("has changed meanwhile")));
        }
        // The file comes last: where it is, its companions are.
        let copies = self.companions.iter().map(|companion| {
            (
                self.source.with_file_name("").join(companion),
                kept.with_file_name("").join(companion),
            )
        });
        for (from, to) in copies.chain([(self.source.clone(), kept.clone())]) {
            let bytes = read(&from)?;
            create_folder(to.parent().unwrap_or(out))?;
            write_atomically(&to, &bytes)?;
        }
        Ok(())
    }
}

/// SHA-256 of the bytes of the file at `path`, in hexadecimal.
pub(crate) fn sha256(path: &Path) -> io::Result<String> {
    Ok(hex(&Sha256::digest(read(path)?)))
}

/// Where the file called `name` with this hash is kept beside the sequences in `out`.
pub fn path(out: &Path, name: &Path, sha256: &str) -> PathBuf {
    out.join(FOLDER).join(sha256).join(name.file_name().unwrap_or_default())
}

/// SHA-256 of the file at `source`, or of the list of its and its companions' names and hashes.
fn hash(source: &Path, companions: &[PathBuf]) -> io::Result<String> {
    let own = sha256(source)?;
    if companions.is_empty() {
        return Ok(own);
    }
    let mut list = Sha256::new();
    list.update(&own);
    for companion in companions {
        let hash = sha256(&source.with_file_name("").join(companion))?;
        list.update(format!("\n{} {hash}", companion.display()));
    }
    Ok(hex(&list.finalize()))
}

/// The files that the model at `source` names, from its folder: libraries of materials, buffers and pictures.
/// Those that are not there are left to the reader of the model to miss.
///
/// # Errors
/// The model or a library of it cannot be read.
pub fn companions(source: &Path) -> io::Result<Vec<PathBuf>> {
    let folder = source.with_file_name("");
    let ending = source.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match ending.as_str() {
        "obj" => {
            let mut libraries = mentioned(&read(source)?, "mtllib", &folder, Path::new(""));
            libraries.sort();
            libraries.dedup();
            let mut all = libraries.clone();
            for library in libraries {
                let beside = library.parent().unwrap_or(Path::new(""));
                all.extend(mentioned(&read(&folder.join(&library))?, "map_Kd", &folder, beside));
            }
            Ok(all)
        }
        "gltf" | "glb" => {
            let bytes = read(source)?;
            let document: serde_json::Value =
                serde_json::from_slice(json_chunk(&bytes)).unwrap_or_default();
            let uris = ["buffers", "images"]
                .into_iter()
                .flat_map(|list| document[list].as_array().into_iter().flatten())
                .filter_map(|entry| entry["uri"].as_str())
                .filter(|uri| !uri.starts_with("data:"));
            let decoded = uris.map(|uri| percent_decode_str(uri).decode_utf8_lossy().into_owned());
            Ok(decoded.map(PathBuf::from).filter(|path| folder.join(path).is_file()).collect())
        }
        _ => Ok(vec![]),
    }
}

/// The JSON of a glTF file: all of it, or the first chunk of a binary one, behind a header of 12 bytes, its
/// length and its type.
fn json_chunk(bytes: &[u8]) -> &[u8] {
    let chunk = || {
        let length = u32::from_le_bytes(bytes.get(12..16)?.try_into().ok()?);
        bytes.get(20..)?.get(..length as usize)
    };
    if bytes.starts_with(b"glTF") { chunk().unwrap_or_default() } else { bytes }
}

/// The bytes of a regular file: a device may never end, and a pipe may never begin.
fn read(path: &Path) -> io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path).map_err(|e| named(path, &e))?;
    if !metadata.is_file() {
        return Err(named(path, &io::Error::other("not a regular file")));
    }
    std::fs::read(path).map_err(|e| named(path, &e))
}

/// Longest line of a model that is looked at for names of files.
const MAX_LINE: usize = 4096;

/// The files below `folder` that lines of `text` name behind `key`: options may come first, and names may
/// have spaces, so it is the longest ending of the line that is a file. Names count from `beside`.
fn mentioned(text: &[u8], key: &str, folder: &Path, beside: &Path) -> Vec<PathBuf> {
    let text = String::from_utf8_lossy(text);
    let name = |line: &str| {
        let mut rest = line.trim().strip_prefix(key)?.strip_prefix(char::is_whitespace)?.trim();
        loop {
            let path = beside.join(rest.replace('\\', "/"));
            if folder.join(&path).is_file() {
                return Some(path);
            }
            rest = rest.split_once(char::is_whitespace)?.1.trim_start();
        }
    };
    text.lines().filter(|line| line.len() <= MAX_LINE).filter_map(name).collect()
}

/// Refuses a model that there is not; `field` of `place` is what an error calls the name.
pub(crate) fn check_made(file: &str, field: &str, place: &str) -> Result<(), DefinitionError> {
    let Some(name) = made(file).filter(|name| !MADE.contains(name)) else { return Ok(()) };
    let hint = nearest(name, MADE).map_or(String::new(), |near| format!("; did you mean {near}?"));
    let allowed = format!("the models that are made are {}{hint}", MADE.join(", "));
    Err(DefinitionError::value(place, field, file, allowed))
}

/// Collects the files that a definition names.
#[derive(Debug)]
pub(crate) struct Assets<'a> {
    /// What an error calls the definition.
    pub place: &'a str,
    /// The folder that paths are from.
    pub folder: PathBuf,
    /// What was found.
    pub found: Vec<Asset>,
}

impl Assets<'_> {
    /// Finds the file called `file`, which the table `field` names, and puts its name and hash in their places; a
    /// hash that is there must be right. A model that is made has neither.
    pub fn find(
        &mut self,
        field: &str,
        kind: Kind,
        file: &mut String,
        sha256: &mut String,
    ) -> Result<(), DefinitionError> {
        if kind == Kind::Model && made(file).is_some() {
            if !sha256.is_empty() {
                let field = format!("{field}.sha256");
                let allowed = "a model that is made has none";
                return Err(DefinitionError::value(self.place, field, &*sha256, allowed));
            }
            return check_made(file, &format!("{field}.file"), self.place);
        }
        let source = self.folder.join(&*file);
        let known = self.found.iter().find(|asset| asset.source == source && asset.kind == kind);
        let is_new = known.is_none();
        let asset = match known {
            Some(asset) => asset.clone(),
            None => Asset::open(&source, kind).map_err(|error| {
                DefinitionError::value(
                    self.place,
                    format!("{field}.file"),
                    &*file,
                    error.to_string(),
                )
            })?,
        };
        if !sha256.is_empty() && *sha256 != asset.sha256 {
            let allowed = format!("the file's SHA-256 is {}", asset.sha256);
            return Err(DefinitionError::value(
                self.place,
                format!("{field}.sha256"),
                &*sha256,
                allowed,
            ));
        }
        *file = source.file_name().unwrap_or_default().to_string_lossy().into_owned();
        sha256.clone_from(&asset.sha256);
        if is_new {
            self.found.push(asset);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_kept_by_what_it_holds() {
        let folder = tempfile::tempdir().unwrap();
        let source = folder.path().join("sky.hdr");
        std::fs::write(&source, "abc").unwrap();
        let asset = Asset::open(&source, Kind::LightMap).unwrap();
        // The hash of "abc" in FIPS 180-2.
        assert!(asset.sha256.starts_with("ba7816bf8f01cfea414140de5dae2223"));
        asset.keep(folder.path()).unwrap();
        let kept = path(folder.path(), &source, &asset.sha256);
        assert_eq!(std::fs::read(&kept).unwrap(), b"abc");
        std::fs::write(&source, "abd").unwrap();
        asset.keep(folder.path()).unwrap();
        std::fs::write(&kept, "damaged").unwrap();
        let error = asset.keep(folder.path()).unwrap_err().to_string();
        assert!(error.contains("sky.hdr: has changed meanwhile"), "{error}");
    }

    #[test]
    fn a_model_is_kept_with_all_that_it_names() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        write("in/cow.obj", "mtllib ./mtl/cow.mtl\nmtllib missing.mtl\nv 0 0 0\n");
        write("in/mtl/cow.mtl", "newmtl a\nmap_Kd -s 1 1 1 maps/the cow.png\n");
        write("in/mtl/maps/the cow.png", "picture");
        let source = folder.path().join("in/cow.obj");
        let open = |path: &Path| Asset::open(path, Kind::Model);
        let asset = open(&source).unwrap();
        let out = folder.path().join("out");
        asset.keep(&out).unwrap();
        let kept = path(&out, &source, &asset.sha256);
        assert_eq!(open(&kept).unwrap().sha256, asset.sha256);
        assert!(kept.with_file_name("mtl").join("maps/the cow.png").exists());
        write("in/mtl/maps/the cow.png", "another");
        assert_ne!(open(&source).unwrap().sha256, asset.sha256);

        let gltf = |uri: &str| {
            format!(r#"{{"buffers": [{{"uri": "{uri}"}}], "images": [{{"uri": "data:,"}}]}}"#)
        };
        write("in/a.gltf", &gltf("a%20b.bin"));
        write("in/a b.bin", "numbers");
        let asset = open(&folder.path().join("in/a.gltf")).unwrap();
        assert_eq!(asset.companions, [PathBuf::from("a b.bin")]);

        write("in/b.gltf", &gltf("../in/a%20b.bin"));
        let error = open(&folder.path().join("in/b.gltf")).unwrap_err().to_string();
        assert!(error.contains("b.gltf: names ../in/a b.bin, which is neither"), "{error}");
    }
}
