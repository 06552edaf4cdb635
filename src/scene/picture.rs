//! Pictures on surfaces, all of a scene in one table. Between texels they are interpolated linearly, beyond
//! their edges they repeat.

use super::import::image::Picture;
use super::texel::{exponent_base, pack, unpack};
use bytemuck::{Pod, Zeroable};

/// Most texels of all pictures of a scene, well within what 32-bit indices count.
pub const MAX_TEXELS: usize = 1 << 29;

/// Reflectances are at most 1.
const LARGEST: f32 = 1.0;

/// Where a picture is in the table, as both devices read it. Without texels it is white.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct PictureRef {
    /// Its first texel.
    pub first: u32,
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// The texels of pictures, one after the other, as [`pack`] gives them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pictures {
    /// Row by row from the upper left.
    pub texels: Vec<u32>,
}

impl Pictures {
    /// Takes in `picture`. What reflects more than all light reflects all of it.
    pub fn push(&mut self, picture: &Picture) -> PictureRef {
        let first = self.texels.len() as u32;
        let base = exponent_base(LARGEST);
        self.texels.extend(
            picture.texels.iter().map(|texel| pack(texel.min(glam::Vec3::splat(LARGEST)), base)),
        );
        PictureRef { first, width: picture.width, height: picture.height }
    }

    /// The colour of `picture` at (u, v), v from the upper edge; the whole picture is from 0 to 1.
    pub fn color(&self, picture: PictureRef, u: f32, v: f32) -> glam::Vec3 {
        if picture.width == 0 {
            return glam::Vec3::ONE;
        }
        let along = |at: f32, size: u32| {
            let at = (at - at.floor()) * size as f32 - 0.5;
            let low = at.floor();
            let first = if low < 0.0 { size - 1 } else { (low as u32).min(size - 1) };
            (first, if first + 1 == size { 0 } else { first + 1 }, at - low)
        };
        let (left, right, x) = along(u, picture.width);
        let (upper, lower, y) = along(v, picture.height);
        let texel = |i: u32, j: u32| {
            let place = picture.first + j * picture.width + i;
            unpack(self.texels[place as usize], exponent_base(LARGEST))
        };
        let row = |j: u32| texel(left, j) * (1.0 - x) + texel(right, j) * x;
        row(upper) * (1.0 - y) + row(lower) * y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn colours_are_interpolated_and_repeat() {
        let mut pictures = Pictures::default();
        let texels = [0.0, 1.0, 0.5, 0.25].map(Vec3::splat).to_vec();
        pictures.push(&Picture { width: 1, height: 1, texels: vec![Vec3::ONE] });
        let picture = pictures.push(&Picture { width: 2, height: 2, texels });
        let at = |u, v| pictures.color(picture, u, v).x;
        // In the middles of texels, between two, between all four, and beyond an edge.
        assert_eq!([at(0.25, 0.25), at(0.75, 0.25), at(0.25, 0.75)], [0.0, 1.0, 0.5]);
        assert_eq!([at(0.5, 0.25), at(0.25, 0.5), at(0.5, 0.5)], [0.5, 0.25, 0.4375]);
        assert_eq!([at(0.0, 0.25), at(1.0, 0.25), at(-0.75, 3.25)], [0.5, 0.5, 0.0]);
        assert_eq!(pictures.color(PictureRef::default(), 0.3, 0.3), Vec3::ONE);
    }
}
