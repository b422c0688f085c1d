//! Heights over a regular grid: terrain as surveyors, satellites and image editors store it.

use crate::{TriangleMesh, VertexId};
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

    /// The surface over all samples, in mesh space: x metres to the east of the south-western sample, y to the north, z
    /// the height in metres times the exaggeration. Each cell of four samples is cut through those of its corners whose
    /// column and row from the south add up to an even number; triangles with a missing corner are left out.
    pub fn to_mesh(&self, exaggeration: f32) -> TriangleMesh {
        let (columns, rows) = (self.columns, self.rows);
        let spacing = self.spacing_metres();
        let scale = self.vertical.metres() * exaggeration as f64;
        let mut vertex = vec![u32::MAX; self.heights.len()];
        let mut mesh = TriangleMesh::default();
        let mut push = |corners: [[u32; 2]; 3]| {
            if corners.iter().any(|&[x, y]| self.height(x, rows - 1 - y).is_nan()) {
                return;
            }
            let triangle = corners.map(|[x, y]| {
                let v = &mut vertex[(y * columns + x) as usize];
                if *v == u32::MAX {
                    *v = mesh.positions.len() as u32;
                    let ground = DVec2::new(x as f64, y as f64) * spacing;
                    let height = self.height(x, rows - 1 - y) as f64 * scale;
                    mesh.positions.push(ground.extend(height).as_vec3());
                }
                VertexId(*v)
            });
            mesh.triangles.push(triangle);
        };
        for y in 0..rows - 1 {
            for x in 0..columns - 1 {
                let [sw, se, nw, ne] = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
                let cut = if (x + y) % 2 == 0 { [[sw, se, ne], [sw, ne, nw]] } else { [[sw, se, nw], [se, ne, nw]] };
                cut.into_iter().for_each(&mut push);
            }
        }
        mesh
    }

    /// How many samples are missing.
    pub fn missing(&self) -> usize {
        self.heights.iter().filter(|h| h.is_nan()).count()
    }
}
