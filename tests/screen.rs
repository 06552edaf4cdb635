//! `screen`: every pair once, the same numbers again, and nothing lost when it is stopped.

use crate::support::{fail, succeed};

#[test]
fn pairs_are_compared_once_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    // Not smaller: FLIP wants a few pixels to the degree.
    let words = "render demo -o s --size 96x54 --device cpu --frames 11..13 --select samples=A3";
    succeed(folder.path(), &words.split(' ').collect::<Vec<_>>());
    let words = ["screen", "s", "--select", "shutter=T3", "--select", "shutter=1,samples=256"];
    succeed(folder.path(), &words);
    let file = folder.path().join("s/screen.csv");
    let first = std::fs::read_to_string(&file).unwrap();
    let lines: Vec<&str> = first.lines().collect();
    let columns = "reference,test,reference_sha256,test_sha256,cvvdp_jod,flip_mean,psnr_db";
    assert_eq!((lines.len(), lines[0]), (2, columns));
    assert!(lines[1].starts_with("M2-S2-T3-A3,M2-S2-T5-A3,"), "{first}");

    // More pairs are added to those that are known, which are not compared again.
    let known = lines[1].rsplit_once(',').unwrap().0;
    std::fs::write(&file, format!("{columns}\n{known},12.25\n")).unwrap();
    succeed(folder.path(), &["screen", "s", "--select", "samples=A3"]);
    let more = std::fs::read_to_string(&file).unwrap();
    assert!(more.lines().count() == 4 && more.contains(",12.25\n"), "{more}");
    succeed(folder.path(), &words);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), more);
    succeed(folder.path(), &["screen", "s"]);
    let figure = std::fs::read_to_string(folder.path().join("s/screen.svg")).unwrap();
    // Either half of the matrix.
    assert_eq!(figure.matches("<rect x=").count(), 6);

    let error = fail(folder.path(), 1, &["screen", "s", "--select", "shutter=1"]);
    assert!(error.contains("1 sequence found: at least two are needed"), "{error}");
    let error = fail(folder.path(), 2, &["screen", "s", "--select", "samples=A9"]);
    assert!(error.contains("samples=A9: the levels of samples are A3"), "{error}");
    let error = fail(folder.path(), 2, &["screen", "s", "--select", "samples"]);
    assert!(error.contains("AXIS=LEVEL is needed"), "{error}");
    std::fs::write(&file, "reference,test\na,b\n").unwrap();
    let error = fail(folder.path(), 1, &words);
    assert!(error.contains("screen.csv: cannot be read"), "{error}");
}
