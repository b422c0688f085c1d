//! Numbers and words out of the bytes of a text file.
//!
//! Numbers are read where they stand, with `fast-float2`; lines are counted only when something is wrong.

use super::error::{Fail, ReadErrorKind, quote};

/// A place in a text that moves forward.
pub(super) struct Scanner<'a> {
    pub bytes: &'a [u8],
    /// Next byte; at most `bytes.len()`.
    pub at: usize,
}

/// Spaces within a line. `\r` counts, so that both line endings work.
fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | b'\r' | 0x0b | 0x0c)
}

impl<'a> Scanner<'a> {
    pub fn new(bytes: &'a [u8]) -> Scanner<'a> {
        // A byte order mark is no part of the text.
        Scanner { bytes, at: if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 } }
    }

    #[inline]
    pub fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// Bytes not yet read.
    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Skips blanks of this line, and a backslash that continues the line.
    #[inline]
    pub fn skip_blanks(&mut self) {
        while let Some(b) = self.peek() {
            if is_blank(b) {
                self.at += 1;
            } else if b == b'\\' && self.continues_line() {
                self.at = self.bytes[self.at..]
                    .iter()
                    .position(|&b| b == b'\n')
                    .map_or(self.bytes.len(), |n| self.at + n + 1);
            } else {
                break;
            }
        }
    }

    #[cold]
    fn continues_line(&self) -> bool {
        let rest = &self.bytes[self.at + 1..];
        rest.starts_with(b"\n") || rest.starts_with(b"\r\n")
    }

    /// Skips blanks and line ends.
    #[inline]
    pub fn skip_space(&mut self) {
        while self.peek().is_some_and(|b| is_blank(b) || b == b'\n') {
            self.at += 1;
        }
    }

    /// Skips blanks, line ends and comments from `#` to the end of the line.
    pub fn skip_space_and_comments(&mut self) {
        loop {
            self.skip_space();
            if self.peek() != Some(b'#') {
                return;
            }
            self.skip_line();
        }
    }

    /// Moves behind the end of this line.
    #[inline]
    pub fn skip_line(&mut self) {
        self.at = memchr::memchr(b'\n', &self.bytes[self.at..]).map_or(self.bytes.len(), |n| self.at + n + 1);
    }

    /// Whether nothing is left on this line but blanks and a comment; skips the blanks.
    #[inline]
    pub fn line_is_done(&mut self) -> bool {
        self.skip_blanks();
        matches!(self.peek(), None | Some(b'\n' | b'#'))
    }

    /// The rest of this line without its end, and moves behind that.
    pub fn line(&mut self) -> &'a [u8] {
        let start = self.at;
        self.skip_line();
        self.bytes[start..self.at].trim_ascii_end()
    }

    /// The bytes up to the next space or line end; empty at one.
    #[inline]
    pub fn token(&mut self) -> &'a [u8] {
        let start = self.at;
        self.at += self.bytes[start..].iter().take_while(|&&b| !is_blank(b) && b != b'\n').count();
        &self.bytes[start..self.at]
    }

    /// A 32-bit number that may be NaN or infinite. Nothing may stick to it but a space or line end.
    #[inline]
    pub fn any_f32(&mut self, what: &'static str) -> Result<f32, Fail> {
        match fast_float2::parse_partial::<f32, _>(&self.bytes[self.at..]) {
            Ok((value, len)) if self.ends_at(self.at + len) => {
                self.at += len;
                Ok(value)
            }
            _ => Err(self.unexpected(what)),
        }
    }

    /// A finite 32-bit number.
    #[inline]
    pub fn f32(&mut self, what: &'static str) -> Result<f32, Fail> {
        let start = self.at;
        let value = self.any_f32(what)?;
        if value.is_finite() { Ok(value) } else { Err(self.fail_at(start, ReadErrorKind::NotFinite { what })) }
    }

    /// A finite 64-bit number.
    pub fn f64(&mut self, what: &'static str) -> Result<f64, Fail> {
        match fast_float2::parse_partial::<f64, _>(&self.bytes[self.at..]) {
            Ok((value, len)) if self.ends_at(self.at + len) => {
                if !value.is_finite() {
                    return Err(self.fail(ReadErrorKind::NotFinite { what }));
                }
                self.at += len;
                Ok(value)
            }
            _ => Err(self.unexpected(what)),
        }
    }

    /// An integer: a sign or none, and up to 18 digits. Something may stick to it.
    #[inline]
    pub fn integer(&mut self, what: &'static str) -> Result<i64, Fail> {
        let start = self.at;
        let sign = match self.peek() {
            Some(b'-') => -1,
            Some(b'+') => 1,
            _ => 0,
        };
        self.at += (sign != 0) as usize;
        let digits = self.at;
        let mut value = 0i64;
        while let Some(digit) = self.peek().map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
            // Past 18 digits the value may wrap, and is refused below.
            value = value.wrapping_mul(10).wrapping_add(i64::from(digit));
            self.at += 1;
        }
        if self.at == digits || self.at - digits > 18 {
            self.at = start;
            return Err(self.unexpected(what));
        }
        Ok(if sign < 0 { -value } else { value })
    }

    /// An integer to which nothing sticks.
    #[inline]
    pub fn lone_integer(&mut self, what: &'static str) -> Result<i64, Fail> {
        let start = self.at;
        let value = self.integer(what)?;
        if self.ends_at(self.at) {
            Ok(value)
        } else {
            self.at = start;
            Err(self.unexpected(what))
        }
    }

    #[inline]
    fn ends_at(&self, at: usize) -> bool {
        self.bytes.get(at).is_none_or(|&b| is_blank(b) || matches!(b, b'\n' | b'#'))
    }

    /// The error that something else was expected here, or that the file ends here.
    #[cold]
    pub fn unexpected(&self, expected: &str) -> Fail {
        let rest = &self.bytes[self.at..];
        if rest.trim_ascii_start().is_empty() {
            return self.fail(ReadErrorKind::Truncated { expected: expected.to_owned() });
        }
        let token: Vec<u8> = rest.iter().copied().take_while(|&b| !is_blank(b) && b != b'\n').take(32).collect();
        let found = if token.is_empty() { "the end of the line".to_owned() } else { quote(&token) };
        self.fail(ReadErrorKind::Unexpected { expected: expected.to_owned(), found })
    }

    /// An error here.
    #[cold]
    pub fn fail(&self, kind: ReadErrorKind) -> Fail {
        self.fail_at(self.at, kind)
    }

    /// An error at a byte that was read before.
    #[cold]
    pub fn fail_at(&self, at: usize, kind: ReadErrorKind) -> Fail {
        Fail::line(self.bytes, at, kind)
    }
}
