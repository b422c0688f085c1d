//! How long reading a file of heights takes: `cargo run --release -p meshfront-mesh --example height_time FILE...`.

use std::time::Instant;

use meshfront_mesh::io::height;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for path in std::env::args().skip(1) {
        let start = Instant::now();
        let source = height::read(&path)?;
        let seconds = start.elapsed().as_secs_f64();
        let megabytes = source.report.bytes as f64 / 1e6;
        println!("{path}: {}", source.report);
        println!("  {seconds:.3} s, {:.0} MB/s", megabytes / seconds);
    }
    Ok(())
}
