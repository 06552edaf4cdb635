//! Properties of progressive meshes: every level is what it is whatever was before, the finest is the input.

use super::*;
use crate::mesh::distance::distance;
use crate::mesh::simplify::detail::{PerimeterLimit, perimeter_px};
use crate::mesh::simplify::direction::{ScreenMotion, Seen, Weight};
use crate::mesh::simplify::simplify;
use crate::sampling::random::StreamKey;
use std::collections::HashMap;

/// `n` by `n` squares, in two triangles each, at the places that `place` gives for each point of the unit square.
fn grid(n: u32, place: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let m = n + 1;
    let at = |i: u32| i as f32 / n as f32;
    let squares = (0..n * n).map(|i| i % n + m * (i / n));
    Mesh {
        positions: (0..m * m).map(|i| place(at(i % m), at(i / m))).collect(),
        triangles: squares.flat_map(|i| [[i, i + 1, i + m + 1], [i, i + m + 1, i + m]]).collect(),
        ..Mesh::default()
    }
}

fn hills(x: f32, y: f32) -> Vec3 {
    Vec3::new(x, y, 0.05 * (9.0 * x).sin() * (7.0 * y).cos())
}

/// A bumpy ball of 6 `n`² squares: a cube blown up, without seams.
pub fn ball(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for side in 0..6 {
        let face = grid(n, |x, y| {
            // Odd sides are the even ones turned about the diagonal, so that all look outwards.
            let (u, v) = (2.0 * x - 1.0, 2.0 * y - 1.0);
            let mut p = if side % 2 == 0 { [u, v, 1.0] } else { [v, u, -1.0] };
            p.rotate_left(side / 2);
            Vec3::from(p)
        });
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(face.positions);
        mesh.triangles.extend(face.triangles.iter().map(|t| t.map(|vertex| vertex + first)));
    }
    // Places of the cube are exact: equal ones are one vertex.
    let mut known = HashMap::new();
    let mut positions = vec![];
    for vertex in mesh.triangles.as_flattened_mut() {
        let place = mesh.positions[*vertex as usize];
        *vertex =
            *known.entry((place + Vec3::ZERO).to_array().map(f32::to_bits)).or_insert_with(|| {
                let d = place.normalize();
                positions
                    .push(d * (1.0 + 0.05 * (9.0 * d.x).sin() * (8.0 * d.y + 2.0 * d.z).cos()));
                positions.len() as u32 - 1
            });
    }
    Mesh { positions, ..mesh }
}

/// A tube along y, open at both ends, with a seam of the texture.
fn tube(n: u32) -> Mesh {
    let flat = grid(n, |x, y| Vec3::new(x, y, 0.0));
    let texture = flat.positions.iter().map(|p| p.truncate()).collect();
    let round = |p: &Vec3| {
        // The last column is where the first is.
        let (sin, cos) = (p.x % 1.0 * std::f32::consts::TAU).sin_cos();
        Vec3::new(cos, 3.0 * p.y, -sin) * (1.0 + 0.1 * (6.0 * p.y).sin())
    };
    let positions: Vec<Vec3> = flat.positions.iter().map(round).collect();
    let normals = positions.iter().map(|p| Vec3::new(p.x, 0.0, p.z).normalize()).collect();
    Mesh { positions, normals: Some(normals), texture_coordinates: Some(texture), ..flat }
}

/// A ball with a second pose.
fn bending() -> Mesh {
    let ball = ball(8);
    let bent = |p: &Vec3| Vec3::new(p.x + p.y * p.y, p.y, p.z * 1.5);
    Mesh { end_positions: Some(ball.positions.iter().map(bent).collect()), ..ball }
}

/// Faces that share no vertices, some twice, some without area, a vertex of no face, and a negative zero.
fn rubble() -> Mesh {
    let grid = grid(12, hills);
    let mut positions = vec![Vec3::new(-0.0, 5.0, 5.0)];
    let mut triangles = vec![];
    for triangle in &grid.triangles {
        let first = positions.len() as u32;
        positions.extend(triangle.map(|vertex| grid.positions[vertex as usize]));
        triangles.push([first, first + 1, first + 2]);
    }
    triangles.insert(7, triangles[40]);
    triangles.insert(90, triangles[7]);
    triangles.extend([[5, 5, 9], [3, 3, 3], [1, 2, 900]]);
    positions.push(Vec3::ONE);
    for vertex in triangles.as_flattened_mut() {
        *vertex = (*vertex).min(positions.len() as u32 - 2);
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Meshes with their groups.
pub fn inputs() -> Vec<(&'static str, Mesh, Option<Vec<u32>>)> {
    let hilly = grid(20, hills);
    let groups = hilly.triangles.iter().map(|t| u32::from(t[0] % 21 > 9)).collect();
    vec![
        ("ball", ball(10), None),
        ("hills", hilly.clone(), None),
        ("two materials", hilly, Some(groups)),
        ("tube", tube(20), None),
        ("bending", bending(), None),
        ("rubble", rubble(), None),
    ]
}

pub fn recorded(mesh: &Mesh, groups: Option<&[u32]>) -> ProgressiveMesh {
    record(mesh, groups, &Options::default(), &[]).unwrap()
}

/// All numbers of a mesh, bit for bit.
pub fn bits(mesh: &Mesh) -> Vec<u32> {
    let vectors = [&Some(mesh.positions.clone()), &mesh.end_positions, &mesh.normals];
    let vectors = vectors.into_iter().flatten().flatten().flat_map(|v| v.to_array());
    let texture = mesh.texture_coordinates.iter().flatten().flat_map(|v| v.to_array());
    let triangles = mesh.triangles.as_flattened().iter().copied();
    vectors.chain(texture).map(f32::to_bits).chain(triangles).collect()
}

#[test]
fn the_finest_level_is_the_input() {
    for (name, input, groups) in inputs() {
        let mut progressive = recorded(&input, groups.as_deref());
        let [coarsest, finest] = progressive.face_counts();
        assert_eq!((progressive.face_count(), finest), (coarsest, input.triangles.len()), "{name}");
        assert!(coarsest < finest / 3, "{name}: {coarsest}");
        assert!(progressive.error() > 0.0);
        progressive.set_faces(usize::MAX);
        let (mesh, faces) = progressive.mesh();
        assert_eq!((bits(&mesh), progressive.error()), (bits(&input), 0.0), "{name}");
        assert!(faces.into_iter().eq(0..finest as u32));
    }
}

#[test]
fn a_level_does_not_depend_on_the_way_there() {
    for (name, input, groups) in inputs() {
        let start = recorded(&input, groups.as_deref());
        let mut walked = start.clone();
        let key = StreamKey::new(1, name, 0, 0, 0);
        for step in 0..25 {
            let mut direct = start.clone();
            let [kind, number, ..] = key.words(step, 0, 0);
            for mesh in [&mut walked, &mut direct] {
                match kind % 3 {
                    0 => mesh.set_error(start.error() * (number as f32 / u32::MAX as f32).powi(4)),
                    _ => mesh.set_faces(number as usize % (input.triangles.len() + 20)),
                }
            }
            assert_eq!(walked.mesh(), direct.mesh(), "{name}, step {step}");
        }
        walked.set_faces(0);
        assert_eq!(walked, start);
    }
}

/// The edges, by their places, that more than two triangles have.
fn crowded_edges(mesh: &Mesh) -> usize {
    let mut edges: HashMap<_, u32> = HashMap::new();
    for triangle in &mesh.triangles {
        let places = triangle.map(|v| (mesh.positions[v as usize] + Vec3::ZERO).to_array());
        let places = places.map(|place| place.map(f32::to_bits));
        for side in 0..3 {
            let (a, b) = (places[side], places[(side + 1) % 3]);
            *edges.entry((a.min(b), a.max(b))).or_default() += 1;
        }
    }
    edges.values().filter(|&&faces| faces > 2).count()
}

#[test]
fn every_level_is_a_sound_mesh() {
    for (name, input, groups) in inputs() {
        let mut progressive = recorded(&input, groups.as_deref());
        let [coarsest, finest] = progressive.face_counts();
        let mut last_error = progressive.error();
        for asked in (coarsest..finest).step_by(13) {
            progressive.set_faces(asked);
            let (mesh, faces) = progressive.mesh();
            mesh.check(name).unwrap();
            let count = mesh.triangles.len();
            assert_eq!((count, faces.len()), (progressive.face_count(), count));
            // The doubles and faces without area of the input come at once.
            let slack = if name == "rubble" { 6 } else { 2 };
            assert!(count <= asked && count + slack > asked, "{name}: {count} of {asked}");
            assert!(faces.is_sorted_by(|a, b| a < b));
            assert_eq!(crowded_edges(&mesh), 0, "{name} with {count} faces");
            assert!(progressive.error() <= last_error);
            last_error = progressive.error();
            let mut by_error = progressive.clone();
            by_error.set_error(last_error);
            assert!(by_error.error() <= last_error && by_error.face_count() <= count);
        }
    }
}

/// Where simplification at once ends, it looks more closely: levels of a record are up to some 6 % worse.
#[test]
fn levels_are_as_near_to_the_input_as_meshes_simplified_at_once() {
    let input = ball(20);
    let mut progressive = recorded(&input, None);
    for faces in [2000, 600, 200] {
        progressive.set_faces(faces);
        let options = Options { faces, ..Options::default() };
        let direct = simplify(&input, None, &options).unwrap().mesh;
        let rms = |mesh: &Mesh| distance(&input, mesh, 20_000).symmetric().rms;
        let [level, direct] = [rms(&progressive.mesh().0), rms(&direct)];
        assert!((level / direct - 1.0).abs() < 0.1, "{faces} faces: {level} beside {direct}");
    }
}

/// Moves over the image as fast as the point is high.
struct Shear;

impl ScreenMotion for Shear {
    fn seen(&self, [place, _]: [Vec3; 2]) -> Seen {
        let speed_px = 10.0 + 10.0 * place.y;
        Seen {
            position_px: 100.0 * place.truncate(),
            velocity_px: Vec2::new(speed_px, 0.0),
            speed_px,
            magnification: 1.0,
        }
    }
}

#[test]
fn no_triangle_is_larger_than_the_limit_at_any_speed() {
    let input = grid(40, hills);
    let limit = PerimeterLimit { slope: 1.0, intercept_px: 5.0 };
    let options = Options { motion: Some(&Shear), limit: Some(limit), ..Options::default() };
    let speeds = [0.5, 1.0, 2.0, 4.0];
    let mut progressive = record(&input, None, &options, &speeds).unwrap();
    progressive.set_speed(0.4);
    assert_eq!(progressive.mesh().0, input);
    let mut last = input.triangles.len();
    for speed in speeds {
        progressive.set_speed(1.1 * speed);
        let (mesh, _) = progressive.mesh();
        assert!(mesh.triangles.len() < last, "{speed}: {}", mesh.triangles.len());
        last = mesh.triangles.len();
        let limit = PerimeterLimit { slope: speed, ..limit };
        for &triangle in &mesh.triangles {
            let seen = mesh.corners(triangle, 0.0).map(|place| Shear.seen([place; 2]));
            let slowest = seen.iter().map(|seen| seen.speed_px).fold(f32::INFINITY, f32::min);
            assert!(perimeter_px(&seen) <= 1.0001 * limit.at(slowest));
        }
    }
    assert_eq!(last, progressive.face_counts()[0]);
}

/// Moves along a direction of the image.
struct Slide(Vec2);

impl ScreenMotion for Slide {
    fn seen(&self, [place, _]: [Vec3; 2]) -> Seen {
        let (position_px, velocity_px) = (100.0 * place.truncate(), self.0);
        Seen { position_px, velocity_px, speed_px: self.0.length(), magnification: 1.0 }
    }
}

#[test]
fn a_changed_direction_starts_from_the_nearest_record() {
    let (input, groups) = (grid(30, hills), vec![0; 1800]);
    let (x, y) = (Slide(Vec2::X * 30.0), Slide(Vec2::Y * 30.0));
    fn options(motion: &Slide, faces: usize) -> Options<'_> {
        let weight = Weight::Mirrored { r: 1.0, epsilon: 0.01 };
        Options { faces, weight, motion: Some(motion), ..Options::default() }
    }
    let mut records = [(Vec3::X, &x), (Vec3::Y, &y)].map(|(direction, motion)| Directed {
        direction,
        mesh: record(&input, None, &options(motion, 1), &[]).unwrap(),
    });
    let coarsest = records[0].mesh.face_counts()[0];
    records[1].mesh.set_faces(100);
    for direction in [Vec3::new(2.0, 0.5, 0.0), Vec3::new(-3.0, 1.0, 0.0)] {
        records[0].mesh.set_faces(0);
        let motion = Slide(direction.truncate());
        let coarse =
            redirect(&mut records, direction, Some(&groups), &options(&motion, 200)).unwrap();
        assert!((190..=200).contains(&coarse.mesh.triangles.len()));
        assert!(coarse.faces.iter().all(|&face| face < 1800));
        assert!(coarse.faces.is_sorted_by(|a, b| a < b));
        assert!((790..=800).contains(&records[0].mesh.face_count()));
        assert!(records[0].mesh.error() <= coarse.error);
        assert!((98..=100).contains(&records[1].mesh.face_count()), "the other stays");
    }
    // An error is met as well as a number of faces.
    let strict = Options { error: Some(1e-3), ..options(&x, 1) };
    let close = redirect(&mut records, Vec3::X, None, &strict).unwrap();
    assert!(close.error <= 1e-3 && close.mesh.triangles.len() > 2 * coarsest, "{}", close.error);

    let message = |records: &mut [Directed], direction, groups: Option<&[u32]>| {
        redirect(records, direction, groups, &strict).unwrap_err().to_string()
    };
    assert!(message(&mut records, Vec3::ZERO, None).starts_with("direction: [0, 0, 0]: "));
    assert_eq!(message(&mut [], Vec3::X, None), "records: 0: 1 or more are needed");
    assert_eq!(
        message(&mut records, Vec3::X, Some(&[1, 2])),
        "groups: 2: one for each of the 1800 faces of the input"
    );
}

/// Normals of the faces' own are left out by a simplification, so only the input has them; and what lies at one point
/// a hundred times takes no hundred times the room.
#[test]
fn corners_of_their_own_are_recorded() {
    let n = 400;
    let rim = |k: u32| {
        let angle = k as f32 / n as f32 * std::f32::consts::TAU;
        Vec3::new(angle.cos(), angle.sin(), 0.3 * (9.0 * angle).sin())
    };
    let corners = (0..n).flat_map(|k| [Vec3::Z, rim(k), rim(k + 1)]);
    let positions: Vec<Vec3> = corners.collect();
    let normal = |three: &[Vec3]| [(three[1] - three[0]).cross(three[2] - three[0]); 3];
    let fan = Mesh {
        normals: Some(positions.chunks(3).flat_map(normal).collect()),
        triangles: (0..n).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        positions,
        ..Mesh::default()
    };
    let mut progressive = recorded(&fan, None);
    progressive.set_faces(100);
    let (coarse, _) = progressive.mesh();
    assert!(coarse.triangles.len() <= 100 && coarse.normals.is_none());
    let mut file = vec![];
    progressive.write(&mut file).unwrap();
    assert!(file.len() < 80 * n as usize, "{}", file.len());
    let reader = file::Reader::open("fan", &file[..]).unwrap();
    let mut read = reader.read_all().unwrap();
    read.set_faces(usize::MAX);
    assert_eq!(bits(&read.mesh().0), bits(&fan));
    read.set_faces(100);
    assert_eq!(bits(&read.mesh().0), bits(&coarse));
}
