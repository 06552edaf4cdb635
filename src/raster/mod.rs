//! The rasterizer: which triangle is seen at the centre of each pixel, how far away and where on it.
//!
//! Corners are snapped to a grid of 2⁻¹² pixels, and edge functions [Pineda1988] in integers decide which
//! pixels lie inside. Nothing is rounded there, so that of triangles that share an edge exactly one has each
//! pixel along it: a centre on an edge belongs to the triangle below the edge or to its right. Triangles that
//! reach behind the camera or far out of the image are clipped beforehand [Sutherland1974], a shared edge in
//! the same place for both of its triangles.

pub mod picture;
pub mod shapes;

use glam::{Affine3A, Mat3, Vec3};

/// Bits of a pixel's fraction.
const FRACTION: u32 = 12;
const PIXEL: i64 = 1 << FRACTION;
/// Farther from the image's corner nothing is drawn, in pixels: products of coordinates fit in 64 bits.
const REACH_PX: f32 = (1 << 17) as f32;
/// Nearer than this to the camera's plane nothing is drawn, in metres.
const NEAR: f32 = 1e-6;

/// What is seen in each pixel, row by row from the top left.
#[derive(Clone, Debug)]
pub struct Raster {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Distance along the view, in metres; infinite where nothing is seen.
    pub depths: Vec<f32>,
    /// What is seen where the depth is finite.
    pub fragments: Vec<Fragment>,
    /// How many triangles were drawn.
    drawn: u32,
    /// The vertices that are being drawn.
    vertices: Vec<Vertex>,
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fragment {
    /// The triangle, counted over all that were drawn since the image was cleared.
    pub triangle: u32,
    /// Weights of the triangle's corners at this point of its plane, which add up to 1.
    pub barycentrics: [f32; 3],
}

/// A vertex as the camera sees it.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    /// Its place in the image, from the corner, and 1, all times its distance along the view.
    homogeneous: Vec3,
    /// Where it is in the image, if it may be drawn as it is.
    corner: Option<Corner>,
}

/// A corner on the grid.
#[derive(Clone, Copy, Debug)]
struct Corner {
    x: i32,
    y: i32,
    inverse_depth: f32,
}

impl Corner {
    fn new(homogeneous: Vec3) -> Self {
        let inverse_depth = homogeneous.z.recip();
        let snapped = |length: f32| (length * inverse_depth * PIXEL as f32) as i32;
        Self { x: snapped(homogeneous.x), y: snapped(homogeneous.y), inverse_depth }
    }
}

/// The planes that triangles are clipped at: how far inside a point lies is the product with the vector
/// less the number.
const PLANES: [(Vec3, f32); 5] = [
    (Vec3::Z, NEAR),
    (Vec3::new(1.0, 0.0, REACH_PX), 0.0),
    (Vec3::new(-1.0, 0.0, REACH_PX), 0.0),
    (Vec3::new(0.0, 1.0, REACH_PX), 0.0),
    (Vec3::new(0.0, -1.0, REACH_PX), 0.0),
];

fn inside(point: Vec3, (normal, offset): (Vec3, f32)) -> f32 {
    normal.dot(point) - offset
}

impl Raster {
    /// An image in which nothing is seen.
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = width as usize * height as usize;
        Self {
            width,
            height,
            depths: vec![f32::INFINITY; pixels],
            fragments: vec![Fragment::default(); pixels],
            drawn: 0,
            vertices: vec![],
        }
    }

    /// Forgets what was drawn.
    pub fn clear(&mut self) {
        self.depths.fill(f32::INFINITY);
        self.drawn = 0;
    }

    /// Draws triangles, from whichever side they are seen. `to_image` takes a point to (x·z, y·z, z): x and y in
    /// pixels from the centre of the image, to the right and downwards; z the distance along the view
    /// ([`to_image`](crate::scene::screen_motion::to_image)). Of points at the same distance the first that was
    /// drawn is seen. A triangle of a vertex that there is not is left out, and so is what is nearer than 10⁻⁶ m
    /// or farther than 2¹⁷ pixels from the image's corner.
    pub fn draw(
        &mut self,
        positions: impl IntoIterator<Item = Vec3>,
        triangles: &[[u32; 3]],
        to_image: &Affine3A,
    ) {
        let centre = Vec3::new(0.5 * self.width as f32, 0.5 * self.height as f32, 1.0);
        let from_corner = Mat3::from_cols(Vec3::X, Vec3::Y, centre);
        let to_image = Affine3A::from_mat3(from_corner) * *to_image;
        let mut vertices = std::mem::take(&mut self.vertices);
        vertices.clear();
        vertices.extend(positions.into_iter().map(|position| {
            let homogeneous = to_image.transform_point3(position);
            let is_inside = PLANES.iter().all(|&plane| inside(homogeneous, plane) >= 0.0);
            Vertex { homogeneous, corner: is_inside.then(|| Corner::new(homogeneous)) }
        }));
        for (triangle, indices) in (self.drawn..).zip(triangles) {
            let vertex = |k: usize| vertices.get(indices[k] as usize);
            let (Some(a), Some(b), Some(c)) = (vertex(0), vertex(1), vertex(2)) else { continue };
            match (a.corner, b.corner, c.corner) {
                (Some(a), Some(b), Some(c)) => self.fill([a, b, c], triangle, None),
                _ => self.clip([a, b, c].map(|vertex| vertex.homogeneous), triangle),
            }
        }
        self.drawn += triangles.len() as u32;
        self.vertices = vertices;
    }

    /// Each pixel in which something is seen, with its depth and what is seen.
    pub fn seen(&self) -> impl Iterator<Item = (usize, f32, &Fragment)> {
        let pixels = self.depths.iter().zip(&self.fragments).enumerate();
        pixels
            .filter(|(_, (depth, _))| depth.is_finite())
            .map(|(pixel, (&depth, fragment))| (pixel, depth, fragment))
    }

    /// Draws what lies within all planes, as a fan of triangles.
    fn clip(&mut self, corners: [Vec3; 3], triangle: u32) {
        // Each with its barycentrics.
        let mut polygon: Vec<(Vec3, Vec3)> =
            corners.into_iter().zip([Vec3::X, Vec3::Y, Vec3::Z]).collect();
        for plane in PLANES {
            let mut clipped = Vec::with_capacity(polygon.len() + 1);
            for (place, &here) in polygon.iter().enumerate() {
                let next = polygon[(place + 1) % polygon.len()];
                let [h, n] = [here, next].map(|(point, _)| inside(point, plane));
                if h >= 0.0 {
                    clipped.push(here);
                }
                if (h >= 0.0) != (n >= 0.0) {
                    // From the inner end, whichever way round the edge is gone along.
                    let (from, to, t) = if h >= 0.0 {
                        (here, next, h / (h - n))
                    } else {
                        (next, here, n / (n - h))
                    };
                    clipped.push((from.0 + (to.0 - from.0) * t, from.1 + (to.1 - from.1) * t));
                }
            }
            polygon = clipped;
        }
        for last in 2..polygon.len() {
            let fan = [0, last - 1, last].map(|place| polygon[place]);
            let [a, b, c] = fan.map(|(_, barycentrics)| barycentrics);
            let corners = fan.map(|(homogeneous, _)| Corner::new(homogeneous));
            self.fill(corners, triangle, Some(Mat3::from_cols(a, b, c)));
        }
    }

    /// Draws a triangle within the planes. If it is a piece of another, `whole` takes its barycentrics to
    /// those of the other.
    #[inline]
    fn fill(&mut self, corners: [Corner; 3], triangle: u32, whole: Option<Mat3>) {
        // The pixels whose centres lie within the corners' bounds.
        let [xs, ys] = [corners.map(|corner| corner.x), corners.map(|corner| corner.y)];
        let bounds = |[a, b, c]: [i32; 3], end: u32| {
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let first = (i64::from(low) + PIXEL / 2 - 1) >> FRACTION;
            let end = ((i64::from(high) + PIXEL / 2) >> FRACTION).min(i64::from(end));
            first.max(0)..end
        };
        let (columns, rows) = (bounds(xs, self.width), bounds(ys, self.height));
        if columns.is_empty() || rows.is_empty() {
            return;
        }
        let [x, y] = [xs, ys].map(|values| values.map(i64::from));
        let area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
        if area == 0 {
            return;
        }
        // The edge function against each corner, gone along so that it is positive inside: its value at the
        // first centre, less 1 where a centre on the edge is outside, since it is neither a left nor a top edge;
        // and its steps to the right and downwards.
        let edges = [(1, 2), (2, 0), (0, 1)].map(|(from, to)| {
            let (dx, dy) = ((x[to] - x[from]) * area.signum(), (y[to] - y[from]) * area.signum());
            let first_x = columns.start * PIXEL + PIXEL / 2 - x[from];
            let first_y = rows.start * PIXEL + PIXEL / 2 - y[from];
            let outside = i64::from(dy > 0 || (dy == 0 && dx < 0));
            (dx * first_y - dy * first_x - outside, -dy * PIXEL, dx * PIXEL, outside)
        });
        let area = area.unsigned_abs() as f32;
        let mut row_values = edges.map(|edge| edge.0);
        for row in rows {
            let start = row as usize * self.width as usize;
            let pixels = start + columns.start as usize..start + columns.end as usize;
            let [mut a, mut b, mut c] = row_values;
            let mut was_inside = false;
            for (depth, fragment) in
                self.depths[pixels.clone()].iter_mut().zip(&mut self.fragments[pixels])
            {
                if a | b | c >= 0 {
                    was_inside = true;
                    let weight = |k: usize, value: i64| {
                        (value + edges[k].3) as f32 * corners[k].inverse_depth
                    };
                    let weights = Vec3::new(weight(0, a), weight(1, b), weight(2, c));
                    let inverse_sum = (weights.x + weights.y + weights.z).recip();
                    if area * inverse_sum < *depth {
                        *depth = area * inverse_sum;
                        let barycentrics = match &whole {
                            Some(whole) => *whole * (weights * inverse_sum),
                            None => weights * inverse_sum,
                        };
                        *fragment = Fragment { triangle, barycentrics: barycentrics.to_array() };
                    }
                } else if was_inside {
                    break;
                }
                (a, b, c) = (a + edges[0].1, b + edges[1].1, c + edges[2].1);
            }
            row_values = [0, 1, 2].map(|k| row_values[k] + edges[k].2);
        }
    }
}

#[cfg(test)]
mod tests;
