//! Shaders without a GPU: they validate, and the structs they share with Rust have the same fields at
//! the same places.

use shutterlab::mesh::upload::MeshRange;
use shutterlab::pipelines::accumulation_buffer::drawing::Place;
use shutterlab::pipelines::accumulation_buffer::{Image, drawing, render};
use shutterlab::pipelines::distribution_ray_tracing::compute::TRACE_WGSL;
use shutterlab::pipelines::frame::FrameParams;
use shutterlab::pipelines::mesh_probe;
use shutterlab::pipelines::resources::EnvironmentParams;
use shutterlab::pipelines::stochastic_rasterization::bins::{Band, Segment};
use shutterlab::pipelines::stochastic_rasterization::{bins, compute};
use shutterlab::pipelines::variant::Variant;
use shutterlab::pipelines::visibility;
use shutterlab::scene::camera::Camera;
use shutterlab::scene::light::Light;
use shutterlab::scene::object::Object;
use shutterlab::scene::picture::PictureRef;
use shutterlab::shading::bsdf::Bsdf;
use shutterlab::shading::material::Material;
use std::collections::BTreeMap;

type Layout = (usize, BTreeMap<String, usize>);

/// Size of a Rust struct and the offset of each field, but for those that only pad.
macro_rules! layout {
    ($type:ident { $($field:ident),* $(,)? }) => {{
        let fields = [$((stringify!($field).to_string(), std::mem::offset_of!($type, $field))),*];
        (stringify!($type), (size_of::<$type>(), BTreeMap::from(fields)))
    }};
}

fn layouts_in_rust() -> Vec<(&'static str, Layout)> {
    vec![
        layout!(FrameParams {
            camera,
            width,
            height,
            first_sample,
            sample_count,
            key,
            strata,
            sampler,
            shutter_kind,
            shutter_width,
            shutter_reach,
            is_local,
            first_pixel,
        }),
        layout!(Camera {
            position,
            focal_length_px,
            forward,
            shift_px,
            right,
            moves,
            up,
            look_at_distance,
            travel,
            lens_radius,
            look_at_travel,
            focus_distance,
        }),
        layout!(Object {
            to_axis,
            from_axis,
            position,
            size,
            direction,
            distance,
            travel,
            bounce,
            turns,
            turns_per_m,
            pose,
            poses_per_m,
        }),
        layout!(Material { light, kind, dark, frequency, octaves, contrast, picture }),
        layout!(PictureRef { first, width, height }),
        layout!(Bsdf { kind, alpha, eta, internal }),
        layout!(Light { place, is_point, color }),
        layout!(MeshRange {
            min,
            nodes,
            max,
            end_nodes,
            leaves,
            end_leaves,
            faces,
            vertices,
            end_vertices,
            normals,
            texture_coordinates,
            materials,
        }),
        layout!(EnvironmentParams {
            width,
            height,
            exponent_base,
            part_bits,
            inverse_flux,
            part_scale,
        }),
    ]
}

/// Scenes of few things, written out, and of many, in loops; with all that there is, and with little.
fn variants() -> [Variant; 3] {
    let many = Variant {
        sampler: 2,
        shutter_kind: 2,
        counts: [2, 1, 2],
        kinds: vec![0, 1, 2, 3, 4],
        lights: 3,
        planes_move: true,
        planes_turn: true,
        planes_tilt: true,
        camera_moves: true,
        has_lens: true,
        coats: true,
        meshes_move: true,
        is_local: false,
    };
    let few = Variant {
        counts: [1, 0, 0],
        kinds: vec![0],
        lights: 0,
        planes_move: false,
        planes_turn: false,
        planes_tilt: false,
        camera_moves: false,
        has_lens: false,
        coats: false,
        meshes_move: false,
        ..many.clone()
    };
    let moving =
        Variant { counts: [1, 1, 1], kinds: vec![3, 1, 4], is_local: true, ..many.clone() };
    [many, few, moving]
}

fn module(source: &str) -> naga::Module {
    let module = naga::front::wgsl::parse_str(source)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    let mut validator = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::default(),
    );
    validator.validate(&module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    module
}

fn layout_in_wgsl(module: &naga::Module, name: &str) -> Layout {
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    match &found.unwrap_or_else(|| panic!("no struct {name}")).1.inner {
        naga::TypeInner::Struct { members, span } => {
            let field = |m: &naga::StructMember| (m.name.clone().unwrap(), m.offset as usize);
            (*span as usize, members.iter().map(field).collect())
        }
        other => panic!("{name} is {other:?}"),
    }
}

#[test]
fn structs_are_laid_out_alike() {
    module(&mesh_probe::wgsl(true, false));
    for variant in variants() {
        let module = module(&variant.wgsl(&[TRACE_WGSL]));
        for (name, layout) in layouts_in_rust() {
            let wgsl_name = if name == "EnvironmentParams" { "Environment" } else { name };
            assert_alike(&module, wgsl_name, &layout);
        }
    }
}

#[test]
fn structs_of_rasterizers_are_laid_out_alike() {
    let (_, place) = layout!(Place { to_clip, object, faces, vertices, end_vertices, time });
    assert_alike(&module(&drawing::wgsl()), "Place", &place);
    let (_, segment) = layout!(Segment {
        to_image,
        to_image_at_end,
        poses,
        before,
        count,
        object,
        triangles,
        faces,
        vertices,
        end_vertices,
        first_group,
    });
    let (_, band) = layout!(Band {
        columns,
        first_column,
        first_row,
        end_row,
        fills,
        nearest,
        layers_per_m,
        blur_px,
        inverse_focus
    });
    let binning = module(&bins::wgsl());
    assert_alike(&binning, "Segment", &segment);
    assert_alike(&binning, "Band", &band);
    let (_, image) = layout!(Image { in_pixel, lens, shutter, word });
    for variant in variants() {
        let local = Variant { is_local: true, ..variant };
        assert_alike(&module(&visibility::wgsl(&local, &render::samples_wgsl())), "Sample", &image);
        module(&visibility::wgsl(&local, compute::SAMPLES_WGSL));
        module(&compute::wgsl(&local));
    }
}

fn assert_alike(module: &naga::Module, name: &str, (size, fields): &Layout) {
    let (wgsl_size, wgsl_fields) = layout_in_wgsl(module, name);
    assert_eq!(*fields, wgsl_fields, "{name}");
    assert!(wgsl_size <= *size, "{name}: {wgsl_size} bytes in WGSL, {size} in Rust");
}
