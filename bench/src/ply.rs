//! The one mesh file of these benches: binary PLY as `rivals.py` writes it, with nothing but positions and triangles.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

/// Positions in mesh units, and three indices a triangle.
pub struct Mesh {
    pub positions: Vec<[f32; 3]>,
    pub indices: Vec<u32>,
}

impl Mesh {
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }

    /// Length of the bounding box's diagonal.
    pub fn diagonal(&self) -> f64 {
        let extent = |axis: usize| {
            let values = self.positions.iter().map(|p| f64::from(p[axis]));
            let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
            high - low
        };
        (0..3).map(|axis| extent(axis).powi(2)).sum::<f64>().sqrt()
    }
}

const END: &[u8] = b"end_header\n";
/// A count of one byte, then three indices of four.
const FACE: usize = 13;

pub fn read(path: &Path) -> Result<Mesh> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    parse(&bytes).with_context(|| format!("{} is not a PLY that rivals.py wrote", path.display()))
}

fn parse(bytes: &[u8]) -> Result<Mesh> {
    let end = bytes.windows(END.len()).position(|window| window == END).context("no end_header")? + END.len();
    let header = std::str::from_utf8(&bytes[..end])?;
    let count = |element: &str| -> Result<usize> {
        let line = header.lines().find_map(|line| line.strip_prefix(element));
        Ok(line.with_context(|| format!("no {element:?}"))?.trim().parse()?)
    };
    let (vertices, faces) = (count("element vertex")?, count("element face")?);
    let body = &bytes[end..];
    if body.len() != vertices * 12 + faces * FACE {
        bail!("{} bytes for {vertices} vertices and {faces} faces", body.len());
    }
    let (points, cells) = body.split_at(vertices * 12);
    let word = |bytes: &[u8], i: usize| [bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]];
    let positions = points.chunks_exact(12).map(|p| [0, 4, 8].map(|i| f32::from_le_bytes(word(p, i)))).collect();
    let indices = cells.chunks_exact(FACE).flat_map(|c| [1, 5, 9].map(|i| u32::from_le_bytes(word(c, i)))).collect();
    Ok(Mesh { positions, indices })
}

pub fn write(path: &Path, mesh: &Mesh) -> Result<()> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles()
    )
    .into_bytes();
    bytes.extend(mesh.positions.iter().flatten().flat_map(|x| x.to_le_bytes()));
    for triangle in mesh.indices.chunks_exact(3) {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|i| i.to_le_bytes()));
    }
    fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}
