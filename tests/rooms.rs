//! Which room may import from which, read from the sources themselves.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The rooms of the root package and how far to the right each stands. A room imports only from rooms
/// further to the left; rooms of one number do not know each other.
const ROOMS: &[(&str, u32)] = &[
    ("gpu", 0),
    ("sampling", 0),
    ("mesh", 1),
    ("scene", 2),
    ("shading", 3),
    ("film", 3),
    ("raster", 4),
    ("pipelines", 5),
    ("postprocess", 5),
    ("render", 6),
    ("cli", 7),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The source files below `folder` that end in one of `endings`, with their text.
fn sources(folder: &str, endings: &[&str]) -> BTreeMap<PathBuf, String> {
    let mut files = BTreeMap::new();
    let mut folders = vec![root().join(folder)];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if endings.iter().any(|ending| path.extension().is_some_and(|e| e == *ending)) {
                files.insert(
                    path.strip_prefix(root()).unwrap().into(),
                    std::fs::read_to_string(&path).unwrap(),
                );
            }
        }
    }
    files
}

/// The rooms that `text` names after `crate::`, braces included.
fn imported(text: &str) -> Vec<String> {
    let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code = code.collect::<Vec<_>>().join("\n");
    let mut rooms = vec![];
    for (at, found) in code.match_indices("crate::") {
        let rest = &code[at + found.len()..];
        let names = match rest.strip_prefix('{') {
            Some(list) => list[..list.find('}').unwrap()].split(',').map(str::trim).collect(),
            None => vec![rest],
        };
        let first = |name: &str| {
            name.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap().to_string()
        };
        rooms.extend(names.into_iter().map(first).filter(|name| !name.is_empty()));
    }
    rooms
}

/// The room of a source file: the folder or file directly below `src`.
fn room(path: &Path) -> String {
    let name = path.components().nth(1).unwrap().as_os_str().to_string_lossy();
    name.trim_end_matches(".rs").to_string()
}

fn place(room: &str) -> Option<u32> {
    ROOMS.iter().find(|(name, _)| *name == room).map(|(_, place)| *place)
}

#[test]
fn rooms_import_only_from_rooms_to_their_left() {
    let mut wrong = vec![];
    for (path, text) in sources("src", &["rs"]) {
        let here = room(&path);
        if ["lib", "main"].contains(&here.as_str()) {
            continue;
        }
        let here_place =
            place(&here).unwrap_or_else(|| panic!("{}: no room of the house", path.display()));
        for there in imported(&text) {
            let there_place =
                place(&there).unwrap_or_else(|| panic!("{}: crate::{there}", path.display()));
            if there != here && there_place >= here_place {
                wrong.push(format!("{}: {here} imports {there}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn pipelines_never_import_one_another() {
    let files = sources("src/pipelines", &["rs"]);
    let pipeline = |path: &Path| {
        path.components().nth(2).map(|c| c.as_os_str().to_string_lossy().into_owned())
    };
    let names: Vec<String> = files
        .keys()
        .filter_map(|path| pipeline(path))
        .filter(|name| !name.ends_with(".rs"))
        .collect();
    for (path, text) in &files {
        let own = pipeline(path).unwrap();
        // What knows all of them.
        if ["mod.rs", "tests"].contains(&own.as_str()) {
            continue;
        }
        for other in names.iter().filter(|name| **name != own) {
            assert!(!text.contains(&format!("pipelines::{other}")), "{}: {other}", path.display());
        }
    }
}

/// The four light packages know no renderer, and each other only as the arrows say.
#[test]
fn packages_depend_only_along_the_arrows() {
    let allowed: [(&str, &[&str]); 4] = [
        ("data-schema", &[]),
        ("stimuli", &["data-schema"]),
        ("analysis", &["data-schema"]),
        ("experiments", &["data-schema", "stimuli"]),
    ];
    for (package, arrows) in allowed {
        let manifest = std::fs::read_to_string(root().join(package).join("Cargo.toml")).unwrap();
        for line in manifest.lines().skip_while(|line| *line != "[dependencies]") {
            if let Some(rest) = line.strip_prefix("shutterlab-") {
                let name = rest.split(['.', ' ', '=']).next().unwrap();
                assert!(arrows.contains(&name), "{package} depends on {name}");
            }
            assert!(
                !line.starts_with("shutterlab.") && !line.starts_with("shutterlab "),
                "{package} depends on the root"
            );
        }
    }
}

#[test]
fn features_are_switched_at_the_doors() {
    let doors = [
        "src/lib.rs",
        "src/pipelines/",
        "src/cli/",
        "experiments/src/lib.rs",
        "stimuli/src/lib.rs",
        "experiments/src/run.rs",
    ];
    for folder in ["src", "stimuli/src", "experiments/src", "analysis/src", "data-schema/src"] {
        for (path, text) in sources(folder, &["rs"]) {
            let name = path.to_string_lossy().replace('\\', "/");
            let is_door = doors.iter().any(|door| name.starts_with(door));
            assert!(is_door || !text.contains("cfg(feature"), "{name} switches a feature");
        }
    }
}

/// A file says in its first line what it is.
#[test]
fn files_say_what_they_are() {
    for folder in [
        "src",
        "stimuli/src",
        "experiments/src",
        "analysis/src",
        "data-schema/src",
        "tests",
        "benches",
    ] {
        for (path, text) in sources(folder, &["rs", "wgsl"]) {
            let first = text.lines().next().unwrap_or_default();
            assert!(first.starts_with("//"), "{}: {first}", path.display());
        }
    }
}

/// The check itself sees what it is meant to see.
#[test]
fn imports_are_found() {
    let text = "use crate::film::Film;\nuse crate::{gpu::device, scene};\n// crate::cli\nlet x = crate::render::y;";
    assert_eq!(imported(text), ["film", "gpu", "scene", "render"]);
}
