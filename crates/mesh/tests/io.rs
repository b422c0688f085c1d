//! What is written comes back; every dialect is read; every damaged file is an error or a valid mesh.

mod common;

use std::collections::BTreeMap;
use std::fs;

use common::*;
use glam::Vec3;
use meshfront_mesh::clean::clean;
use meshfront_mesh::io::{
    self, Format, Phase, Place, Progress, ReadErrorKind, ReadOptions, UnknownFormat, WriteError, WriteOptions,
};
use meshfront_mesh::{TriangleMesh, VertexColumns, VertexId, sample};
use proptest::prelude::*;

/// Triangles as points, each starting at its least corner, in order: equal for equal surfaces.
fn surface(mesh: &TriangleMesh) -> Vec<[[u32; 3]; 3]> {
    let bits = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut list: Vec<_> = (mesh.triangles.iter())
        .map(|t| {
            let p = t.map(|v| bits(mesh.positions[v.ix()]));
            let least = (0..3).min_by_key(|&i| p[i]).unwrap();
            [p[least], p[(least + 1) % 3], p[(least + 2) % 3]]
        })
        .collect();
    list.sort();
    list
}

#[test]
fn every_dialect_gives_the_square() {
    for (name, format, bytes) in small_files() {
        let source = io::read_bytes(&bytes, format, name).unwrap_or_else(|e| panic!("{e}"));
        assert_valid(&source.mesh);
        assert_eq!(source.mesh.triangles.len(), 2, "{name}");
        assert_eq!(source.mesh.positions.len(), 4, "{name}");
        // The square may be cut along either diagonal, but faces up and has area 1.
        let mut area = 0.0;
        for t in &source.mesh.triangles {
            let [a, b, c] = t.map(|v| source.mesh.positions[v.ix()]);
            let twice = (b - a).cross(c - a);
            assert!(twice.z > 0.0, "{name}");
            area += twice.z / 2.0;
        }
        assert_eq!(area, 1.0, "{name}");
        let columns = [source.mesh.vertex.normals.len(), source.mesh.vertex.colors.len()];
        let expected = match name {
            "cnoff" | "obj with all" => [4, 4],
            "ascii ply" => [0, 4],
            _ => [0, 0],
        };
        assert_eq!(columns, expected, "{name}");
    }
}

#[test]
fn columns_are_read_by_value() {
    let read = |wanted: &str| {
        let (name, format, bytes) = small_files().into_iter().find(|f| f.0 == wanted).unwrap();
        io::read_bytes(&bytes, format, name).unwrap().mesh.vertex
    };
    let cnoff = read("cnoff");
    assert_eq!(cnoff.colors, [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [9, 9, 9, 255]]);
    assert_eq!(cnoff.normals, [Vec3::Z; 4]);
    assert_eq!(read("obj with all").colors, [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]]);
    assert_eq!(read("ascii ply").colors, [[1, 2, 3, 255]; 4]);
}

#[test]
fn obj_vertices_are_split_by_normal_and_only_then() {
    let bytes = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvn 0 2 0\nf 1//1 2//1 3//1\nf 1//2 4//2 2//2\n";
    let source = io::read_bytes(bytes, Format::Obj, "split.obj").unwrap();
    // Points 1 and 2 have two normals each, points 3 and 4 one.
    assert_eq!(source.mesh.positions.len(), 6);
    assert_eq!(source.report.vertices_in_file, 4);
    for t in &source.mesh.triangles {
        let [a, b, c] = t.map(|v| source.mesh.positions[v.ix()]);
        let normal = (b - a).cross(c - a).normalize();
        assert!(t.iter().all(|v| source.mesh.vertex.normals[v.ix()] == normal));
    }
    // The same normal given twice is no reason to split.
    let twice = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 0 1\nvn 0 0 1\nf 1//1 2//1 3//1\nf 2//2 4//2 3//2\n";
    assert_eq!(io::read_bytes(twice, Format::Obj, "twice.obj").unwrap().mesh.positions.len(), 4);
}

#[test]
fn normals_become_unit_vectors_or_are_recomputed() {
    let text = "NOFF\n3 1 0\n0 0 0  0 0 5\n1 0 0  nan 0 0\n0 1 0  0 0 0\n3 0 1 2\n";
    let source = io::read_bytes(text.as_bytes(), Format::Off, "n.off").unwrap();
    assert_eq!(source.mesh.vertex.normals, [Vec3::Z; 3]);
    assert_eq!(source.report.normals_repaired, 2);
}

#[test]
fn report_counts_what_was_done_and_says_it_in_one_line() {
    // A concave polygon, a triangle twice (also turned), a folded one, a line, a duplicate vertex, an unused one.
    let text = "OFF\n8 6 0\n0 0 0\n4 0 0\n1 1 0\n0 4 0\n-0 4 0\n9 9 9\n5 5 5\n6 5 5\n\
                4 0 1 2 3\n3 1 6 7\n3 6 7 1\n3 1 7 6\n3 3 4 6\n2 0 1\n";
    let source = io::read_bytes(text.as_bytes(), Format::Off, "all.off").unwrap();
    let r = &source.report;
    assert_eq!((r.vertices_in_file, r.faces_in_file, r.polygons_triangulated, r.faces_too_small), (8, 6, 1, 1));
    assert_eq!((r.vertices, r.triangles), (6, 4));
    assert_eq!(
        r.to_string(),
        "OFF with 8 vertices and 6 faces, 1 polygon triangulated, 1 face of too few corners dropped, welded 1 \
         duplicate vertex, dropped 1 unreferenced vertex, 1 degenerate triangle, 1 duplicate triangle: 6 vertices, 4 \
         triangles"
    );
    let as_is = io::read_bytes_with(
        text.as_bytes(),
        Format::Off,
        "all.off",
        ReadOptions { clean: false, ..ReadOptions::default() },
    );
    assert_eq!(as_is.unwrap().mesh.positions.len(), 8);
}

#[test]
fn seams_stay_or_are_joined_as_asked() {
    // A tetrahedron with a normal for each face: 12 vertices at 4 places.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 -1\nvn 0 -1 0\nvn -1 0 0\nvn 1 1 1\n\
                f 1//1 3//1 2//1\nf 1//2 2//2 4//2\nf 1//3 4//3 3//3\nf 2//4 3//4 4//4\n";
    let read = |weld_seams| {
        let options = ReadOptions { weld_seams, ..ReadOptions::default() };
        io::read_bytes_with(text.as_bytes(), Format::Obj, "t.obj", options).unwrap()
    };
    assert_eq!(read(false).mesh.positions.len(), 12);
    let joined = read(true);
    assert_eq!((joined.mesh.positions.len(), joined.report.seams_welded), (4, 8));
    assert_eq!(joined.report.cleaned.vertices_unreferenced, 0);
    assert_eq!(surface(&joined.mesh), surface(&read(false).mesh));
    let corner = joined.mesh.positions.iter().position(|&p| p == Vec3::ZERO).unwrap();
    assert!(joined.mesh.vertex.normals[corner].abs_diff_eq(Vec3::splat(-(1f32 / 3.0).sqrt()), 1e-6));
}

#[test]
fn gltf_nodes_place_turn_and_mirror() {
    let read = |node: &str, root: &str| {
        io::read_bytes(gltf_square(node, root).as_bytes(), Format::Gltf, "s.gltf").map(|s| s.mesh)
    };
    let moved = read(r#""translation":[10,0,0],"rotation":[0,0,0.70710678,0.70710678],"scale":[2,1,1],"#, "").unwrap();
    let bounds = moved.bounds().unwrap();
    assert!(bounds.min.abs_diff_eq(Vec3::new(9.0, 0.0, 0.0), 1e-5), "{bounds:?}");
    assert!(bounds.max.abs_diff_eq(Vec3::new(10.0, 2.0, 0.0), 1e-5), "{bounds:?}");
    let mirrored = read(r#""matrix":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1],"#, "").unwrap();
    for t in &mirrored.triangles {
        let [a, b, c] = t.map(|v| mirrored.positions[v.ix()]);
        assert!((b - a).cross(c - a).z > 0.0, "mirrored triangles still face up");
    }
    let cycle = read(r#""children":[0],"#, "").unwrap_err().to_string();
    assert!(cycle.contains("two parents"), "{cycle}");
    let draco = read("", r#""extensionsRequired":["KHR_draco_mesh_compression"],"#).unwrap_err().to_string();
    assert!(draco.contains("KHR_draco_mesh_com") && draco.contains("without mesh compression"), "{draco}");
}

#[test]
fn gltf_buffers_lie_beside_the_file_and_nowhere_else() {
    let folder = tempfile::tempdir().unwrap();
    let inside = gltf_square("", "");
    let (before, after) = inside.split_once("data:").unwrap();
    let uri_end = after.find('"').unwrap();
    let data = &after[after.find("base64,").unwrap() + 7..uri_end];
    use base64::Engine;
    let bytes = base64::engine::general_purpose::STANDARD.decode(data).unwrap();
    fs::write(folder.path().join("a b.bin"), &bytes).unwrap();
    fs::create_dir(folder.path().join("sub")).unwrap();
    for (place, uri, ok) in
        [("s.gltf", "a%20b.bin", true), ("sub/s.gltf", "../a%20b.bin", false), ("s.gltf", "none.bin", false)]
    {
        let path = folder.path().join(place);
        fs::write(&path, format!("{before}{uri}{}", &after[uri_end..])).unwrap();
        let result = io::read(&path);
        assert_eq!(result.is_ok(), ok, "{uri}: {:?}", result.map(|_| ()));
    }
    let path = folder.path().join("s.gltf");
    fs::write(folder.path().join("none.bin"), &bytes[..40]).unwrap();
    assert!(io::read(&path).unwrap_err().to_string().contains("cut short"));
}

#[test]
fn gltf_sparse_and_quantized_accessors() {
    use base64::Engine;
    // Four positions in normalized u16, of which the third is replaced by a sparse value.
    let mut data: Vec<u8> = Vec::new();
    for p in [[0u16, 0, 0], [65535, 0, 0], [7, 7, 7], [0, 65535, 0]] {
        p.iter().for_each(|c| data.extend(c.to_le_bytes()));
        data.extend([0; 2]);
    }
    [65535u16, 65535, 0].iter().for_each(|c| data.extend(c.to_le_bytes()));
    data.extend([2, 0, 1, 2, 0, 2, 3]);
    let length = data.len();
    let data = base64::engine::general_purpose::STANDARD.encode(data);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsRequired":["KHR_mesh_quantization"],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}},{{"attributes":{{"POSITION":0}},"mode":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5123,"normalized":true,"count":4,"type":"VEC3","sparse":{{"count":1,
          "indices":{{"bufferView":1,"byteOffset":6,"componentType":5121}},"values":{{"bufferView":1}}}}}},
          {{"bufferView":1,"byteOffset":7,"componentType":5121,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":32,"byteStride":8}},{{"buffer":0,"byteOffset":32,"byteLength":13}}],
        "buffers":[{{"byteLength":{length},"uri":"data:;base64,{data}"}}]}}"#
    );
    let source = io::read_bytes(json.as_bytes(), Format::Gltf, "q.gltf").unwrap();
    assert_eq!(source.mesh, square());
    assert_eq!(source.report.primitives_skipped, 1);
}

#[test]
fn bad_files_are_told_with_place_and_remedy() {
    let ply = |body: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n{body}"
        )
    };
    let cases: Vec<(&str, Format, Vec<u8>, &str)> = vec![
        ("a.off", Format::Off, b"OOF\n1 1 0".into(), "a.off, line 1: expected the word OFF, found `OOF`"),
        (
            "b.off",
            Format::Off,
            b"OFF\n\n99 1 0\n0 0 0\n".into(),
            "b.off, line 3: 99 vertices are promised, but the 11 bytes that follow can hold no more than 2; the file \
             was cut short or its header is damaged: copy, download or export it again",
        ),
        (
            "c.off",
            Format::Off,
            b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n".into(),
            "c.off, line 6: vertex 3 does not exist: there are 3, counted from 0",
        ),
        (
            "d.off",
            Format::Off,
            b"OFF\n3 1 0\n0 0 0\n1 inf 0\n0 1 0\n3 0 1 2\n".into(),
            "d.off, line 4: a y coordinate is not a finite 32-bit number; clean or rescale the data in the program \
             that made it",
        ),
        (
            "f.off",
            Format::Off,
            b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3\n".into(),
            "f.off, line 7: expected the end",
        ),
        ("e.off", Format::Off, b"4OFF\n".into(), "e.off, line 1: the kind `4OFF` of OFF cannot be read; export it as"),
        (
            "a.obj",
            Format::Obj,
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n".into(),
            "a.obj, line 4: vertex 4 does not exist: there are 3, counted from 1",
        ),
        ("b.obj", Format::Obj, b"v 0 0 0\nf 0 1 1\n".into(), "b.obj, line 2: vertex 0 does not exist"),
        ("c.obj", Format::Obj, b"v 0 0\nv 1 2 3\n".into(), "c.obj, line 1: expected a z coordinate, found the end of"),
        ("d.obj", Format::Obj, b"v 0 0 1e39\n".into(), "d.obj, line 1: a coordinate is not a finite"),
        ("e.obj", Format::Obj, b"v 0 0 0\n\x01\x02 f".into(), "e.obj, line 2: expected a statement such as"),
        ("f.obj", Format::Obj, b"v 0 0 0\nf 1/x 1 1\n".into(), "f.obj, line 2: expected the index of a texture"),
        (
            "g.obj",
            Format::Obj,
            b"v 0 0 0\n".into(),
            "g.obj: holds 1 vertices but no triangle; a point cloud must be meshed first",
        ),
        ("a.ply", Format::Ply, b"plx\n".into(), "a.ply, line 1: expected the word `ply`, found `plx`"),
        (
            "b.ply",
            Format::Ply,
            ply("0 0 0\n1 0 0\n0 1 0\n3 0 1\n").into(),
            "b.ply, line 14: the file ends where a vertex index should be; it was probably cut short",
        ),
        ("c.ply", Format::Ply, ply("0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n").into(), "c.ply, line 11: a z coordinate is not"),
        ("d.ply", Format::Ply, ply("0 0 0\n1 0 0\n0 1 0\n3 0 1 -2\n").into(), "d.ply, line 13: vertex -2 does not"),
        (
            "e.ply",
            Format::Ply,
            ply("0 0 0\n1 0 0 1\n0 1 0\n3 0 1 2\n").into(),
            "e.ply, line 11: expected the end of the line, found `1`",
        ),
        (
            "f.ply",
            Format::Ply,
            ply("").replace("vertex 3", "vertex 4000000000").into(),
            "f.ply, line 10: 4000000000 vertices are promised, but the 0 bytes",
        ),
        (
            "g.ply",
            Format::Ply,
            ply("").replace("float x", "float w").into(),
            "g.ply, line 1: expected the properties x, y and z",
        ),
        ("h.ply", Format::Ply, ply("").replace("float x", "real x").into(), "h.ply, line 4: expected `property TYPE"),
        (
            "i.ply",
            Format::Ply,
            ply("0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 2 1\n").into(),
            "i.ply, line 14: expected the end of the file after the elements that the header promises, found 8 more",
        ),
        ("a.stl", Format::Stl, b"hello".into(), "a.stl, byte 0: expected the word `solid`, or 80 bytes"),
        ("b.stl", Format::Stl, b"solid\nfacet normal 0 0\n".into(), "b.stl, line 3: the file ends where a component"),
        ("c.stl", Format::Stl, [255; 200].into(), "c.stl, byte 80: 4294967295 triangles are promised, but the 116"),
        ("a.glb", Format::Glb, b"glTF\x02\0\0\0".into(), "a.glb, byte 8: the file ends where the header of a GLB"),
        ("a.gltf", Format::Gltf, b"{\n\"asset\":3}".into(), "a.gltf, line 2: expected glTF as JSON, found"),
        (
            "b.gltf",
            Format::Gltf,
            gltf_square("", "").replace("\"count\":4", "\"count\":5").into(),
            "b.gltf: expected 5 items of 12 bytes in buffer view 0, found fewer bytes",
        ),
        (
            "c.gltf",
            Format::Gltf,
            gltf_square("", "").replace("\"POSITION\":0", "\"POSITION\":7").into(),
            "c.gltf: accessor 7 does not exist: there are 1, counted from 0",
        ),
        ("a.ply.gz", Format::Ply, b"\x1f\x8b\x08\0\0\0\0\0\0\x03garbage".into(), "a.ply.gz: the gzip data is damaged"),
    ];
    for (name, format, bytes, expected) in cases {
        let message = io::read_bytes(&bytes, format, name).map(|_| ()).unwrap_err().to_string();
        assert!(message.starts_with(expected), "\n     got: {message}\nexpected: {expected}");
    }
}

/// Every cut and every changed byte: an error that names the file, or a valid mesh.
#[test]
fn damage_is_an_error_or_a_valid_mesh() {
    let mut files = small_files();
    for format in [Format::Off, Format::Obj, Format::Ply, Format::Glb] {
        files.push(("painted", format, written(&painted(), format)));
    }
    for (name, format, bytes) in files {
        let read = |bytes: &[u8]| match io::read_bytes(bytes, format, name) {
            Ok(source) => {
                assert_valid(&source.mesh);
                true
            }
            Err(error) => {
                assert!(error.to_string().starts_with(name));
                false
            }
        };
        assert!(read(&bytes));
        let binary = !bytes.is_ascii();
        for length in 0..bytes.len() {
            let whole = read(&bytes[..length]);
            assert!(!(whole && binary), "{name} ({format}) cut to {length} bytes of {} passed", bytes.len());
        }
        let mut damaged = bytes.clone();
        for i in 0..bytes.len() {
            for flip in [1, 2, 4, 8, 16, 32, 64, 128, 255] {
                damaged[i] = bytes[i] ^ flip;
                read(&damaged);
            }
            for byte in *b"0- \n/" {
                damaged[i] = byte;
                read(&damaged);
            }
            damaged[i] = bytes[i];
        }
    }
}

#[test]
fn a_bomb_of_gzip_is_refused() {
    let bomb = gzipped(&vec![b'\n'; 20 << 20]);
    let error = io::read_bytes(&bomb, Format::Obj, "bomb.obj.gz").unwrap_err();
    assert!(matches!(error.kind, ReadErrorKind::InflatesTooMuch { .. }), "{error}");
    assert!(error.to_string().contains("gunzip"));
}

#[test]
fn formats_by_name() {
    assert_eq!(Format::from_path("a/b.PLY"), Ok(Format::Ply));
    assert_eq!(Format::from_path("b.stl.GZ"), Ok(Format::Stl));
    assert_eq!(Format::from_path("b.tar.gz"), Err(UnknownFormat::Ending { ending: "tar".into() }));
    assert_eq!(Format::from_path("mesh"), Err(UnknownFormat::NoEnding));
    let message = io::read("mesh.fbx").unwrap_err().to_string();
    assert_eq!(
        message,
        "mesh.fbx: the ending .fbx is not a known format: known are .off, .obj, .ply, .stl, .glb and .gltf, each also \
         with .gz behind it"
    );
    let missing = io::read("no/such/mesh.ply").unwrap_err();
    assert_eq!(missing.place, Place::File);
    assert!(matches!(missing.kind, ReadErrorKind::Io(_)));
}

#[test]
fn files_are_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let names = || {
        let mut names: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    let mesh = painted();
    for ending in ["off", "obj", "ply", "stl", "glb", "ply.gz"] {
        let path = folder.path().join(format!("m.{ending}"));
        io::write(&path, &mesh, WriteOptions::default()).unwrap();
        assert_eq!(surface(&io::read(&path).unwrap().mesh), surface(&mesh), "{ending}");
        let refused = io::write(&path, &square(), WriteOptions::default()).unwrap_err();
        assert!(matches!(refused, WriteError::Exists { .. }), "{refused}");
        assert_eq!(surface(&io::read(&path).unwrap().mesh), surface(&mesh), "{ending} was kept");
        io::write(&path, &square(), WriteOptions { overwrite: true }).unwrap();
        assert_eq!(io::read(&path).unwrap().mesh.triangles.len(), 2);
        fs::remove_file(&path).unwrap();
    }
    assert!(names().is_empty(), "{:?}", names());

    fs::create_dir(folder.path().join("folder.ply")).unwrap();
    let over = WriteOptions { overwrite: true };
    assert!(matches!(io::write(folder.path().join("folder.ply"), &mesh, over), Err(WriteError::NotAFile { .. })));
    assert!(matches!(io::write(folder.path().join("a/b.ply"), &mesh, over), Err(WriteError::Io { .. })));
    assert!(matches!(io::write(folder.path().join("b.fbx"), &mesh, over), Err(WriteError::UnknownFormat { .. })));
    assert!(matches!(io::write(folder.path().join("b.gltf"), &mesh, over), Err(WriteError::Unsupported { .. })));
    assert_eq!(names(), ["folder.ply"]);

    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let path = folder.path().join("m.ply");
        io::write(&path, &mesh, over).unwrap();
        fs::write(folder.path().join("plain"), "").unwrap();
        let mode = |p: &std::path::Path| fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&folder.path().join("plain")), "permissions of any new file");
    }
}

#[test]
fn progress_grows_to_the_end_in_each_phase() {
    let bytes = gzipped(&written(&sample::terrain(20_000), Format::Obj));
    let mut calls: Vec<Progress> = Vec::new();
    let mut note = |p: Progress| calls.push(p);
    let options = ReadOptions { progress: Some(&mut note), ..ReadOptions::default() };
    io::read_bytes_with(&bytes, Format::Obj, "t.obj.gz", options).unwrap();
    let phases: Vec<Phase> = calls.chunk_by(|a, b| a.phase == b.phase).map(|run| run[0].phase).collect();
    assert_eq!(phases, [Phase::Decompress, Phase::Parse, Phase::Clean]);
    for run in calls.chunk_by(|a, b| a.phase == b.phase) {
        assert!(run.is_sorted_by_key(|p| p.done));
        assert_eq!(run.last().unwrap().done, run[0].total, "{:?}", run[0].phase);
    }
    let parsing = calls.iter().filter(|p| p.phase == Phase::Parse).count();
    assert!((150..=203).contains(&parsing), "{parsing}");
}

/// Any mesh, with columns or without, that cleaning leaves as it is.
fn clean_mesh() -> impl Strategy<Value = TriangleMesh> {
    let number = prop_oneof![any::<f32>().prop_filter("finite", |x| x.is_finite()), -2f32..2.0, Just(0.0), Just(-0.0)];
    let point = (number.clone(), number.clone(), number).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    let normal = (-1f32..1.0, -1f32..1.0, 0.1f32..1.0).prop_map(|(x, y, z)| Vec3::new(x, y, z).normalize());
    let vertex = (point, normal, any::<[u8; 4]>());
    (prop::collection::vec(vertex, 3..40), prop::collection::vec(any::<[u16; 3]>(), 1..60), any::<[bool; 2]>())
        .prop_map(|(vertices, triangles, [with_normals, with_colors])| {
            let n = vertices.len() as u32;
            let mut mesh = TriangleMesh {
                positions: vertices.iter().map(|v| v.0).collect(),
                triangles: triangles.iter().map(|t| t.map(|i| VertexId(u32::from(i) % n))).collect(),
                vertex: VertexColumns {
                    normals: vertices.iter().map(|v| v.1).filter(|_| with_normals).collect(),
                    colors: vertices.iter().map(|v| v.2).filter(|_| with_colors).collect(),
                },
            };
            clean(&mut mesh);
            mesh
        })
        .prop_filter("some triangle", |mesh| !mesh.triangles.is_empty())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn written_and_read_is_the_same(mesh in clean_mesh()) {
        for format in [Format::Off, Format::Obj, Format::Ply, Format::Glb] {
            let mut expected = mesh.clone();
            if format == Format::Obj {
                // The format has no alpha.
                expected.vertex.colors.iter_mut().for_each(|c| c[3] = 255);
                clean(&mut expected);
            }
            let source = io::read_bytes(&written(&expected, format), format, "mesh").unwrap();
            prop_assert_eq!(&source.mesh, &expected, "{}", format);
        }
        let stl = io::read_bytes(&written(&mesh, Format::Stl), Format::Stl, "mesh").unwrap().mesh;
        let mut bare = TriangleMesh { vertex: VertexColumns::default(), ..mesh };
        clean(&mut bare);
        prop_assert_eq!(surface(&stl), surface(&bare));
        prop_assert_eq!(stl.positions.len(), bare.positions.len());
    }

    #[test]
    fn cleaning_agrees_with_the_plain_way(
        points in prop::collection::vec(0u8..3, 3..30),
        triangles in prop::collection::vec(any::<[u8; 3]>(), 0..40),
    ) {
        // Few places, so that much is welded; the colour tells apart vertices at one place.
        let n = points.len() as u32;
        let mut mesh = TriangleMesh {
            positions: points.iter().enumerate().map(|(i, &p)| Vec3::new(f32::from(p), (i % 4) as f32, 0.0)).collect(),
            triangles: triangles.iter().map(|t| t.map(|i| VertexId(u32::from(i) % n))).collect(),
            vertex: VertexColumns { colors: (0..n).map(|i| [(i / 4 % 2) as u8, 0, 0, 0]).collect(), ..Default::default() },
        };
        let before = mesh.clone();
        let key = |m: &TriangleMesh, v: VertexId| (m.positions[v.ix()].to_array().map(f32::to_bits), m.vertex.colors[v.ix()]);
        // Triangles by value, first of each kind, in order; the kind is the cyclic order.
        let mut expected = Vec::new();
        let mut seen = BTreeMap::new();
        for &t in &before.triangles {
            let k = t.map(|v| key(&before, v));
            if k[0].0 == k[1].0 || k[1].0 == k[2].0 || k[2].0 == k[0].0 {
                continue;
            }
            let turns = [k, [k[1], k[2], k[0]], [k[2], k[0], k[1]]];
            if seen.insert(turns.into_iter().min().unwrap(), ()).is_none() {
                expected.push(k);
            }
        }
        let report = clean(&mut mesh);
        let got: Vec<_> = mesh.triangles.iter().map(|t| t.map(|v| key(&mesh, v))).collect();
        prop_assert_eq!(&got, &expected);
        let dropped = report.triangles_degenerate + report.triangles_duplicate;
        prop_assert_eq!(dropped as usize, before.triangles.len() - mesh.triangles.len());
        let gone = report.vertices_welded + report.vertices_unreferenced;
        prop_assert_eq!(gone as usize, before.positions.len() - mesh.positions.len());
        let again = mesh.clone();
        prop_assert!(clean(&mut mesh).is_nothing());
        prop_assert_eq!(mesh, again);
    }

    #[test]
    fn garbage_behind_a_good_start_is_no_panic(
        which in 0usize..16, cut in 0.0f64..1.0, tail in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let (name, format, mut bytes) = small_files().swap_remove(which);
        bytes.truncate((cut * bytes.len() as f64) as usize);
        bytes.extend(tail);
        if let Ok(source) = io::read_bytes(&bytes, format, name) {
            assert_valid(&source.mesh);
        }
    }
}
