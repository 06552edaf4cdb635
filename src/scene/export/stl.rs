//! Meshes as binary STL files.

use super::put;
use crate::mesh::Mesh;
use std::io::{self, Write};

pub(super) fn write(mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
    // It must not begin with `solid`, as a text does.
    write!(out, "{:80}", concat!("binary STL by Shutterlab ", env!("CARGO_PKG_VERSION")))?;
    out.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for &triangle in &mesh.triangles {
        let corners = mesh.corners(triangle, 0.0);
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        put(out, &(b - a).cross(c - a).normalize_or_zero().as_vec3().to_array())?;
        for corner in corners {
            put(out, &corner.to_array())?;
        }
        out.write_all(&[0, 0])?;
    }
    Ok(())
}
