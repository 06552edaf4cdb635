//! The display profile: one screen as it stands in front of the participant, one TOML file. How large
//! and how far it is, what its code values become, and how two eyes' images reach the eyes.

use crate::definition::{self, DefinitionError};
use crate::response::Resampling;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::cmp::Ordering;
use std::path::{Path, PathBuf};

/// One display.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DisplayProfile {
    /// Version of this format: 1.
    pub schema: u32,
    /// Name of the display, written into each answer's row.
    #[schemars(length(min = 1, max = 64))]
    pub name: String,
    /// The monitor, as the system calls it; the system chooses one if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<String>,
    /// Shows a window of this size; the whole screen is filled if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<WindowSize>,
    /// Size, pixels and distance of the screen; without them nobody knows how large an image appears.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub screen: Option<Screen>,
    /// Refreshes per second that the screen is set to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub refresh_hz: Option<f64>,
    /// Whether the screen refreshes when it gets a frame (adaptive synchronisation).
    #[serde(default)]
    pub variable_refresh: bool,
    /// Luminance of white, for the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 100_000.0))]
    pub luminance_cd_m2: Option<f64>,
    /// Luminance of black, for the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub black_cd_m2: Option<f64>,
    /// Physical pixels per image pixel. Whole numbers repeat pixels; others mix neighbours in linear
    /// light.
    #[serde(default = "one")]
    #[schemars(range(min = 1.0, max = 16.0))]
    pub magnification: f64,
    /// What light a code value becomes.
    #[serde(default)]
    pub transfer: DisplayTransfer,
    /// How side-by-side stereo images are shown.
    #[serde(default)]
    pub stereo: StereoOutput,
    /// A patch for a photodiode, white while a sequence is to be seen; none if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub photodiode: Option<Photodiode>,
    /// SHA-256 over the file's bytes and those of its table; none without a file.
    #[serde(skip)]
    pub sha256: Option<String>,
    /// The rows of the transfer's table; empty without one.
    #[serde(skip)]
    pub levels: Vec<Level>,
}

/// Inside of a window, in physical pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WindowSize {
    /// Width.
    #[schemars(range(min = 1, max = 100_000))]
    pub width_px: u32,
    /// Height.
    #[schemars(range(min = 1, max = 100_000))]
    pub height_px: u32,
}

/// A flat screen, looked at in the middle and at a right angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Screen {
    /// Width of the picture.
    #[schemars(range(min = 10.0, max = 10_000.0))]
    pub width_mm: f64,
    /// Height of the picture.
    #[schemars(range(min = 10.0, max = 10_000.0))]
    pub height_mm: f64,
    /// Columns of physical pixels.
    #[schemars(range(min = 1, max = 100_000))]
    pub width_px: u32,
    /// Rows of physical pixels.
    #[schemars(range(min = 1, max = 100_000))]
    pub height_px: u32,
    /// Distance of the eyes.
    #[schemars(range(min = 1.0, max = 10_000.0))]
    pub distance_cm: f64,
}

/// What light a display makes of a code value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum DisplayTransfer {
    /// That which the stimuli were encoded for: code values go out unchanged.
    Identity {},
    /// A pure power: light = code^γ.
    Gamma {
        /// The exponent.
        #[schemars(range(min = 0.1, max = 10.0))]
        gamma: f64,
    },
    /// As measured.
    Table {
        /// The measured table, from the folder of the profile: a CSV with the columns `code` and
        /// `luminance_cd_m2`, both increasing, the codes 0 and 255 among them.
        file: PathBuf,
    },
}

/// A row of a measured table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Level {
    /// Code value of red, green and blue.
    pub code: u8,
    /// Luminance of a patch of it.
    pub luminance_cd_m2: f64,
}

/// How side-by-side stereo images are shown. Stimuli stored in another layout are shown as they are.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StereoOutput {
    /// How the images of the two eyes are put on the screen.
    pub mode: StereoMode,
    /// The right eye's monitor, for `two-windows`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_output: Option<String>,
}

/// How the images of the two eyes are put on the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StereoMode {
    /// Left eye left, right eye right: for a stereoscope or parallel eyes.
    #[default]
    SideBySide,
    /// Left eye right, right eye left: for crossed eyes.
    Crossed,
    /// Side by side, each image squeezed to half its width, as 3D screens take it.
    HalfWidth,
    /// Left eye above right.
    TopBottom,
    /// For red-cyan glasses: the least-squares anaglyph of Dubois, in linear light.
    Anaglyph,
    /// Left eye in the screen's even rows, counted from 0, right eye in the odd ones.
    RowInterleaved,
    /// Left eye in one window, right eye in another: for a mirror stereoscope or two projectors.
    TwoWindows,
}

/// A patch for a photodiode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Photodiode {
    /// Where it is.
    pub corner: Corner,
    /// Width and height, in physical pixels.
    #[schemars(range(min = 1, max = 2000))]
    pub size_px: u32,
}

/// A corner of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[expect(missing_docs, reason = "the names say it")]
pub enum Corner {
    TopLeft,
    TopRight,
    BottomLeft,
    BottomRight,
}

impl Default for DisplayTransfer {
    fn default() -> Self {
        Self::Identity {}
    }
}

impl StereoMode {
    /// Its name in profiles and rows.
    pub fn name(self) -> &'static str {
        match self {
            Self::SideBySide => "side-by-side",
            Self::Crossed => "crossed",
            Self::HalfWidth => "half-width",
            Self::TopBottom => "top-bottom",
            Self::Anaglyph => "anaglyph",
            Self::RowInterleaved => "row-interleaved",
            Self::TwoWindows => "two-windows",
        }
    }
}

impl DisplayProfile {
    /// The display of which nothing is known: pixel for pixel, code values unchanged.
    pub fn identity() -> Self {
        Self {
            schema: 1,
            name: "identity".into(),
            output: None,
            window: None,
            screen: None,
            refresh_hz: None,
            variable_refresh: false,
            luminance_cd_m2: None,
            black_cd_m2: None,
            magnification: 1.0,
            transfer: DisplayTransfer::default(),
            stereo: StereoOutput::default(),
            photodiode: None,
            sha256: None,
            levels: vec![],
        }
    }

    /// Reads and checks the profile at `path`, and its table.
    ///
    /// # Errors
    /// As [`DisplayProfile::parse`], or the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, DefinitionError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| DefinitionError::Unreadable { path: path.into(), source })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Parses and checks a profile and reads its table; `file` is what an error calls it, and its folder
    /// is where the table's path begins.
    ///
    /// # Errors
    /// As [`definition::parse`] and [`DisplayProfile::check`], or the table cannot be read or is none.
    pub fn parse(text: &str, file: &str) -> Result<Self, DefinitionError> {
        let mut profile: Self = definition::parse(text, file)?;
        profile.check(file)?;
        let mut hasher = Sha256::new();
        hasher.update(text);
        if let DisplayTransfer::Table { file: table } = &profile.transfer {
            let path = Path::new(file).with_file_name(table);
            let bytes = std::fs::read(&path)
                .map_err(|source| DefinitionError::Unreadable { path: path.clone(), source })?;
            hasher.update(&bytes);
            profile.levels = levels(&bytes, &path.display().to_string())?;
        }
        profile.sha256 = Some(hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect());
        Ok(profile)
    }

    /// Refuses values that no display can have.
    ///
    /// # Errors
    /// The first field that does not fit, by name.
    pub fn check(&self, file: &str) -> Result<(), DefinitionError> {
        definition::check_schema(self.schema, file)?;
        let refuse = |field: &str, value: String, allowed: &str| {
            Err(DefinitionError::value(file, field, value, allowed))
        };
        if !(1..=64).contains(&self.name.chars().count()) || self.name.contains(char::is_control) {
            let allowed = "1 to 64 characters on one line are allowed";
            return refuse("name", format!("{:?}", self.name), allowed);
        }
        let screen = self.screen.as_ref();
        let gamma = match self.transfer {
            DisplayTransfer::Gamma { gamma } => Some(gamma),
            _ => None,
        };
        let numbers = [
            ("screen.width_mm", screen.map(|s| s.width_mm), 10.0..=10_000.0),
            ("screen.height_mm", screen.map(|s| s.height_mm), 10.0..=10_000.0),
            ("screen.distance_cm", screen.map(|s| s.distance_cm), 1.0..=10_000.0),
            ("refresh_hz", self.refresh_hz, 1.0..=1000.0),
            ("luminance_cd_m2", self.luminance_cd_m2, 1.0..=100_000.0),
            ("black_cd_m2", self.black_cd_m2, 0.0..=1000.0),
            ("magnification", Some(self.magnification), 1.0..=16.0),
            ("transfer.gamma", gamma, 0.1..=10.0),
        ];
        for (field, value, allowed) in numbers {
            if let Some(value) = value.filter(|value| !allowed.contains(value)) {
                let allowed = format!("{} to {} is allowed", allowed.start(), allowed.end());
                return refuse(field, value.to_string(), &allowed);
            }
        }
        let sides = [
            ("screen.width_px", screen.map(|s| s.width_px), 100_000),
            ("screen.height_px", screen.map(|s| s.height_px), 100_000),
            ("window.width_px", self.window.map(|w| w.width_px), 100_000),
            ("window.height_px", self.window.map(|w| w.height_px), 100_000),
            ("photodiode.size_px", self.photodiode.map(|p| p.size_px), 2000),
        ];
        for (field, value, most) in sides {
            if let Some(value) = value.filter(|value| !(1..=most).contains(value)) {
                let allowed = format!("1 to {most} pixels are allowed");
                return refuse(field, value.to_string(), &allowed);
            }
        }
        if let Some(s) = screen {
            let (x, y) = (s.width_mm / f64::from(s.width_px), s.height_mm / f64::from(s.height_px));
            if (x / y - 1.0).abs() > 0.03 {
                let found = format!("pixels of {x:.4} × {y:.4} mm");
                return refuse("screen", found, "pixels must be square, to 3 %: measure again");
            }
        }
        if self.stereo.mode == StereoMode::RowInterleaved && self.window.is_some() {
            let allowed = "the rows must be those of the screen: leave the window out";
            return refuse("stereo.mode", "row-interleaved".into(), allowed);
        }
        let two = self.stereo.mode == StereoMode::TwoWindows;
        match (&self.stereo.second_output, two, self.window) {
            (Some(output), false, _) => {
                let allowed = "only the mode two-windows has a second output";
                refuse("stereo.second_output", format!("{output:?}"), allowed)
            }
            (None, true, None) => {
                let allowed = "two windows that fill their screens need to know the second";
                refuse("stereo.second_output", "none".into(), allowed)
            }
            _ => Ok(()),
        }
    }

    /// Image pixels per degree of visual angle of an image `width_px` wide, as the stimuli's own: the
    /// width over the angle it subtends. None if the profile does not know the screen.
    pub fn pixels_per_degree(&self, width_px: u32) -> Option<f64> {
        let screen = self.screen?;
        let width_mm =
            f64::from(width_px) * self.magnification * screen.width_mm / f64::from(screen.width_px);
        let angle_deg = 2.0 * (0.05 * width_mm / screen.distance_cm).atan().to_degrees();
        Some(f64::from(width_px) / angle_deg)
    }

    /// How image pixels become physical ones by the magnification.
    pub fn resampling(&self) -> Resampling {
        match self.magnification {
            1.0 => Resampling::None,
            by if by.fract() == 0.0 => Resampling::Nearest,
            _ => Resampling::Linear,
        }
    }
}

/// The rows of a measured table, checked; `file` is what an error calls it.
fn levels(bytes: &[u8], file: &str) -> Result<Vec<Level>, DefinitionError> {
    let rows: Result<Vec<Level>, csv::Error> =
        csv::Reader::from_reader(bytes).deserialize().collect();
    let levels = rows.map_err(|error| DefinitionError::Malformed {
        file: file.into(),
        line: error.position().map_or(1, |position| position.line() as usize),
        message: error.to_string(),
    })?;
    let refuse = |field: &str, value: String, allowed: &str| {
        Err(DefinitionError::value(file, field, value, allowed))
    };
    if let [.., last] = levels.as_slice()
        && (levels[0].code, last.code) == (0, 255)
    {
        let first = levels[0].luminance_cd_m2;
        if !(first >= 0.0 && last.luminance_cd_m2.is_finite()) {
            let found = format!("{first} to {}", last.luminance_cd_m2);
            return refuse("luminance_cd_m2", found, "finite numbers from 0 are allowed");
        }
    } else {
        let codes: Vec<u8> = levels.iter().map(|level| level.code).collect();
        return refuse("code", format!("{codes:?}"), "the first must be 0 and the last 255");
    }
    for pair in levels.windows(2) {
        if pair[1].code <= pair[0].code {
            let found = format!("{} after {}", pair[1].code, pair[0].code);
            return refuse("code", found, "codes must increase");
        }
        let (a, b) = (pair[0].luminance_cd_m2, pair[1].luminance_cd_m2);
        // What is no number is refused too.
        if b.partial_cmp(&a) != Some(Ordering::Greater) {
            let found = format!("{b} at code {} after {a}", pair[1].code);
            return refuse("luminance_cd_m2", found, "luminance must increase with the code");
        }
    }
    Ok(levels)
}

fn one() -> f64 {
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn screen() -> Screen {
        Screen {
            width_mm: 500.0,
            height_mm: 250.0,
            width_px: 2000,
            height_px: 1000,
            distance_cm: 57.3,
        }
    }

    /// At 57.3 cm a centimetre is a degree; here 40 physical pixels are one.
    #[test]
    fn the_screen_and_the_magnification_give_the_angle() {
        let mut profile = DisplayProfile { screen: Some(screen()), ..DisplayProfile::identity() };
        let near = |found: Option<f64>, expected: f64| {
            assert!((found.unwrap() - expected).abs() < 0.001 * expected, "{found:?}");
        };
        near(profile.pixels_per_degree(40), 40.0);
        profile.magnification = 2.0;
        near(profile.pixels_per_degree(40), 20.0);
        // A wide image subtends less than its width in centimetres: 47.14 degrees for 50 cm.
        near(profile.pixels_per_degree(1000), 1000.0 / 47.14);
        assert_eq!(DisplayProfile::identity().pixels_per_degree(40), None);
    }

    #[test]
    fn the_hash_is_of_profile_and_table() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lab.toml");
        let text = "schema = 1\nname = \"lab\"\n[transfer]\nkind = \"table\"\nfile = \"t.csv\"\n";
        let table = |peak: u32| format!("code,luminance_cd_m2\n0,0.2\n128,22.5\n255,{peak}\n");
        let read = |text: &str, table: &str| {
            std::fs::write(&path, text).unwrap();
            std::fs::write(folder.path().join("t.csv"), table).unwrap();
            DisplayProfile::read(&path).unwrap()
        };
        let profile = read(text, &table(100));
        assert_eq!(profile.levels[1], Level { code: 128, luminance_cd_m2: 22.5 });
        let both = Sha256::digest([text, &table(100)].concat());
        let hash: String = both.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(profile.sha256.as_ref(), Some(&hash));
        assert_ne!(read(text, &table(101)).sha256, profile.sha256);
        assert_ne!(read(&text.replace("lab", "hall"), &table(100)).sha256, profile.sha256);
    }

    #[test]
    fn tables_that_no_display_has_are_refused_by_name() {
        for (rows, expected) in [
            ("0,1\n255,x", "t.csv: line 3: "),
            ("0,1\n128,2", "t.csv: code: [0, 128]: the first must be 0"),
            ("", "t.csv: code: []: the first must be 0"),
            ("0,1\n100,5\n100,6\n255,9", "t.csv: code: 100 after 100: codes must increase"),
            ("0,1\n100,5\n200,5\n255,9", "t.csv: luminance_cd_m2: 5 at code 200 after 5: "),
            ("0,1\n100,NaN\n255,9", "t.csv: luminance_cd_m2: NaN at code 100 after 1: "),
            ("0,-1\n255,9", "t.csv: luminance_cd_m2: -1 to 9: "),
            ("0,1\n255,inf", "t.csv: luminance_cd_m2: 1 to inf: "),
            ("0,1\n256,9", "t.csv: line 3: "),
        ] {
            let text = format!("code,luminance_cd_m2\n{rows}\n");
            let error = levels(text.as_bytes(), "t.csv").unwrap_err().to_string();
            assert!(error.starts_with(expected), "{rows}: {error}");
        }
    }
}
