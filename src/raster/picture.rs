//! A model and its simplified version side by side: shaded above, with the edges of the triangles below.

use super::{Fragment, Raster};
use crate::scene::import::{ImportError, Model, image};
use crate::scene::picture::{PictureRef, Pictures};
use crate::scene::screen_motion::to_image;
use glam::{Affine3A, Vec3};
use shutterlab_stimuli::frames::{EncodedImage, LinearImage, Transfer};
use shutterlab_stimuli::letters;
use shutterlab_stimuli::stimulus::View;

/// Size of one of the four panels.
pub const PANEL_PX: [u32; 2] = [800, 600];
/// Height of the captions above them.
const CAPTION_PX: u32 = 32;
/// Samples of a pixel along each side.
const SAMPLES: u32 = 3;
/// Half of a line's width, in pixels; each of the triangles along an edge has one of the halves.
const HALF_LINE_PX: f32 = 0.3;

const BACKGROUND: Vec3 = Vec3::splat(0.8);
const INK: Vec3 = Vec3::new(0.01, 0.02, 0.08);
/// Part of a surface's reflectance that it shows where it is seen edge on; facing the camera it shows all.
const GRAZING: f32 = 0.15;

/// The picture of both models as `view` has them in an image `width_px` wide, in the colours of their materials,
/// lit from the camera. Normals are those of the models or else area-weighted; a deforming model is seen as
/// the shutter opens.
///
/// # Errors
/// A texture cannot be read.
pub fn side_by_side(
    original: &Model,
    simplified: &Model,
    view: &View,
    width_px: u32,
) -> Result<EncodedImage, ImportError> {
    let scale = (SAMPLES * PANEL_PX[0]) as f32 / width_px as f32;
    let to_image = Affine3A::from_scale(Vec3::new(scale, scale, 1.0))
        * to_image(view, width_px, 0.0).as_affine3a();
    let [width, height] = PANEL_PX.map(|side| side as usize);
    let rows = CAPTION_PX as usize + 2 * height;
    let mut pixels = vec![[1.0; 3]; 2 * width * rows];
    for (column, model) in [original, simplified].into_iter().enumerate() {
        for (row, panel) in panels(model, &to_image)?.into_iter().enumerate() {
            for (y, line) in panel.chunks(width).enumerate() {
                let start = (CAPTION_PX as usize + row * height + y) * 2 * width + column * width;
                pixels[start..start + width].copy_from_slice(line);
            }
        }
    }
    let image = LinearImage { width: 2 * PANEL_PX[0], height: rows as u32, pixels };
    let mut image = image.encode(0.0, Transfer::Srgb);
    let [before, after] = [original, simplified].map(|model| model.mesh.triangles.len());
    let part = 100.0 * after as f64 / before as f64;
    for (column, caption) in
        [format!("{before} faces"), format!("{after} faces, {part:.2} %")].iter().enumerate()
    {
        letters::write(&mut image, [column * width + 8, 8], caption, 2);
    }
    Ok(image)
}

/// `model` without and with its edges.
fn panels(model: &Model, to_image: &Affine3A) -> Result<[Vec<[f32; 3]>; 2], ImportError> {
    let mesh = &model.mesh;
    let mut raster = Raster::new(SAMPLES * PANEL_PX[0], SAMPLES * PANEL_PX[1]);
    raster.draw(mesh.positions.iter().copied(), &mesh.triangles, to_image);

    let own_normals;
    let normals = match &mesh.normals {
        Some(normals) => normals,
        None => {
            own_normals = mesh.area_weighted_normals();
            &own_normals
        }
    };
    let mut pictures = Pictures::default();
    let mut textures = vec![];
    for material in &model.materials {
        textures.push(match &material.texture {
            Some(texture) => pictures.push(&image::texture(texture)?),
            None => PictureRef::default(),
        });
    }
    // Along the view: the last row of the map.
    let forward = Vec3::from(to_image.matrix3.transpose().z_axis);
    let shaded = |fragment: &Fragment| {
        let triangle = fragment.triangle as usize;
        let corners = mesh.triangles[triangle].map(|vertex| vertex as usize);
        let weighted = || corners.into_iter().zip(fragment.barycentrics);
        let normal: Vec3 =
            weighted().map(|(vertex, b)| normals[vertex].normalize_or_zero() * b).sum();
        let [a, b, c] = mesh.corners(mesh.triangles[triangle], 0.0);
        let normal = normal.try_normalize().unwrap_or((b - a).cross(c - a).normalize_or_zero());
        let material = model.face_materials[triangle] as usize;
        let texture = match &mesh.texture_coordinates {
            Some(coordinates) => {
                let at: glam::Vec2 = weighted().map(|(vertex, b)| coordinates[vertex] * b).sum();
                pictures.color(textures[material], at.x, 1.0 - at.y)
            }
            None => Vec3::ONE,
        };
        let light = GRAZING + (1.0 - GRAZING) * normal.dot(forward).abs();
        model.materials[material].base_color * texture * light
    };
    // Distance of a point of the image from the nearest edge of its triangle, seen from the point itself so that
    // nothing is lost to rounding.
    let from_edge = |fragment: &Fragment, x: f32, y: f32| {
        let corners = mesh.corners(mesh.triangles[fragment.triangle as usize], 0.0).map(|corner| {
            let seen = to_image.transform_point3(corner);
            Vec3::new(seen.x - x * seen.z, seen.y - y * seen.z, seen.z)
        });
        let distance = |a: usize, b: usize| {
            let line = corners[a].cross(corners[b]);
            line.z.abs() / line.truncate().length()
        };
        distance(0, 1).min(distance(1, 2)).min(distance(2, 0))
    };

    let width = raster.width as usize;
    let [mut plain, mut edged] =
        [0, 1].map(|_| vec![Vec3::ZERO; (PANEL_PX[0] * PANEL_PX[1]) as usize]);
    for (sample, (depth, fragment)) in raster.depths.iter().zip(&raster.fragments).enumerate() {
        let [x, y] = [sample % width, sample / width];
        let pixel = y / SAMPLES as usize * PANEL_PX[0] as usize + x / SAMPLES as usize;
        if depth.is_infinite() {
            plain[pixel] += BACKGROUND;
            edged[pixel] += BACKGROUND;
            continue;
        }
        let color = shaded(fragment);
        plain[pixel] += color;
        let place = |at: usize, count: u32| at as f32 + 0.5 - 0.5 * count as f32;
        let distance = from_edge(fragment, place(x, raster.width), place(y, raster.height));
        let is_on_line = distance < HALF_LINE_PX * SAMPLES as f32;
        edged[pixel] += if is_on_line { INK } else { color };
    }
    let mean = |sum: &Vec3| (*sum / (SAMPLES * SAMPLES) as f32).to_array();
    Ok([plain, edged].map(|sums| sums.iter().map(mean).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::scene::import::Material;
    use crate::scene::screen_motion::camera;
    use glam::DVec3;

    /// A square of one or two triangles that fills the middle of the image.
    fn square(triangles: &[[u32; 3]]) -> Model {
        let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        Model {
            mesh: Mesh {
                positions: vec![
                    corner(-1.0, -1.0),
                    corner(1.0, -1.0),
                    corner(1.0, 1.0),
                    corner(-1.0, 1.0),
                ],
                triangles: triangles.to_vec(),
                ..Mesh::default()
            },
            face_materials: vec![0; triangles.len()],
            materials: vec![Material { base_color: Vec3::X, ..Material::default() }],
        }
    }

    #[test]
    fn four_panels_show_faces_and_edges() {
        let camera = camera(3.0 * DVec3::Z, DVec3::ZERO, [400, 300], 53.13);
        let view = View { camera, travel_m: [[0.0; 3]; 2], shift_px: 0.0, noise: 0 };
        let whole = square(&[[0, 1, 2], [0, 2, 3]]);
        let half = square(&[[0, 2, 3]]);
        let image = side_by_side(&whole, &half, &view, 400).unwrap();
        assert_eq!([image.width, image.height], [1600, 1232]);
        let pixel = |x: usize, y: usize| -> [u8; 3] {
            image.bytes[3 * ((y + 32) * 1600 + x)..][..3].try_into().unwrap()
        };
        // The square covers 400 pixels in the middle of a panel; of the half, the upper left is there.
        let (red, background) = ([255, 0, 0], pixel(0, 0));
        for y in [300, 900] {
            assert_eq!(pixel(350, y), red);
            assert_eq!(pixel(450, y), red);
            assert_eq!(pixel(1150, y - 60), red);
            assert_eq!(pixel(1250, y + 60), background);
        }
        // The diagonal is an edge below only.
        assert_eq!(pixel(400, 299), red);
        assert!(pixel(400, 899)[0] < 240, "{:?}", pixel(400, 899));
        // Something is written above both.
        for column in [0, 800] {
            let caption =
                (0..32 * 200).map(|k| image.bytes[3 * (k / 200 * 1600 + column + k % 200)]);
            assert!(caption.filter(|&code| code == 0).count() > 100);
        }
    }
}
