//! Coverage counted by hand and against rays.

use super::*;
use crate::mesh::Mesh;
use crate::mesh::bvh::Bvh;
use crate::mesh::ray::Ray;
use crate::sampling::random::{StreamKey, unit};
use crate::scene::camera::Camera;
use crate::scene::screen_motion;
use glam::{DVec3, Vec2};
use shutterlab_stimuli::stimulus::View;

/// Draws points (x·z, y·z, z) with x and y from the image's corner.
fn from_corner(raster: &Raster) -> Affine3A {
    let centre = Vec3::new(0.5 * raster.width as f32, 0.5 * raster.height as f32, -1.0);
    Affine3A::from_mat3(Mat3::from_cols(Vec3::X, Vec3::Y, -centre))
}

/// How often each pixel is covered, triangle by triangle.
fn covered(raster: &mut Raster, points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut counts = vec![0; raster.depths.len()];
    for triangle in triangles {
        raster.clear();
        raster.draw(points.iter().copied(), &[*triangle], &from_corner(raster));
        counts.iter_mut().zip(&raster.depths).for_each(|(n, d)| *n += u32::from(d.is_finite()));
    }
    counts
}

/// `count` numbers in [0, 1).
fn numbers(name: &str, count: usize) -> Vec<f32> {
    let key = StreamKey::new(1, name, 0, 0, 0);
    (0..count).map(|draw| unit(key.words(draw as u32, 0, 0)[0])).collect()
}

/// A net over 16×16 pixels whose inner points are moved, not so far that it folds: by half a pixel and a half,
/// onto the centres of pixels; by any number of halves; and anywhere.
#[test]
fn neighbours_cover_each_pixel_once() {
    const SIDE: u32 = 9;
    let moves = numbers("net", 2 * (SIDE * SIDE) as usize);
    for (round, grain) in [(0, 0.0), (1, 2.0), (2, 4096.0)] {
        let points: Vec<Vec3> = (0..SIDE * SIDE)
            .map(|k| {
                let [column, row] = [k % SIDE, k / SIDE];
                let at = |place: u32, draw: u32| {
                    let moved = 0.99 * (moves[draw as usize] - 0.5);
                    let snapped = if grain > 0.0 { (moved * grain).round() / grain } else { 0.5 };
                    let is_inner = place > 0 && place < SIDE - 1;
                    2.0 * place as f32 + if is_inner { snapped } else { 0.0 }
                };
                Vec3::new(at(column, 2 * k), at(row, 2 * k + 1), 1.0)
            })
            .collect();
        let triangles: Vec<[u32; 3]> = (0..SIDE * SIDE)
            .filter(|k| k % SIDE < SIDE - 1 && k / SIDE < SIDE - 1)
            .flat_map(|k| [[k, k + SIDE, k + 1], [k + 1, k + SIDE, k + SIDE + 1]])
            .collect();
        let mut raster = Raster::new(16, 16);
        assert!(covered(&mut raster, &points, &triangles).iter().all(|&n| n == 1), "{round}");
        // And from behind.
        let turned: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert!(covered(&mut raster, &points, &turned).iter().all(|&n| n == 1), "{round}");
    }
}

/// A fan around each of many points, thin slivers among them, that reaches out of the image.
#[test]
fn fans_cover_each_pixel_once() {
    let moves = numbers("fan", 2 * 40 + 13);
    for k in 0..40 {
        let centre = Vec3::new(10.0 * moves[2 * k], 10.0 * moves[2 * k + 1], 1.0);
        let mut angles: Vec<f32> = (0..9)
            .flat_map(|n| [n as f32 * 40.0, n as f32 * 40.0 + 40.0 * moves[80 + n] * moves[k]])
            .collect();
        angles.sort_by(f32::total_cmp);
        let rim = angles.iter().map(|degrees| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            centre + 200.0 * Vec3::new(cosine, sine, 0.0)
        });
        let points: Vec<Vec3> = std::iter::once(centre).chain(rim).collect();
        let triangles: Vec<[u32; 3]> = (0..18).map(|n| [0, 1 + n, 1 + (n + 1) % 18]).collect();
        let counts = covered(&mut Raster::new(10, 10), &points, &triangles);
        assert!(counts.iter().all(|&n| n == 1), "{k}: {counts:?}");
    }
}

/// As many pixels as its area; of those with their centre on the rim, the ones on the left and at the top.
#[test]
fn a_rectangle_has_the_pixels_within() {
    for (low, high, area) in [
        ([2.5, 1.5], [9.5, 7.5], 42),
        ([2.501, 1.5], [9.501, 7.5], 42),
        ([0.0, 0.0], [3.0, 4.0], 12),
    ] {
        let [a, b] = [low, high].map(|[x, y]: [f32; 2]| Vec3::new(x, y, 1.0));
        let points = [a, a.with_x(b.x), b, b.with_x(a.x)];
        let counts = covered(&mut Raster::new(12, 12), &points, &[[0, 1, 2], [0, 2, 3]]);
        let within = |k: usize| {
            let (x, y) = ((k % 12) as f32 + 0.5, (k / 12) as f32 + 0.5);
            u32::from((a.x..b.x).contains(&x) && (a.y..b.y).contains(&y))
        };
        assert_eq!(counts, (0..144).map(within).collect::<Vec<_>>());
        assert_eq!(counts.iter().sum::<u32>(), area);
    }
}

#[test]
fn a_point_of_a_triangle_by_hand() {
    let mut raster = Raster::new(4, 4);
    // Of the centre of pixel (1, 1): a half of the first corner on the screen, a quarter of the others. The
    // depths are 1, 2 and 4, so that the weights in space are as 1/2 to 1/8 to 1/16.
    let corner = |x: f32, y: f32, depth: f32| Vec3::new(x * depth, y * depth, depth);
    let corners = [corner(0.5, 0.5, 1.0), corner(4.5, 0.5, 2.0), corner(0.5, 4.5, 4.0)];
    let to_image = from_corner(&raster);
    raster.draw(corners, &[[0, 1, 2]], &to_image);
    let found = raster.fragments[5];
    let known = [8.0, 2.0, 1.0].map(|weight| weight / 11.0);
    assert!(found.barycentrics.iter().zip(known).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    assert!((raster.depths[5] - 16.0 / 11.0).abs() < 1e-6);
    assert_eq!(raster.depths[15], f32::INFINITY);
}

#[test]
fn the_nearest_is_seen_and_the_first_of_equals() {
    let layer =
        |z: f32| [Vec3::new(-9.0, -9.0, z), Vec3::new(99.0, -9.0, z), Vec3::new(-9.0, 99.0, z)];
    let mut raster = Raster::new(2, 2);
    let to_image = from_corner(&raster);
    let points = [layer(3.0), layer(2.0), layer(2.0), layer(4.0)].concat();
    let triangles: Vec<[u32; 3]> = (0..4).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    raster.draw(points, &triangles, &to_image);
    let triangles: Vec<u32> = raster.seen().map(|(_, _, fragment)| fragment.triangle).collect();
    assert_eq!(triangles, [1; 4]);
}

#[test]
fn what_cannot_be_drawn_is_left_out() {
    let mut raster = Raster::new(3, 3);
    let to_image = from_corner(&raster);
    let far = 1e9;
    let points = [
        Vec3::Z,
        Vec3::new(3.0, 3.0, 1.0),
        Vec3::new(1.5, 1.5, 1.0),
        Vec3::splat(f32::NAN),
        Vec3::INFINITY,
        Vec3::new(0.0, 3.0, -1.0),
        Vec3::new(3.0, 0.0, -4.0),
        Vec3::new(-far, 1.0, 1.0),
        Vec3::new(-far, 2.0, far),
    ];
    for triangle in [[0, 1, 2], [0, 0, 1], [0, 1, 9], [3, 4, 0], [3, 3, 3], [5, 6, 5], [7, 8, 7]] {
        raster.draw(points, &[triangle], &to_image);
        assert_eq!(raster.seen().count(), 0, "{triangle:?}");
    }
    // Nor does it lead astray if a corner lies 10⁹ pixels away.
    raster.draw(points, &[[1, 7, 6], [8, 1, 0]], &to_image);
    Raster::new(0, 0).draw(points, &[[0, 1, 5]], &to_image);
}

/// Triangle soup all around the camera, also behind it and through its plane, and a ball: rays through the
/// centres of pixels see the same, except where the centre lies so near an edge that snapping decides.
#[test]
fn rays_see_the_same() {
    let words = numbers("soup", 9 * 60);
    let soup = Mesh {
        positions: words
            .chunks(3)
            .map(|p| 8.0 * (Vec3::from_slice(p) - 0.5) + 2.5 * Vec3::Z)
            .collect(),
        triangles: (0..60).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        ..Mesh::default()
    };
    let turn = |k: u32, of: u32| (std::f32::consts::TAU * k as f32 / of as f32).sin_cos();
    let ball = Mesh {
        positions: (0..=40)
            .flat_map(|row| (0..80).map(move |column| (row, column)))
            .map(|(row, column)| {
                let ((sine, cosine), (east, north)) = (turn(row, 80), turn(column, 80));
                Vec3::new(sine * east, cosine, sine * north)
            })
            .collect(),
        triangles: (0..40 * 80)
            .flat_map(|k| {
                let next = k / 80 * 80 + (k + 1) % 80;
                [[k, k + 80, next], [next, k + 80, next + 80]]
            })
            .collect(),
        ..Mesh::default()
    };
    let description = screen_motion::camera(DVec3::new(0.1, 0.2, 3.0), DVec3::ZERO, [80, 60], 53.0);
    let view = View { camera: description, travel_m: [[0.0; 3]; 2], shift_px: 0.0, noise: 0 };
    let camera = Camera::new(&view, 80);
    let to_image = screen_motion::to_image(&view, 80, 0.0).as_affine3a();
    for (name, mesh) in [("soup", soup), ("ball", ball)] {
        let bvh = Bvh::new(&mesh);
        let mut raster = Raster::new(80, 60);
        raster.draw(mesh.positions.iter().copied(), &mesh.triangles, &to_image);
        let (mut seen, mut differing) = (0, 0);
        for (pixel, (&depth, fragment)) in raster.depths.iter().zip(&raster.fragments).enumerate() {
            let (x, y) = ((pixel % 80) as f32 - 39.5, (pixel / 80) as f32 - 29.5);
            let (origin, direction) = camera.ray(x, y, 0.0, Vec2::ZERO);
            let ray = Ray { origin, direction, time: 0.0, between: [0.0, f32::INFINITY] };
            let hit = bvh.nearest(&ray);
            seen += u32::from(hit.is_some());
            let known = hit.map(|hit| hit.triangle);
            if known != depth.is_finite().then_some(fragment.triangle) {
                differing += 1;
                continue;
            }
            let Some(hit) = hit else { continue };
            let along = hit.distance * direction.dot(camera.forward);
            assert!((depth / along - 1.0).abs() < 1e-2, "{name} {pixel}: {depth} {along}");
            // The point lies on the ray, within the grid of the snapping.
            let corners = mesh.corners(mesh.triangles[fragment.triangle as usize], 0.0);
            let point: Vec3 =
                corners.into_iter().zip(fragment.barycentrics).map(|(c, b)| c * b).sum();
            let image = to_image.transform_point3(point);
            let off = (image / image.z - Vec3::new(x, y, 1.0)).abs().max_element();
            assert!(off < 2e-3, "{name} {pixel}: {image} {off}");
        }
        assert!(seen > 1000 && differing <= 5, "{name}: {differing} of {seen}");
    }
}
