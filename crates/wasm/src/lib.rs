//! The engine as WebAssembly: opened `.front` files with one front each. A thin shell; `web/core` wraps it for
//! TypeScript and runs it in a worker.
//!
//! All points and lengths are in mesh space and mesh units, angles in radians, times in microseconds.

mod fly_by;
mod ranges;

use glam::Vec3;
use meshfront_format::ReadError;
use meshfront_hierarchies::live::TriangleBuffers;
use meshfront_hierarchies::{AnySurface, Hierarchy};
use meshfront_refine::criteria::{Region, Scale, Shape, Uniform, View};
use meshfront_refine::{Camera, Criterion, Member, Outcome, Request, ViewOptions, adapt_together, view};
use wasm_bindgen::prelude::*;

use fly_by::FlyBy;
use ranges::{coalesce, gather};

/// Unchanged vertex slots (28 bytes each) and triangle slots (12 bytes) that are uploaded along rather than
/// starting another range: about a kilobyte, what an upload call costs beside its bytes.
const VERTEX_GAP: u32 = 32;
const TRIANGLE_GAP: u32 = 96;
/// The most ranges of one update, per kind of slot.
const MOST_RANGES: usize = 512;

/// Less than any error that can be seen or computed, and still a number to calculate with.
const LEAST_TOLERANCE_PX: f32 = 1e-6;

#[wasm_bindgen]
extern "C" {
    /// Milliseconds of the host's monotone clock.
    #[wasm_bindgen(js_namespace = performance)]
    fn now() -> f64;
}

fn clock_us() -> u64 {
    (now() * 1000.0) as u64
}

/// Opened files with one front each, that share a budget and a deadline.
#[wasm_bindgen]
#[derive(Default)]
pub struct Session {
    /// By number; closed ones leave a hole.
    models: Vec<Option<Model>>,
    /// Time in the engine of the last call, milliseconds.
    engine_ms: f64,
}

struct Model {
    front: Box<dyn AnySurface>,
    /// Everything is to be uploaded: nothing was so far.
    fresh: bool,
    /// Where it is to be looked at from in the next call.
    look: Option<Look>,
    outcome: Outcome,
}

struct Look {
    view: View,
    /// Shape, and the error that is allowed outside of it.
    region: Option<(Shape, f32)>,
    tolerance_px: f32,
}

#[wasm_bindgen]
impl Session {
    /// Without any model.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Session {
        Session::default()
    }

    /// Reads the bytes of a `.front` file; gives the model's number.
    ///
    /// # Errors
    /// A JavaScript `Error` whose `name` is the kind (`not-front`, `too-new`, `damaged`) and whose message says what
    /// is wrong where, beginning with `name`.
    pub fn open(&mut self, bytes: &[u8], name: &str) -> Result<usize, js_sys::Error> {
        let hierarchy = read(bytes).map_err(|error| {
            let js = js_sys::Error::new(&format!("{name}{}", what(&error)));
            js.set_name(kind(&error));
            js
        })?;
        let model = Model { front: hierarchy.into_front(), fresh: true, look: None, outcome: Outcome::default() };
        self.models.push(Some(model));
        Ok(self.models.len() - 1)
    }

    /// Forgets a model. Its number is not given again.
    pub fn close(&mut self, model: usize) {
        if let Some(model) = self.models.get_mut(model) {
            *model = None;
        }
    }

    /// Numbers of a model.
    ///
    /// # Errors
    /// A `RangeError` where no such model is open.
    pub fn info(&self, model: usize) -> Result<ModelInfo, js_sys::RangeError> {
        let front = &self.models.get(model).and_then(Option::as_ref).ok_or_else(not_open)?.front;
        let (bounds, source) = (front.bounds(), front.source());
        Ok(ModelInfo {
            updates: front.updates() as u32,
            source_vertices: source.vertices,
            source_triangles: source.triangles,
            base_triangles: front.base_triangles() as u32,
            bounds: [bounds.min.to_array(), bounds.max.to_array()].concat(),
            floor_error: front.floor_error(),
            up: front.up().to_array().to_vec(),
            has_colors: front.has_colors(),
        })
    }

    /// Says where a model is to be looked at from in the next `adapt`.
    ///
    /// - `camera`, in the model's own space: eye, target, up (3 numbers each), vertical field of view, width and height in pixels,
    ///   near plane;
    /// - `region`: empty, or a sphere (centre, radius) or a box (least, greatest corner) and then the error that is
    ///   allowed outside of it: 5 or 7 numbers.
    ///
    /// # Errors
    /// A `RangeError` where `camera` or `region` has another length, or no such model is open.
    pub fn look(
        &mut self,
        model: usize,
        camera: &[f32],
        tolerance_px: f32,
        frustum: bool,
        orientation: bool,
        region: &[f32],
    ) -> Result<(), js_sys::RangeError> {
        let model = self.model(model)?;
        let camera = camera_of(camera).ok_or_else(|| js_sys::RangeError::new("a camera has 13 numbers"))?;
        let region = match *region {
            [] => None,
            [x, y, z, radius, error] => Some((Shape::Sphere { center: Vec3::new(x, y, z), radius }, error)),
            [x0, y0, z0, x1, y1, z1, error] => {
                Some((Shape::Box { min: Vec3::new(x0, y0, z0), max: Vec3::new(x1, y1, z1) }, error))
            }
            _ => return Err(js_sys::RangeError::new("a region has 5 or 7 numbers")),
        };
        let view = view(&camera, ViewOptions { frustum, orientation, outside: None });
        // A tolerance of 0 would leave no unit to measure the outside of a region in.
        model.look = Some(Look { view, region, tolerance_px: tolerance_px.max(LEAST_TOLERANCE_PX) });
        Ok(())
    }

    /// Adapts the fronts of all models that `look` was called for since the last call, what is worst in any of them
    /// first. `max_triangles` (`u32::MAX` for no limit) is for all models together, those included that stay as they
    /// are. Then ask for the `frame` of each.
    pub fn adapt(&mut self, max_triangles: u32, deadline_us: u32) {
        let looks: Vec<Option<Look>> =
            self.models.iter_mut().map(|model| model.as_mut().and_then(|model| model.look.take())).collect();
        // One tolerance for all: where a model has a larger one, its pixels count for less.
        let tolerance = looks.iter().flatten().map(|look| look.tolerance_px).fold(f32::INFINITY, f32::min);
        let lasting = self.models.iter().zip(&looks).filter(|(_, look)| look.is_none());
        let lasting: usize = lasting.filter_map(|(model, _)| model.as_ref()).map(|model| model.front.cells()).sum();
        let request = Request {
            tolerance,
            max_cells: (max_triangles != u32::MAX).then(|| (max_triangles as usize).saturating_sub(lasting)),
            deadline_us: Some(deadline_us),
            clock: clock_us,
        };
        let criteria: Vec<Option<Box<dyn Criterion>>> =
            looks.iter().map(|look| look.as_ref().and_then(|look| look.composed(tolerance))).collect();

        let start = now();
        let mut members: Vec<Box<dyn Member>> = vec![];
        let mut outcomes = vec![];
        for ((model, look), criterion) in self.models.iter_mut().zip(&looks).zip(&criteria) {
            if let (Some(Model { front, outcome, .. }), Some(look)) = (model, look) {
                members.push(match criterion {
                    Some(criterion) => front.viewed_as(&**criterion),
                    None => front.viewed(&look.view),
                });
                outcomes.push((outcome, look.factor(tolerance)));
            }
        }
        let mut together: Vec<&mut dyn Member> = members.iter_mut().map(|member| &mut **member as _).collect();
        adapt_together(&mut together, &request);
        for (member, (outcome, factor)) in together.iter().zip(outcomes) {
            *outcome = member.outcome();
            outcome.error_px /= factor;
        }
        self.engine_ms = now() - start;
    }

    /// Flies once around a model with a front of its own, at one pixel without limits.
    ///
    /// # Errors
    /// A `RangeError` where no such model is open.
    #[wasm_bindgen(js_name = flyBy)]
    pub fn fly_by(&mut self, model: usize) -> Result<FlyBy, js_sys::RangeError> {
        Ok(fly_by::run(&*self.model(model)?.front, now))
    }

    /// Gathers what changed in a model since it was last asked, and forgets it.
    ///
    /// # Errors
    /// A `RangeError` where no such model is open.
    pub fn frame(&mut self, model: usize) -> Result<Frame, js_sys::RangeError> {
        let engine_ms = self.engine_ms;
        let model = self.model(model)?;
        let start = now();
        let buffers = model.front.buffers_mut();
        let (vertex_ranges, triangle_ranges) = if std::mem::take(&mut model.fresh) {
            (vec![0, buffers.positions.len() as u32], vec![0, buffers.triangles.len() as u32])
        } else {
            (
                coalesce(&mut buffers.changes.vertices, VERTEX_GAP, MOST_RANGES),
                coalesce(&mut buffers.changes.triangles, TRIANGLE_GAP, MOST_RANGES),
            )
        };
        buffers.clear_changes();
        let TriangleBuffers { positions, normals, colors, levels, triangles, .. } = buffers;
        Ok(Frame {
            vertex_slots: positions.len() as u32,
            triangle_slots: triangles.len() as u32,
            positions: gather(bytemuck::cast_slice::<Vec3, [f32; 3]>(positions), &vertex_ranges),
            normals: gather(normals, &vertex_ranges),
            colors: if colors.is_empty() { vec![] } else { gather(colors, &vertex_ranges) },
            levels: gather(levels.as_chunks::<1>().0, &vertex_ranges),
            corners: gather(triangles, &triangle_ranges),
            vertex_ranges,
            triangle_ranges,
            outcome: model.outcome,
            engine_ms,
            gather_ms: now() - start,
        })
    }

    fn model(&mut self, model: usize) -> Result<&mut Model, js_sys::RangeError> {
        self.models.get_mut(model).and_then(Option::as_mut).ok_or_else(not_open)
    }
}

fn not_open() -> js_sys::RangeError {
    js_sys::RangeError::new("no such model is open")
}

impl Look {
    /// What its pixels are multiplied with, where the common tolerance is this one.
    fn factor(&self, tolerance: f32) -> f32 {
        tolerance / self.tolerance_px
    }
    /// The criterion, where it is more than that of the camera.
    fn composed(&self, tolerance: f32) -> Option<Box<dyn Criterion>> {
        let (inside, factor) = (self.view, self.factor(tolerance));
        Some(match self.region {
            Some((shape, error)) => {
                // In units of the tolerance, so that one threshold serves both sides.
                let outside = Scale { inner: Uniform, factor: self.tolerance_px / error.max(f32::MIN_POSITIVE) };
                Box::new(Scale { inner: Region { shape, inside, outside }, factor })
            }
            None if factor != 1.0 => Box::new(Scale { inner: inside, factor }),
            None => return None,
        })
    }
}

/// Numbers of an opened model. Points and lengths in mesh units.
#[wasm_bindgen(getter_with_clone)]
pub struct ModelInfo {
    /// Number of updates.
    pub updates: u32,
    /// Vertices of the source, after cleaning.
    #[wasm_bindgen(js_name = sourceVertices)]
    pub source_vertices: u32,
    /// Triangles of the source, after cleaning.
    #[wasm_bindgen(js_name = sourceTriangles)]
    pub source_triangles: u32,
    /// Triangles of the base mesh.
    #[wasm_bindgen(js_name = baseTriangles)]
    pub base_triangles: u32,
    /// Least and greatest corner of the box of all vertices of all levels: six numbers.
    pub bounds: Vec<f32>,
    /// The error that is left with every update applied.
    #[wasm_bindgen(js_name = floorError)]
    pub floor_error: f32,
    /// Which way is up: a unit vector.
    pub up: Vec<f32>,
    /// Whether there are colours.
    #[wasm_bindgen(js_name = hasColors)]
    pub has_colors: bool,
}

/// What one call did: counters, and copies of the slots that changed. Columns are taken once and leave nothing
/// behind. Ranges are pairs (first slot, number of slots), ascending and apart.
#[wasm_bindgen]
pub struct Frame {
    vertex_slots: u32,
    triangle_slots: u32,
    vertex_ranges: Vec<u32>,
    triangle_ranges: Vec<u32>,
    positions: Vec<f32>,
    normals: Vec<i16>,
    colors: Vec<u8>,
    levels: Vec<u8>,
    corners: Vec<u32>,
    outcome: Outcome,
    engine_ms: f64,
    gather_ms: f64,
}

#[wasm_bindgen]
impl Frame {
    /// Vertex slots in use, free ones between them included.
    #[wasm_bindgen(getter, js_name = vertexSlots)]
    pub fn vertex_slots(&self) -> u32 {
        self.vertex_slots
    }
    /// Triangle slots in use, free ones between them included.
    #[wasm_bindgen(getter, js_name = triangleSlots)]
    pub fn triangle_slots(&self) -> u32 {
        self.triangle_slots
    }
    /// Changed vertex slots.
    #[wasm_bindgen(js_name = takeVertexRanges)]
    pub fn take_vertex_ranges(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.vertex_ranges)
    }
    /// Changed triangle slots.
    #[wasm_bindgen(js_name = takeTriangleRanges)]
    pub fn take_triangle_ranges(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.triangle_ranges)
    }
    /// 3 numbers per changed vertex slot.
    #[wasm_bindgen(js_name = takePositions)]
    pub fn take_positions(&mut self) -> Vec<f32> {
        std::mem::take(&mut self.positions)
    }
    /// 4 numbers per changed vertex slot: a unit vector times 32767, and 0.
    #[wasm_bindgen(js_name = takeNormals)]
    pub fn take_normals(&mut self) -> Vec<i16> {
        std::mem::take(&mut self.normals)
    }
    /// 4 numbers per changed vertex slot, or none where there are no colours.
    #[wasm_bindgen(js_name = takeColors)]
    pub fn take_colors(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.colors)
    }
    /// 1 number per changed vertex slot: splits between it and the base mesh, up to 255.
    #[wasm_bindgen(js_name = takeLevels)]
    pub fn take_levels(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.levels)
    }
    /// 3 vertex slots per changed triangle slot; a free one holds 0, 0, 0.
    #[wasm_bindgen(js_name = takeCorners)]
    pub fn take_corners(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.corners)
    }
    /// Triangles of the front.
    #[wasm_bindgen(getter)]
    pub fn triangles(&self) -> u32 {
        self.outcome.cells as u32
    }
    /// Updates applied.
    #[wasm_bindgen(getter)]
    pub fn refined(&self) -> u32 {
        self.outcome.refined
    }
    /// Updates undone.
    #[wasm_bindgen(getter)]
    pub fn coarsened(&self) -> u32 {
        self.outcome.coarsened
    }
    /// How often the criterion was asked.
    #[wasm_bindgen(getter)]
    pub fn evaluations(&self) -> u32 {
        self.outcome.evaluations
    }
    /// Whether nothing is left to do for this view.
    #[wasm_bindgen(getter)]
    pub fn settled(&self) -> bool {
        self.outcome.settled
    }
    /// Whether the triangle budget keeps the front from its tolerance.
    #[wasm_bindgen(getter, js_name = budgetBound)]
    pub fn budget_bound(&self) -> bool {
        self.outcome.budget_bound
    }
    /// A bound on how wrong the front looks.
    #[wasm_bindgen(getter, js_name = errorPx)]
    pub fn error_px(&self) -> f32 {
        self.outcome.error_px
    }
    /// Time in the engine, milliseconds.
    #[wasm_bindgen(getter, js_name = engineMs)]
    pub fn engine_ms(&self) -> f64 {
        self.engine_ms
    }
    /// Time to gather what changed, milliseconds.
    #[wasm_bindgen(getter, js_name = gatherMs)]
    pub fn gather_ms(&self) -> f64 {
        self.gather_ms
    }
}

/// Errors call the file nothing: `what` tells why.
fn read(bytes: &[u8]) -> Result<Hierarchy, ReadError> {
    let stored = meshfront_format::decode(bytes, "")?;
    Hierarchy::new(stored).map_err(|source| ReadError::Hierarchy { file: String::new(), source })
}

fn camera_of(numbers: &[f32]) -> Option<Camera> {
    let numbers: &[f32; 13] = numbers.try_into().ok()?;
    let vec3 = |i: usize| Vec3::new(numbers[i], numbers[i + 1], numbers[i + 2]);
    let [.., fov_y, width_px, height_px, near] = *numbers;
    Some(Camera { eye: vec3(0), target: vec3(3), up: vec3(6), fov_y, width_px, height_px, near })
}

/// The reader's message without its advice, which is for a terminal: `web/core/src/errors.ts` has that for a page.
/// Both are one sentence, the advice after the first semicolon; a file's name might hold one too.
fn what(error: &ReadError) -> String {
    let message = error.to_string();
    message.split_once("; ").map_or(&*message, |(what, _)| what).to_owned()
}

/// The kind of error, in the words of `web/core/src/errors.ts`.
fn kind(error: &ReadError) -> &'static str {
    match error {
        ReadError::NotFront { .. } => "not-front",
        ReadError::NewerVersion { .. } | ReadError::UnknownModel { .. } | ReadError::UnknownPart { .. } => "too-new",
        ReadError::Io { .. } | ReadError::Length { .. } | ReadError::Damaged { .. } | ReadError::Hierarchy { .. } => {
            "damaged"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_keep_the_place_and_leave_the_advice_to_the_page() {
        let file = String::new;
        let damaged = ReadError::Damaged { file: file(), section: "UPDT", offset: 2096, reason: "checksum is wrong" };
        assert_eq!(what(&damaged), ": section `UPDT`, byte 2096: checksum is wrong");
        let newer = ReadError::NewerVersion { file: file(), found: 9, known: 1 };
        assert_eq!((kind(&newer), what(&newer).contains("version 9")), ("too-new", true));
        let other = read(b"ply\nformat ascii 1.0\n").unwrap_err();
        assert_eq!((kind(&other), &*what(&other)), ("not-front", ": not a .front file"));
    }
}
