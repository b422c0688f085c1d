//! Rate and speed of the coder: `cargo run --release -p meshfront-format --example rate -- FILE.front [RUNS]`.
//!
//! Reads the file, then packs and unpacks its columns again and prints bits per update and column, and median times.

use std::time::Instant;

use meshfront_format::edge_collapse::{decode, encode, inspect};

fn main() {
    let mut args = std::env::args().skip(1);
    let (Some(path), runs) = (args.next(), args.next()) else {
        return eprintln!("usage: rate FILE.front [RUNS]");
    };
    let runs = runs.and_then(|r| r.parse().ok()).unwrap_or(9);
    let bytes = std::fs::read(&path).expect("readable file");
    let columns = decode(&bytes, &path).expect("sound file");
    let packed = encode(&columns).expect("sound columns");
    let info = inspect(&packed, "packed again").expect("just packed");
    let updates = info.updates.max(1) as f64;
    for c in &info.columns {
        println!("{:>10} {:>9} bytes {:>7.3} bits/update", c.name, c.bytes, 8.0 * c.bytes as f64 / updates);
    }
    let per_vertex = info.bytes as f64 / info.source_vertices.max(1) as f64;
    println!("{:>10} {:>9} bytes {per_vertex:>7.3} bytes/source vertex; head {}", "file", info.bytes, info.head_bytes);
    let median = |work: &dyn Fn()| {
        let mut times: Vec<f64> = (0..runs)
            .map(|_| {
                let start = Instant::now();
                work();
                start.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        times.sort_by(f64::total_cmp);
        times[runs / 2]
    };
    println!("{:>10} {:>9.1} ms", "encode", median(&|| drop(encode(&columns).expect("sound columns"))));
    println!("{:>10} {:>9.1} ms", "decode", median(&|| drop(decode(&packed, "packed").expect("just packed"))));
}
