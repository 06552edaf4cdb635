//! Meshes as binary PLY files. Texture coordinates are called s and t, as Blender does.

use super::put;
use crate::mesh::Mesh;
use std::io::{self, Write};

pub(super) fn write(mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
    let mut properties = vec!["x", "y", "z"];
    properties.extend(mesh.normals.iter().flat_map(|_| ["nx", "ny", "nz"]));
    properties.extend(mesh.texture_coordinates.iter().flat_map(|_| ["s", "t"]));
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "element vertex {}", mesh.positions.len())?;
    for property in properties {
        writeln!(out, "property float {property}")?;
    }
    writeln!(out, "element face {}", mesh.triangles.len())?;
    writeln!(out, "property list uchar uint vertex_indices\nend_header")?;
    for (vertex, position) in mesh.positions.iter().enumerate() {
        put(out, &position.to_array())?;
        if let Some(normals) = &mesh.normals {
            put(out, &normals[vertex].to_array())?;
        }
        if let Some(coordinates) = &mesh.texture_coordinates {
            put(out, &coordinates[vertex].to_array())?;
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        out.write_all(&triangle.map(u32::to_le_bytes).concat())?;
    }
    Ok(())
}
