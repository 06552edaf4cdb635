//! Damaged and hostile files of every format: each is read or refused by one error that names the
//! file, and none makes a reader panic, hang, or believe a number that no bytes stand behind.

use super::image::tests::{file_of, radiance, radiance_file};
use super::*;
use crate::sampling::random::StreamKey;
use ::image::ImageFormat;

const CHANGED_FILES: u32 = 4000;
const TRUNCATED_FILES: usize = 1500;

type Parse = fn(&str, &[u8]) -> Result<(), ImportError>;

fn as_ply(file: &str, bytes: &[u8]) -> Result<(), ImportError> {
    ply::parse(file, bytes).map(drop)
}

fn as_obj(file: &str, bytes: &[u8]) -> Result<(), ImportError> {
    obj::parse(file, bytes, Path::new("/nowhere")).map(drop)
}

fn as_mtl(file: &str, bytes: &[u8]) -> Result<(), ImportError> {
    obj::parse_materials(file, bytes)
}

fn as_gltf(file: &str, bytes: &[u8]) -> Result<(), ImportError> {
    let model = gltf::parse(file, bytes, Path::new("/nowhere"))?;
    for material in model.materials {
        if let Some(texture @ Texture::Embedded { .. }) = material.texture {
            image::texture(&texture)?;
        }
    }
    Ok(())
}

fn as_stl(file: &str, bytes: &[u8]) -> Result<(), ImportError> {
    stl::parse(file, bytes).map(drop)
}

fn as_picture(file: &str, bytes: &[u8]) -> Result<(), ImportError> {
    let any = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Hdr, ImageFormat::OpenExr];
    image::decode(file, bytes, &any).map(drop)
}

/// One good file of each format; the last number is how many bytes at its end are not needed.
fn files() -> Vec<(&'static str, Parse, Vec<u8>, usize)> {
    let light = || radiance([[1.0, 2.0, 3e5], [0.0; 3], [0.5; 3], [7.0, 0.0, 0.1]]);
    let colors =
        || ::image::RgbImage::from_fn(9, 5, |x, y| [x as u8 * 20, y as u8 * 50, 77].into());
    let obj =
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 3//1\n";
    let mtl = "newmtl a\nKd 1 0.5 0.25\nmap_Kd -s 2 2 1 -clamp on a b.png\n";
    vec![
        ("text.ply", as_ply, ply::tests::TEXT.into(), 2),
        ("little.ply", as_ply, ply::tests::binary(false), 0),
        ("big.ply", as_ply, ply::tests::binary(true), 0),
        ("a.obj", as_obj, obj.into(), 6),
        ("a.mtl", as_mtl, mtl.into(), mtl.len()),
        ("a.gltf", as_gltf, gltf::tests::embedded().into(), 0),
        ("a.glb", as_gltf, gltf::tests::binary(), 0),
        ("text.stl", as_stl, stl::tests::TEXT.into(), 10),
        ("a.stl", as_stl, stl::tests::binary(), 0),
        ("a.hdr", as_picture, radiance_file("EXPOSURE=2", 2, &[[128; 4], [9; 4]]), 0),
        ("long.hdr", as_picture, file_of(light(), ImageFormat::Hdr), 0),
        ("a.exr", as_picture, file_of(light(), ImageFormat::OpenExr), 0),
        ("a.png", as_picture, file_of(colors(), ImageFormat::Png), 12),
        ("a.jpg", as_picture, file_of(colors(), ImageFormat::Jpeg), 0),
    ]
}

fn refused(file: &str, result: Result<(), ImportError>) -> bool {
    let Err(error) = result else { return false };
    let message = error.to_string();
    // A changed name of a library or buffer is the name of another file.
    assert!(message.contains(file) || message.contains(": cannot be read: "), "{file}: {message}");
    assert!(message.len() < 600, "{message}");
    true
}

#[test]
fn a_file_that_ends_too_soon_is_refused() {
    for (file, parse, bytes, spare) in files() {
        assert!(!refused(file, parse(file, &bytes)), "{file}: {:?}", parse(file, &bytes));
        for length in (0..bytes.len()).step_by(bytes.len().div_ceil(TRUNCATED_FILES)) {
            let is_refused = refused(file, parse(file, &bytes[..length]));
            assert!(is_refused || length >= bytes.len().saturating_sub(spare), "{file}: {length}");
        }
    }
}

#[test]
fn changed_files_are_read_or_refused() {
    for (file, parse, bytes, _) in files() {
        let key = StreamKey::new(1, file, 0, 0, 0);
        let changed = |number: u32| {
            let mut bytes = bytes.clone();
            for change in 0..1 + key.words(number, 0, 0)[0] % 4 {
                let [place, kind, a, b] = key.words(number, 1, change).map(|word| word as usize);
                let at = place % bytes.len().max(1);
                let end = (at + 1 + a % 12).min(bytes.len());
                match kind % 7 {
                    _ if bytes.is_empty() => {}
                    0 => bytes[at] ^= 1 << (a % 8),
                    1 => bytes[at] = [0, 1, 127, 128, 255][a % 5],
                    2 => bytes[at] = b"0123456789-.e /\n\"[]{}"[a % 21],
                    3 => drop(bytes.drain(at..end)),
                    4 => bytes.insert(at, b"0123456789-.e /\n"[a % 16]),
                    5 => {
                        let copy = bytes[at..end].to_vec();
                        let to = b % bytes.len();
                        bytes.splice(to..to, copy);
                    }
                    _ => bytes[at..end].fill(a as u8),
                }
            }
            bytes
        };
        let bad = (0..CHANGED_FILES).filter(|&n| refused(file, parse(file, &changed(n)))).count();
        // The changes reach what matters, and not only the first line.
        assert!((80..CHANGED_FILES as usize).contains(&bad), "{file}: {bad}");
    }
}

#[test]
fn only_regular_files_with_a_known_ending_are_read() {
    let message = |path: &Path| model(path).unwrap_err().to_string();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ply");
    assert!(message(&path).contains("a.ply: cannot be read: "));
    std::fs::create_dir(&path).unwrap();
    assert!(message(&path).ends_with("a.ply: cannot be read: not a regular file"));
    let path = folder.path().join("a.off");
    let expected = "a.off: ending: off: models are .ply, .obj, .gltf, .glb and .stl files";
    assert!(message(&path).ends_with(expected));
    let path = folder.path().join("b.PLY");
    std::fs::write(&path, ply::tests::TEXT).unwrap();
    assert_eq!(model(&path).unwrap().mesh.triangles.len(), 2);
}

/// Not a check: the good files become what `script/fuzz` begins with.
#[test]
#[ignore = "writes into fuzz/corpus"]
fn seeds_of_the_fuzzers() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz");
    for (file, _, bytes, _) in files() {
        let reader = match file.rsplit('.').next() {
            Some("glb") => "gltf",
            ending => ending.unwrap(),
        };
        if fuzz.join(format!("fuzz_targets/{reader}.rs")).exists() {
            let corpus = fuzz.join("corpus").join(reader);
            std::fs::create_dir_all(&corpus).unwrap();
            std::fs::write(corpus.join(file), bytes).unwrap();
        }
    }
}
