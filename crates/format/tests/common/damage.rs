//! Files that are not as they were written.

use super::Random;
use super::checksums::repair;

/// Every shorter length, and a change of any one byte, must be seen: `reads` says whether a file is read, `inspects` whether it
/// is looked into.
pub fn is_checked(file: &[u8], reads: impl Fn(&[u8], &str) -> bool, inspects: impl Fn(&[u8], &str) -> bool) {
    for length in 0..file.len() {
        assert!(!reads(&file[..length], "cut.front") && !inspects(&file[..length], "cut.front"), "{length} bytes");
    }
    for at in 0..file.len() {
        let mut changed = file.to_vec();
        changed[at] ^= 0x41;
        assert!(!reads(&changed, "changed.front"), "byte {at}");
    }
}

/// The file with one to three other bytes, which checksums do not tell.
pub fn unnoticed(file: &[u8], random: &mut Random) -> Vec<u8> {
    let mut changed = file.to_vec();
    for _ in 0..1 + random.below(3) {
        let at = random.below(file.len() as u64) as usize;
        changed[at] = random.bits() as u8;
    }
    repair(&mut changed);
    changed
}
