//! Reads meshes and says what they hold and how long it took: `cargo run --release --example read_time -- FILE...`

use std::time::Instant;

use meshfront_mesh::io;

fn main() {
    for path in std::env::args_os().skip(1) {
        let mut seconds = Vec::new();
        for _ in 0..5 {
            let start = Instant::now();
            match io::read(&path) {
                Ok(source) => {
                    if seconds.is_empty() {
                        println!("{}: {}", path.display(), source.report);
                    }
                }
                Err(error) => {
                    println!("{error}");
                    break;
                }
            }
            seconds.push(start.elapsed().as_secs_f64());
        }
        seconds.sort_by(f64::total_cmp);
        if let Some(s) = seconds.get(2) {
            println!("    median of 5: {:.1} ms", s * 1e3);
        }
    }
}
