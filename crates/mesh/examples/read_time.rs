//! Reads meshes and says what they hold and how long each phase took, as medians of seven readings:
//! `cargo run --release -p meshfront-mesh --example read_time -- FILE...`

use std::time::Instant;

use meshfront_mesh::io::{self, Phase, Progress, ReadOptions};

const READINGS: usize = 7;

fn main() {
    for path in std::env::args_os().skip(1) {
        let mut times: [Vec<f64>; 4] = Default::default();
        let mut bytes = 0;
        for reading in 0..READINGS {
            let start = Instant::now();
            // When each phase began; one that did not happen begins with the next.
            let mut begun = [None; 3];
            let mut note = |p: Progress| {
                begun[p.phase as usize].get_or_insert_with(Instant::now);
                bytes = bytes.max(if p.phase == Phase::Decompress { 0 } else { p.total });
            };
            match io::read_with(&path, ReadOptions { progress: Some(&mut note), ..ReadOptions::default() }) {
                Ok(source) if reading == 0 => println!("{}: {}", path.display(), source.report),
                Ok(_) => {}
                Err(error) => {
                    println!("{error}");
                    break;
                }
            }
            let end = Instant::now();
            let clean = begun[Phase::Clean as usize].unwrap_or(end);
            let parse = begun[Phase::Parse as usize].unwrap_or(clean);
            for (list, span) in times.iter_mut().zip([parse - start, clean - parse, end - clean, end - start]) {
                list.push(span.as_secs_f64());
            }
        }
        if times[0].len() < READINGS {
            continue;
        }
        let [load, parse, clean, all] = times.map(|mut list| {
            list.sort_by(f64::total_cmp);
            list[READINGS / 2]
        });
        let rate = bytes as f64 / 1e6 / (parse + clean);
        println!(
            "    load {:.0} ms, parse {:.0} ms, clean {:.0} ms, all {:.0} ms; {rate:.0} MB/s without loading",
            1e3 * load,
            1e3 * parse,
            1e3 * clean,
            1e3 * all
        );
    }
}
