//! Figures as files of their own: SVG that says what it shows, and PNG drawn from it.

use super::plot::{ORANGE, rgb};
use resvg::{tiny_skia, usvg};
use std::sync::{Arc, LazyLock};

/// Height of the line above a figure that says that its observers were simulated.
const BANNER: f64 = 20.0;
/// Pixels of the PNG per CSS pixel.
const SCALE: f32 = 2.0;

/// The figure `svg` as a file: with a line in the picture if the observers were simulated, so that it
/// cannot be shown without.
pub(super) fn standalone(svg: &str, simulated: bool) -> String {
    let size = |name: &str| -> Option<f64> {
        let (_, rest) = svg.split_once(&format!(" {name}=\""))?;
        rest.split('"').next()?.parse().ok()
    };
    let (Some(width), Some(height), true) = (size("width"), size("height"), simulated) else {
        return svg.into();
    };
    let (width, tall) = (width.max(360.0), height + BANNER);
    let inner = svg.replacen("<svg ", &format!("<svg y=\"{BANNER}\" "), 1);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.1} {tall:.1}\" \
         width=\"{width:.1}\" height=\"{tall:.1}\" font-family=\"sans-serif\" font-size=\"12\">\
         <text x=\"4\" y=\"14\" fill=\"{}\">Simulated observers: a check of the tool, never a finding\
         </text>{inner}</svg>",
        rgb(ORANGE)
    )
}

/// The figure as PNG on white, at twice its size; none if it cannot be drawn.
pub(super) fn png(svg: &str) -> Option<Vec<u8>> {
    // The same letters on every computer, whatever fonts it has.
    static FONTS: LazyLock<Arc<usvg::fontdb::Database>> = LazyLock::new(|| {
        let mut fonts = usvg::fontdb::Database::new();
        fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
        Arc::new(fonts)
    });
    let font = FONTS.faces().next()?.families.first()?.0.clone();
    let options = usvg::Options {
        font_family: font.clone(),
        fontdb: FONTS.clone(),
        ..usvg::Options::default()
    };
    // Whatever the page asks for, there is one font here.
    let named = svg.replace("font-family=\"", &format!("font-family=\"{font}, "));
    let tree = usvg::Tree::from_str(&named, &options).ok()?;
    let size = tree.size().to_int_size().scale_by(SCALE)?;
    let mut image = tiny_skia::Pixmap::new(size.width(), size.height())?;
    image.fill(tiny_skia::Color::WHITE);
    resvg::render(&tree, tiny_skia::Transform::from_scale(SCALE, SCALE), &mut image.as_mut());
    image.encode_png().ok()
}
