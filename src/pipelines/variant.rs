//! What a shader is built for: the constants that come before its parts.

use super::FRAME_WGSL;
use super::frame::Frame;
use crate::gpu::shader;
use crate::mesh::BVH_WGSL;
use crate::sampling::{RANDOM_WGSL, SAMPLER_WGSL, WARP_WGSL};
use crate::scene::object::Object;
use crate::scene::world::World;
use crate::scene::{
    CAMERA_WGSL, ENVIRONMENT_WGSL, LIGHT_WGSL, OBJECT_WGSL, PICTURE_WGSL, SHUTTER_WGSL, WORLD_WGSL,
};
use crate::shading::bsdf::Bsdf;
use crate::shading::{BSDF_WGSL, DIRECT_WGSL, MATERIAL_WGSL, SURFACE_WGSL};

/// The parts of every shader of frames, behind the constants.
const PARTS: [&str; 16] = [
    RANDOM_WGSL,
    SAMPLER_WGSL,
    WARP_WGSL,
    BVH_WGSL,
    ENVIRONMENT_WGSL,
    SHUTTER_WGSL,
    CAMERA_WGSL,
    LIGHT_WGSL,
    PICTURE_WGSL,
    OBJECT_WGSL,
    WORLD_WGSL,
    MATERIAL_WGSL,
    BSDF_WGSL,
    SURFACE_WGSL,
    DIRECT_WGSL,
    FRAME_WGSL,
];

/// With more objects the code for each is not worth a copy.
const MAX_UNROLLED: usize = 4;

/// What is constant in a shader: numbers of things that loops over them are unrolled by, and what frames
/// never do, because branches that are never taken cost time on SIMD.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Variant {
    /// See [`FrameParams::sampler`].
    pub sampler: u32,
    /// See [`FrameParams::shutter_kind`].
    pub shutter_kind: u32,
    /// Spheres, planes and meshes.
    pub counts: [usize; 3],
    /// The kind of each object's material.
    pub kinds: Vec<u32>,
    /// Lights without extent.
    pub lights: usize,
    /// Whether any plane moves at all.
    pub planes_move: bool,
    /// Whether any plane turns.
    pub planes_turn: bool,
    /// Whether any plane does not lie level, with its sides along x and z.
    pub planes_tilt: bool,
    /// Whether the camera moves.
    pub camera_moves: bool,
    /// Whether the camera is a lens, not a pinhole.
    pub has_lens: bool,
    /// Whether any surface is not Lambertian.
    pub coats: bool,
    /// Whether any mesh has a second pose.
    pub meshes_move: bool,
    /// Whether light comes from the lights alone.
    pub is_local: bool,
}

impl Variant {
    /// The variant for `frame` in `world`.
    pub fn new(frame: &Frame, world: &World) -> Self {
        let planes = &frame.objects[world.counts[0]..][..world.counts[1]];
        Self {
            sampler: frame.params.sampler,
            shutter_kind: frame.params.shutter_kind,
            counts: world.counts,
            kinds: frame.materials.iter().map(|material| material.kind).collect(),
            lights: world.lights.len(),
            planes_move: planes.iter().any(Object::moves),
            planes_tilt: planes.iter().any(Object::is_turned),
            planes_turn: planes.iter().any(|plane| plane.turns_per_m != 0.0),
            camera_moves: frame.params.camera.moves != 0,
            has_lens: frame.params.camera.lens_radius > 0.0,
            coats: frame.bsdfs.iter().any(|bsdf| *bsdf != Bsdf::new(None)),
            is_local: frame.params.is_local != 0,
            meshes_move: world.meshes.iter().any(|of| of.mesh.end_positions.is_some()),
        }
    }

    /// The shader of frames that ends with `own` parts.
    pub fn wgsl(&self, own: &[&str]) -> String {
        let [spheres, planes, meshes] = self.counts;
        let numbers = [
            ("SAMPLER", self.sampler as usize),
            ("SHUTTER_KIND", self.shutter_kind as usize),
            ("SPHERES", spheres),
            ("PLANES", planes),
            ("MESHES", meshes),
            ("OBJECTS", self.kinds.len()),
            ("LIGHTS", self.lights),
        ];
        let truths = [
            ("PLANES_MOVE", self.planes_move),
            ("PLANES_TURN", self.planes_turn),
            ("PLANES_TILT", self.planes_tilt),
            ("CAMERA_MOVES", self.camera_moves),
            ("HAS_LENS", self.has_lens),
            ("COATS", self.coats),
            ("MESHES_MOVE", self.meshes_move),
            ("IS_LOCAL", self.is_local),
            ("MAY_END", self.coats || meshes > 0),
            ("MANY_OBJECTS", self.kinds.len() > MAX_UNROLLED),
        ];
        let kinds: Vec<String> = self.kinds.iter().map(|kind| format!("{kind}u")).collect();
        let constants = numbers
            .map(|(name, value)| format!("const {name} = {value}u;\n"))
            .into_iter()
            .chain(truths.map(|(name, value)| format!("const {name} = {value};\n")))
            .chain([format!("const KINDS = array<u32, OBJECTS>({});\n", kinds.join(", "))]);
        let most = if self.kinds.len() > MAX_UNROLLED { 0 } else { MAX_UNROLLED };
        constants.collect::<String>()
            + &shader::unroll(&shader::join(&[&PARTS, own].concat()), &numbers, most)
    }
}
