//! Any bytes as a file of a progressive mesh, with checksums that are right: what can be read of it goes from
//! level to level.
#![no_main]

use shutterlab::mesh::simplify::progressive::file::Reader;

/// The header up to the speeds, the place of their number, and the head of a block.
const HEADER: usize = 44;
const SPEEDS: usize = 40;
const HEAD: usize = 8;

fn number(bytes: &[u8], at: usize) -> usize {
    bytes[at..at + 4].iter().rev().fold(0, |number, &byte| number << 8 | usize::from(byte))
}

/// Puts right the checksum at `at` of the `bytes` in `range`, if they are there.
fn mend(bytes: &mut [u8], range: std::ops::Range<usize>, at: usize) -> Option<()> {
    let checksum = crc32fast::hash(bytes.get(range)?);
    bytes.get_mut(at..at + 4)?.copy_from_slice(&checksum.to_le_bytes());
    Some(())
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut bytes = bytes.to_vec();
    if bytes.len() > HEADER {
        let end = HEADER + 8 * number(&bytes, SPEEDS);
        mend(&mut bytes, 0..end, end);
        let mut at = end + 4;
        while bytes.len() >= at + HEAD {
            let behind = at + HEAD + number(&bytes, at);
            mend(&mut bytes, at + HEAD..behind, at + 4);
            at = behind;
        }
    }
    let Ok(mut reader) = Reader::open("a", &bytes[..]) else { return };
    let most = reader.mesh().face_counts()[0];
    for faces in [most + 10, most, 3 * most, usize::MAX] {
        drop(reader.set_faces(faces));
        reader.mesh().mesh().0.check("a").expect("a sound mesh");
    }
    let mut mesh = reader.mesh().clone();
    for faces in [2 * most, 0, usize::MAX] {
        mesh.set_faces(faces);
        mesh.mesh().0.check("a").expect("a sound mesh");
    }
});
