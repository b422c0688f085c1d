//! What a front is made of: columns to colour by, what is drawn in a triangle, and the spheres of what would come next.

use glam::Vec3;
use meshfront_hierarchies::AnySurface;
use meshfront_refine::Criterion;
use std::collections::HashMap;
use wasm_bindgen::prelude::*;

/// What to colour by: a number per vertex slot.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// How far the original surface may be from what is drawn there, mesh units.
    Error = 0,
    /// Half angle of the normals of all that lies below, radians.
    Cone = 1,
    /// Frames since the slot was last written.
    Age = 2,
}

/// A column of a front, other than ages. Of the triangles around a vertex the worst counts.
pub fn column(front: &dyn AnySurface, by: Shade) -> Vec<f32> {
    let least = match by {
        Shade::Error => front.floor_error(),
        Shade::Cone | Shade::Age => 0.0,
    };
    let buffers = front.buffers();
    let mut column = vec![least; buffers.positions.len()];
    for (slot, t) in buffers.triangles.iter().enumerate() {
        // A free slot has none either.
        let Some(next) = front.next_at(slot as u32) else { continue };
        let footprint = front.footprint(next);
        let value = match by {
            Shade::Error => footprint.error,
            Shade::Cone | Shade::Age => half_angle(footprint.cone.cos),
        };
        for &v in t {
            column[v as usize] = column[v as usize].max(value);
        }
    }
    column
}

fn half_angle(cos: f32) -> f32 {
    // A cone that culls nothing is stored as one of all directions.
    if cos <= 0.0 { std::f32::consts::PI } else { cos.min(1.0).acos() }
}

/// What is drawn in a triangle.
#[wasm_bindgen(getter_with_clone)]
pub struct Inspection {
    /// The update that would replace it; none where it is one of the source's.
    pub update: Option<u32>,
    /// How far the original surface may be from it, mesh units.
    pub error: f32,
    /// Splits between it and the base mesh: of its finest corner.
    pub level: u8,
    /// Half angle of the normals below, radians.
    #[wasm_bindgen(js_name = coneAngle)]
    pub cone_angle: f32,
    /// Centre and radius of the update's sphere: four numbers.
    pub sphere: Vec<f32>,
}

/// `None` where there is no such triangle.
pub fn inspect(front: &dyn AnySurface, triangle: u32) -> Option<Inspection> {
    let buffers = front.buffers();
    let corners = buffers.live_triangle(triangle)?;
    let level = corners.iter().map(|&v| buffers.levels[v as usize]).max().unwrap_or_default();
    let next = front.next_at(triangle);
    Some(match next.map(|m| front.footprint(m)) {
        Some(f) => Inspection {
            update: next.map(|m| m.0),
            error: f.error,
            level,
            cone_angle: half_angle(f.cone.cos),
            sphere: f.center.extend(f.radius).to_array().to_vec(),
        },
        None => {
            let [a, b, c] = corners.map(|v| buffers.positions[v as usize]);
            let center = (a + b + c) / 3.0;
            let radius = [a, b, c].map(|p: Vec3| p.distance(center)).into_iter().fold(0.0, f32::max);
            let sphere = center.extend(radius).to_array().to_vec();
            Inspection { update: None, error: front.floor_error(), level, cone_angle: 0.0, sphere }
        }
    })
}

/// Spheres of the updates that would come next, four numbers each: what looks worst first, no more than `most`.
pub fn spheres(front: &dyn AnySurface, criterion: &dyn Criterion, most: usize) -> Vec<f32> {
    let slots = 0..front.buffers().triangles.len() as u32;
    let mut next: HashMap<_, _> = HashMap::new();
    for m in slots.filter_map(|slot| front.next_at(slot)) {
        next.entry(m).or_insert_with(|| {
            let footprint = front.footprint(m);
            (criterion.pixels(&footprint), footprint.center.extend(footprint.radius))
        });
    }
    let mut next: Vec<_> = next.into_iter().collect();
    next.sort_unstable_by(|(m, (a, _)), (n, (b, _))| b.total_cmp(a).then(m.cmp(n)));
    next.into_iter().take(most).flat_map(|(_, (_, sphere))| sphere.to_array()).collect()
}
