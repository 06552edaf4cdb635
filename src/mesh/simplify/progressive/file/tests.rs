//! Files hold what was written, are read in part, and do no harm if they are damaged or made to.

use super::*;
use crate::mesh::simplify::progressive::tests::{ball, bits, inputs, recorded};
use crate::sampling::random::StreamKey;
use std::io::Read;

fn written(mesh: &ProgressiveMesh) -> Vec<u8> {
    let mut file = vec![];
    mesh.write(&mut file).unwrap();
    file
}

fn read(file: &[u8]) -> Result<ProgressiveMesh, FileError> {
    Reader::open("a", file)?.read_all()
}

#[test]
fn a_file_holds_what_was_written() {
    for (name, input, groups) in inputs() {
        let mut progressive = recorded(&input, groups.as_deref());
        progressive.speeds = vec![(0.5, 90), (2.0, 10)];
        let mut again = read(&written(&progressive)).unwrap();
        assert_eq!(again, progressive, "{name}");
        again.set_faces(usize::MAX);
        assert_eq!(bits(&again.mesh().0), bits(&input), "{name}");
        assert_eq!(written(&again), written(&progressive), "whatever the level");
    }
}

#[test]
fn a_file_is_smaller_than_the_mesh() {
    let input = ball(40);
    let plain = 12 * (input.positions.len() + input.triangles.len());
    let file = written(&recorded(&input, None)).len();
    assert!(file < plain, "{file} beside {plain}");
}

/// Counts the bytes that are read.
struct Counted<'a>(&'a [u8], &'a std::cell::Cell<usize>);

impl Read for Counted<'_> {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        let count = self.0.read(to)?;
        self.1.set(self.1.get() + count);
        Ok(count)
    }
}

#[test]
fn a_coarse_level_is_read_from_a_part_of_the_file() {
    let mut whole = recorded(&ball(60), None);
    let last = whole.splits.len() as u32;
    whole.speeds = vec![(1.0, last / 2), (2.0, last / 10), (3.0, 0)];
    let file = written(&whole);
    let count = std::cell::Cell::new(0);
    let mut reader = Reader::open("a", Counted(&file, &count)).unwrap();
    assert!(count.get() < file.len() / 20, "{} of {}", count.get(), file.len());
    let same = |reader: &Reader<_>, whole: &ProgressiveMesh, part: f32| {
        assert_eq!(reader.mesh().mesh(), whole.mesh());
        assert_eq!(reader.mesh().error(), whole.error());
        assert!(
            (count.get() as f32) < part * file.len() as f32,
            "{} of {}",
            count.get(),
            file.len()
        );
    };
    for (faces, part) in [(3000, 0.3), (500, 0.3), (14_000, 0.6), (4000, 0.6)] {
        reader.set_faces(faces).unwrap();
        whole.set_faces(faces);
        same(&reader, &whole, part);
    }
    // What was read in part can be written, and read again.
    let part = read(&written(reader.mesh())).unwrap();
    assert_eq!(part.face_counts()[1], reader.mesh().face_counts()[1]);
    for speed in [2.5, 3.5] {
        reader.set_speed(speed).unwrap();
        whole.set_speed(speed);
        same(&reader, &whole, 0.6);
    }
    let error = whole.error_after(whole.splits.len() * 3 / 5);
    reader.set_error(error).unwrap();
    whole.set_error(error);
    same(&reader, &whole, 0.85);
    whole.set_faces(0);
    assert_eq!(reader.read_all().unwrap(), whole);
}

fn refusal(file: &[u8]) -> String {
    read(file).unwrap_err().to_string()
}

#[test]
fn a_file_that_ends_too_soon_or_was_damaged_is_refused() {
    let file = written(&recorded(&ball(6), None));
    for length in 0..file.len() {
        let message = refusal(&file[..length]);
        assert!(message.starts_with("a: ") && message.contains("the end of the file"), "{message}");
    }
    for place in 0..file.len() {
        let mut file = file.clone();
        file[place] ^= 1 << (place % 8);
        let message = refusal(&file);
        assert!(message.starts_with("a: ") && message.len() < 200, "{message}");
    }
}

#[test]
fn errors_name_the_place() {
    let file = written(&recorded(&ball(6), None));
    let message = |place: usize, bytes: &[u8]| {
        let mut file = file.clone();
        file[place..place + bytes.len()].copy_from_slice(bytes);
        refusal(&file)
    };
    for (found, expected) in [
        (
            message(0, b"ply"),
            "header: plyPM\\r\\n\\x1a: such a file begins with \\x89SLPM\\r\\n\\x1a",
        ),
        (message(8, &[2]), "version: 2: 1 is known"),
        (message(12, &[16]), "layout: 16: 0 to 15 are allowed"),
        (message(16, &[255; 4]), "vertices: 4294967295: 1 to 67108864 are allowed"),
        (message(24, &[0; 4]), "vertices of the coarsest mesh: 0: 1 to 218 are allowed"),
        (message(32, &[0, 0, 192, 127]), "error: NaN: finite numbers from 0 are allowed"),
    ] {
        assert_eq!(found, format!("a: {expected}"));
    }
    assert!(message(36, &[1]).starts_with("a: header: CRC-32: "));
    let end = file.len() - 1;
    let last = file[end];
    assert!(message(end, &[!last]).starts_with("a: block 1: CRC-32: "));
}

/// A file whose checksums are right, and whose columns `change` has changed.
fn changed(
    mesh: &ProgressiveMesh,
    mut change: impl FnMut(&mut [Column; columns::COUNT]),
) -> Vec<u8> {
    let mut mesh = mesh.clone();
    mesh.go_to(0);
    let mut file = mesh.header();
    let mut front = Front::default();
    let mut base = mesh.base_block(&mut front);
    change(&mut base);
    file.extend(block(&base).unwrap());
    while mesh.done < mesh.splits.len() {
        let mut columns = Column::all();
        for _ in 0..100.min(mesh.splits.len() - mesh.done) {
            mesh.write_split(&mut front, &mut columns);
        }
        change(&mut columns);
        file.extend(block(&columns).unwrap());
    }
    file
}

#[test]
fn files_made_to_do_harm_are_refused_or_make_sound_meshes() {
    let (mut refused, mut passed) = (0, 0);
    for (name, input, groups) in inputs() {
        let mesh = recorded(&input, groups.as_deref());
        let key = StreamKey::new(1, name, 0, 0, 0);
        assert_eq!(read(&changed(&mesh, |_| {})).unwrap(), mesh);
        for number in 0..60 {
            let mut block = 0;
            let file = changed(&mesh, |columns| {
                block += 1;
                let [which, place, kind, value] = key.words(number, block, 0);
                let bytes = &mut columns[which as usize % columns::COUNT].bytes;
                if block > 1 + number % 4 || bytes.is_empty() {
                    return;
                }
                let place = place as usize % bytes.len();
                match kind % 4 {
                    0 => bytes[place] ^= 1 << (value % 8),
                    1 => bytes[place] = value as u8,
                    2 => drop(bytes.remove(place)),
                    _ => bytes.insert(place, value as u8),
                }
            });
            let Ok(mut reader) = Reader::open("a", &file[..]) else {
                refused += 1;
                continue;
            };
            let mut is_good = true;
            for faces in [100, 20, 300, 0, usize::MAX] {
                is_good &= reader.set_faces(faces).is_ok();
                reader.mesh().mesh().0.check(name).unwrap();
            }
            let mut mesh = reader.mesh().clone();
            for faces in [50, 150, 0, usize::MAX, 77] {
                mesh.set_faces(faces);
                mesh.mesh().0.check(name).unwrap();
            }
            assert!(!is_good || read(&file).is_ok());
            *if is_good { &mut passed } else { &mut refused } += 1;
        }
    }
    assert!(refused > 50 && passed > 20, "{refused}, {passed}");
}

#[test]
fn few_bytes_do_not_stand_for_many() {
    let mut columns = Column::all();
    columns[columns::FACES].bytes.resize(1 << 20, 0);
    let honest = block(&columns).unwrap();
    assert!(honest.len() > 1 << 16, "{}", honest.len());
    let mut bomb = vec![0; 8 * columns::COUNT];
    bomb[0..4].copy_from_slice(&(1u32 << 30).to_le_bytes());
    let wrong = columns::columns(&bomb).unwrap_err();
    assert_eq!((wrong.field, wrong.value), ("uncompressed bytes", (1u32 << 30).to_string()));
}

/// Not a check: a good file becomes what `script/fuzz` begins with.
#[test]
#[ignore = "writes into fuzz/corpus"]
fn seeds_of_the_fuzzers() {
    let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/corpus/progressive");
    std::fs::create_dir_all(corpus).unwrap();
    for (name, input, groups) in inputs() {
        let file = written(&recorded(&input, groups.as_deref()));
        std::fs::write(format!("{corpus}/{name}"), file).unwrap();
    }
}
