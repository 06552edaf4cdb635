//! Simplifies a mesh with meshoptimizer: `METHOD MESH.ply FACES RUNS OUT.ply`, where METHOD is `simplify` or
//! `update` (`simplifyWithUpdate`). Prints what it cost, as all programs here do. Meshes are binary, a vertex
//! three floats, a face a byte and three indices.

#[path = "../../../../simplify/cost.rs"]
mod cost;

use meshopt::SimplifyOptions;
use std::io::{BufRead, BufReader, BufWriter, Read, Write};

type Failure = Box<dyn std::error::Error>;
type Mesh = (Vec<[f32; 3]>, Vec<u32>);

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [method, file, faces, runs, out] = &arguments[..] else {
        return Err("METHOD MESH.ply FACES RUNS OUT.ply".into());
    };
    let input = read(file)?;
    let (target, runs) = (3 * faces.parse::<usize>()?, runs.parse()?);
    let mut result = input.clone();
    let mut costs = vec![];
    for _ in 0..runs {
        let cost;
        match method.as_str() {
            "simplify" => (result.1, cost) = cost::of(|| simplify(&input, target))?,
            // It works in place, on a copy.
            "update" => {
                result.clone_from(&input);
                ((), cost) = cost::of(|| update(&mut result, target))?;
            }
            _ => return Err(format!("{method}: simplify and update are allowed").into()),
        }
        costs.push(cost);
    }
    write(out, &result)?;
    println!("{}", cost::line(&costs).ok_or("RUNS: 0")?);
    Ok(())
}

fn simplify((positions, indices): &Mesh, target: usize) -> Vec<u32> {
    let bytes = meshopt::typed_to_bytes(positions);
    let vertices = meshopt::VertexDataAdapter::new(bytes, 12, 0).expect("12 bytes to a vertex");
    meshopt::simplify(indices, &vertices, target, f32::MAX, SimplifyOptions::None, None)
}

fn update((positions, indices): &mut Mesh, target: usize) {
    let none = SimplifyOptions::None;
    let (attributes, weights) = (&mut [], &[]);
    let kept = meshopt::simplify_with_update(
        indices,
        positions,
        attributes,
        weights,
        0,
        None,
        target,
        f32::MAX,
        none,
        None,
    );
    indices.truncate(kept);
}

fn read(file: &str) -> Result<Mesh, Failure> {
    let mut reader = BufReader::new(std::fs::File::open(file)?);
    let [mut vertices, mut faces] = [0_usize; 2];
    loop {
        let mut line = String::new();
        reader.read_line(&mut line)?;
        match line.split_whitespace().collect::<Vec<_>>()[..] {
            ["element", "vertex", count] => vertices = count.parse()?,
            ["element", "face", count] => faces = count.parse()?,
            ["end_header"] => break,
            [] => return Err("no end of the header".into()),
            _ => {}
        }
    }
    let mut bytes = vec![];
    reader.read_to_end(&mut bytes)?;
    if bytes.len() != 12 * vertices + 13 * faces {
        return Err("not 12 bytes to a vertex and 13 to a face".into());
    }
    let (vertices, faces) = bytes.split_at(12 * vertices);
    let word = |bytes: &[u8], at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let position = |vertex: &[u8]| [0, 4, 8].map(|at| f32::from_le_bytes(word(vertex, at)));
    let corners = |face: &[u8]| [1, 5, 9].map(|at| u32::from_le_bytes(word(face, at)));
    Ok((
        vertices.chunks_exact(12).map(position).collect(),
        faces.chunks_exact(13).flat_map(corners).collect(),
    ))
}

fn write(file: &str, (positions, indices): &Mesh) -> Result<(), Failure> {
    let mut out = BufWriter::new(std::fs::File::create(file)?);
    let (vertices, faces) = (positions.len(), indices.len() / 3);
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\n\
         property float y\nproperty float z\nelement face {faces}\n\
         property list uchar int vertex_indices\nend_header\n"
    )?;
    for value in positions.iter().flatten() {
        out.write_all(&value.to_le_bytes())?;
    }
    for face in indices.chunks_exact(3) {
        out.write_all(&[3])?;
        for index in face {
            out.write_all(&index.to_le_bytes())?;
        }
    }
    Ok(out.flush()?)
}
