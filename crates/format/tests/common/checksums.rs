//! Makes a changed file's checksums right again, so that what lies behind them is reached. Written after
//! `docs/format.md`; shares no code with the reader.

fn number(bytes: &[u8], at: usize) -> usize {
    bytes.get(at..at + 4).map_or(0, |b| u32::from_le_bytes(b.try_into().unwrap()) as usize)
}

fn put(bytes: &mut [u8], at: usize, value: u32) {
    if let Some(place) = bytes.get_mut(at..at + 4) {
        place.copy_from_slice(&value.to_le_bytes());
    }
}

/// Repairs the length, the pages' checksums, the sections' and the header's, as far as the file's own numbers allow.
pub fn repair(file: &mut [u8]) {
    let length = file.len() as u32;
    if length < 56 {
        return;
    }
    put(file, 16, length);
    put(file, 20, 0);
    let rows = number(file, 12).min(64);
    let section = |file: &[u8], name: &[u8]| {
        (0..rows).map(|row| 56 + 32 * row).find_map(|at| {
            let (start, bytes) = (number(file, at + 8), number(file, at + 16));
            (file.get(at..at + 4)? == name && start + bytes <= file.len()).then_some(start..start + bytes)
        })
    };
    for (table, body, row_length, sum_at) in
        [(b"UTAB", b"UPDT", 16, 12), (b"NTAB", b"NRML", 8, 4), (b"CTAB", b"COLR", 8, 4)]
    {
        let (Some(table), Some(body)) = (section(file, table), section(file, body)) else { continue };
        let mut page = body.start;
        for row in table.step_by(row_length) {
            let end = page + number(file, row);
            if end > body.end {
                break;
            }
            let sum = crc32fast::hash(&file[page..end]);
            put(file, row + sum_at, sum);
            page = end;
        }
    }
    for at in (0..rows).map(|row| 56 + 32 * row) {
        let (start, bytes) = (number(file, at + 8), number(file, at + 16));
        if let Some(body) = file.get(start..start.saturating_add(bytes)) {
            let sum = crc32fast::hash(body);
            put(file, at + 24, sum);
        }
    }
    let end = (56 + 32 * rows).min(file.len());
    let covered = [&file[..52], &file[56..end]].concat();
    put(file, 52, crc32fast::hash(&covered));
}
