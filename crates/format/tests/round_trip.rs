//! What is written is what is read.

mod common;

use common::{Shape, plausible};
use glam::{DVec3, Vec3};
use meshfront_format::edge_collapse::{PAGE_UPDATES, decode, encode, inspect};
use meshfront_format::{EncodeError, round_error_up};
use meshfront_hierarchies::edge_collapse::{AddedTriangle, Columns, ExplicitSplit, Grid, InvalidColumns, Oct};
use meshfront_hierarchies::{EdgeCollapse, SourceCounts};
use meshfront_mesh::{TriangleMesh, VertexColumns, VertexId, sample};
use meshfront_refine::UpdateId;
use meshfront_simplify::{EdgeCollapseOptions, edge_collapse};
use proptest::collection::vec;
use proptest::prelude::*;

#[test]
fn all_kinds_of_columns_come_back() {
    for bits in [None, Some(10), Some(16), Some(24)] {
        for flags in 0..8 {
            for updates in [0, 1, 300] {
                let attributes = updates > 0;
                let (normals, colors) = (attributes && flags & 1 != 0, attributes && flags & 2 != 0);
                let columns = plausible(Shape { updates, bits, normals, colors, explicit: flags & 4 != 0 }, 7);
                let bytes = encode(&columns).unwrap();
                assert_eq!(decode(&bytes, "test").unwrap(), columns);
            }
        }
    }
}

#[test]
fn pages_join_without_a_seam() {
    for updates in [PAGE_UPDATES - 1, PAGE_UPDATES, PAGE_UPDATES + 1, 3 * PAGE_UPDATES + 17] {
        let shape = Shape { updates, bits: Some(14), normals: true, colors: true, explicit: true };
        let columns = plausible(shape, 1);
        let bytes = encode(&columns).unwrap();
        assert_eq!(decode(&bytes, "test").unwrap(), columns);
        let info = inspect(&bytes, "test").unwrap();
        assert_eq!(info.pages.len(), updates.div_ceil(PAGE_UPDATES));
        assert_eq!(info.pages.iter().map(|p| p.updates as usize).sum::<usize>(), updates);
    }
}

#[test]
fn hierarchies_of_meshes_come_back() {
    for sample in sample::Sample::ALL {
        for (bits, painted) in [(Some(12), false), (Some(16), true), (None, true)] {
            let mut mesh = sample.make(2000);
            if painted {
                sample::paint(&mut mesh);
            }
            let options = EdgeCollapseOptions { bits, base_triangles: 100 };
            let columns = edge_collapse(&mesh, &options, &()).unwrap().columns();
            let bytes = encode(&columns).unwrap();
            let read = decode(&bytes, "test").unwrap();
            assert_eq!(read, columns, "{} with {bits:?}: built and read must not differ in a bit", sample.name());
            EdgeCollapse::new(read).unwrap();
        }
    }
}

/// A page of the table says what it takes to be that wrong; a column's bytes add up.
#[test]
fn inspecting_agrees_with_the_columns() {
    let shape = Shape { updates: 2 * PAGE_UPDATES + 5, bits: Some(16), normals: true, colors: false, explicit: true };
    let columns = plausible(shape, 3);
    let bytes = encode(&columns).unwrap();
    let info = inspect(&bytes, "test").unwrap();
    for page in &info.pages {
        let range = page.first_update as usize..(page.first_update + page.updates) as usize;
        assert_eq!(page.max_error.unwrap(), columns.errors[range].iter().copied().fold(0.0, f32::max));
    }
    assert_eq!((info.bits, info.updates, info.normals, info.colors), (Some(16), shape.updates as u32, true, false));
    assert_eq!(info.base_error.unwrap(), columns.errors.iter().copied().fold(0.0, f32::max));
    assert_eq!(info.sections.iter().map(|s| s.bytes).sum::<u64>() + 56 + 32 * info.sections.len() as u64, info.bytes);
    assert_eq!(info.pages[0].offset, info.head_bytes);
    let first_pages = info.sections.iter().find(|s| s.name == "UPDT").unwrap();
    assert_eq!(info.pages.iter().map(|p| p.bytes).sum::<u64>(), first_pages.bytes);
    assert_eq!(info.columns.last().unwrap().name, "normals");
}

/// Header, tables and base mesh of a scan of 430k vertices fit into a first request; nine bytes a vertex hold it all.
#[test]
fn large_files_start_small_and_stay_small() {
    let shape = Shape { updates: 430_000, bits: Some(16), normals: false, colors: false, explicit: false };
    let columns = plausible(shape, 2);
    let info = inspect(&encode(&columns).unwrap(), "test").unwrap();
    // The test's base mesh is tiny: allow for 300 triangles and 152 vertices as they are in memory.
    assert!(info.head_bytes + 300 * 12 + 152 * 12 < 18_000, "{} bytes", info.head_bytes);
    assert!(info.bytes < 9 * info.source_vertices as u64, "{} bytes", info.bytes);
}

#[test]
fn the_same_columns_give_the_same_bytes_on_any_number_of_threads() {
    let shape = Shape { updates: 20_000, bits: Some(16), normals: true, colors: true, explicit: true };
    let columns = plausible(shape, 4);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| encode(&columns).unwrap())
    };
    assert_eq!(on(1), on(5));
}

#[test]
fn errors_are_rounded_up_by_a_sixteenth_at_most_and_only_once() {
    let mut last = 0.0;
    for bits in (0..f32::MAX.to_bits()).step_by(99_991) {
        let error = f32::from_bits(bits);
        let rounded = round_error_up(error);
        assert!(rounded >= error && rounded >= last);
        assert!(rounded <= error * 1.0626 || error < f32::MIN_POSITIVE, "{error} became {rounded}");
        assert_eq!(round_error_up(rounded).to_bits(), rounded.to_bits());
        last = rounded;
    }
    let mut columns = plausible(Shape { updates: 5, bits: None, normals: false, colors: false, explicit: false }, 1);
    columns.errors = vec![1.0, 0.7001, 0.6, 1e-30, 0.0];
    let read = decode(&encode(&columns).unwrap(), "test").unwrap();
    assert_eq!(read.errors, columns.errors.iter().map(|&e| round_error_up(e)).collect::<Vec<_>>());
}

#[test]
fn columns_that_cannot_be_stored_are_named() {
    let sound = plausible(Shape { updates: 20, bits: Some(16), normals: true, colors: true, explicit: true }, 9);
    let refused = |change: &dyn Fn(&mut Columns)| {
        let mut columns = sound.clone();
        change(&mut columns);
        encode(&columns).unwrap_err()
    };
    let update = |e: EncodeError| match e {
        EncodeError::Columns(InvalidColumns::Update { update, .. }) => update,
        other => panic!("{other}"),
    };
    assert!(matches!(
        refused(&|c| c.sides.truncate(19)),
        EncodeError::Columns(InvalidColumns::Length { column: "sides", found: 19, expected: 20 })
    ));
    assert_eq!(update(refused(&|c| c.vertex[3] = VertexId(12 + 6))), 3);
    assert_eq!(update(refused(&|c| c.errors[4] = f32::NAN)), 4);
    assert_eq!(update(refused(&|c| c.errors[4] = -1.0)), 4);
    assert_eq!(update(refused(&|c| c.errors[4] = f32::MAX)), 4);
    assert_eq!(update(refused(&|c| c.sides[5] |= Columns::EXPLICIT)), 5);
    assert_eq!(update(refused(&|c| drop(c.explicit.remove(0)))), 3);
    let off = refused(&|c| c.positions[6][1].x += 0.3 * c.grid.unwrap().step as f32);
    assert_eq!(off, EncodeError::OffGrid { vertex: 12 + 13 });
    assert_eq!(refused(&|c| c.base.positions[2].y = f32::NAN), EncodeError::OffGrid { vertex: 2 });
    assert!(matches!(refused(&|c| c.grid.as_mut().unwrap().bits = 25), EncodeError::Grid(_)));
    assert!(matches!(
        refused(&|c| c.base.triangles[0][0] = VertexId(12)),
        EncodeError::Columns(InvalidColumns::Base(_))
    ));
}

prop_compose! {
    /// Any columns that `encode` promises to take: no statistics, no order, no geometry.
    fn any_columns()(
        bits in prop_oneof![Just(None), (10u32..=24).prop_map(Some)],
        origin in [-1e3f64..1e3, -1e3f64..1e3, -1e3f64..1e3],
        step in 1e-3f64..10.0,
        base in vec(any::<[u32; 4]>(), 1..20),
        updates in vec((any::<u32>(), any::<u32>(), any::<[[u32; 3]; 2]>(), 0u32..0x7f70_0000, any::<[[i16; 2]; 2]>(), any::<[[u8; 4]; 2]>()), 0..120),
        added in vec((0u8..31, any::<bool>(), any::<bool>()), 0..8),
        flags in 0u32..16,
        floor in 0u32..0x7f7f_ffff,
    ) -> Columns {
        let grid = bits.map(|bits| Grid { bits, origin: DVec3::from_array(origin), step });
        let point = |p: [u32; 3]| match grid {
            Some(grid) => grid.snap(grid.point(p.map(|i| i & ((1 << grid.bits) - 1)))),
            // Any float but infinities and NaN, subnormals and -0 included.
            None => Vec3::from_array(p.map(|b| f32::from_bits(b & !(1 << 30 & (b << 1 & b << 2 & b << 3)))))
                .map(|x| if x.is_finite() { x } else { -0.0 }),
        };
        let count = base.len() as u32;
        let has = |flag: u32, column: usize| if flags & flag != 0 { column } else { 0 };
        let mut columns = Columns {
            grid,
            base: TriangleMesh {
                positions: base.iter().map(|b| point([b[0], b[1], b[2]])).collect(),
                triangles: base.iter().map(|b| [b[1], b[2], b[3]].map(|v| VertexId(v % count))).collect(),
                vertex: VertexColumns {
                    normals: base.iter().take(has(1, base.len())).map(|b| Oct([b[0] as i16, b[3] as i16]).decode()).collect(),
                    colors: base.iter().take(has(2, base.len())).map(|b| b[3].to_le_bytes()).collect(),
                },
            },
            errors: updates.iter().map(|u| round_error_up(f32::from_bits(u.3))).collect(),
            positions: updates.iter().map(|u| u.2.map(point)).collect(),
            sides: updates.iter().map(|u| u.1).collect(),
            vertex: updates.iter().enumerate().map(|(m, u)| VertexId(u.0 % (count + 2 * m as u32))).collect(),
            normals: updates.iter().take(has(4, updates.len())).map(|u| u.4.map(Oct)).collect(),
            colors: updates.iter().take(has(8, updates.len())).map(|u| u.5).collect(),
            floor_error: f32::from_bits(floor),
            source: SourceCounts { vertices: floor, triangles: flags },
            explicit: Vec::new(),
        };
        let added: Vec<_> =
            added.iter().map(|&(star, before, flipped)| AddedTriangle { star, before, flipped }).collect();
        for m in 0..updates.len() {
            if columns.sides[m] & Columns::EXPLICIT != 0 {
                columns.explicit.push(ExplicitSplit { update: UpdateId(m as u32), added: added.clone() });
            }
        }
        columns
    }
}

/// Columns to the bit: `==` cannot tell 0 from −0.
fn bits_of(columns: &Columns) -> String {
    let points = |points: &[Vec3]| points.iter().map(|p| p.to_array().map(f32::to_bits)).collect::<Vec<_>>();
    let floats = columns.errors.iter().chain([&columns.floor_error]).map(|e| e.to_bits()).collect::<Vec<_>>();
    let children = bytemuck::cast_slice(&columns.positions);
    format!("{:?}{:?}{floats:?}{columns:?}", points(&columns.base.positions), points(children))
}

proptest! {
    #[test]
    fn any_columns_come_back_to_the_bit(columns in any_columns()) {
        let bytes = encode(&columns).unwrap();
        let read = decode(&bytes, "test").unwrap();
        prop_assert_eq!(bits_of(&read), bits_of(&columns));
        prop_assert_eq!(inspect(&bytes, "test").unwrap().updates as usize, columns.vertex.len());
    }
}

/// The base mesh alone, from as much of the file as holds it.
#[test]
fn a_base_mesh_is_read_from_the_start_of_a_file() {
    for painted in [false, true] {
        let mut mesh = sample::knot(4000);
        if painted {
            sample::paint(&mut mesh);
        }
        let columns =
            edge_collapse(&mesh, &EdgeCollapseOptions { bits: Some(14), base_triangles: 100 }, &()).unwrap().columns();
        let bytes = encode(&columns).unwrap();
        let reaches = (0..bytes.len()).find(|&n| meshfront_format::base(&bytes[..n]).is_some()).expect("a base mesh");
        assert!(reaches < bytes.len() / 3, "{reaches} of {}", bytes.len());
        for n in [reaches, reaches + 1, bytes.len()] {
            assert_eq!(meshfront_format::base(&bytes[..n]), Some(columns.base.clone()));
        }
        // Nothing else is ever taken for it.
        for at in 0..reaches {
            let mut altered = bytes[..reaches].to_vec();
            altered[at] ^= 0x10;
            if let Some(base) = meshfront_format::base(&altered) {
                assert_eq!(base, columns.base, "byte {at}");
            }
        }
    }
}
