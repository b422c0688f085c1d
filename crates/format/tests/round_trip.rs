//! What is written is what is read.

mod common;

use common::{Shape, plausible};
use meshfront_format::{PAGE_UPDATES, decode, encode, inspect};

#[test]
fn all_kinds_of_columns_come_back() {
    for bits in [None, Some(10), Some(16), Some(24)] {
        for flags in 0..8 {
            for updates in [0, 1, 300] {
                let attributes = updates > 0;
                let (normals, colors) = (attributes && flags & 1 != 0, attributes && flags & 2 != 0);
                let columns = plausible(Shape { updates, bits, normals, colors, explicit: flags & 4 != 0 }, 7);
                let bytes = encode(&columns).unwrap();
                assert_eq!(decode(&bytes, "test").unwrap(), columns);
            }
        }
    }
}

#[test]
fn pages_join_without_a_seam() {
    for updates in [PAGE_UPDATES - 1, PAGE_UPDATES, PAGE_UPDATES + 1, 3 * PAGE_UPDATES + 17] {
        let shape = Shape { updates, bits: Some(14), normals: true, colors: true, explicit: true };
        let columns = plausible(shape, 1);
        let bytes = encode(&columns).unwrap();
        assert_eq!(decode(&bytes, "test").unwrap(), columns);
        let info = inspect(&bytes, "test").unwrap();
        assert_eq!(info.pages.len(), updates.div_ceil(PAGE_UPDATES));
        assert_eq!(info.pages.iter().map(|p| p.updates as usize).sum::<usize>(), updates);
    }
}
