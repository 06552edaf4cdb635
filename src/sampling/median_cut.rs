//! Median cut (after Debevec 2005): divides a grid of weights into 2^b rectangles of equal weight.
//!
//! A uniform index then draws a rectangle by the weight in it, and a uniform point in the rectangle
//! draws a place of the grid nearly by its weight: exactly in the limit of many rectangles, and for
//! every b with the known density 2^−b per area of the rectangle. The table has the same size however
//! large the grid is, and the halves of the words' bits are the
//! halves of the grid, so words that are well stratified stay so.

use bytemuck::{Pod, Zeroable};

/// A rectangle of the grid; lengths in grid cells.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Rectangle {
    /// Left border.
    pub x: f32,
    /// Upper border.
    pub y: f32,
    /// Extent to the right.
    pub width: f32,
    /// Extent downwards.
    pub height: f32,
}

/// The 2^`bits` rectangles of equal weight of a grid of `weights`, row by row, `width` to the row.
/// The weights are finite and not negative. Where there is none to divide, the area is halved.
pub fn median_cut(weights: &[f64], width: usize, bits: u32) -> Vec<Rectangle> {
    let sums = SummedArea::new(weights, width);
    let whole = Bounds { x: [0.0, width as f64], y: [0.0, (weights.len() / width) as f64] };
    let mut parts = vec![whole];
    for _ in 0..bits {
        parts = parts.iter().flat_map(|part| part.halves(&sums)).collect();
    }
    let rectangle = |Bounds { x, y }: Bounds| Rectangle {
        x: x[0] as f32,
        y: y[0] as f32,
        width: (x[1] - x[0]) as f32,
        height: (y[1] - y[0]) as f32,
    };
    parts.into_iter().map(rectangle).collect()
}

#[derive(Clone, Copy)]
struct Bounds {
    x: [f64; 2],
    y: [f64; 2],
}

impl Bounds {
    /// The two parts of equal weight that a cut across the longer side leaves.
    fn halves(&self, sums: &SummedArea) -> [Self; 2] {
        let across_x = self.x[1] - self.x[0] >= self.y[1] - self.y[0];
        let cut_at = |at: f64| {
            if across_x {
                [Self { x: [self.x[0], at], ..*self }, Self { x: [at, self.x[1]], ..*self }]
            } else {
                [Self { y: [self.y[0], at], ..*self }, Self { y: [at, self.y[1]], ..*self }]
            }
        };
        let [mut low, mut high] = if across_x { self.x } else { self.y };
        let half = 0.5 * sums.weight(self);
        if half <= 0.0 {
            return cut_at(0.5 * (low + high));
        }
        // More steps than a double has bits to tell.
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if sums.weight(&cut_at(middle)[0]) < half { low = middle } else { high = middle }
        }
        cut_at(low)
    }
}

/// Weights summed over all rectangles that begin at the grid's corner (Crow 1984).
struct SummedArea {
    sums: Vec<f64>,
    columns: usize,
    rows: usize,
}

impl SummedArea {
    fn new(weights: &[f64], width: usize) -> Self {
        let columns = width + 1;
        let mut sums = vec![0.0; columns];
        for row in weights.chunks_exact(width) {
            let mut along = 0.0;
            sums.push(0.0);
            for weight in row {
                along += weight;
                sums.push(along + sums[sums.len() - columns]);
            }
        }
        Self { columns, rows: sums.len() / columns, sums }
    }

    /// The weight within `bounds`; each grid cell's is spread evenly over it.
    fn weight(&self, Bounds { x, y }: &Bounds) -> f64 {
        self.to(x[1], y[1]) - self.to(x[0], y[1]) - self.to(x[1], y[0]) + self.to(x[0], y[0])
    }

    fn to(&self, x: f64, y: f64) -> f64 {
        let i = (x as usize).min(self.columns - 2);
        let j = (y as usize).min(self.rows - 2);
        let (along, down) = (x - i as f64, y - j as f64);
        let at = |i: usize, j: usize| self.sums[j * self.columns + i];
        let upper = at(i, j) * (1.0 - along) + at(i + 1, j) * along;
        let lower = at(i, j + 1) * (1.0 - along) + at(i + 1, j + 1) * along;
        upper * (1.0 - down) + lower * down
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 24;
    const HEIGHT: usize = 10;

    /// Smooth, but for one cell that outweighs half of the rest, and an empty corner.
    fn weights() -> Vec<f64> {
        (0..WIDTH * HEIGHT)
            .map(|k| match (k % WIDTH, k / WIDTH) {
                (17, 3) => 500.0,
                (0..6, 0..4) => 0.0,
                (i, j) => 1.0 + (i * j % 7) as f64,
            })
            .collect()
    }

    /// Weight of a rectangle, cell by cell.
    fn weight(weights: &[f64], r: &Rectangle) -> f64 {
        let overlap = |from: f32, length: f32, cell: usize| {
            let (from, cell) = (f64::from(from), cell as f64);
            ((from + f64::from(length)).min(cell + 1.0) - from.max(cell)).max(0.0)
        };
        (0..weights.len())
            .map(|k| {
                let (i, j) = (k % WIDTH, k / WIDTH);
                weights[k] * overlap(r.x, r.width, i) * overlap(r.y, r.height, j)
            })
            .sum()
    }

    #[test]
    fn rectangles_have_equal_weight_and_tile_the_grid() {
        let weights = weights();
        let total: f64 = weights.iter().sum();
        for bits in [0, 1, 6, 9] {
            let rectangles = median_cut(&weights, WIDTH, bits);
            assert_eq!(rectangles.len(), 1 << bits);
            let share = total / rectangles.len() as f64;
            for rectangle in &rectangles {
                let found = weight(&weights, rectangle);
                assert!((found / share - 1.0).abs() < 2e-3, "{rectangle:?}: {found} of {share}");
            }
            // Every place of the grid lies in exactly one of them.
            for place in 0..2000 {
                let x = (place as f32 * 0.7548777).fract() * WIDTH as f32;
                let y = (place as f32 * 0.5698403).fract() * HEIGHT as f32;
                let holds = |r: &&Rectangle| {
                    r.x <= x && x < r.x + r.width && r.y <= y && y < r.y + r.height
                };
                assert_eq!(rectangles.iter().filter(holds).count(), 1, "({x}, {y})");
            }
        }
    }

    #[test]
    fn a_grid_without_weight_is_halved() {
        let rectangles = median_cut(&[0.0; 8], 4, 3);
        assert!(rectangles.iter().all(|r| r.width * r.height == 1.0), "{rectangles:?}");
    }
}
