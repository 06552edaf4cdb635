//! Linear images for other programs: Portable Float Map.

use shutterlab_stimuli::LinearImage;
use std::io::Write;
use std::path::Path;

/// A Portable Float Map: little-endian 32-bit RGB, rows from the bottom.
pub fn write(image: &LinearImage, path: &Path) -> std::io::Result<()> {
    let mut file = std::io::BufWriter::new(std::fs::File::create(path)?);
    write!(file, "PF\n{} {}\n-1.0\n", image.width, image.height)?;
    for row in image.pixels.chunks(image.width as usize).rev() {
        for value in row.iter().flatten() {
            file.write_all(&value.to_le_bytes())?;
        }
    }
    file.flush()
}
