//! Shaders without a GPU: they validate, and the structs they share with Rust have the same fields at
//! the same places.

use shutterlab::gpu::shader::join;
use shutterlab::mesh::upload::MeshRange;
use shutterlab::pipelines::distribution_ray_tracing::FrameParams;
use shutterlab::pipelines::distribution_ray_tracing::compute::{EnvironmentParams, WGSL};
use shutterlab::pipelines::mesh_probe;
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
            camera_position,
            width,
            camera_forward,
            height,
            camera_right,
            focal_length_px,
            camera_up,
            sphere_radius,
            rolling_x,
            rolling_travel,
            rolling_turns,
            rolling_bounce,
            floor_albedo,
            floor_half_side,
            first_sample,
            sample_count,
            key,
            strata,
            sampler,
            shutter_kind,
            shutter_width,
            shutter_reach,
            shift_px,
            material,
        }),
        layout!(Material { light, kind, dark, frequency, octaves, contrast }),
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

fn mesh_layouts_in_rust() -> Vec<(&'static str, Layout)> {
    vec![layout!(MeshRange {
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
        padding,
    })]
}

fn module(parts: &[&str]) -> naga::Module {
    let source = join(parts);
    let module = naga::front::wgsl::parse_str(&source)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    let mut validator = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::default(),
    );
    validator.validate(&module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
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
    for (parts, layouts) in [(WGSL, layouts_in_rust()), (mesh_probe::WGSL, mesh_layouts_in_rust())]
    {
        let module = module(parts);
        for (name, (size, fields)) in layouts {
            let wgsl_name = if name == "EnvironmentParams" { "Environment" } else { name };
            let (wgsl_size, wgsl_fields) = layout_in_wgsl(&module, wgsl_name);
            assert_eq!(fields, wgsl_fields, "{name}");
            assert!(wgsl_size <= size, "{name}: {wgsl_size} bytes in WGSL, {size} in Rust");
        }
    }
}
