//! The container, the same for all models: header, table of sections, sections. `docs/format.md` has it byte by byte.

use crate::error::{Fault, ReadError};

/// First bytes of every file. As in PNG: not text, and damaged by what damages line ends.
pub const MAGIC: [u8; 8] = *b"\x89FRONT\r\n";
/// The newest version that is read, and the one that is written.
pub const VERSION: u32 = 1;

/// Bytes before the table of sections.
pub(crate) const HEADER_LENGTH: usize = 56;
/// Bytes of a row of the table of sections.
pub(crate) const ROW_LENGTH: usize = 32;
/// More than any model needs; bounds what is read before a checksum was seen.
const MAX_SECTIONS: u32 = 64;
/// Room for a model's name, padded with zeros.
const MODEL_LENGTH: usize = 24;
/// Where the header's checksum lies. It covers the bytes before it and the table of sections.
const CHECKSUM_AT: usize = 52;

/// Flag of a section: readers that do not know it may pass over it.
const OPTIONAL: u32 = 1;

/// How a section's bytes are coded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Codec {
    /// Plain little-endian numbers.
    Stored,
    /// Adaptive asymmetric numeral systems.
    Rans,
}

impl Codec {
    #[cfg(feature = "write")]
    fn number(self) -> u32 {
        match self {
            Codec::Stored => 0,
            Codec::Rans => 1,
        }
    }
    fn of(number: u32) -> Option<Codec> {
        match number {
            0 => Some(Codec::Stored),
            1 => Some(Codec::Rans),
            _ => None,
        }
    }
}

/// A section: where it lies and what it holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section<'a> {
    pub(crate) name: &'static str,
    pub(crate) codec: Codec,
    /// Byte of the file at which `bytes` starts.
    pub(crate) offset: usize,
    pub(crate) bytes: &'a [u8],
}

impl Section<'_> {
    /// A fault at a byte of the section.
    pub(crate) fn fault(&self, at: usize, reason: &'static str) -> Fault {
        Fault { section: self.name, offset: self.offset + at, reason }
    }
}

/// CRC-32 as in PNG, zip and zlib.
pub(crate) fn checksum(bytes: &[u8]) -> u32 {
    crc32fast::hash(bytes)
}

/// A section to write: its name of four letters, codec and bytes.
#[cfg(feature = "write")]
pub(crate) struct Part {
    pub(crate) name: &'static str,
    pub(crate) codec: Codec,
    pub(crate) bytes: Vec<u8>,
}

/// Header, table of sections, sections.
#[cfg(feature = "write")]
pub(crate) fn assemble(model: &str, parts: &[Part]) -> Vec<u8> {
    let start = HEADER_LENGTH + ROW_LENGTH * parts.len();
    let total = start + parts.iter().map(|p| p.bytes.len()).sum::<usize>();
    let mut file = Vec::with_capacity(total);
    file.extend_from_slice(&MAGIC);
    file.extend_from_slice(&VERSION.to_le_bytes());
    file.extend_from_slice(&(parts.len() as u32).to_le_bytes());
    file.extend_from_slice(&(total as u64).to_le_bytes());
    let mut name = [0; MODEL_LENGTH];
    name[..model.len()].copy_from_slice(model.as_bytes());
    file.extend_from_slice(&name);
    file.extend_from_slice(&[0; 8]); // flags, then the checksum, filled in below
    let mut offset = start;
    for part in parts {
        file.extend_from_slice(part.name.as_bytes());
        file.extend_from_slice(&part.codec.number().to_le_bytes());
        file.extend_from_slice(&(offset as u64).to_le_bytes());
        file.extend_from_slice(&(part.bytes.len() as u64).to_le_bytes());
        file.extend_from_slice(&checksum(&part.bytes).to_le_bytes());
        file.extend_from_slice(&0u32.to_le_bytes());
        offset += part.bytes.len();
    }
    let sum = header_checksum(&file[..start]);
    file[CHECKSUM_AT..HEADER_LENGTH].copy_from_slice(&sum.to_le_bytes());
    for part in parts {
        file.extend_from_slice(&part.bytes);
    }
    file
}

fn header_checksum(header_and_table: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&header_and_table[..CHECKSUM_AT]);
    hasher.update(&header_and_table[HEADER_LENGTH..]);
    hasher.finalize()
}

/// Little-endian numbers at a place that is known to exist.
pub(crate) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

/// Little-endian numbers at a place that is known to exist.
pub(crate) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
}

/// Checks the header and the table of sections; gives the model's name and the number of sections.
pub(crate) fn open_header<'a>(bytes: &'a [u8], file: &str) -> Result<(&'a str, usize), ReadError> {
    let (name, count, total) = start_header(bytes, file)?;
    if total != bytes.len() as u64 {
        return Err(ReadError::Length { file: file.into(), found: bytes.len() as u64, expected: total });
    }
    Ok((name, count))
}

/// The same of the first bytes of a file; gives its length besides.
fn start_header<'a>(bytes: &'a [u8], file: &str) -> Result<(&'a str, usize, u64), ReadError> {
    let length_error = |expected: u64| ReadError::Length { file: file.into(), found: bytes.len() as u64, expected };
    let header_fault = |offset, reason| Fault { section: "header", offset, reason }.in_file(file);
    if bytes.len() < MAGIC.len() || bytes[..MAGIC.len()] != MAGIC {
        return Err(ReadError::NotFront { file: file.into() });
    }
    if bytes.len() < HEADER_LENGTH {
        return Err(length_error(HEADER_LENGTH as u64));
    }
    let version = u32_at(bytes, 8);
    if version == 0 {
        return Err(header_fault(8, "version 0"));
    }
    if version > VERSION {
        return Err(ReadError::NewerVersion { file: file.into(), found: version, known: VERSION });
    }
    let count = u32_at(bytes, 12);
    if count > MAX_SECTIONS {
        return Err(header_fault(12, "too many sections"));
    }
    let total = u64_at(bytes, 16);
    let start = HEADER_LENGTH + ROW_LENGTH * count as usize;
    if total < start as u64 || bytes.len() < start {
        return Err(length_error(total.max(start as u64)));
    }
    if u32_at(bytes, CHECKSUM_AT) != header_checksum(&bytes[..start]) {
        return Err(header_fault(CHECKSUM_AT, "checksum of header and section table is wrong"));
    }
    let name = &bytes[24..24 + MODEL_LENGTH];
    let name = &name[..name.iter().position(|&b| b == 0).unwrap_or(MODEL_LENGTH)];
    let name = std::str::from_utf8(name).map_err(|_| header_fault(24, "the model's name is not text"))?;
    Ok((name, count as usize, total))
}

/// A row of the table of sections.
struct Row<'a> {
    letters: &'a [u8],
    codec: u32,
    offset: u64,
    length: u64,
    checksum: u32,
    flags: u32,
}

impl<'a> Row<'a> {
    /// Of a table that is known to be there.
    fn of(bytes: &'a [u8], row: usize) -> Row<'a> {
        let row = &bytes[HEADER_LENGTH + ROW_LENGTH * row..][..ROW_LENGTH];
        Row {
            letters: &row[..4],
            codec: u32_at(row, 4),
            offset: u64_at(row, 8),
            length: u64_at(row, 16),
            checksum: u32_at(row, 24),
            flags: u32_at(row, 28),
        }
    }
    fn name(&self, known: &[&'static str]) -> Option<&'static str> {
        known.iter().copied().find(|n| n.as_bytes() == self.letters)
    }
}

/// The model's name, and those of the sections that lie within the first bytes of a file and are as they were written.
pub(crate) fn start<'a>(bytes: &'a [u8], known: &[&'static str]) -> Option<(&'a str, Vec<Section<'a>>)> {
    let (model, count, _) = start_header(bytes, "").ok()?;
    let row = |row: usize| {
        let row = Row::of(bytes, row);
        let (offset, length) = (usize::try_from(row.offset).ok()?, usize::try_from(row.length).ok()?);
        let body = bytes.get(offset..offset.checked_add(length)?)?;
        let section = Section { name: row.name(known)?, codec: Codec::of(row.codec)?, offset, bytes: body };
        (row.checksum == checksum(body)).then_some(section)
    };
    Some((model, (0..count).filter_map(row).collect()))
}

/// As much of a section as lies within the first bytes of a file, checksum or not; for one whose parts have their own.
pub(crate) fn start_of<'a>(bytes: &'a [u8], name: &str) -> Option<&'a [u8]> {
    let (_, count, _) = start_header(bytes, "").ok()?;
    let row = (0..count).map(|row| Row::of(bytes, row)).find(|row| row.letters == name.as_bytes())?;
    let there = bytes.get(usize::try_from(row.offset).ok()?..)?;
    Some(&there[..usize::try_from(row.length).ok()?.min(there.len())])
}

/// The sections of a file, in order; those that may be passed over are, if not among `known`.
///
/// When this returns, every byte of the file has been covered by a checksum that was right, and the sections lie one
/// after the other without gaps. Nothing is allocated but the list of sections.
pub(crate) fn open<'a>(bytes: &'a [u8], file: &str, known: &[&'static str]) -> Result<Vec<Section<'a>>, ReadError> {
    let (_, count) = open_header(bytes, file)?;
    let length_error = |expected: u64| ReadError::Length { file: file.into(), found: bytes.len() as u64, expected };
    let header_fault = |offset, reason| Fault { section: "header", offset, reason }.in_file(file);
    let start = HEADER_LENGTH + ROW_LENGTH * count;
    let unknown = |section: String, what: String| ReadError::UnknownPart { file: file.into(), section, what };
    let flags = u32_at(bytes, 48);
    if flags != 0 {
        return Err(unknown("header".into(), format!("flags {flags:#x}")));
    }

    let mut sections = Vec::with_capacity(count);
    let mut end = start;
    for number in 0..count {
        let (at, row) = (HEADER_LENGTH + ROW_LENGTH * number, Row::of(bytes, number));
        if row.offset != end as u64 || row.length > (bytes.len() - end) as u64 {
            return Err(header_fault(at, "sections do not follow one another"));
        }
        let offset = end;
        end += row.length as usize;
        let body = &bytes[offset..end];
        let Some(name) = row.name(known) else {
            if row.flags & OPTIONAL != 0 && row.checksum == checksum(body) {
                continue;
            }
            return Err(unknown(String::from_utf8_lossy(row.letters).into_owned(), "a section".into()));
        };
        if sections.iter().any(|s: &Section| s.name == name) {
            return Err(header_fault(at, "section listed twice"));
        }
        let codec = Codec::of(row.codec).ok_or_else(|| unknown(name.into(), format!("codec {}", row.codec)))?;
        let section = Section { name, codec, offset, bytes: body };
        if row.checksum != checksum(body) {
            return Err(section.fault(0, "checksum is wrong").in_file(file));
        }
        sections.push(section);
    }
    if end != bytes.len() {
        return Err(length_error(end as u64));
    }
    Ok(sections)
}
