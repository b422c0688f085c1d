//! Numbers as people read them, and output that a closed pipe does not upset.

use std::io::{ErrorKind, Write};
use std::time::Duration;

/// Prints a result on standard output. A reader that left (`| head`) is no error: there is nobody to tell.
pub fn print(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => Ok(result?),
    }
}

/// Prints a value as JSON on standard output.
pub fn print_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    print(&(serde_json::to_string_pretty(value)? + "\n"))
}

/// 1234567 as 1,234,567.
pub fn count(n: impl TryInto<u64>) -> String {
    let digits = n.try_into().unwrap_or(u64::MAX).to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A length with four significant digits.
pub fn length(x: f64) -> String {
    let magnitude = x.abs().log10().floor();
    if x == 0.0 {
        "0".into()
    } else if (-4.0..6.0).contains(&magnitude) {
        format!("{x:.*}", (3.0 - magnitude).max(0.0) as usize)
    } else {
        format!("{x:.3e}")
    }
}

/// A share as a percentage with three significant digits.
pub fn percent(share: f64) -> String {
    let x = 100.0 * share;
    let magnitude = x.abs().log10().floor();
    if x == 0.0 { "0 %".into() } else { format!("{x:.*} %", (2.0 - magnitude).clamp(0.0, 9.0) as usize) }
}

/// A number of bytes, decimal units.
pub fn bytes(n: u64) -> String {
    let units = [(1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    match units.iter().find(|(size, _)| n as f64 >= *size) {
        Some((size, unit)) => format!("{:.1} {unit}", n as f64 / size),
        None => format!("{n} bytes"),
    }
}

/// A duration with two or three digits.
pub fn seconds(time: Duration) -> String {
    let s = time.as_secs_f64();
    if s < 0.0995 { format!("{:.0} ms", s * 1e3) } else { format!("{s:.*} s", if s < 9.95 { 2 } else { 1 }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped() {
        assert_eq!([0u64, 999, 1000, 871_414, 12_345_678].map(count), ["0", "999", "1,000", "871,414", "12,345,678"]);
    }

    #[test]
    fn lengths_and_shares_keep_their_digits() {
        assert_eq!(
            [0.0, 0.000123456, 1.5, 123.456, 1e-9].map(length),
            ["0", "0.0001235", "1.500", "123.5", "1.000e-9"]
        );
        assert_eq!([0.0, 0.5, 0.001, 0.00000123].map(percent), ["0 %", "50.0 %", "0.100 %", "0.000123 %"]);
        assert_eq!([999, 3_900_000].map(bytes), ["999 bytes", "3.9 MB"]);
    }
}
