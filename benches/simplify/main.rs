//! What simplifying a mesh costs and how far the result is from it: our part of `script/bench peers simplifiers`.
//!
//! ```text
//! cargo bench --bench simplify -- simplify THREADS MESH FACES RUNS OUT.ply
//! cargo bench --bench simplify -- plain MESH OUT.ply
//! cargo bench --bench simplify -- measure MESH FILE…
//! cargo bench --bench simplify -- table1 MESH…
//! cargo bench --bench simplify -- law BUNNY
//! ```
//! The first prints the median seconds on the clock and of the processor, the megabytes that were resident before
//! and those above them, as all programs in `benches/peers/simplifiers` do. `plain` leaves nothing but positions
//! and triangles. `measure` prints for each FILE its name, its faces and the root of the mean squared distance,
//! the mean and the largest, in both directions together and relative to the diagonal of the box around MESH.
//! `table1` and `law` put Table 1 of Zhang et al. 2014 beside ours; meshes are bunny.ply, igea.ply, dragon.ply and
//! large.ply, the dragon subdivided once.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

mod cost;
mod table1;

use shutterlab::mesh::Mesh;
use shutterlab::mesh::distance::distance;
use shutterlab::mesh::simplify::{Options, simplify};
use shutterlab::scene::export;
use shutterlab::scene::import::{self, Material, Model};
use std::path::Path;

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Points of each mesh, besides its vertices.
const SAMPLES: usize = 1_000_000;

fn main() -> Result<(), Failure> {
    // cargo says --bench.
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["simplify", threads, mesh, faces, runs, out] => {
            let (faces, runs) = (faces.parse()?, runs.parse()?);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.parse()?).build()?;
            pool.install(|| cost(&read(mesh)?, faces, runs, out))
        }
        ["plain", mesh, out] => write(read(mesh)?, out),
        ["measure", mesh, ref files @ ..] => measure(&read(mesh)?, files),
        ["table1", ref files @ ..] => table1::times(files),
        ["law", bunny] => table1::law(bunny),
        _ => Err("simplify, plain, measure, table1 or law, and what they need".into()),
    }
}

fn cost(mesh: &Mesh, faces: usize, runs: usize, out: &str) -> Result<(), Failure> {
    let options = Options { faces, ..Options::default() };
    let mut costs = vec![];
    let mut simplified = Mesh::default();
    for _ in 0..runs {
        drop(std::mem::take(&mut simplified));
        let (result, cost) = cost::of(|| simplify(mesh, None, &options))?;
        simplified = result?.mesh;
        costs.push(cost);
    }
    println!("{}", cost::line(&costs).ok_or("RUNS: 0: 1 or more are needed")?);
    write(simplified, out)
}

fn measure(mesh: &Mesh, files: &[&str]) -> Result<(), Failure> {
    println!("file,faces,rms,mean,hausdorff");
    for file in files {
        let simplified = read(file)?;
        let measured = distance(mesh, &simplified, SAMPLES);
        let error = measured.symmetric().over(measured.diagonal);
        let name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
        let faces = simplified.triangles.len();
        println!("{name},{faces},{:.4e},{:.4e},{:.4e}", error.rms, error.mean, error.max);
    }
    Ok(())
}

fn read(file: &str) -> Result<Mesh, Failure> {
    let Mesh { positions, triangles, .. } = import::model(Path::new(file))?.mesh;
    Ok(Mesh { positions, triangles, ..Mesh::default() })
}

fn write(mesh: Mesh, file: &str) -> Result<(), Failure> {
    let face_materials = vec![0; mesh.triangles.len()];
    let model = Model { mesh, face_materials, materials: vec![Material::default()] };
    export::model(&model, Path::new(file))?;
    Ok(())
}
