//! What a file holds, without unpacking it.

use meshfront_hierarchies::SourceCounts;

use crate::container::{Codec, Section, VERSION, u32_at};

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
    /// Bits per coordinate; `None`: lossless, or a matter of the step.
    pub bits: Option<u32>,
    /// Mesh units between neighbouring grid points or heights; `None`: lossless.
    pub grid_step: Option<f64>,
    /// Vertices of the source.
    pub source_vertices: u32,
    /// Triangles of the source.
    pub source_triangles: u32,
    /// Vertices of the base mesh; `None` where only the hierarchy tells.
    pub base_vertices: Option<u32>,
    /// Triangles of the base mesh; `None` where only the hierarchy tells.
    pub base_triangles: Option<u32>,
    /// Ids of updates.
    pub updates: u32,
    /// Whether vertices have normals of the source.
    pub normals: bool,
    /// Whether vertices have colours.
    pub colors: bool,
    /// Error of the base mesh, mesh units: the largest of any update, or the floor where there is none. `None` where
    /// errors are found on reading.
    pub base_error: Option<f32>,
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
    /// Largest error, mesh units: with all pages before this one applied, the mesh is at most this wrong. `None` where
    /// errors are found on reading.
    pub max_error: Option<f32>,
}

impl Info {
    /// What is the same for all models.
    pub(crate) fn of_file(
        model: &'static str,
        bytes: &[u8],
        head: usize,
        source: SourceCounts,
        sections: &[Section],
    ) -> Info {
        Info {
            version: u32_at(bytes, 8).min(VERSION),
            model,
            bytes: bytes.len() as u64,
            head_bytes: head as u64,
            bits: None,
            grid_step: None,
            source_vertices: source.vertices,
            source_triangles: source.triangles,
            base_vertices: None,
            base_triangles: None,
            updates: 0,
            normals: false,
            colors: false,
            base_error: None,
            floor_error: 0.0,
            sections: sections
                .iter()
                .map(|s| SectionInfo {
                    name: s.name,
                    codec: s.codec,
                    offset: s.offset as u64,
                    bytes: s.bytes.len() as u64,
                })
                .collect(),
            columns: vec![],
            pages: vec![],
        }
    }
}
