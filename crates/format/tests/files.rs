//! Files appear whole or not at all.

use std::fs;
use std::path::Path;

use meshfront_format::{ReadError, WriteError, WriteOptions, edge_collapse, inspect_file, read, write};
use meshfront_hierarchies::Stored;
use meshfront_hierarchies::edge_collapse::Columns;
use meshfront_mesh::sample;
use meshfront_simplify::{EdgeCollapseOptions, edge_collapse_columns};

const KEEP: WriteOptions = WriteOptions { overwrite: false };
const REPLACE: WriteOptions = WriteOptions { overwrite: true };

fn columns() -> Columns {
    let options = EdgeCollapseOptions { base_triangles: 50, ..Default::default() };
    edge_collapse_columns(&sample::knot(600), &options, &()).unwrap()
}

fn stored() -> Stored {
    Stored::EdgeCollapse(columns())
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn written_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("knot.front");
    let written = write(&path, &stored(), &KEEP).unwrap();
    assert_eq!(written.bytes, fs::metadata(&path).unwrap().len());
    assert_eq!(read(&path).unwrap().stored(), stored());
    assert_eq!(inspect_file(&path).unwrap().bytes, written.bytes);
    assert_eq!(names(folder.path()), ["knot.front"]);
}

#[test]
fn an_existing_file_stays_unless_asked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("knot.front");
    fs::write(&path, "precious").unwrap();
    let error = write(&path, &stored(), &KEEP).unwrap_err();
    assert!(matches!(&error, WriteError::Exists { path: p } if *p == path));
    assert!(error.to_string().contains("--force"), "{error}");
    assert_eq!(fs::read(&path).unwrap(), b"precious");
    write(&path, &stored(), &REPLACE).unwrap();
    read(&path).unwrap();
    assert_eq!(names(folder.path()), ["knot.front"]);
}

#[test]
fn nothing_is_left_where_writing_fails() {
    let folder = tempfile::tempdir().unwrap();
    let occupied = folder.path().join("folder.front");
    fs::create_dir(&occupied).unwrap();
    assert!(matches!(write(&occupied, &stored(), &REPLACE), Err(WriteError::Io { .. })));
    assert_eq!(names(folder.path()), ["folder.front"]);
    let nowhere = folder.path().join("missing").join("knot.front");
    let error = write(&nowhere, &stored(), &KEEP).unwrap_err();
    assert!(error.to_string().contains("knot.front"), "{error}");
    assert_eq!(names(folder.path()), ["folder.front"]);
}

#[cfg(unix)]
#[test]
fn others_may_read_what_the_umask_allows() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (ours, plain) = (folder.path().join("a.front"), folder.path().join("b"));
    write(&ours, &stored(), &KEEP).unwrap();
    fs::write(&plain, "").unwrap();
    let mode = |path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&ours), mode(&plain));
}

#[test]
fn reading_names_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let missing = read(folder.path().join("missing.front")).unwrap_err();
    assert!(matches!(missing, ReadError::Io { .. }));
    assert!(missing.to_string().contains("missing.front"), "{missing}");
    let mesh = folder.path().join("mesh.ply");
    fs::write(&mesh, "ply\nformat ascii 1.0\nend_header\n").unwrap();
    let error = read(&mesh).unwrap_err().to_string();
    assert!(error.contains("mesh.ply") && error.contains("meshfront build"), "{error}");
}

/// Whole bytes, sound columns, but no hierarchy: splits that cannot be applied.
#[test]
fn columns_that_are_no_hierarchy_are_refused() {
    let mut columns = columns();
    columns.vertex.swap(0, 1);
    columns.vertex[1] = columns.vertex[0];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("twice.front");
    fs::write(&path, edge_collapse::encode(&columns).unwrap()).unwrap();
    let error = read(&path).unwrap_err();
    assert!(matches!(error, ReadError::Hierarchy { .. }), "{error}");
    assert!(error.to_string().contains("twice.front"), "{error}");
}
