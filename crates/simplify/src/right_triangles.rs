//! Terrain: heights to a hierarchy of right triangles. There is nothing to simplify, since the order of cuts is given:
//! heights are put into mesh units and quantized, and [`RightTriangles`] finds the errors.

use crate::{BuildError, Progress};
use meshfront_hierarchies::RightTriangles;
use meshfront_hierarchies::right_triangles::{Columns, Place, Steps};
use meshfront_mesh::HeightField;
use rayon::prelude::*;

/// How to build.
#[derive(Clone, Debug)]
pub struct RightTrianglesOptions {
    /// Bits per height, 10 to 24; `None` keeps heights as they are. Whole numbers that need no more bits are kept exactly.
    pub bits: Option<u32>,
    /// How many times too high to make the mesh; positive.
    pub exaggeration: f32,
}

impl Default for RightTrianglesOptions {
    fn default() -> Self {
        RightTrianglesOptions { bits: Some(16), exaggeration: 1.0 }
    }
}

/// Builds the hierarchy of a terrain. See [`RightTriangles::new`] for what it costs.
///
/// # Errors
/// An unusable height field or option; or [`BuildError::Cancelled`].
pub fn right_triangles(
    field: &HeightField,
    options: &RightTrianglesOptions,
    progress: &dyn Progress,
) -> Result<RightTriangles, BuildError> {
    let columns = right_triangles_columns(field, options)?;
    if progress.cancelled() {
        return Err(BuildError::Cancelled);
    }
    progress.phase("measure", "samples", columns.heights.len() as u64);
    Ok(RightTriangles::new(columns)?)
}

/// What is stored of the hierarchy of a terrain: heights in mesh units, quantized.
///
/// # Errors
/// An unusable option.
pub fn right_triangles_columns(field: &HeightField, options: &RightTrianglesOptions) -> Result<Columns, BuildError> {
    if let Some(bits) = options.bits.filter(|b| !(10..=24).contains(b)) {
        return Err(BuildError::Bits(bits));
    }
    let exaggeration = options.exaggeration;
    if !(exaggeration > 0.0 && exaggeration.is_finite()) {
        return Err(BuildError::Exaggeration(exaggeration));
    }
    let scale = field.vertical.metres() * exaggeration as f64;
    // `min` and `max` pass over what is missing.
    let (low, high) = (field.heights.par_iter())
        .fold(|| (f32::MAX, f32::MIN), |(low, high), &h| (h.min(low), h.max(high)))
        .reduce(|| (f32::MAX, f32::MIN), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    let range = (high as f64 - low as f64).max(0.0);
    let (steps, exact) = match (options.bits, field.step) {
        (None, _) => (None, true),
        (Some(bits), Some(step)) if range / (step as f64) < (1u64 << bits) as f64 => {
            (Some(Steps { zero: low as f64 * scale, step: step as f64 * scale }), true)
        }
        (Some(bits), _) => {
            let step = (range / ((1u64 << bits) - 1) as f64).max(1e-6 * (low.abs().max(high.abs()) as f64)).max(1e-9);
            (Some(Steps { zero: low as f64 * scale, step: step * scale }), false)
        }
    };
    let mesh_height = |h: f32| {
        let height = (h as f64 * scale) as f32;
        steps.map_or(height, |s| if h.is_nan() { h } else { s.height(s.nearest(height)) })
    };
    let columns = field.columns.max(1) as usize;
    let mut heights = vec![0f32; field.heights.len()];
    let rows = heights.par_chunks_exact_mut(columns).zip(field.heights.par_chunks_exact(columns).rev());
    rows.for_each(|(ours, theirs)| ours.iter_mut().zip(theirs).for_each(|(ours, &h)| *ours = mesh_height(h)));
    let south = field.spacing.y * (field.rows as f64 - 1.0);
    Ok(Columns {
        columns: field.columns,
        rows: field.rows,
        spacing: field.spacing_metres(),
        heights,
        steps,
        // Half a step, and the rounding to 32 bits.
        floor_error: match steps {
            Some(s) if !exact => {
                (0.5 * s.step) as f32 * 1.001 + 1e-7 * (low.abs().max(high.abs()) as f64 * scale) as f32
            }
            _ => 0.0,
        },
        place: Place {
            origin: glam::DVec2::new(field.origin.x, field.origin.y - south),
            horizontal: field.horizontal,
            spacing: field.spacing,
            vertical: field.vertical,
            exaggeration,
        },
    })
}
