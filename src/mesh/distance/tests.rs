//! Distances known by hand, and what rounding, threads and poor triangles must not change.

use super::*;
use crate::mesh::bvh::tests::{Numbers, sphere};

/// A square from `from` to `to` on both axes, of `cells`² cells of unequal sizes.
fn square(from: f32, to: f32, height: f32, cells: u32) -> Mesh {
    let place = |k: u32| from + (to - from) * (k as f32 / cells as f32).powi(2);
    let row = cells + 1;
    let vertices = (0..row * row).map(|k| Vec3::new(place(k % row), place(k / row), height));
    let corners = (0..cells * cells).map(|k| k / cells * row + k % cells);
    Mesh {
        positions: vertices.collect(),
        triangles: corners
            .flat_map(|k| [[k, k + 1, k + row], [k + 1, k + row + 1, k + row]])
            .collect(),
        ..Mesh::default()
    }
}

fn assert_near(found: Deviation, mean: f64, rms: f64, max: f64, tolerance: f64) {
    for (found, truth) in [(found.mean, mean), (found.rms, rms), (found.max, max)] {
        assert!((found - truth).abs() <= tolerance, "{found} {truth}");
    }
}

#[test]
fn a_plane_and_its_shifted_copy() {
    let measured = distance(&square(0.0, 3.0, 0.0, 7), &square(0.0, 3.0, 0.25, 5), 10_000);
    for deviation in [measured.forward, measured.backward, measured.symmetric()] {
        assert_near(deviation, 0.25, 0.25, 0.25, 1e-15);
    }
    assert!((measured.diagonal - 18.0_f64.sqrt()).abs() < 1e-6);
    assert_near(measured.forward.over(0.5), 0.5, 0.5, 0.5, 1e-15);
}

/// Of nine unit squares the middle one is the other mesh. The four at its sides are at y from it, at the corners
/// at √(x² + y²), for which the integrals over a unit square are ½ and (√2 + ln(1 + √2))/3, of the squares ⅓
/// and ⅔. Unequal triangles must not weigh alike.
#[test]
fn a_square_and_one_nine_times_as_large() {
    let measured = distance(&square(0.0, 1.0, 0.0, 3), &square(-1.0, 2.0, 0.0, 9), 100_000);
    assert_near(measured.forward, 0.0, 0.0, 0.0, 1e-7);
    let root = 2.0_f64.sqrt();
    let mean = (2.0 + 4.0 / 3.0 * (root + (1.0 + root).ln())) / 9.0;
    assert_near(measured.backward, mean, 2.0 / 3.0, root, 2e-4);
    assert_near(measured.symmetric(), 0.5 * mean, 2.0 / 3.0 / root, root, 2e-4);
}

#[test]
fn a_sphere_and_a_larger_one() {
    let ball = |radius: f32| {
        let (positions, triangles) = sphere(80, 50, |p| radius * p);
        Mesh { positions, triangles, ..Mesh::default() }
    };
    // Between the faces, whose planes are within 0.3 % of the radius from the centre, it is a little less.
    let measured = distance(&ball(1.0), &ball(1.1), 20_000);
    for deviation in [measured.forward, measured.backward] {
        assert_near(deviation, 0.0998, 0.0998, 0.1, 3e-4);
    }
}

#[test]
fn equal_meshes_are_apart_by_rounding_only_and_the_order_of_two_does_not_matter() {
    let mut numbers = Numbers::new(6);
    let [a, b] = [numbers.soup(300, false), numbers.soup(200, true)];
    assert!(distance(&a, &a, 5000).symmetric().max < 1e-7);
    let [there, back] = [distance(&a, &b, 5000), distance(&b, &a, 5000)];
    assert_eq!((there.forward, there.backward), (back.backward, back.forward));
    assert_eq!(there.symmetric(), back.symmetric());
    // As the shutter opens.
    assert_eq!(there, distance(&a, &Mesh { end_positions: None, ..b }, 5000));
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let mut numbers = Numbers::new(7);
    let [a, b] = [numbers.soup(3000, false), numbers.soup(2000, false)];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| distance(&a, &b, 5000))
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn triangles_without_area_and_vertices_without_triangles() {
    let flat = square(0.0, 1.0, 0.0, 2);
    let mut poor = square(0.0, 1.0, 0.0, 2);
    let tip = poor.positions.len() as u32;
    poor.positions.extend([Vec3::new(0.0, 0.0, 0.5), Vec3::splat(9.0)]);
    poor.triangles.extend([[tip, 0, 0], [tip; 3]]);
    let measured = distance(&poor, &flat, 1000);
    assert_near(measured.forward, 0.0, 0.0, 0.5, 1e-7);
    assert_near(measured.backward, 0.0, 0.0, 0.0, 1e-7);
    // A spike alone, and its foot: a third of its samples' weight is the tip's, a sixth of its square.
    let spike = Mesh { triangles: vec![[tip, 0, 0]], ..poor.clone() };
    let point = Mesh { triangles: vec![[0; 3]], ..poor };
    let measured = distance(&spike, &point, 1000);
    assert_near(measured.forward, 0.5 / 3.0, 0.5 / 6.0_f64.sqrt(), 0.5, 1e-3);
    assert_near(measured.backward, 0.0, 0.0, 0.0, 0.0);
}
