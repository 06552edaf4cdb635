//! How surfaces scatter on a graphics device, beside the twin on the processor.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use shutterlab::gpu::device::Gpu;
use shutterlab::gpu::{buffers, shader};
use shutterlab::sampling::random::{StreamKey, unit};
use shutterlab::sampling::{RANDOM_WGSL, WARP_WGSL};
use shutterlab::shading::BSDF_WGSL;
use shutterlab::shading::bsdf::{Bsdf, Scattered};
use shutterlab_stimuli::scene::Coat;
use wgpu::BufferUsages;

/// As the shader below says; the number of cases is a multiple.
const WORKGROUP: u32 = 64;

/// A question to both devices.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Case {
    bsdf: Bsdf,
    albedo: Vec3,
    first_word: u32,
    normal: Vec3,
    second_word: u32,
    to_viewer: Vec3,
    padding: u32,
    to_light: Vec3,
    padding_2: u32,
}

/// What they answer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct Answer {
    /// BSDF × cos θ.
    value: Vec3,
    value_density: f32,
    direction: Vec3,
    drawn_density: f32,
    weight: Vec3,
    padding: u32,
}

const MAIN: &str = "
struct Case {
    bsdf: Bsdf,
    albedo: vec3f,
    first_word: u32,
    normal: vec3f,
    second_word: u32,
    to_viewer: vec3f,
    to_light: vec3f,
}

struct Answer {
    value: vec3f,
    value_density: f32,
    direction: vec3f,
    drawn_density: f32,
    weight: vec3f,
}

@group(0) @binding(0) var<storage, read> cases: array<Case>;
@group(0) @binding(1) var<storage, read_write> answers: array<Answer>;

@compute @workgroup_size(64)
fn answer(@builtin(global_invocation_id) id: vec3u) {
    let c = cases[id.x];
    let words = vec2u(c.first_word, c.second_word);
    let evaluated = bsdf_evaluate(c.bsdf, c.albedo, c.normal, c.to_viewer, c.to_light);
    let drawn = bsdf_sample(c.bsdf, c.albedo, c.normal, c.to_viewer, words);
    // Where the path ends, its direction is of no concern.
    let direction = select(vec3f(0.0), drawn.direction, drawn.density > 0.0);
    answers[id.x] = Answer(evaluated.xyz, evaluated.w, direction, drawn.density, drawn.weight);
}
";

fn on_gpu(gpu: &Gpu, cases: &[Case]) -> Vec<Answer> {
    let parts = [RANDOM_WGSL, WARP_WGSL, BSDF_WGSL, MAIN];
    let pipeline = shader::compute_pipeline(gpu, shader::join(&parts), "answer");
    let size = cases.len() * size_of::<Answer>();
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let asked = buffers::holding(gpu, "cases", BufferUsages::STORAGE, cases).unwrap();
    let answers = buffers::empty(gpu, "answers", usage, size as u64).unwrap();
    let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("answer"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: asked.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: answers.as_entire_binding() },
        ],
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.dispatch_workgroups(cases.len() as u32 / WORKGROUP, 1, 1);
    }
    gpu.queue.submit([encoder.finish()]);
    buffers::read(gpu, &answers).unwrap()
}

fn on_cpu(case: &Case) -> Answer {
    let Case { bsdf, albedo, normal, to_viewer, to_light, .. } = *case;
    let (value, value_density) = bsdf.evaluate(albedo, normal, to_viewer, to_light);
    let drawn = bsdf.sample(albedo, normal, to_viewer, [case.first_word, case.second_word]);
    let nowhere = Scattered { direction: Vec3::ZERO, density: 0.0, weight: Vec3::ZERO };
    let Scattered { direction, density: drawn_density, weight } = drawn.unwrap_or(nowhere);
    Answer { value, value_density, direction, drawn_density, weight, padding: 0 }
}

/// `count` cases, of every kind and roughness.
fn cases(count: u32) -> Vec<Case> {
    let coats = [0.02, 0.1, 0.3, 0.6, 1.0].map(|roughness| {
        [
            None,
            Some(Coat::Metal { roughness }),
            Some(Coat::Dielectric { roughness, ior: 1.5 }),
            Some(Coat::Dielectric { roughness, ior: 2.5 }),
        ]
    });
    let bsdfs: Vec<_> = coats.iter().flatten().map(|coat| Bsdf::new(coat.as_ref())).collect();
    let key = StreamKey::new(1, "bsdf", 0, 0, 0);
    let case = |i: u32| {
        let vector = |block| {
            let [a, b, c, _] = key.words(i, 0, block).map(|word| 2.0 * unit(word) - 1.0);
            Vec3::new(a, b, c).normalize()
        };
        let above = |normal: Vec3, v: Vec3| if normal.dot(v) < 0.0 { -v } else { v };
        let normal = vector(0);
        let to_viewer = above(normal, vector(1));
        let bsdf = bsdfs[i as usize % bsdfs.len()];
        let mirror = 2.0 * normal.dot(to_viewer) * normal - to_viewer;
        let is_near_mirror = i as usize / bsdfs.len() % 2 == 1;
        let about = if is_near_mirror { mirror + bsdf.alpha * vector(2) } else { vector(2) };
        let to_light = about.normalize();
        let [a, b, c, d] = key.words(i, 0, 3);
        Case {
            bsdf,
            albedo: Vec3::new(unit(c), unit(d), 0.5),
            first_word: a,
            normal,
            second_word: b,
            to_viewer,
            padding: 0,
            to_light,
            padding_2: 0,
        }
    };
    (0..count).map(case).collect()
}

/// Numbers differ by 10⁻³ of the largest, and for narrow lobes by as much as rounding turns unit vectors
/// against their width. One case in a thousand may stand apart: a first number at the border of coat and
/// base, or a direction along the surface.
#[test]
fn the_twins_scatter_alike() {
    let gpu = match Gpu::open() {
        Ok(gpu) => gpu,
        Err(error) => {
            assert!(std::env::var_os("SHUTTERLAB_REQUIRE_GPU").is_none(), "{error}");
            return;
        }
    };
    let cases = cases(WORKGROUP * 256);
    let apart: Vec<_> = cases
        .iter()
        .zip(on_gpu(&gpu, &cases))
        .filter(|(case, answer)| {
            let truth = on_cpu(case);
            let allowed = 1e-3 + 2e-6 / case.bsdf.alpha;
            let pairs = [
                (answer.value, truth.value),
                (answer.direction, truth.direction),
                (answer.weight, truth.weight),
                (Vec3::splat(answer.value_density), Vec3::splat(truth.value_density)),
                (Vec3::splat(answer.drawn_density), Vec3::splat(truth.drawn_density)),
            ];
            let agree = |(a, b): (Vec3, Vec3)| {
                (a - b).abs().max_element() <= allowed * b.abs().max_element()
            };
            !pairs.into_iter().all(agree)
        })
        .collect();
    assert!(apart.len() <= cases.len() / 1000, "{}: {:?}", apart.len(), apart[0]);
}
