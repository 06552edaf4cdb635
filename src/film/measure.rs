//! How far an image is from the truth.

use shutterlab_stimuli::LinearImage;

/// Relative mean squared error of `image` against `truth` over linear RGB.
///
/// # Formula
/// ```text
/// mean of (x − y)² / (y² + ε²)
/// ```
/// where `epsilon` is 1 % of the mean of the truth over the pixels that the moving object or its
/// shadow touches: see [`epsilon`].
pub fn relative_mse(image: &LinearImage, truth: &LinearImage, epsilon: f64) -> f64 {
    let pairs = image.pixels.iter().flatten().zip(truth.pixels.iter().flatten());
    let sum: f64 = pairs
        .map(|(&x, &y)| (f64::from(x), f64::from(y)))
        .map(|(x, y)| (x - y).powi(2) / (y * y + epsilon * epsilon))
        .sum();
    sum / (3 * truth.pixels.len()) as f64
}

/// 1 % of the mean of `truth` over the pixels that differ by more than 1 % from `empty`, the same
/// view without the moving object; over all pixels, if none does.
pub fn epsilon(truth: &LinearImage, empty: &LinearImage) -> f64 {
    let mean = |pixels: &[&[f32; 3]]| {
        let sum: f64 = pixels.iter().flat_map(|pixel| pixel.iter()).map(|&v| f64::from(v)).sum();
        sum / (3 * pixels.len()) as f64
    };
    let differs = |a: &[f32; 3], b: &[f32; 3]| (0..3).any(|c| (a[c] - b[c]).abs() > 0.01 * b[c]);
    let pairs = truth.pixels.iter().zip(&empty.pixels);
    let touched: Vec<&[f32; 3]> = pairs.filter(|(a, b)| differs(a, b)).map(|(a, _)| a).collect();
    let all: Vec<&[f32; 3]> = truth.pixels.iter().collect();
    0.01 * if touched.is_empty() { mean(&all) } else { mean(&touched) }
}

/// Part of the pixels of which some channel differs by more than `tolerance`.
pub fn differing(image: &LinearImage, truth: &LinearImage, tolerance: f32) -> f64 {
    let pairs = image.pixels.iter().zip(&truth.pixels);
    let count = pairs.filter(|(a, b)| (0..3).any(|c| (a[c] - b[c]).abs() > tolerance)).count();
    count as f64 / truth.pixels.len() as f64
}
