//! Reading takes memory in proportion to the file, whatever the file says. One test alone, since memory is counted for
//! the whole process.

mod common;
#[path = "common/heights.rs"]
mod heights;

use std::fmt::Write;

use common::written;
use meshfront_mesh::io::height::{self, HeightFormat};
use meshfront_mesh::io::{self, Format};
use meshfront_mesh::sample;
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Most memory that reading takes at once beyond the file's own bytes, as a multiple of those, and whether it was read.
fn growth(bytes: &[u8], format: Format) -> (f64, bool) {
    growth_of(bytes, || io::read_bytes(bytes, format, "memory").is_ok())
}

fn growth_of(bytes: &[u8], read: impl FnOnce() -> bool) -> (f64, bool) {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let read = read();
    ((MEMORY.peak_usage() - before) as f64 / bytes.len() as f64, read)
}

/// `start`, then `n` lines.
fn lines(start: &str, n: usize, mut line: impl FnMut(usize, &mut String)) -> Vec<u8> {
    let mut text = start.to_owned();
    for i in 0..n {
        line(i, &mut text);
    }
    text.into_bytes()
}

#[test]
fn memory_follows_the_size_of_the_file() {
    let mut terrain = sample::terrain(100_000);
    for painted in [false, true] {
        if painted {
            sample::paint(&mut terrain);
        }
        for format in [Format::Off, Format::Obj, Format::Ply, Format::Stl, Format::Glb] {
            let (times, read) = growth(&written(&terrain, format), format);
            assert!(read && times < 5.0, "{format}: {times:.1} times the file");
        }
    }

    const LINES: usize = 1_000_000;
    let ply = "ply\nformat binary_little_endian 1.0\nelement vertex 4294967294\nproperty uchar x\nproperty uchar y\n\
               property uchar z\nelement face 4294967295\nproperty list uchar uchar vertex_indices\nend_header\n";
    let hostile: Vec<(&str, Format, Vec<u8>)> = vec![
        ("garbage lines", Format::Obj, lines("", LINES, |i, s| writeln!(s, "q{} \x01~{i}", i % 7).unwrap())),
        ("garbage lines", Format::Off, lines("", LINES, |i, s| writeln!(s, "q{} {i}", i % 7).unwrap())),
        (
            "garbage lines",
            Format::Ply,
            lines("ply\nformat ascii 1.0\n", LINES, |i, s| writeln!(s, "comment {i}").unwrap()),
        ),
        ("garbage lines", Format::Stl, lines("solid x\n", LINES, |i, s| writeln!(s, "facet {i}").unwrap())),
        ("many solids", Format::Stl, lines("", LINES, |_, s| s.push_str("solid\nendsolid\n"))),
        ("tiny points", Format::Obj, lines("f\n", LINES, |_, s| s.push_str("v 0 0 0\n"))),
        ("tiny faces", Format::Obj, lines("v 0 0 0\n", LINES, |_, s| s.push_str("f 1 1 1\n"))),
        ("tiny faces with normals", Format::Obj, {
            lines("v 0 0 0\nvn 0 0 1\nf 1//1 1//1 1//1\n", LINES, |_, s| s.push_str("f 1 1 1\n"))
        }),
        ("one face", Format::Obj, lines("v 0 0 0\nf", LINES, |_, s| s.push_str(" 1"))),
        ("faces of many corners", Format::Obj, {
            lines("v 0 0 0\nv 1 0 0\nv 0 1 0\n", LINES, |i, s| s.push_str(if i % 60_000 == 0 { "\nf 1" } else { " 2" }))
        }),
        ("tiny colours", Format::Obj, lines("", LINES, |_, s| s.push_str("v 0 0 0 0 0 0\n"))),
        ("promises", Format::Ply, ply.into()),
        ("promises of faces", Format::Ply, [ply.replace("4294967294", "1").as_bytes(), &[0; 3], &[1; LINES]].concat()),
        ("faces of one corner", Format::Ply, {
            [
                ply.replace("4294967294", "1").replace("4294967295", "500000").as_bytes(),
                &[0; 3],
                &[1, 0].repeat(500_000),
            ]
            .concat()
        }),
        ("tiny points", Format::Ply, {
            [ply.replace("4294967294", "1000000").replace("4294967295", "0").as_bytes(), &[0; 3 * LINES]].concat()
        }),
        ("deep json", Format::Gltf, vec![b'['; LINES]),
        ("nodes", Format::Gltf, {
            let mut text = lines(r#"{"asset":{"version":"2.0"},"nodes":[{}"#, LINES, |_, s| s.push_str(",{}"));
            text.extend(b"]}");
            text
        }),
        ("copies", Format::Gltf, {
            let count = 20_000;
            let mut nodes = r#""nodes":[{}"#.to_owned();
            (1..count).for_each(|_| nodes.push_str(r#",{"mesh":0}"#));
            let roots: Vec<String> = (0..count).map(|i| i.to_string()).collect();
            let text = common::gltf_square("", "").replace(r#""nodes":[{"mesh":0}]"#, &format!("{nodes}]"));
            text.replacen(r#""nodes":[0]"#, &format!(r#""nodes":[{}]"#, roots.join(",")), 1).into_bytes()
        }),
    ];
    for (name, format, bytes) in hostile {
        let (times, _) = growth(&bytes, format);
        // A small file may take a few pages.
        let slack = (1 << 20) as f64 / bytes.len() as f64;
        println!("{name} ({format}): {times:.1}");
        assert!(times < 24.0 + slack, "{name} ({format}): {times:.1} times the file");
    }
    heights_follow_the_size_of_the_file();
}

fn heights_follow_the_size_of_the_file() {
    use HeightFormat::*;
    let growth = |bytes: &[u8], format| growth_of(bytes, || height::read_bytes(bytes, format, "memory").is_ok());
    let terrain = sample::terrain_heights(700, 700);
    let mut whole = terrain.clone();
    whole.heights.iter_mut().for_each(|h| *h = h.round());
    whole.step = Some(1.0);
    for (field, format) in
        [(&terrain, EsriAscii), (&whole, EsriAscii), (&terrain, GeoTiff), (&whole, GeoTiff), (&whole, Png)]
    {
        let (times, read) = growth(&heights::written(field, format), format);
        // A compressed image takes what its samples do, and as heights twice that.
        let most = if format == Png { 24.0 } else { 5.0 };
        assert!(read && times < most, "{format}: {times:.1} times the file");
    }
    let profiles = (0..500).map(|i| (f64::from(i), 0.0, vec![1; 500])).collect();
    let (times, read) = growth(&heights::Dem { spacing: [1.0; 3], ..heights::Dem::of(profiles) }.bytes(), UsgsDem);
    assert!(read && times < 3.0, "{UsgsDem}: {times:.1} times the file");

    const MANY: usize = 100_000;
    let tag = |tag, kind, count: usize, bytes: Vec<u8>| {
        let tiff = heights::Tiff { more: vec![(tag, kind, count as u32, bytes)], ..heights::Tiff::default() };
        tiff.bytes()
    };
    // Two profiles of many heights far apart: the grid that holds both is mostly holes.
    let apart = |gap: f64| {
        let far = vec![(0.0, 0.0, vec![1; 50]), (1.0, gap, vec![1; 50])];
        heights::Dem { spacing: [1.0; 3], ..heights::Dem::of(far) }.bytes()
    };
    let hostile: Vec<(&str, HeightFormat, Vec<u8>)> = vec![
        ("tiny heights", EsriAscii, [b"ncols 1000 nrows 1000 cellsize 1 ".to_vec(), b"1 ".repeat(1_000_000)].concat()),
        ("promises", EsriAscii, [b"ncols 9999999 nrows 9999999 cellsize 1 ".to_vec(), b"1 ".repeat(MANY)].concat()),
        ("garbage", EsriAscii, b"ncols\n".repeat(MANY)),
        ("promises", UsgsDem, apart(1e9)),
        ("holes", UsgsDem, apart(8000.0)),
        ("garbage", UsgsDem, b"     1".repeat(MANY)),
        ("many numbers", GeoTiff, tag(33922, 12, MANY, vec![0; 8 * MANY])),
        ("many keys", GeoTiff, tag(34735, 3, MANY, vec![1; 2 * MANY])),
        ("many bytes", GeoTiff, tag(34735, 1, MANY, vec![1; MANY])),
        ("many offsets", GeoTiff, tag(273, 1, MANY, vec![1; MANY])),
        ("many depths", GeoTiff, tag(258, 1, MANY, vec![16; MANY])),
        ("metadata", GeoTiff, tag(42112, 2, MANY, b"<Item ".repeat(MANY / 6 + 1)[..MANY].to_vec())),
        ("wide tiles", GeoTiff, {
            let more = vec![(322, 4, 1, vec![0, 0, 0, 0x40]), (323, 4, 1, vec![16, 0, 0, 0])];
            heights::Tiff { tiles: true, more, ..heights::Tiff::default() }.bytes()
        }),
    ];
    for (name, format, bytes) in hostile {
        let (times, _) = growth(&bytes, format);
        let slack = (1 << 20) as f64 / bytes.len() as f64;
        println!("{name} ({format}): {times:.1}");
        assert!(times < 24.0 + slack, "{name} ({format}): {times:.1} times the file");
    }
}
