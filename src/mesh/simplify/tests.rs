//! What a simplifier must keep, on meshes made by hand and by formula.

use super::direction::{ScreenMotion, Seen, Weight};
use super::shapes::{edges_of, euler, grid, octahedron, sphere, torus, with_texture};
use super::*;
use crate::mesh::distance::distance;
use glam::{Mat3, Quat, Vec2, Vec3};

fn to_faces(mesh: &Mesh, faces: usize) -> Mesh {
    simplify(mesh, None, &Options { faces, ..Options::default() }).unwrap().mesh
}

fn without_loss(mesh: &Mesh) -> Mesh {
    simplify(mesh, None, &Options { error: Some(1e-4), ..Options::default() }).unwrap().mesh
}

/// Seen from above, a unit is 100 pixels; everything goes to the right.
struct ToTheRight {
    speed_px: f32,
}

impl ScreenMotion for ToTheRight {
    fn seen(&self, [place, _]: [Vec3; 2]) -> Seen {
        Seen {
            position_px: Vec2::new(place.x, -place.y) * 100.0,
            velocity_px: Vec2::X * self.speed_px,
            speed_px: self.speed_px,
            magnification: 1.0,
        }
    }
}

#[test]
fn a_flat_square_becomes_two_triangles_on_its_corners() {
    for n in 2..=6 {
        let mesh = without_loss(&grid(n, |_, _| 0.25));
        assert_eq!(mesh.triangles.len(), 2, "{n}");
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        assert_eq!(mesh.positions, corners.map(|[x, y]| Vec3::new(x, y, 0.25)));
    }
}

#[test]
fn closed_shells_end_as_tetrahedra() {
    let tetrahedron = to_faces(&octahedron(), 1);
    assert_eq!((tetrahedron.triangles.len(), tetrahedron.positions.len()), (4, 4));
    assert_eq!(to_faces(&tetrahedron, 1), tetrahedron);

    let mut two = octahedron();
    two.positions.extend(octahedron().positions.iter().map(|p| p + 5.0 * Vec3::X));
    two.triangles.extend(octahedron().triangles.iter().map(|t| t.map(|v| v + 6)));
    assert_eq!(to_faces(&two, 1).triangles.len(), 8);
    assert_eq!(to_faces(&sphere(4), 1).triangles.len(), 4);
}

#[test]
fn a_ring_keeps_its_hole() {
    // A square with a square hole: 8 vertices, 8 faces.
    let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let place = |scale: f32| square.map(|[x, y]| Vec3::new(x * scale, y * scale, 0.0));
    let ring = Mesh {
        positions: [place(3.0), place(1.0)].concat(),
        triangles: (0..4u32)
            .flat_map(|i| {
                let next = (i + 1) % 4;
                [[i, next, 4 + next], [i, 4 + next, 4 + i]]
            })
            .collect(),
        ..Mesh::default()
    };
    let coarse = to_faces(&ring, 1);
    assert_eq!(euler(&coarse), 0);
    assert_eq!(edges_of(&coarse, |count| count > 2), 0);
    // Two boundaries of three edges at least.
    assert!(edges_of(&coarse, |count| count == 1) >= 6);
}

#[test]
fn a_mobius_strip_stays_one() {
    let n = 9u32;
    let mut strip = Mesh::default();
    for i in 0..n {
        let turn = i as f32 / n as f32 * std::f32::consts::TAU;
        let across = Quat::from_rotation_z(turn) * Quat::from_rotation_y(0.5 * turn) * Vec3::X;
        let middle = Quat::from_rotation_z(turn) * (3.0 * Vec3::X);
        strip.positions.extend([middle - across, middle + across]);
        let [a, b] = [2 * i, 2 * i + 1];
        let [c, d] = if i + 1 < n { [a + 2, b + 2] } else { [1, 0] };
        strip.triangles.extend([[a, b, c], [b, d, c]]);
    }
    for faces in (1..18).rev() {
        let coarse = to_faces(&strip, faces);
        assert_eq!((euler(&coarse), edges_of(&coarse, |count| count > 2)), (0, 0));
    }
}

#[test]
fn edges_of_three_faces_stay_where_they_are() {
    // Three sheets on one edge, which is divided in four.
    let mut mesh = Mesh::default();
    for i in 0..5 {
        let along = Vec3::Z * i as f32;
        mesh.positions.push(along);
        mesh.positions.extend([Vec3::X, Vec3::Y, -Vec3::X].map(|across| along + across));
    }
    for (i, sheet) in (0..4u32).flat_map(|i| (1..4u32).map(move |sheet| (i, sheet))) {
        let [a, b] = [4 * i, 4 * i + 4];
        mesh.triangles.extend([[a, b, a + sheet], [b, b + sheet, a + sheet]]);
    }
    let coarse = to_faces(&mesh, 1);
    assert_eq!(edges_of(&coarse, |count| count == 3), 4);
    assert!(coarse.triangles.len() < mesh.triangles.len());
}

#[test]
fn what_is_asked_for_is_reached_on_bent_surfaces() {
    for mesh in [torus(40, 0.05), sphere(4), grid(40, |x, y| 0.1 * (9.0 * x).sin() * y)] {
        for faces in [2000, 501, 100, 37] {
            let count = to_faces(&mesh, faces).triangles.len();
            assert!(count == faces || count + 1 == faces, "{count} for {faces}");
        }
    }
}

#[test]
fn topology_stays_and_no_face_is_flipped() {
    let torus = torus(48, 0.05);
    let hills = grid(48, |x, y| 0.2 * (12.0 * x).sin() * (10.0 * y).cos());
    for faces in [3000, 1000, 300, 60] {
        let coarse = to_faces(&torus, faces);
        assert_eq!((euler(&coarse), edges_of(&coarse, |count| count != 2)), (0, 0));
        let coarse = to_faces(&hills, faces);
        assert_eq!((euler(&coarse), edges_of(&coarse, |count| count > 2)), (1, 0));
        for triangle in &coarse.triangles {
            let [a, b, c] = triangle.map(|vertex| coarse.positions[vertex as usize]);
            assert!((b - a).cross(c - a).z > 0.0);
        }
    }
}

#[test]
fn boundaries_are_kept() {
    let hills = grid(40, |x, y| 0.3 * (x * (1.0 - x) * y * (1.0 - y)));
    let coarse = to_faces(&hills, 100);
    let outline =
        coarse.positions.iter().filter(|p| p.x.min(1.0 - p.x).min(p.y).min(1.0 - p.y) < 1e-4);
    assert!(outline.count() >= 4);
    for corner in [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0)] {
        assert!(coarse.positions.iter().any(|p| p.distance(corner) < 1e-3));
    }
    let boundary: f32 = shapes::edges(&coarse)
        .into_iter()
        .filter(|(_, count)| *count == 1)
        .map(|([a, b], _)| {
            Vec3::from(a.map(f32::from_bits)).distance(Vec3::from(b.map(f32::from_bits)))
        })
        .sum();
    assert!((boundary - 4.0).abs() < 1e-2, "{boundary}");
}

#[test]
fn seams_and_texture_stay() {
    for n in [2, 30] {
        let mesh = with_texture(grid(n, |_, _| 0.0), 0.5);
        let coarse = without_loss(&mesh);
        // Two triangles on either side of the seam, whose ends are there twice.
        assert_eq!((coarse.triangles.len(), coarse.positions.len()), (4, 8));
    }
    let mesh = with_texture(grid(40, |x, y| 0.1 * (7.0 * x).sin() * (5.0 * y).sin()), 0.5);
    for attributes in [Attributes::Quadrics, Attributes::Averaged] {
        let options = Options { faces: 200, attributes, ..Options::default() };
        let coarse = simplify(&mesh, None, &options).unwrap().mesh;
        let texture = coarse.texture_coordinates.as_ref().unwrap();
        let mut squares = 0.0;
        for triangle in &coarse.triangles {
            let middle: f32 =
                triangle.iter().map(|&v| coarse.positions[v as usize].x).sum::<f32>() / 3.0;
            for &vertex in triangle {
                let place = coarse.positions[vertex as usize];
                let side = if middle > 0.5 { Vec2::X } else { Vec2::ZERO };
                let wrong = texture[vertex as usize] - side - Vec2::new(place.x, place.y);
                squares += wrong.length_squared();
            }
        }
        let rms = (squares / (3 * coarse.triangles.len()) as f32).sqrt();
        let most = if attributes == Attributes::Quadrics { 0.005 } else { 0.1 };
        assert!(rms < most, "{attributes:?}: {rms}");
    }
}

#[test]
fn groups_keep_their_borders() {
    let mesh = grid(20, |_, _| 0.0);
    let groups: Vec<u32> = mesh
        .triangles
        .iter()
        .map(|t| u32::from(t.iter().map(|&v| mesh.positions[v as usize].x).sum::<f32>() > 1.5))
        .collect();
    let options = Options { error: Some(1e-4), ..Options::default() };
    let coarse = simplify(&mesh, Some(&groups), &options).unwrap();
    assert_eq!(coarse.mesh.triangles.len(), 4);
    for (triangle, &face) in coarse.mesh.triangles.iter().zip(&coarse.faces) {
        let sides = triangle.map(|v| coarse.mesh.positions[v as usize].x);
        let expected = if groups[face as usize] == 1 { 0.5..=1.0 } else { 0.0..=0.5 };
        assert!(sides.iter().all(|x| expected.contains(x)), "{sides:?}");
    }
}

#[test]
fn the_threads_do_not_matter() {
    let mesh = with_texture(torus(100, 0.05), 0.1);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| to_faces(&mesh, 3000))
    };
    let one = with(1);
    assert_eq!(edges_of(&one, |count| count > 2), 0);
    assert!([2, 3, 7].into_iter().all(|threads| with(threads) == one));
}

#[test]
fn scale_turn_and_order_do_not_matter() {
    let mesh = torus(128, 0.04);
    let coarse = to_faces(&mesh, 3000);
    let map = |f: &dyn Fn(Vec3) -> Vec3| Mesh {
        positions: mesh.positions.iter().map(|&p| f(p)).collect(),
        ..mesh.clone()
    };
    for scale in [2f32.powi(-20), 0.5, 8.0, 2f32.powi(20)] {
        let scaled = to_faces(&map(&|p| p * scale), 3000);
        let back = Mesh {
            positions: scaled.positions.iter().map(|p| p / scale).collect(),
            ..scaled.clone()
        };
        assert_eq!(back, coarse, "{scale}");
    }

    let rms = |mesh: &Mesh| distance(mesh, &to_faces(mesh, 3000), 100_000).symmetric().rms;
    let expected = rms(&mesh);
    let turn = Mat3::from_quat(Quat::from_axis_angle(Vec3::new(1.0, 2.0, -1.0).normalize(), 0.7));
    let count = mesh.positions.len() as u32;
    let mut back = vec![0; count as usize];
    (0..count).for_each(|v| back[(v * 7 % count) as usize] = v);
    let renumbered = Mesh {
        positions: (0..count).map(|v| mesh.positions[(v * 7 % count) as usize]).collect(),
        triangles: mesh.triangles.iter().rev().map(|t| t.map(|v| back[v as usize])).collect(),
        ..Mesh::default()
    };
    for (other, scale) in [(map(&|p| p * 0.3), 0.3), (map(&|p| turn * p), 1.0), (renumbered, 1.0)] {
        let found = rms(&other) / scale;
        assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    }
}

#[test]
fn no_contraction_has_a_larger_error_than_is_allowed() {
    let mesh = torus(64, 0.04);
    for error in [1e-3, 3e-3, 1e-2] {
        let options = Options { error: Some(error), ..Options::default() };
        let simplified = simplify(&mesh, None, &options).unwrap();
        assert!(
            simplified.error <= error && simplified.error > 0.3 * error,
            "{} {error}",
            simplified.error
        );
        let measured = distance(&mesh, &simplified.mesh, 20_000).symmetric().rms;
        assert!(measured < 2.0 * f64::from(error), "{measured} for {error}");
    }
}

#[test]
fn without_r_all_directions_weigh_alike() {
    let mesh = torus(40, 0.05);
    let isotropic = to_faces(&mesh, 500);
    for weight in [
        Weight::Printed { r: 0.0, epsilon: 0.7 },
        Weight::Mirrored { r: 0.0, epsilon: 0.3 },
        Weight::Isotropic,
    ] {
        let motion = ToTheRight { speed_px: 30.0 };
        let options = Options { faces: 500, weight, motion: Some(&motion), ..Options::default() };
        assert_eq!(simplify(&mesh, None, &options).unwrap().mesh, isotropic);
    }
}

/// Of edges across the motion those of the printed weight go first, so that triangles get long across it; with
/// its mirror they get long along it.
#[test]
fn a_weight_makes_triangles_long_in_its_direction() {
    let mesh = grid(80, |x, y| 0.02 * ((31.0 * x).sin() * (29.0 * y).sin()));
    let shape = |weight: Weight| {
        let motion = ToTheRight { speed_px: 30.0 };
        let options = Options { faces: 1500, weight, motion: Some(&motion), ..Options::default() };
        let coarse = simplify(&mesh, None, &options).unwrap().mesh;
        let mut sums = Vec2::ZERO;
        for &[a, b, c] in &coarse.triangles {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let edge = coarse.positions[p as usize] - coarse.positions[q as usize];
                sums += Vec2::new(edge.x.abs(), edge.y.abs());
            }
        }
        sums.x / sums.y
    };
    let isotropic = shape(Weight::Isotropic);
    assert!((isotropic - 1.0).abs() < 0.2, "{isotropic}");
    let printed = shape(Weight::Printed { r: 4.0, epsilon: 0.1 });
    let mirrored = shape(Weight::Mirrored { r: 4.0, epsilon: 0.1 });
    assert!(printed < 0.9 * isotropic && mirrored > 1.1 * isotropic, "{printed} {mirrored}");
}

#[test]
fn no_triangle_is_seen_larger_than_the_limit() {
    let mesh = grid(100, |x, y| 0.02 * ((31.0 * x).sin() * (29.0 * y).sin()));
    let mut last = mesh.triangles.len() + 1;
    for speed_px in [0.5, 1.0, 2.0, 4.0] {
        let motion = ToTheRight { speed_px };
        let limit = Some(PerimeterLimit { slope: 7.3, intercept_px: 0.36 });
        let options = Options { motion: Some(&motion), limit, ..Options::default() };
        let coarse = simplify(&mesh, None, &options).unwrap().mesh;
        let original = 1.0 + 1.0 + 2f32.sqrt();
        for triangle in &coarse.triangles {
            let seen = triangle.map(|v| motion.seen([coarse.positions[v as usize]; 2]));
            let most = (7.3 * speed_px + 0.36).max(original);
            assert!(detail::perimeter_px(&seen) <= most * 1.0001);
        }
        assert!(coarse.triangles.len() < last);
        last = coarse.triangles.len();
    }
}

#[test]
fn both_keyframes_are_simplified_together() {
    let end = grid(60, |x, _| 0.2 * (12.0 * x).sin());
    let mesh = Mesh { end_positions: Some(end.positions.clone()), ..grid(60, |_, _| 0.0) };
    let coarse = to_faces(&mesh, 400);
    let at_end = Mesh {
        positions: coarse.end_positions.clone().unwrap(),
        end_positions: None,
        ..coarse.clone()
    };
    assert!(distance(&end, &at_end, 20_000).symmetric().rms < 2e-3);
    // Without the second keyframe next to nothing would be left.
    assert!(coarse.positions.iter().all(|p| p.z.abs() < 1e-4));
    assert!(coarse.triangles.len() >= 399);
}

/// What only goes up and down does not slide: each vertex is the same place of the surface in both keyframes, so that
/// what lies between them is right, too.
#[test]
fn vertices_do_not_slide_from_keyframe_to_keyframe() {
    let height = |x: f32, y: f32| 0.15 * (5.0 * x + 3.0 * y).sin();
    let end = grid(60, height);
    let mesh = Mesh { end_positions: Some(end.positions), ..grid(60, |_, _| 0.0) };
    for (faces, most) in [(1000, 0.01), (100, 0.04)] {
        let coarse = to_faces(&mesh, faces);
        let ends = coarse.end_positions.as_ref().unwrap();
        let slides = coarse.positions.iter().zip(ends).map(|(a, b)| (*b - *a).truncate().length());
        let farthest = slides.fold(0.0, f32::max);
        assert!(farthest < most, "{faces}: {farthest}");
        let halfway = |positions: &[Vec3], ends: &[Vec3]| -> Vec<Vec3> {
            positions.iter().zip(ends).map(|(a, b)| a.midpoint(*b)).collect()
        };
        let positions = halfway(&coarse.positions, ends);
        let middle = Mesh { positions, end_positions: None, ..coarse.clone() };
        let known = grid(60, |x, y| 0.5 * height(x, y));
        let error = distance(&known, &middle, 20_000).symmetric().rms;
        assert!(error < 0.6 / faces as f64, "{faces}: {error}");
    }
}

#[test]
fn rubbish_is_refused_in_words() {
    let mesh = octahedron();
    let message =
        |mesh: &Mesh, options: Options| simplify(mesh, None, &options).unwrap_err().to_string();
    let weighted =
        |r, epsilon| Options { weight: Weight::Printed { r, epsilon }, ..Options::default() };
    for (found, expected) in [
        (message(&mesh, Options { faces: 0, ..Options::default() }), "faces: 0: 1 or more"),
        (message(&mesh, weighted(-1.0, 0.5)), "r: -1: finite numbers from 0"),
        (message(&mesh, weighted(4.0, -0.5)), "epsilon: -0.5: finite numbers from 0"),
        (message(&mesh, weighted(4.0, f32::NAN)), "epsilon: NaN: finite numbers from 0"),
        (message(&mesh, weighted(0.0, 0.0)), "epsilon: 0: above 0 where r is 0"),
        (message(&mesh, weighted(4.0, 0.5)), "motion: none: a weight by direction"),
        (
            message(&mesh, Options { error: Some(f32::INFINITY), ..Options::default() }),
            "error: inf: finite numbers from 0",
        ),
        (message(&Mesh::default(), Options::default()), "mesh: vertices: 0"),
        (
            message(&Mesh { triangles: vec![[0, 0, 1]], ..mesh.clone() }, Options::default()),
            "faces: all 1 without area",
        ),
        (
            message(&Mesh { positions: vec![Vec3::NAN; 6], ..mesh.clone() }, Options::default()),
            "mesh: position of vertex 0: [NaN, NaN, NaN]",
        ),
    ] {
        assert!(found.starts_with(expected), "{found}");
    }
    let groups = simplify(&mesh, Some(&[1]), &Options::default()).unwrap_err().to_string();
    assert!(groups.starts_with("groups: 1: one for each of the 8 faces"), "{groups}");
}

#[test]
fn zero_area_and_double_faces_and_lonely_vertices_do_no_harm() {
    let mut mesh = grid(10, |x, y| 0.1 * x * y);
    let count = mesh.positions.len() as u32;
    mesh.positions.extend([Vec3::splat(9.0), mesh.positions[5]]);
    let triangles = mesh.triangles.clone();
    // Without area, doubled, doubled with another vertex at the same place, and to a needle.
    mesh.triangles.extend([[3, 3, 4], [7, 8, 7], triangles[20], [count + 1, 5, 6]]);
    mesh.triangles.push(triangles[9].map(|vertex| if vertex == 5 { count + 1 } else { vertex }));
    let coarse = to_faces(&mesh, 20);
    assert_eq!(coarse.check("mesh"), Ok(()));
    assert_eq!(edges_of(&coarse, |count| count > 2), 0);
    let one = Mesh { triangles: vec![[0, 1, 12]], ..mesh };
    assert_eq!(to_faces(&one, 1).positions.len(), 3);
    // Many more points than a cluster has, and nothing to be done.
    let mut lonely = octahedron();
    lonely.positions.extend((0..20_000).map(|k| Vec3::splat(k as f32)));
    assert_eq!(to_faces(&lonely, 1).triangles.len(), 4);
}

/// Vertices without faces, and faces that are there twice, do not make seams.
#[test]
fn what_no_face_needs_holds_nothing_fast() {
    let plain = with_texture(grid(40, |x, y| 0.1 * (4.0 * x).sin() * y), 2.0);
    let known = to_faces(&plain, 200);
    let other = |at: &Vec2| Vec2::ONE - *at;
    let mut doubled = plain.clone();
    let count = plain.positions.len() as u32;
    doubled.positions.extend(&plain.positions);
    let list = doubled.texture_coordinates.as_mut().unwrap();
    list.extend(plain.texture_coordinates.iter().flatten().map(other));
    let lonely = to_faces(&doubled, 200);
    assert_eq!(lonely, known);
    doubled.triangles.extend(plain.triangles.iter().map(|t| t.map(|vertex| vertex + count)));
    assert!(to_faces(&doubled, 200).triangles.len() <= 200);
}

/// A shell of its own does not vanish, whether it is closed or not.
#[test]
fn open_shells_stay() {
    let mut mesh = octahedron();
    for k in 0..300 {
        let first = mesh.positions.len() as u32;
        let at = Vec3::new(k as f32, 10.0, 0.0);
        mesh.positions.extend([at, at + 0.1 * Vec3::X, at + 0.1 * Vec3::Y]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    assert_eq!(to_faces(&mesh, 1).triangles.len(), 304);
}

#[test]
fn no_vertex_goes_farther_than_meshes_reach() {
    let scale = 0.99 * crate::mesh::MAX_COORDINATE;
    for times in 2..4 {
        let mut mesh = sphere(times);
        mesh.positions.iter_mut().for_each(|p| *p *= scale);
        for faces in [20, 60, 100] {
            assert_eq!(to_faces(&mesh, faces).check("mesh"), Ok(()));
        }
    }
}

/// Triangles thrown together at random, with doubles and needles among them.
#[test]
fn any_soup_of_triangles_is_survived() {
    let mut state = 1u32;
    let mut random = |below: u32| {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        ((u64::from(state >> 8) * u64::from(below)) >> 24) as u32
    };
    for round in 0..300 {
        let count = 4 + random(40);
        let cell = |n: u32| n as f32 * 0.25;
        let place = |r: &mut dyn FnMut(u32) -> u32| Vec3::new(cell(r(5)), cell(r(5)), cell(r(2)));
        let positions: Vec<Vec3> = (0..count).map(|_| place(&mut random)).collect();
        let ends = (round % 3 == 0).then(|| (0..count).map(|_| place(&mut random)).collect());
        let uv = |r: &mut dyn FnMut(u32) -> u32| Vec2::new(cell(r(2)), cell(r(2)));
        let texture = (round % 2 == 0).then(|| (0..count).map(|_| uv(&mut random)).collect());
        let faces = 1 + random(80);
        let triangles: Vec<[u32; 3]> =
            (0..faces).map(|_| [random(count), random(count), random(count)]).collect();
        let mesh = Mesh {
            positions,
            end_positions: ends,
            texture_coordinates: texture,
            triangles,
            ..Mesh::default()
        };
        let groups: Vec<u32> = (0..faces).map(|_| random(2)).collect();
        let goal = 1 + random(faces) as usize;
        let options = Options { faces: goal, ..Options::default() };
        if let Ok(coarse) = simplify(&mesh, Some(&groups), &options) {
            assert_eq!(coarse.mesh.check("coarse"), Ok(()));
            assert!(coarse.mesh.triangles.len() <= mesh.triangles.len());
            let crowded = |count: usize| count > 2;
            assert!(edges_of(&coarse.mesh, crowded) <= edges_of(&mesh, crowded));
        }
    }
}

#[test]
fn a_fan_of_many_triangles_takes_no_time() {
    let n = 200_000u32;
    let rim = |i: u32| Vec2::from_angle(i as f32 / n as f32 * std::f32::consts::TAU).extend(0.0);
    let fan = Mesh {
        positions: std::iter::once(Vec3::Z).chain((0..n).map(rim)).collect(),
        triangles: (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect(),
        ..Mesh::default()
    };
    let coarse = to_faces(&fan, 100);
    assert_eq!(edges_of(&coarse, |count| count > 2), 0);
}
