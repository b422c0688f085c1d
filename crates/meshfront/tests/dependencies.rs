//! The rules of dependency on one flight: what must hold whatever the figures.

use meshfront::dependencies::{DependencyOptions, dependencies};
use meshfront::{EdgeCollapseOptions, mesh::sample};

#[test]
fn the_less_order_the_less_is_forced() {
    let options = DependencyOptions {
        build: EdgeCollapseOptions { bits: Some(16), base_triangles: 100 },
        tolerance_px: 4.0,
        look_every: 60,
        runs: 1,
    };
    let found = dependencies(&sample::scan(6_000), &options, &()).expect("a sound mesh");
    let [lists, neighbours, numbers, faces, none] = &found.rules[..] else { panic!("{:?}", found.rules) };
    for same in [neighbours, numbers] {
        assert_eq!((same.wanted, same.forced_per_wanted), (lists.wanted, lists.forced_per_wanted));
        assert_eq!((same.triangles, same.error_px_max), (lists.triangles, lists.error_px_max));
        assert_eq!((same.foreign, same.folded), (0.0, lists.folded));
    }
    assert!(lists.error_px_max <= 4.0 && lists.foreign == 0.0);
    assert!(lists.wanted > 100.0 && lists.wanted == none.wanted, "all are asked for the same");
    assert!(none.forced_per_wanted < faces.forced_per_wanted && faces.forced_per_wanted < lists.forced_per_wanted);
    assert!(none.triangles < faces.triangles && faces.triangles < lists.triangles);
    assert!(none.foreign > 0.0 && faces.foreign > 0.0);
    assert!(none.bytes_per_update == 0.0 && numbers.bytes_per_update < 1.0);
    assert!(lists.bytes_per_update < neighbours.bytes_per_update);
}
