//! The engine as WebAssembly: opened `.front` files with one front each. A thin shell; `web/core` wraps it for
//! TypeScript and runs it in a worker.
//!
//! All points and lengths are in mesh space and mesh units, angles in radians, times in microseconds.

mod base;
mod fly_by;
mod memory;
mod ranges;
mod room;
mod shade;

use glam::Vec3;
use meshfront_format::ReadError;
use meshfront_hierarchies::live::{Changes, TriangleBuffers};
use meshfront_hierarchies::{AnySurface, Hierarchy, Progress};
use meshfront_refine::criteria::{Max, Region, Scale, Shape, Uniform, View};
use meshfront_refine::{Camera, Criterion, Member, Outcome, Request, ViewOptions, adapt_together, view};
use wasm_bindgen::prelude::*;

pub use base::{BaseMesh, base_of};
use fly_by::FlyBy;
use memory::{Cap, Capacity};
use ranges::{coalesce, gather, slots};
use room::{Growing, has_room_for_another, has_room_for_copies};
pub use shade::{Inspection, Shade};

/// Unchanged slots that are uploaded along, as multiples of the changed ones, rather than starting another range: an upload call
/// costs as much as kilobytes, but a changed triangle is to cost no more than 64 bytes. Without any it is 20.
const SPARE: usize = 2;
/// The most ranges of one update, per kind of slot.
const MOST_RANGES: usize = 1024;

/// Which part of opening a file is unpacking it.
const UNPACKING: f32 = 0.2;

/// Less than any error that can be seen or computed, and still a number to calculate with.
const LEAST_TOLERANCE_PX: f32 = 1e-6;

#[wasm_bindgen]
extern "C" {
    /// Milliseconds of the host's monotone clock.
    #[wasm_bindgen(js_namespace = performance)]
    fn now() -> f64;
}

/// Where memory ends, so does every deadline.
fn clock_us() -> u64 {
    if room::is_short() { u64::MAX / 2 } else { (now() * 1000.0) as u64 }
}

/// Opened files with one front each, that share a budget and a deadline. Sessions know nothing of each other but the hierarchies that
/// their fronts may share: the limits of one are none of the other.
#[wasm_bindgen]
#[derive(Default)]
pub struct Session {
    /// By number; closed ones leave a hole.
    models: Vec<Option<Model>>,
    /// Of the memory of all fronts.
    cap: Option<Cap>,
    /// Time in the engine of the last call, milliseconds.
    engine_ms: f64,
}

/// A front that belongs to no session yet.
#[wasm_bindgen]
pub struct LooseFront(Box<dyn AnySurface>);

struct Model {
    front: Box<dyn AnySurface>,
    /// Everything is to be uploaded: nothing was so far.
    fresh: bool,
    /// Where it is to be looked at from in the next call: the finest counts.
    looks: Vec<Look>,
    /// Where it was looked at from last.
    seen: Vec<Look>,
    outcome: Outcome,
    byte_bound: bool,
    /// Of the page's buffers.
    capacity: Capacity,
    /// How many frames were gathered, and in which of them a vertex slot was written last.
    frames: u32,
    written: Vec<u32>,
    /// What to colour by, and whether it was asked for since the last frame.
    shade: Option<Shade>,
    shade_is_new: bool,
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

    /// Reads the bytes of a `.front` file; gives the model's number. `progress` is called with the part that is done, from 0 to 1.
    ///
    /// # Errors
    /// A JavaScript `Error` whose `name` is the kind (`not-front`, `too-new`, `damaged`) and whose message says what
    /// is wrong where, beginning with `name`.
    pub fn open(&mut self, bytes: &[u8], name: &str, progress: &js_sys::Function) -> Result<usize, js_sys::Error> {
        // What the page thinks of it is not for the reader to know.
        let mut tell = |part: f32| drop(progress.call1(&JsValue::NULL, &part.into()));
        let hierarchy = read(bytes, &mut tell).map_err(|error| {
            let js = js_sys::Error::new(&format!("{name}{}", what(&error)));
            js.set_name(kind(&error));
            js
        })?;
        Ok(self.add(hierarchy.into_front()))
    }

    /// Another front of an open model, at the base mesh, for `join` of this session or of another. They share the hierarchy.
    ///
    /// # Errors
    /// A `RangeError` where no such model is open, or there is no memory for it.
    pub fn another(&self, model: usize) -> Result<LooseFront, js_sys::RangeError> {
        let front = &*self.get(model)?.front;
        // An engine that stopped in here would keep hold of the session for ever.
        if !has_room_for_another(front) {
            return Err(js_sys::RangeError::new("no memory for another front"));
        }
        Ok(LooseFront(front.another()))
    }

    /// Takes a front in; gives its number.
    pub fn join(&mut self, front: LooseFront) -> usize {
        self.add(front.0)
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
        let front = &self.get(model)?.front;
        let (bounds, source) = (front.bounds(), front.source());
        Ok(ModelInfo {
            model: front.model().name().into(),
            updates: front.updates() as u32,
            source_vertices: source.vertices,
            source_triangles: source.triangles,
            base_triangles: front.base_triangles() as u32,
            bounds: [bounds.min.to_array(), bounds.max.to_array()].concat(),
            floor_error: front.floor_error(),
            base_error: front.base_error(),
            hierarchy_bytes: front.hierarchy_bytes() as f64,
            up: front.up().to_array().to_vec(),
            has_colors: front.has_colors(),
        })
    }

    /// Says where a model is to be looked at from in the next `adapt`; where there are several such calls for a model, the finest of
    /// them counts everywhere.
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
        let model = self.get_mut(model)?;
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
        model.looks.push(Look { view, region, tolerance_px: tolerance_px.max(LEAST_TOLERANCE_PX) });
        Ok(())
    }

    /// What the frames of a model are to be coloured by.
    ///
    /// # Errors
    /// A `RangeError` where no such model is open.
    pub fn shade(&mut self, model: usize, by: Option<Shade>) -> Result<(), js_sys::RangeError> {
        let model = self.get_mut(model)?;
        model.shade_is_new |= model.shade != by;
        model.shade = by;
        Ok(())
    }

    /// Adapts the fronts of all models that `look` was called for since the last call, what is worst in any of them
    /// first. Limits are for all models together, those included that stay as they are: `max_triangles` (`u32::MAX` for
    /// no limit), and `max_bytes` (infinite for none) for what fronts and the page's buffers take. Then ask for the `frame` of each.
    ///
    /// Where the browser gives no more memory, the call ends before its deadline, and fronts have as many triangles as they have: that
    /// counts as a budget of bytes.
    /// Where memory has to be given back, fronts start again from their base meshes, and the deadline is not kept.
    pub fn adapt(&mut self, max_triangles: u32, max_bytes: f64, deadline_us: u32) {
        let start = now();
        if !max_bytes.is_finite() {
            self.cap = None;
        } else if self.cap.is_none_or(|cap| cap.bytes() != max_bytes) {
            self.cap = Some(Cap::new(max_bytes.max(0.0)));
        }
        self.run(max_triangles, deadline_us);
        while let Some(mut cap) = self.cap {
            let (triangles, bytes) = self.held();
            if bytes <= cap.bytes() {
                let is_bound = |model: &Model| model.byte_bound && model.outcome.settled;
                if self.looked().any(|model| is_bound(model)) && cap.raise(triangles, bytes) {
                    self.looked().filter(|model| is_bound(model)).for_each(|model| model.outcome.settled = false);
                }
                self.cap = Some(cap);
                break;
            }
            cap.lower(triangles, bytes);
            self.cap = Some(cap);
            if self.looked().all(|model| model.front.applied_count() == 0) {
                break;
            }
            self.looked().for_each(Model::start_again);
            self.run(max_triangles, u32::MAX);
        }
        for model in self.looked() {
            model.seen = std::mem::take(&mut model.looks);
        }
        self.engine_ms = now() - start;
    }

    /// Flies once around a model with a front of its own, at one pixel without limits.
    ///
    /// # Errors
    /// A `RangeError` where no such model is open.
    #[wasm_bindgen(js_name = flyBy)]
    pub fn fly_by(&mut self, model: usize) -> Result<FlyBy, js_sys::RangeError> {
        Ok(fly_by::run(&*self.get(model)?.front, now))
    }

    /// What is drawn in a triangle slot as of the last `frame`; nothing where that is a free one.
    ///
    /// # Errors
    /// A `RangeError` where no such model is open.
    pub fn inspect(&self, model: usize, triangle: u32) -> Result<Option<Inspection>, js_sys::RangeError> {
        Ok(shade::inspect(&*self.get(model)?.front, triangle))
    }

    /// Spheres of the updates that would come next, four numbers each: what looks worst from where it was looked at last
    /// comes first, no more than `most`.
    ///
    /// # Errors
    /// A `RangeError` where no such model is open.
    pub fn spheres(&self, model: usize, most: usize) -> Result<Vec<f32>, js_sys::RangeError> {
        let model = self.get(model)?;
        let criterion = composed(&model.seen, 1.0);
        Ok(shade::spheres(&*model.front, &criterion, most))
    }

    /// Which frame of a model was the last one.
    ///
    /// # Errors
    /// A `RangeError` where no such model is open.
    #[wasm_bindgen(js_name = lastFrame)]
    pub fn last_frame(&self, model: usize) -> Result<u32, js_sys::RangeError> {
        Ok(self.get(model)?.frames)
    }

    /// Gathers what changed in a model since it was last asked, and forgets it.
    ///
    /// # Errors
    /// A `RangeError` where no such model is open.
    pub fn frame(&mut self, model: usize) -> Result<Frame, js_sys::RangeError> {
        let engine_ms = self.engine_ms;
        let model = self.get_mut(model)?;
        let start = now();
        model.frames += 1;
        model.capacity = model.capacity.reserve(&*model.front);
        let front_bytes = model.memory_bytes() as f64;
        let buffers = model.front.buffers_mut();
        let fresh = std::mem::take(&mut model.fresh);
        model.written.resize(buffers.positions.len(), model.frames);
        buffers.changes.vertices.iter().for_each(|&slot| model.written[slot as usize] = model.frames);
        let (vertex_ranges, triangle_ranges) = if fresh {
            (vec![0, buffers.positions.len() as u32], vec![0, buffers.triangles.len() as u32])
        } else {
            let Changes { vertices, triangles } = &mut buffers.changes;
            let ranges = (coalesce(vertices, SPARE, MOST_RANGES), coalesce(triangles, SPARE, MOST_RANGES));
            if has_room_for_copies(slots(&ranges.0), slots(&ranges.1)) {
                ranges
            } else {
                // Nothing but what changed, in however many calls.
                (coalesce(vertices, 0, usize::MAX), coalesce(triangles, 0, usize::MAX))
            }
        };
        buffers.clear_changes();
        let shade_is_new = std::mem::take(&mut model.shade_is_new);
        let changed = shade_is_new || !vertex_ranges.is_empty() || !triangle_ranges.is_empty();
        let shade = match model.shade.filter(|_| changed) {
            Some(Shade::Age) => model.written.iter().map(|&frame| (model.frames - frame) as f32).collect(),
            Some(by) => shade::column(&*model.front, by),
            None => vec![],
        };
        let TriangleBuffers { positions, normals, colors, levels, triangles, .. } = model.front.buffers();
        Ok(Frame {
            frame: model.frames,
            vertices: model.front.buffers().live_vertices() as u32,
            vertex_slots: positions.len() as u32,
            triangle_slots: triangles.len() as u32,
            capacity: model.capacity,
            positions: gather(bytemuck::cast_slice::<Vec3, [f32; 3]>(positions), &vertex_ranges),
            normals: gather(normals, &vertex_ranges),
            colors: if colors.is_empty() { vec![] } else { gather(colors, &vertex_ranges) },
            levels: gather(levels.as_chunks::<1>().0, &vertex_ranges),
            corners: gather(triangles, &triangle_ranges),
            shade,
            vertex_ranges,
            triangle_ranges,
            outcome: model.outcome,
            byte_bound: model.byte_bound,
            front_bytes,
            engine_ms,
            gather_ms: now() - start,
        })
    }
}

impl Session {
    fn add(&mut self, front: Box<dyn AnySurface>) -> usize {
        self.models.push(Some(Model {
            front,
            fresh: true,
            looks: vec![],
            seen: vec![],
            outcome: Outcome::default(),
            byte_bound: false,
            capacity: Capacity::default(),
            frames: 0,
            written: vec![],
            shade: None,
            shade_is_new: false,
        }));
        self.models.len() - 1
    }

    /// The models that `look` was called for.
    fn looked(&mut self) -> impl Iterator<Item = &mut Model> {
        self.models.iter_mut().flatten().filter(|model| !model.looks.is_empty())
    }

    /// Adapts all models that are looked at, and keeps the looks.
    fn run(&mut self, max_triangles: u32, deadline_us: u32) {
        let fronts = self.models.iter().flatten().filter(|model| !model.looks.is_empty());
        let growing = Growing::of(fronts.map(|model| (&*model.front, model.memory_bytes())));
        let full = (!growing.has_room()).then(|| self.held().0);
        let by_bytes = self.cap.map(|cap| cap.triangles()).into_iter().chain(full).min();
        let by_bytes = by_bytes.filter(|&triangles| triangles < max_triangles as usize);
        let max_cells = by_bytes.or((max_triangles != u32::MAX).then_some(max_triangles as usize));
        // One tolerance for all: where a model has a larger one, its pixels count for less.
        let looks = self.models.iter().flatten().flat_map(|model| &model.looks);
        let tolerance = looks.map(|look| look.tolerance_px).fold(f32::INFINITY, f32::min);
        let lasting = self.models.iter().flatten().filter(|model| model.looks.is_empty());
        let lasting: usize = lasting.map(|model| model.front.cells()).sum();
        let request = Request {
            tolerance,
            max_cells: max_cells.map(|most| most.saturating_sub(lasting)),
            // Without one nobody would read the clock.
            deadline_us: Some(deadline_us),
            clock: clock_us,
        };
        let criteria: Vec<Option<Box<dyn Criterion>>> = self
            .models
            .iter()
            .map(|model| match &model.as_ref()?.looks[..] {
                [] => None,
                [look] if look.is_plain(tolerance) => None,
                looks => Some(composed(looks, tolerance)),
            })
            .collect();
        let (mut members, mut outcomes): (Vec<Box<dyn Member>>, Vec<_>) = (vec![], vec![]);
        for (model, criterion) in self.models.iter_mut().zip(&criteria) {
            let Some(Model { front, looks, outcome, byte_bound, .. }) = model else { continue };
            let Some(look) = looks.first() else { continue };
            members.push(match criterion {
                Some(criterion) => front.viewed_as(&**criterion),
                None => front.viewed(&look.view),
            });
            // In pixels of the strictest of its cameras.
            let own = looks.iter().map(|look| look.tolerance_px).fold(f32::INFINITY, f32::min);
            outcomes.push((outcome, byte_bound, tolerance / own));
        }
        let mut together: Vec<&mut dyn Member> = members.iter_mut().map(|member| &mut **member as _).collect();
        room::watch(Some(if full.is_some() { growing.kept() } else { growing }));
        adapt_together(&mut together, &request);
        room::watch(None);
        for (member, (outcome, byte_bound, factor)) in together.iter().zip(outcomes) {
            *outcome = member.outcome();
            outcome.error_px /= factor;
            *byte_bound = outcome.budget_bound && by_bytes.is_some();
        }
    }

    /// Triangles of all fronts, and the bytes of what a cap is for.
    fn held(&self) -> (usize, f64) {
        let models = self.models.iter().flatten();
        models.fold((0, 0.0), |(triangles, bytes), model| {
            let front = &*model.front;
            let page = model.capacity.reserve(front).bytes(front.has_colors(), model.shade.is_some());
            (triangles + front.cells(), bytes + (model.memory_bytes() + page) as f64)
        })
    }

    fn get(&self, model: usize) -> Result<&Model, js_sys::RangeError> {
        self.models.get(model).and_then(Option::as_ref).ok_or_else(not_open)
    }
    fn get_mut(&mut self, model: usize) -> Result<&mut Model, js_sys::RangeError> {
        self.models.get_mut(model).and_then(Option::as_mut).ok_or_else(not_open)
    }
}

impl Model {
    /// Of the front and of what goes with it, bytes.
    fn memory_bytes(&self) -> usize {
        self.front.memory_bytes() + self.written.capacity() * size_of::<u32>()
    }
    /// At the base mesh, with no more memory than that needs, if there is as much beside the present one.
    fn start_again(&mut self) {
        if has_room_for_another(&*self.front) {
            self.front = self.front.another();
        } else {
            self.front.reset();
        }
        (self.fresh, self.capacity, self.written) = (true, Capacity::default(), vec![]);
    }
}

fn not_open() -> js_sys::RangeError {
    js_sys::RangeError::new("no such model is open")
}

/// The criterion of several looks at once, in pixels of a common tolerance: the finest of them counts.
fn composed(looks: &[Look], tolerance: f32) -> Box<dyn Criterion> {
    let each = looks.iter().map(|look| look.composed(tolerance));
    let nothing = || Box::new(Scale { inner: Uniform, factor: 0.0 });
    each.reduce(|a, b| Box::new(Max(a, b))).unwrap_or_else(|| nothing())
}

impl Look {
    /// Whether it is the criterion of a camera and nothing more.
    fn is_plain(&self, tolerance: f32) -> bool {
        self.region.is_none() && self.tolerance_px == tolerance
    }
    fn composed(&self, tolerance: f32) -> Box<dyn Criterion> {
        let (inside, factor) = (self.view, tolerance / self.tolerance_px);
        match self.region {
            Some((shape, error)) => {
                // In units of the tolerance, so that one threshold serves both sides.
                let outside = Scale { inner: Uniform, factor: self.tolerance_px / error.max(f32::MIN_POSITIVE) };
                Box::new(Scale { inner: Region { shape, inside, outside }, factor })
            }
            None => Box::new(Scale { inner: inside, factor }),
        }
    }
}

/// Numbers of an opened model. Points and lengths in mesh units.
#[wasm_bindgen(getter_with_clone)]
pub struct ModelInfo {
    /// The model's name, as in files.
    pub model: String,
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
    /// The error of the base mesh.
    #[wasm_bindgen(js_name = baseError)]
    pub base_error: f32,
    /// Memory of the hierarchy, which all its fronts share.
    #[wasm_bindgen(js_name = hierarchyBytes)]
    pub hierarchy_bytes: f64,
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
    frame: u32,
    vertices: u32,
    capacity: Capacity,
    shade: Vec<f32>,
    byte_bound: bool,
    front_bytes: f64,
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
    /// Counts the frames of the model.
    #[wasm_bindgen(getter)]
    pub fn frame(&self) -> u32 {
        self.frame
    }
    /// Live vertices.
    #[wasm_bindgen(getter)]
    pub fn vertices(&self) -> u32 {
        self.vertices
    }
    /// How many vertex slots the page's buffers are to have. Where there are fewer than before, this frame holds every slot.
    #[wasm_bindgen(getter, js_name = vertexCapacity)]
    pub fn vertex_capacity(&self) -> u32 {
        self.capacity.vertices as u32
    }
    /// The same of triangle slots.
    #[wasm_bindgen(getter, js_name = triangleCapacity)]
    pub fn triangle_capacity(&self) -> u32 {
        self.capacity.triangles as u32
    }
    /// 1 number per vertex slot, changed or not; none where nothing was asked for, or nothing changed.
    #[wasm_bindgen(js_name = takeShade)]
    pub fn take_shade(&mut self) -> Vec<f32> {
        std::mem::take(&mut self.shade)
    }
    /// Whether it is the budget of bytes that keeps the front from its tolerance.
    #[wasm_bindgen(getter, js_name = byteBound)]
    pub fn byte_bound(&self) -> bool {
        self.byte_bound
    }
    /// Memory of the front in the engine, bytes.
    #[wasm_bindgen(getter, js_name = frontBytes)]
    pub fn front_bytes(&self) -> f64 {
        self.front_bytes
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
fn read(bytes: &[u8], tell: Progress) -> Result<Hierarchy, ReadError> {
    let stored = meshfront_format::decode(bytes, "")?;
    // Unpacking takes a fifth of the time, checking and deriving the rest.
    tell(UNPACKING);
    let mut checked = |part: f32| tell(UNPACKING + (1.0 - UNPACKING) * part);
    Hierarchy::with_progress(stored, &mut checked)
        .map_err(|source| ReadError::Hierarchy { file: String::new(), source })
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
        let other = read(b"ply\nformat ascii 1.0\n", &mut |_| {}).unwrap_err();
        assert_eq!((kind(&other), &*what(&other)), ("not-front", ": not a .front file"));
    }
}
