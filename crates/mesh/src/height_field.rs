//! Heights over a regular grid: terrain as surveyors, satellites and image editors store it.

use glam::DVec2;

/// Samples of a height field, with where they are and what they are measured in.
///
/// Sample (column, row) lies at `origin + (column · spacing.x, −row · spacing.y)`: columns run east, rows run south, as
/// in images and maps. A height that is NaN is missing: there is no surface at that sample.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    /// Samples from west to east; at least 2.
    pub columns: u32,
    /// Samples from north to south; at least 2.
    pub rows: u32,
    /// `columns · rows` heights, row by row from the north, each row from the west; units of `vertical`. Finite or NaN.
    pub heights: Vec<f32>,
    /// Where the north-western sample is: easting and northing (longitude and latitude), units of `horizontal`.
    pub origin: DVec2,
    /// Distance between neighbouring columns and between neighbouring rows, units of `horizontal`; both positive.
    pub spacing: DVec2,
    /// What `origin` and `spacing` are measured in.
    pub horizontal: Unit,
    /// What `heights` are measured in.
    pub vertical: Unit,
    /// Where the source holds whole numbers: the difference of height that one of them makes, units of `vertical`; all
    /// heights are then whole multiples of it apart. `None` where heights are any numbers.
    pub step: Option<f32>,
}

/// What lengths are measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Nobody said; taken for metres.
    Unknown,
    /// Metres.
    Metre,
    /// International feet, 0.3048 m.
    Foot,
    /// United States survey feet, 1200/3937 m.
    UsSurveyFoot,
    /// Degrees of longitude and latitude.
    Degree,
    /// Seconds of arc, 1/3600 degree.
    ArcSecond,
}

/// Metres along a meridian per degree: one part in 360 of the mean meridian of WGS 84.
const METRES_PER_DEGREE: f64 = 111_132.95;

impl Unit {
    /// Metres in one; for angles, along a meridian.
    pub fn metres(self) -> f64 {
        match self {
            Unit::Unknown | Unit::Metre => 1.0,
            Unit::Foot => 0.3048,
            Unit::UsSurveyFoot => 1200.0 / 3937.0,
            Unit::Degree => METRES_PER_DEGREE,
            Unit::ArcSecond => METRES_PER_DEGREE / 3600.0,
        }
    }
    /// Degrees in one, if it is an angle.
    pub fn degrees(self) -> Option<f64> {
        match self {
            Unit::Degree => Some(1.0),
            Unit::ArcSecond => Some(1.0 / 3600.0),
            _ => None,
        }
    }
}

impl HeightField {
    /// The height of a sample; NaN where it is missing.
    ///
    /// # Panics
    /// Where the sample does not exist.
    pub fn height(&self, column: u32, row: u32) -> f32 {
        assert!(column < self.columns && row < self.rows, "sample {column}, {row} of {} × {}", self.columns, self.rows);
        self.heights[row as usize * self.columns as usize + column as usize]
    }

    /// Distance between neighbouring columns and rows in metres. For angles a degree of longitude is taken to be as
    /// long as it is at the middle latitude of the field (an equirectangular map: right to a part in a thousand for
    /// fields of some degrees).
    pub fn spacing_metres(&self) -> DVec2 {
        let along_parallel = match self.horizontal.degrees() {
            Some(degrees) => {
                let middle = self.origin.y - 0.5 * (self.rows as f64 - 1.0) * self.spacing.y;
                (middle * degrees).clamp(-89.0, 89.0).to_radians().cos()
            }
            None => 1.0,
        };
        self.spacing * self.horizontal.metres() * DVec2::new(along_parallel, 1.0)
    }

    /// How many samples are missing.
    pub fn missing(&self) -> usize {
        self.heights.iter().filter(|h| h.is_nan()).count()
    }
}
