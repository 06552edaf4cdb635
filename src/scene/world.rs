//! All that rays can meet: the objects of a scene with their meshes, pictures and lights, and the search
//! over them.

use super::import::{self, ImportError, Model, Texture};
use super::light::Light;
use super::object::{Object, Pose};
use super::picture::{MAX_TEXELS, PictureRef, Pictures};
use super::screen_motion::ScreenPaths;
use crate::mesh::Mesh;
use crate::mesh::bvh::Bvh;
use crate::mesh::ray::{Hit, Ray};
use crate::mesh::simplify::direction::Weight;
use crate::mesh::simplify::{Options, Simplified, SimplifyError, simplify};
use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, Vec3};
use shutterlab_stimuli::scene::{Material, Motion, Shape};
use shutterlab_stimuli::{Simplification, Stimulus, assets, scene};
use std::path::Path;

/// What does not change from frame to frame. Objects come in the order spheres, planes, meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// Place in the scene's list of each object.
    order: Vec<usize>,
    /// How many objects are spheres, planes and meshes.
    pub counts: [usize; 3],
    /// The meshes of the last objects.
    pub meshes: Vec<SceneMesh>,
    /// The picture of each object's material, if it has one.
    pub object_pictures: Vec<PictureRef>,
    /// All pictures.
    pub pictures: Pictures,
    /// Lights without extent.
    pub lights: Vec<Light>,
}

/// A mesh with its hierarchy and its file's materials.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneMesh {
    /// In the object's own space.
    pub mesh: Mesh,
    /// Over the mesh.
    pub bvh: Bvh,
    /// How far it reaches from its origin, in any pose.
    pub reach: f32,
    /// Material of each triangle, by its place in `materials`.
    pub face_materials: Vec<u32>,
    /// What the file says of its faces.
    pub materials: Vec<ModelMaterial>,
}

/// A material of a model's file, as both devices read it: a colour times a picture.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ModelMaterial {
    /// Linear Rec. 709.
    pub color: Vec3,
    /// The picture; without texels it is white.
    pub picture: PictureRef,
    /// Fills up to a multiple of 16 bytes.
    pub padding: [u32; 2],
}

/// Where a ray meets something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// The object.
    pub object: usize,
    /// In lengths of the ray's direction.
    pub distance: f32,
    /// A mesh's triangle.
    pub triangle: u32,
    /// Weights of its corners.
    pub barycentrics: [f32; 3],
}

/// The objects at an instant of the shutter interval.
#[derive(Clone, Copy, Debug)]
pub struct Instant<'a> {
    /// Their world.
    pub world: &'a World,
    /// The objects during the frame.
    pub objects: &'a [Object],
    /// The part of the shutter interval that has passed, counted from its middle, in [−½, ½].
    pub shutter: f32,
}

impl World {
    /// The world of `stimulus`; files are taken from `assets`, the folder of the sequences.
    ///
    /// # Errors
    /// A file is missing, or holds no mesh or no picture that can be used.
    pub fn load(stimulus: &Stimulus, assets: &Path) -> Result<Self, ImportError> {
        let all = &stimulus.scene.objects;
        let kind = |object: &scene::Object| match object.shape {
            Shape::Sphere { .. } => 0,
            Shape::Plane { .. } => 1,
            Shape::Mesh { .. } => 2,
        };
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by_key(|&k| kind(&all[k]));
        let mut pictures = Known::default();
        let mut meshes = vec![];
        let mut object_pictures = vec![];
        for object in order.iter().map(|&k| &all[k]) {
            let material = stimulus.material_of(object);
            object_pictures.push(match material {
                Material::Image { file, sha256, .. } => {
                    pictures.get(&Texture::File(assets::path(assets, Path::new(file), sha256)))?
                }
                _ => PictureRef::default(),
            });
            let is_model = matches!(material, Material::Model { .. });
            meshes.extend(SceneMesh::load(stimulus, object, is_model, assets, &mut pictures)?);
        }
        Ok(Self {
            counts: [0, 1, 2].map(|of| all.iter().filter(|object| kind(object) == of).count()),
            order,
            meshes,
            object_pictures,
            pictures: pictures.all,
            lights: stimulus.scene.lights.iter().map(Light::new).collect(),
        })
    }

    /// The objects during frame `frame` of `stimulus`, whose world this is.
    pub fn objects(&self, stimulus: &Stimulus, frame: u32) -> Vec<Object> {
        let [spheres, planes, _] = self.counts;
        let reach =
            |k: usize| self.meshes.get(k.wrapping_sub(spheres + planes)).map_or(0.0, |of| of.reach);
        let described = self.descriptions(stimulus).enumerate();
        described.map(|(k, object)| Object::new(stimulus, object, reach(k), frame)).collect()
    }

    /// The descriptions of the objects of `stimulus`, whose world this is.
    pub fn descriptions<'a>(
        &'a self,
        stimulus: &'a Stimulus,
    ) -> impl Iterator<Item = &'a scene::Object> {
        self.order.iter().map(|&k| &stimulus.scene.objects[k])
    }
}

impl SceneMesh {
    /// The mesh of `object` of `stimulus`, if it is one. The materials of its file are taken in if `is_model`.
    fn load(
        stimulus: &Stimulus,
        object: &scene::Object,
        is_model: bool,
        assets: &Path,
        pictures: &mut Known,
    ) -> Result<Option<Self>, ImportError> {
        let Shape::Mesh { file, sha256, radius_m } = &object.shape else { return Ok(None) };
        let path = match assets::made(file) {
            Some(_) => file.into(),
            None => assets::path(assets, Path::new(file), sha256),
        };
        let Model { mut mesh, mut face_materials, materials } = import::model(&path)?;
        if let Some(Motion { deformation: Some(second), .. }) = &object.motion {
            let path = assets::path(assets, Path::new(&second.file), &second.sha256);
            mesh.end_positions = Some(import::second_pose(&path, &mesh)?);
            // The normals of one pose are not those of the other: its faces are seen flat.
            mesh.normals = None;
        }
        if let Some(radius) = radius_m {
            fit(&mut mesh, *radius as f32);
            mesh.check(&path.display().to_string())?;
        }
        if let Some(how) = &stimulus.simplification {
            let groups = (is_model && materials.len() > 1).then_some(&face_materials[..]);
            let simplified = simplified(stimulus, object, how, &mesh, groups)
                .map_err(|source| ImportError::Simplify { path: path.clone(), source })?;
            face_materials = simplified.faces.iter().map(|&f| face_materials[f as usize]).collect();
            mesh = simplified.mesh;
        }
        let materials = if is_model {
            let material = |of: &import::Material| {
                let picture =
                    of.texture.as_ref().map(|texture| pictures.get(texture)).transpose()?;
                let picture = picture.unwrap_or_default();
                let color = of.base_color.min(Vec3::ONE);
                Ok(ModelMaterial { color, picture, padding: [0; 2] })
            };
            materials.iter().map(material).collect::<Result<_, ImportError>>()?
        } else {
            face_materials.fill(0);
            vec![]
        };
        let bvh = Bvh::new(&mesh);
        let vertices = mesh.positions.iter().chain(mesh.end_positions.iter().flatten());
        // A little more, for rounding.
        let reach = 1.0001 * vertices.map(|p| p.length()).fold(0.0, f32::max);
        Ok(Some(Self { mesh, bvh, reach, face_materials, materials }))
    }
}

/// `mesh`, the shape of `object` of `stimulus`, as simple as the stimulus has it: for all of its motion.
fn simplified(
    stimulus: &Stimulus,
    object: &scene::Object,
    how: &Simplification,
    mesh: &Mesh,
    groups: Option<&[u32]>,
) -> Result<Simplified, SimplifyError> {
    let frames = 0..stimulus.image.frames;
    let motion = ScreenPaths::of_stimulus(stimulus, object, DAffine3::IDENTITY, frames);
    let Simplification { level_of_detail, r, epsilon } = *how;
    let faces = ((level_of_detail * mesh.triangles.len() as f64).round() as usize).max(1);
    let options = Options {
        faces,
        weight: Weight::Printed { r: r as f32, epsilon: epsilon as f32 },
        motion: Some(&motion),
        ..Options::default()
    };
    let simplified = simplify(mesh, groups, &options)?;
    let left = simplified.mesh.triangles.len();
    if left > faces {
        // Else it would be shown and rated as what it is not.
        let allowed = format!(
            "the surface allows no fewer than {left} of its {} faces",
            mesh.triangles.len()
        );
        return Err(SimplifyError::value("level_of_detail", level_of_detail, allowed));
    }
    Ok(simplified)
}

/// The pictures that a scene has so far: what several surfaces show is kept once.
#[derive(Default)]
struct Known {
    textures: Vec<(Texture, PictureRef)>,
    all: Pictures,
}

impl Known {
    /// Where the picture of `texture` is, which is decoded if it is new.
    fn get(&mut self, texture: &Texture) -> Result<PictureRef, ImportError> {
        if let Some((_, known)) = self.textures.iter().find(|(known, _)| known == texture) {
            return Ok(*known);
        }
        let picture = import::image::texture(texture)?;
        let texels = self.all.texels.len() + picture.texels.len();
        if texels > MAX_TEXELS {
            return Err(ImportError::Value {
                file: texture.name(),
                field: "texels of all pictures".into(),
                value: texels.to_string(),
                allowed: format!("{MAX_TEXELS} are allowed"),
            });
        }
        let new = self.all.push(&picture);
        self.textures.push((texture.clone(), new));
        Ok(new)
    }
}

/// Moves the middle of the first pose's bounding box to the origin, and scales the mesh until the
/// farthest vertex is at `radius`.
fn fit(mesh: &mut Mesh, radius: f32) {
    let (middle, scale) = fitting(mesh, radius);
    for position in mesh.positions.iter_mut().chain(mesh.end_positions.iter_mut().flatten()) {
        *position = (*position - middle) * scale;
    }
}

/// What `fit` takes from each position, and by what it multiplies the rest.
pub fn fitting(mesh: &Mesh, radius: f32) -> (Vec3, f32) {
    let (middle, farthest) = mesh.bounding_sphere();
    (middle, if farthest > 0.0 { radius / farthest } else { 1.0 })
}

impl Instant<'_> {
    /// Where `object` is.
    pub fn pose(&self, object: usize) -> Pose {
        self.objects[object].at(self.shutter)
    }

    /// The first thing that a ray meets; `from` is the sphere or plane on which it begins.
    pub fn nearest(&self, origin: Vec3, direction: Vec3, from: Option<usize>) -> Option<Met> {
        let mut nearest: Option<Met> = None;
        for object in 0..self.objects.len() {
            let far = nearest.map_or(f32::INFINITY, |met| met.distance);
            let met = self.meet(object, origin, direction, far, from == Some(object));
            nearest = met.or(nearest);
        }
        nearest
    }

    /// Whether a ray meets anything nearer than `far`.
    pub fn any(&self, origin: Vec3, direction: Vec3, far: f32, from: Option<usize>) -> bool {
        (0..self.objects.len()).any(|object| {
            let on = from == Some(object);
            match self.mesh(object) {
                Some(mesh) => self
                    .ray_of(object, origin, direction, far)
                    .is_some_and(|ray| mesh.bvh.any(&ray)),
                None => self.meet(object, origin, direction, far, on).is_some(),
            }
        })
    }

    /// The mesh of `object`, if it is one.
    pub fn mesh(&self, object: usize) -> Option<&SceneMesh> {
        let [spheres, planes, _] = self.world.counts;
        self.world.meshes.get(object.wrapping_sub(spheres + planes))
    }

    /// The ray in the space of `object`, a mesh, if it may meet it.
    fn ray_of(&self, object: usize, origin: Vec3, direction: Vec3, far: f32) -> Option<Ray> {
        let (of, pose) = (&self.objects[object], &self.pose(object));
        of.may_meet(pose.centre, origin, direction).then(|| Ray {
            origin: of.to_object(pose, origin - pose.centre),
            direction: of.to_object(pose, direction),
            time: pose.time,
            between: [0.0, far],
        })
    }

    /// Where a ray meets `object` nearer than `far`; `on` says that it begins on it.
    pub fn meet(
        &self,
        object: usize,
        origin: Vec3,
        direction: Vec3,
        far: f32,
        on: bool,
    ) -> Option<Met> {
        if let Some(mesh) = self.mesh(object) {
            let ray = self.ray_of(object, origin, direction, far)?;
            let Hit { triangle, distance, barycentrics } = mesh.bvh.nearest(&ray)?;
            return Some(Met { object, distance, triangle, barycentrics });
        }
        let (of, pose) = (&self.objects[object], &self.pose(object));
        let distance = if object < self.world.counts[0] {
            of.meet_sphere(pose.centre, origin, direction, on)
        } else if on {
            // A ray that begins on a plane does not meet it.
            None
        } else {
            of.meet_plane(pose, origin, direction)
        };
        let distance = distance.filter(|&distance| distance < far)?;
        Some(Met { object, distance, triangle: 0, barycentrics: [0.0; 3] })
    }
}
