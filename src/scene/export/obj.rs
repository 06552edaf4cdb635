//! Models as OBJ files, with their materials in MTL files.

use super::pictures::{Picture, Pictures, ending};
use super::{ExportError, by_material, folder_of, told_materials, write as write_file};
use crate::mesh::weld::weld;
use crate::scene::import::{Material, Model};
use glam::Vec3;
use image::ImageFormat::{Hdr, Jpeg, OpenExr, Png};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};
use std::path::Path;

/// Returns what could not be written, in words.
pub(super) fn write(model: &Model, path: &Path) -> Result<Vec<String>, ExportError> {
    let pictures = Pictures::of(model, Some(folder_of(path)), &[Png, Jpeg, Hdr, OpenExr]);
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut files = vec![];
    let mut number = 0;
    for picture in &pictures.all {
        files.push(match picture {
            Picture::Named(name) => name.clone(),
            // Other files stay as they are; the same picture is there already.
            Picture::Bytes(bytes, format) => loop {
                number += 1;
                let name = format!("{stem}-{number}.{}", ending(*format));
                let file = path.with_file_name(&name);
                if file.symlink_metadata().is_err() {
                    write_file(&file, |out| out.write_all(bytes))?;
                    break name;
                }
                if std::fs::read(&file).is_ok_and(|found| found[..] == bytes[..]) {
                    break name;
                }
            },
        });
    }
    let names = material_names(told_materials(model));
    let library = path.with_extension("mtl");
    if !names.is_empty() {
        write_file(&library, |out| {
            for (place, name) in &names {
                let [r, g, b] = model.materials[*place].base_color.to_array();
                writeln!(out, "newmtl {name}\nKd {r} {g} {b}")?;
                if let Some(picture) = pictures.of_material[*place] {
                    writeln!(out, "map_Kd {}", files[picture])?;
                }
            }
            Ok(())
        })?;
    }
    write_file(path, |out| {
        if let (false, Some(library)) = (names.is_empty(), library.file_name()) {
            writeln!(out, "mtllib {}", library.to_string_lossy())?;
        }
        write_mesh(model, &names, out)
    })?;
    Ok(pictures.left_out)
}

fn write_mesh(
    model: &Model,
    names: &BTreeMap<usize, String>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mesh = &model.mesh;
    // Vertices on the two sides of a seam are one `v`, and differ by their `vt` or `vn`.
    let (positions, places) = match (&mesh.texture_coordinates, &mesh.normals) {
        (None, None) => (mesh.positions.clone(), (0..mesh.positions.len() as u32).collect()),
        _ => weld(&mesh.positions),
    };
    for Vec3 { x, y, z } in positions {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for at in mesh.texture_coordinates.iter().flatten() {
        writeln!(out, "vt {} {}", at.x, at.y)?;
    }
    for Vec3 { x, y, z } in mesh.normals.iter().flatten() {
        writeln!(out, "vn {x} {y} {z}")?;
    }
    for (material, triangles) in by_material(model) {
        if let Some(name) = names.get(&material) {
            writeln!(out, "usemtl {name}")?;
        }
        for triangle in triangles {
            write!(out, "f")?;
            for vertex in triangle {
                let (place, own) = (places[vertex as usize] + 1, vertex + 1);
                match (&mesh.texture_coordinates, &mesh.normals) {
                    (None, None) => write!(out, " {place}")?,
                    (Some(_), None) => write!(out, " {place}/{own}")?,
                    (None, Some(_)) => write!(out, " {place}//{own}")?,
                    (Some(_), Some(_)) => write!(out, " {place}/{own}/{own}")?,
                }
            }
            writeln!(out)?;
        }
    }
    Ok(())
}

/// A name of its own for each material, which a line can end with.
fn material_names<'a>(
    materials: impl Iterator<Item = (usize, &'a Material)>,
) -> BTreeMap<usize, String> {
    let mut used = BTreeSet::new();
    // The last number behind each name.
    let mut numbers: BTreeMap<String, u32> = BTreeMap::new();
    materials
        .map(|(place, material)| {
            let plain = material.name.replace(char::is_control, " ");
            let plain = if plain.trim().is_empty() { "material" } else { plain.trim() };
            let mut name = plain.to_string();
            while !used.insert(name.clone()) {
                let number = numbers.entry(plain.to_string()).or_insert(1);
                *number += 1;
                name = format!("{plain}-{number}");
            }
            (place, name)
        })
        .collect()
}
