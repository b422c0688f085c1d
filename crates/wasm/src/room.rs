//! What is left of memory. An allocation that fails half way takes the engine down; fronts that grow no more are only less fine. So
//! whoever needs much asks first.

use std::cell::Cell;
use std::hint::black_box;

use meshfront_hierarchies::AnySurface;

/// What any call may need beside what fronts do, bytes.
const ROOM: usize = 2 << 20;

/// Readings of the clock between two looks: each is for no more than eight updates.
const READINGS: usize = 128;
/// What eight updates take at most: slots, the record of what changed, and copies of that. Bytes.
const PER_READING: usize = 8 * 384;
/// The same of a triangle.
const PER_TRIANGLE: usize = 192;
/// A base mesh per triangle, with columns that are copied as they grow, bytes.
const PER_BASE_TRIANGLE: usize = 256;
/// Counts, bits and directories of a front per update: less than that, bytes.
const PER_UPDATE: usize = 8;
/// Position, normal, colour, level and a number to colour by.
const PER_VERTEX_COPY: usize = 12 + 8 + 4 + 1 + 4;
/// Corners.
const PER_TRIANGLE_COPY: usize = 12;
/// A front of nothing, bytes.
const FRONT: usize = 1 << 18;

/// Whether there are so many bytes, in blocks no larger than the half: no column of a front is more of it, and those grow by a
/// quarter. What is asked for is given back, but WebAssembly's memory stays as large as it has become.
fn has_room(bytes: usize) -> bool {
    let mut blocks = [const { Vec::<u8>::new() }; 3];
    let sizes = [bytes / 2, bytes / 4, bytes / 4];
    let has = blocks.iter_mut().zip(sizes).all(|(block, size)| block.try_reserve_exact(size).is_ok());
    // Or the compiler would see that nobody uses them, and not ask.
    black_box(blocks);
    has
}

/// Whether there is room for another front of the same hierarchy at the base mesh, and for what goes on beside it.
pub fn has_room_for_another(front: &dyn AnySurface) -> bool {
    let base = front.base_triangles().saturating_mul(PER_BASE_TRIANGLE);
    let updates = front.updates().saturating_mul(PER_UPDATE);
    has_room((ROOM + FRONT).saturating_add(base).saturating_add(updates))
}

/// Whether there is room for copies of so many slots. Of few there is always.
pub fn has_room_for_copies(vertices: usize, triangles: usize) -> bool {
    let bytes = vertices.saturating_mul(PER_VERTEX_COPY).saturating_add(triangles.saturating_mul(PER_TRIANGLE_COPY));
    bytes < ROOM / 4 || has_room(bytes)
}

/// Fronts that change while the engine reads the clock.
#[derive(Clone, Copy, Debug, Default)]
pub struct Growing {
    /// Of them, bytes; 0 where they are not to grow.
    bytes: usize,
    /// Triangles that any of them can take before its columns grow.
    spare: usize,
    /// Triangles of all of them when they are complete.
    most: usize,
    readings: usize,
}

impl Growing {
    /// Of these fronts.
    pub fn of<'a>(fronts: impl Iterator<Item = (&'a dyn AnySurface, usize)>) -> Growing {
        let none = Growing { spare: usize::MAX, ..Growing::default() };
        fronts.fold(none, |sum, (front, bytes)| {
            let buffers = front.buffers();
            let [most_vertices, most] = buffers.most_live();
            let (vertices, triangles) = (buffers.positions.capacity(), buffers.triangles.capacity());
            let grows = vertices < most_vertices || triangles < most;
            let spare = (triangles - buffers.live_triangles()).min(2 * (vertices - buffers.live_vertices()));
            Growing {
                bytes: sum.bytes.saturating_add(bytes),
                spare: if grows { sum.spare.min(spare) } else { sum.spare },
                most: sum.most.saturating_add(most),
                readings: 0,
            }
        })
    }
    /// The same where they stay as large as they are.
    pub fn kept(self) -> Growing {
        Growing { bytes: 0, ..self }
    }
    /// Whether there is room to go on until the next look.
    pub fn has_room(&self) -> bool {
        let triangles = 16 * (self.readings + READINGS);
        // While columns have room, that of a directory's pages may have none.
        let growth = if triangles < self.spare { self.bytes / 4 } else { self.bytes };
        let records = self.readings.saturating_mul(PER_READING).min(self.most.saturating_mul(PER_TRIANGLE));
        has_room(ROOM.saturating_add(growth).saturating_add(records))
    }
}

thread_local! {
    static GROWING: Cell<Option<Growing>> = const { Cell::new(None) };
    static IS_SHORT: Cell<bool> = const { Cell::new(false) };
}

/// From now on the clock looks whether there is room for these; `None`: no more.
pub fn watch(fronts: Option<Growing>) {
    IS_SHORT.set(false);
    GROWING.set(fronts);
}

/// Whether time is up because memory is.
pub fn is_short() -> bool {
    if let Some(mut growing) = GROWING.get() {
        growing.readings += 1;
        GROWING.set(Some(growing));
        if growing.readings.is_multiple_of(READINGS) && !growing.has_room() {
            IS_SHORT.set(true);
        }
    }
    IS_SHORT.get()
}
