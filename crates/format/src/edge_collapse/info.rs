//! What a file holds, without unpacking it.

use meshfront_hierarchies::edge_collapse::SourceCounts;

use super::{HAS_BASE_COLORS, HAS_BASE_NORMALS, HAS_COLORS, HAS_NORMALS, MODEL, Opened, decode_table, page, u32_at};
use crate::container::{Codec, VERSION};
use crate::error::ReadError;

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Info {
    /// Version of the container.
    pub version: u32,
    /// Name of the model.
    pub model: &'static str,
    /// Length of the file.
    pub bytes: u64,
    /// Bytes before the first page: all that is needed to show the base mesh and to know where each page is.
    pub head_bytes: u64,
    /// Bits per coordinate; `None`: lossless.
    pub bits: Option<u32>,
    /// Mesh units between neighbouring grid points; `None`: lossless.
    pub grid_step: Option<f64>,
    /// Vertices of the source.
    pub source_vertices: u32,
    /// Triangles of the source.
    pub source_triangles: u32,
    /// Vertices of the base mesh.
    pub base_vertices: u32,
    /// Triangles of the base mesh.
    pub base_triangles: u32,
    /// Updates.
    pub updates: u32,
    /// Whether vertices have normals of the source.
    pub normals: bool,
    /// Whether vertices have colours.
    pub colors: bool,
    /// Error of the base mesh, mesh units: the largest of any update, or the floor where there is none.
    pub base_error: f32,
    /// Error of the full mesh, mesh units: quantization alone.
    pub floor_error: f32,
    /// Every section, in order of the file.
    pub sections: Vec<SectionInfo>,
    /// Bytes of each column of updates, over all pages.
    pub columns: Vec<ColumnInfo>,
    /// Every page of updates, coarse to fine.
    pub pages: Vec<PageInfo>,
}

/// A section of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SectionInfo {
    /// Four letters.
    pub name: &'static str,
    /// How it is coded.
    pub codec: Codec,
    /// First byte in the file.
    pub offset: u64,
    /// Length.
    pub bytes: u64,
}

/// A column of updates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ColumnInfo {
    /// Its name, as in `Columns`.
    pub name: &'static str,
    /// Length over all pages.
    pub bytes: u64,
}

/// A page of updates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PageInfo {
    /// First byte in the file.
    pub offset: u64,
    /// Length.
    pub bytes: u64,
    /// Id of its first update.
    pub first_update: u32,
    /// How many updates.
    pub updates: u32,
    /// Largest error, mesh units: with all pages before this one applied, the mesh is at most this wrong.
    pub max_error: f32,
}

/// What a file that lies in memory holds. `file` is what errors call it.
///
/// Every checksum is compared, so a file that is not as it was written gives an error; pages are not unpacked.
///
/// # Errors
/// [`ReadError`], with section and offset.
pub fn inspect(bytes: &[u8], file: &str) -> Result<Info, ReadError> {
    let opened = Opened::new(bytes, file)?;
    let Opened { meta, sections } = &opened;
    let body = opened.section("UPDT");
    let rows = decode_table(opened.section("UTAB"), body, meta).map_err(|f| f.in_file(file))?;
    let mut totals = [0u64; page::COLUMNS.len()];
    let mut pages = Vec::with_capacity(rows.len());
    for row in &rows {
        let lengths = page::stream_lengths(row.page).map_err(|f| f.in_file(file))?;
        for (total, length) in totals.iter_mut().zip(lengths) {
            *total += length as u64;
        }
        pages.push(PageInfo {
            offset: row.page.offset as u64,
            bytes: row.page.bytes.len() as u64,
            first_update: row.first as u32,
            updates: row.updates as u32,
            max_error: row.max_error,
        });
    }
    let attribute_columns = [("normals", "NRML"), ("colors", "COLR")].into_iter().filter_map(|(name, section)| {
        let section = sections.iter().find(|s| s.name == section)?;
        Some(ColumnInfo { name, bytes: section.bytes.len() as u64 })
    });
    let SourceCounts { vertices, triangles } = meta.source;
    Ok(Info {
        version: u32_at(bytes, 8).min(VERSION),
        model: MODEL,
        bytes: bytes.len() as u64,
        head_bytes: body.offset as u64,
        bits: meta.grid.map(|g| g.bits),
        grid_step: meta.grid.map(|g| g.step),
        source_vertices: vertices,
        source_triangles: triangles,
        base_vertices: meta.base_vertices as u32,
        base_triangles: meta.base_triangles as u32,
        updates: meta.updates as u32,
        normals: meta.has(HAS_NORMALS) || meta.has(HAS_BASE_NORMALS),
        colors: meta.has(HAS_COLORS) || meta.has(HAS_BASE_COLORS),
        base_error: pages.iter().map(|p| p.max_error).fold(meta.floor_error, f32::max),
        floor_error: meta.floor_error,
        sections: sections
            .iter()
            .map(|s| SectionInfo { name: s.name, codec: s.codec, offset: s.offset as u64, bytes: s.bytes.len() as u64 })
            .collect(),
        columns: std::iter::zip(page::COLUMNS, totals)
            .map(|(name, bytes)| ColumnInfo { name, bytes })
            .chain(attribute_columns)
            .collect(),
        pages,
    })
}
