//! What a file of this model holds, without unpacking it.

use super::{HAS_BASE_COLORS, HAS_BASE_NORMALS, HAS_COLORS, HAS_NORMALS, MODEL, Opened, PageRow, decode_table, page};
use crate::error::ReadError;
use crate::info::{ColumnInfo, Info, PageInfo};

/// What a file that lies in memory holds. `file` is what errors call it.
///
/// Every checksum is compared, so a file that is not as it was written gives an error; pages are not unpacked.
///
/// # Errors
/// [`ReadError`], with section and offset.
pub fn inspect(bytes: &[u8], file: &str) -> Result<Info, ReadError> {
    inspect_splits(bytes, file, MODEL, page::COLUMNS)
}

/// The same for every model of splits; `columns` are those of its pages.
pub(crate) fn inspect_splits<const N: usize>(
    bytes: &[u8],
    file: &str,
    model: &'static str,
    columns: [&'static str; N],
) -> Result<Info, ReadError> {
    let opened = Opened::new(bytes, file)?;
    let Opened { meta, sections } = &opened;
    let body = opened.section("UPDT");
    let rows = decode_table(opened.section("UTAB"), body, meta).map_err(|f| f.in_file(file))?;
    let mut totals = [0u64; N];
    let mut pages = Vec::with_capacity(rows.len());
    for row in &rows {
        let lengths = page::stream_lengths::<N>(row.page).map_err(|f| f.in_file(file))?;
        for (total, length) in totals.iter_mut().zip(lengths) {
            *total += length as u64;
        }
        pages.push(PageInfo {
            offset: row.page.offset as u64,
            bytes: row.page.bytes.len() as u64,
            first_update: row.first as u32,
            updates: row.updates as u32,
            max_error: Some(row.max_error),
        });
    }
    let attribute_columns = [("normals", "NRML"), ("colors", "COLR")].into_iter().filter_map(|(name, section)| {
        let section = sections.iter().find(|s| s.name == section)?;
        Some(ColumnInfo { name, bytes: section.bytes.len() as u64 })
    });
    Ok(Info {
        columns: std::iter::zip(columns, totals)
            .map(|(name, bytes)| ColumnInfo { name, bytes })
            .chain(attribute_columns)
            .collect(),
        pages,
        ..info_of(model, bytes, body.offset, &opened, &rows)
    })
}

/// What META and UTAB tell.
pub(crate) fn info_of(
    model: &'static str,
    bytes: &[u8],
    head: usize,
    Opened { meta, sections }: &Opened,
    rows: &[PageRow],
) -> Info {
    Info {
        bits: meta.grid.map(|g| g.bits),
        grid_step: meta.grid.map(|g| g.step),
        base_vertices: Some(meta.base_vertices as u32),
        base_triangles: Some(meta.base_triangles as u32),
        updates: meta.updates as u32,
        normals: meta.has(HAS_NORMALS) || meta.has(HAS_BASE_NORMALS),
        colors: meta.has(HAS_COLORS) || meta.has(HAS_BASE_COLORS),
        base_error: Some(rows.iter().map(|row| row.max_error).fold(meta.floor_error, f32::max)),
        floor_error: meta.floor_error,
        ..Info::of_file(model, bytes, head, meta.source, sections)
    }
}
