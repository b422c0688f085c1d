//! Small files of every format and dialect, and what any mesh must be.
#![allow(dead_code)]

use glam::Vec3;
use meshfront_mesh::io::{self, Format};
use meshfront_mesh::{TriangleMesh, sample};

/// Panics unless ids are in range, coordinates finite, and columns absent or complete.
pub fn assert_valid(mesh: &TriangleMesh) {
    let n = mesh.positions.len();
    assert!(mesh.triangles.iter().flatten().all(|v| v.ix() < n));
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    assert!([0, n].contains(&mesh.vertex.normals.len()));
    assert!([0, n].contains(&mesh.vertex.colors.len()));
    assert!(mesh.vertex.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-3));
}

/// A few triangles with both columns.
pub fn painted() -> TriangleMesh {
    let mut mesh = sample::sphere(8);
    sample::paint(&mut mesh);
    mesh
}

pub fn written(mesh: &TriangleMesh, format: Format) -> Vec<u8> {
    let mut bytes = Vec::new();
    io::write_to(&mut bytes, mesh, format).unwrap();
    bytes
}

pub fn gzipped(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::new(6));
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

/// The two triangles of a square in every dialect, by name.
pub fn small_files() -> Vec<(&'static str, Format, Vec<u8>)> {
    let text = |s: &str| s.as_bytes().to_vec();
    vec![
        ("off", Format::Off, text("OFF # comment\n4 1 0\n0 0 0\n1 0 0\n# here too\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n")),
        ("off without its word", Format::Off, text("4 2\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3")),
        (
            "cnoff",
            Format::Off,
            text(
                "CNOFF 4 2 5\r\n0 0 0 0 0 1 255 0 0 255\r\n1 0 0 0 0 1 0 255 0 255\r\n1 1 0 0 0 1 0.0 0.0 1.0\r\n0 1 0 0 0 1 9 9 9\r\n3 0 1 2\r\n3 0 2 3\r\n",
            ),
        ),
        ("stoff", Format::Off, text("STOFF\n4 1 4\n0 0 0 .1 .2\n1 0 0 .1 .2\n1 1 0 .1 .2\n0 1 0 .1 .2\n4 0 1 2 3\n")),
        (
            "obj",
            Format::Obj,
            text(
                "# x\nmtllib a.mtl\no a\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\nvt 0 0\ns off\nusemtl m\nf 1 2 \\\n 3 4\nl 1 2\n",
            ),
        ),
        ("obj backwards", Format::Obj, text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -4 -2 -1")),
        (
            "obj with all",
            Format::Obj,
            text(
                "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\nvn 0 0 1\nvt 0 0\nf 1//1 2/1/1 3/1/1\nf 1/1/1 3//-1 4//1\n",
            ),
        ),
        (
            "ascii ply",
            Format::Ply,
            text(
                "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty double x\nproperty float y\nproperty float z\nproperty float quality\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty uchar flags\nproperty list uchar int vertex_indices\nend_header\n0 0 0 .5 1 2 3\n1 0 0 .5 1 2 3\n1 1 0 .5 1 2 3\n0 1 0 .5 1 2 3\n7 4 0 1 2 3\n",
            ),
        ),
        ("big-endian ply", Format::Ply, big_endian_ply()),
        ("strips", Format::Ply, strips_ply()),
        (
            "ascii stl",
            Format::Stl,
            text(
                "solid a b\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 1 1 0\n  endloop\n endfacet\n FACET NORMAL nan nan nan\n  OUTER LOOP\n   VERTEX 0 0 0\n   VERTEX 1e0 1 0\n   VERTEX -0 1 0\n  ENDLOOP\n ENDFACET\nendsolid a b\n",
            ),
        ),
        ("stl", Format::Stl, written(&square(), Format::Stl)),
        ("ply", Format::Ply, written(&square(), Format::Ply)),
        ("glb", Format::Glb, written(&square(), Format::Glb)),
        ("gltf", Format::Gltf, text(&gltf_square("", ""))),
        ("ply.gz", Format::Ply, gzipped(&written(&square(), Format::Ply))),
    ]
}

/// The unit square of z = 0, facing up: two triangles.
pub fn square() -> TriangleMesh {
    use meshfront_mesh::VertexId;
    TriangleMesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
        triangles: vec![[0, 1, 2].map(VertexId), [0, 2, 3].map(VertexId)],
        ..TriangleMesh::default()
    }
}

fn big_endian_ply() -> Vec<u8> {
    let mut b = b"ply\nformat binary_big_endian 1.0\nelement camera 1\nproperty list uchar short spam\nelement vertex 4\nproperty short x\nproperty double y\nproperty float z\nproperty list ushort double extra\nelement face 2\nproperty list uint ushort vertex_index\nproperty list uchar float texcoord\nend_header\n".to_vec();
    b.extend([2, 0, 1, 0, 2]);
    for (x, y) in [(0i16, 0f64), (1, 0.0), (1, 1.0), (0, 1.0)] {
        b.extend(x.to_be_bytes());
        b.extend(y.to_be_bytes());
        b.extend(0f32.to_be_bytes());
        b.extend(1u16.to_be_bytes());
        b.extend(3f64.to_be_bytes());
    }
    for corners in [[0u16, 1, 2], [0, 2, 3]] {
        b.extend(3u32.to_be_bytes());
        corners.iter().for_each(|c| b.extend(c.to_be_bytes()));
        b.push(1);
        b.extend(2f32.to_be_bytes());
    }
    b
}

fn strips_ply() -> Vec<u8> {
    let mut b = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n".to_vec();
    for p in square().positions {
        p.to_array().iter().for_each(|c| b.extend(c.to_le_bytes()));
    }
    // 0 1 2, restart, then 3 0 2 as the second (turned) triangle of a strip that begins with a repeated corner.
    let strip = [0i32, 1, 2, -1, 0, 0, 3, 2];
    b.extend((strip.len() as i32).to_le_bytes());
    // (0 0 3) steers, (0 3 2) turned is 3 0 2.
    strip.iter().for_each(|i| b.extend(i.to_le_bytes()));
    b
}

/// The square as a strip in glTF with a data URI; `node` goes into its node, `root` into the root object.
pub fn gltf_square(node: &str, root: &str) -> String {
    use base64::Engine;
    let mut data = Vec::new();
    for p in [square().positions[0], square().positions[1], square().positions[3], square().positions[2]] {
        p.to_array().iter().for_each(|c| data.extend(c.to_le_bytes()));
    }
    let data = base64::engine::general_purpose::STANDARD.encode(data);
    format!(
        r#"{{"asset":{{"version":"2.0"}},{root}"scenes":[{{"nodes":[0]}}],"nodes":[{{{node}"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":5}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}}],
        "buffers":[{{"byteLength":48,"uri":"data:application/octet-stream;base64,{data}"}}]}}"#
    )
}
