//! The command from outside: what it prints, leaves on disk and exits with.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// A folder to work in, and the command run there.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Bench {
        Bench { folder: tempfile::tempdir().unwrap() }
    }
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("meshfront"));
        command.current_dir(self.folder.path()).args(line.split_whitespace()).stdin(Stdio::null());
        command
    }
    fn run(&self, line: &str) -> Ran {
        let Output { status, stdout, stderr } = self.command(line).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Ran { line: line.to_owned(), code: status.code(), out: text(stdout), err: text(stderr) }
    }
    /// Runs a command that must succeed.
    fn ok(&self, line: &str) -> Ran {
        let ran = self.run(line);
        assert_eq!(ran.code, Some(0), "meshfront {line}\n{}", ran.err);
        ran
    }
    fn json(&self, line: &str) -> Value {
        let ran = self.ok(line);
        serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("meshfront {line}: {e} in\n{}", ran.out))
    }
    /// Everything in the folder, hidden files too.
    fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
    /// A bumpy closed mesh with holes, and its hierarchy.
    fn with_scan(triangles: usize) -> Bench {
        let bench = Bench::new();
        bench.ok(&format!("sample scan -o scan.ply --triangles {triangles}"));
        bench.ok("build scan.ply -o scan.front");
        bench
    }
}

struct Ran {
    line: String,
    code: Option<i32>,
    out: String,
    err: String,
}

impl Ran {
    /// Failed with this code, with one line that says all of this, and nothing on standard output.
    fn failed(&self, code: i32, says: &[&str]) {
        assert_eq!(self.code, Some(code), "meshfront {}\n{}", self.line, self.err);
        assert_eq!(self.out, "", "meshfront {}", self.line);
        if code == 1 {
            assert_eq!(self.err.trim_end().lines().count(), 1, "meshfront {}\n{}", self.line, self.err);
        }
        for word in says {
            assert!(self.err.contains(word), "meshfront {} does not say {word:?} but\n{}", self.line, self.err);
        }
        for word in ["panicked", "backtrace", "Error {", "Os {"] {
            assert!(!self.err.contains(word), "meshfront {} says\n{}", self.line, self.err);
        }
    }
}

fn triangles(bench: &Bench, file: &str) -> u64 {
    bench.json(&format!("info {file} --json"))["triangles"].as_u64().unwrap()
}

#[test]
fn from_sample_to_extracted_mesh() {
    let bench = Bench::with_scan(4_000);
    let source = triangles(&bench, "scan.ply");
    let diagonal = bench.json("info scan.front --json")["bounds"]["diagonal"].as_f64().unwrap();
    for format in ["ply", "obj", "stl", "off", "glb", "ply.gz"] {
        bench.ok(&format!("extract scan.front -o out.{format} --error 1%"));
        let coarse = triangles(&bench, &format!("out.{format}"));
        assert!(coarse > 0 && coarse < source / 2, "{format}: {coarse} of {source}");
        let distance = bench.json(&format!("compare scan.ply out.{format} --samples 20000 --json"));
        let (measured, promised) = (distance["a_to_b"]["max"].as_f64().unwrap(), 0.01 * diagonal);
        assert!(measured > 0.0 && measured <= promised, "{format}: {measured} where {promised} is promised");
    }
    // The same tolerance in mesh units is the same mesh.
    bench.ok(&format!("extract scan.front -o same.ply --error {}", 0.01 * diagonal as f32));
    assert_eq!(triangles(&bench, "same.ply"), triangles(&bench, "out.ply"));
}

#[test]
fn extracting_by_size_keeps_to_the_size_and_uses_it() {
    let bench = Bench::with_scan(4_000);
    let source = triangles(&bench, "scan.ply");
    bench.ok("extract scan.front -o n.ply --triangles 1000");
    let n = triangles(&bench, "n.ply");
    assert!((900..=1000).contains(&n), "{n}");
    bench.ok("extract scan.front -o r.ply --ratio 0.5");
    let r = triangles(&bench, "r.ply");
    assert!(r <= source / 2 && r > source * 9 / 20, "{r} of {source}");
    bench.ok("extract scan.front -o all.ply --ratio 1");
    assert_eq!(triangles(&bench, "all.ply"), source);
    bench.run("extract scan.front -o none.ply --triangles 1").failed(1, &["scan.front", "base mesh has"]);
    assert!(!bench.path("none.ply").exists());
}

#[test]
fn extracting_for_a_view_or_a_region_is_fine_there_alone() {
    let bench = Bench::with_scan(4_000);
    bench.ok("extract scan.front -o near.ply --eye 0,0,3 --target 0,0,0 --pixels 1");
    bench.ok("extract scan.front -o far.ply --eye 0,0,300 --target 0,0,0 --pixels 1");
    bench.ok("extract scan.front -o away.ply --eye 0,0,3 --target 0,0,9 --pixels 1");
    let [near, far, away] = ["near.ply", "far.ply", "away.ply"].map(|file| triangles(&bench, file));
    assert!(near > 2 * far && near > 2 * away, "near {near}, far {far}, looking away {away}");

    let said = bench.ok("extract scan.front -o region.ply --error 0.01% --region sphere:1,0,0,0.4 --outside 5%").err;
    assert!(said.contains("inside the region") && said.contains("anywhere"), "{said}");
    bench.ok("extract scan.front -o everywhere.ply --error 0.01%");
    bench.ok("extract scan.front -o box.ply --triangles 1500 --region box:0.6,-2,-2,2,2,2");
    let [region, everywhere, boxed] = ["region.ply", "everywhere.ply", "box.ply"].map(|file| triangles(&bench, file));
    assert!(region < everywhere * 3 / 4, "{region} of {everywhere}");
    assert!(boxed <= 1500);
    // Inside of the region the source is met closely, outside it need not be.
    let apart = bench.json("compare scan.ply region.ply --samples 50000 --json");
    let farthest = apart["a_to_b"]["farthest"].as_array().unwrap();
    let x: Vec<f64> = farthest.iter().map(|x| x.as_f64().unwrap()).collect();
    let from_center = ((x[0] - 1.0).powi(2) + x[1].powi(2) + x[2].powi(2)).sqrt();
    assert!(from_center > 0.4, "the worst is at {x:?}, inside of the region");
}

#[test]
fn lossless_keeps_what_bits_round() {
    let bench = Bench::with_scan(1_500);
    bench.ok("build scan.ply -o exact.front --lossless --threads 1");
    bench.ok("build scan.ply -o exact2.front --lossless --threads 3");
    bench.ok("build scan.ply -o rough.front --bits 10");
    let read = |name| std::fs::read(bench.path(name)).unwrap();
    assert_eq!(read("exact.front"), read("exact2.front"), "threads change the file");
    let length = |name| read(name).len();
    assert!(length("rough.front") < length("scan.front") && length("scan.front") < length("exact.front"));
    let max = |name: &str| {
        bench.json(&format!("compare scan.ply {name} --samples 5000 --json"))["symmetric"]["max_relative"]
            .as_f64()
            .unwrap()
    };
    assert!(max("exact.front") < 1e-9, "{}", max("exact.front"));
    let (rough, fine) = (max("rough.front"), max("scan.front"));
    assert!(fine > 0.0 && fine < 1e-4 && rough > 4.0 * fine && rough < 2e-3, "{fine} and {rough}");
    // A warning where more is asked than rounding leaves.
    assert!(bench.ok("extract rough.front -o x.ply --error 0").err.contains("--lossless"));
}

#[test]
fn info_describes_meshes_and_hierarchies() {
    let bench = Bench::with_scan(2_000);
    let mesh = bench.json("info scan.ply --json");
    assert_eq!((&mesh["kind"], &mesh["components"]), (&"mesh".into(), &1.into()));
    assert!(mesh["boundary_edges"].as_u64().unwrap() > 0, "the scan has holes");
    assert_eq!(mesh["non_manifold_edges"], 0);
    let front = bench.json("info scan.front --json");
    assert_eq!(front["kind"], "hierarchy");
    assert_eq!(front["source_triangles"], mesh["triangles"]);
    assert_eq!(front["bytes"], std::fs::metadata(bench.path("scan.front")).unwrap().len());
    for (file, words) in
        [("scan.ply", ["boundary edges", "components"]), ("scan.front", ["updates", "error, base mesh"])]
    {
        let said = bench.ok(&format!("info {file}")).out;
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    }
    // What was dropped is told.
    std::fs::write(bench.path("twice.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nf 1 2 3\nf 4 2 3\nf 1 1 2\n").unwrap();
    let twice = bench.json("info twice.obj --json");
    assert_eq!((&twice["triangles"], &twice["in_file"]["faces"]), (&1.into(), &3.into()));
    assert_eq!(twice["in_file"]["vertices_welded"], 1);
    assert!(bench.ok("build twice.obj -o twice.front").err.contains("welded 1 duplicate vertex"));
}

#[test]
fn a_build_takes_the_model_that_serves_best_and_says_why() {
    let bench = Bench::with_scan(1_000);
    let says = |line: &str, words: &[&str]| {
        let said = bench.ok(line).err;
        words.iter().for_each(|word| assert!(said.contains(word), "{line}\n{said}"));
    };
    says("build scan.ply -o scan.front -f", &["model edge_collapse, since it is a 2-manifold"]);
    // Three sheets on one edge.
    let mut book = "OFF\n14 12 0\n".to_owned();
    (0..2).for_each(|k| book += &format!("0 0 {k}\n"));
    for angle in [0.0f32, 2.0, 4.0] {
        let (x, y) = (angle.cos(), angle.sin());
        (0..2).for_each(|k| book += &format!("{x} {y} {k}\n{} {} {k}\n", 2.0 * x, 2.0 * y));
    }
    for first in [2, 6, 10] {
        let [a, b, c, d] = [first, first + 1, first + 2, first + 3];
        book += &format!("3 0 {a} {c}\n3 0 {c} 1\n3 {a} {b} {d}\n3 {a} {d} {c}\n");
    }
    std::fs::write(bench.path("book.off"), book).unwrap();
    says("build book.off -o book.front", &["model vertex_pair, since it is no 2-manifold at 1 edges and vertices"]);
    bench.ok("sample assembly -o many.ply --triangles 1");
    says("build many.ply -o apart.front", &["model edge_collapse, since it is a 2-manifold", "join its 200 pieces"]);
    says("build many.ply -o many.front --model vertex_pair", &["model vertex_pair;"]);
    assert_eq!(bench.json("info many.front --json")["base_triangles"], 20);
    says("build scan.ply -o pairs.front --pairs geometry-first --metric length", &["vertex_pair, as its options say"]);
    bench
        .run("build scan.ply -o x.front --model edge_collapse --metric length")
        .failed(2, &["--metric", "vertex_pair"]);
    bench.run("build scan.ply -o x.front --longest-join 0.1").failed(2, &["10%"]);
}

#[test]
fn study_compares_the_rules_of_dependency() {
    let bench = Bench::new();
    bench.ok("sample scan -o scan.ply --triangles 3000");
    let said = bench.json("study dependencies scan.ply --tolerance 4 --json --quiet");
    let rules = said["rules"].as_array().unwrap();
    assert_eq!(rules.len(), 5);
    assert!(rules.iter().all(|r| r["triangles"].as_f64().is_some_and(|n| n > 0.0)), "{said}");
    let words = bench.ok("study dependencies scan.ply").out;
    assert!(words.contains("implicit numbers") && words.contains("forced"), "{words}");
    assert_eq!(bench.run("study dependencies none.ply").code, Some(1));
    assert_eq!(bench.run("study dependencies scan.ply --tolerance 0").code, Some(2));
}

#[test]
fn bench_prints_the_figures_and_json() {
    let bench = Bench::with_scan(3_000);
    let said = bench.json("bench scan.front --json --quiet");
    assert_eq!(said["fly_by"]["frames"], 600);
    for figure in [
        "/fly_by/ms/mean",
        "/fly_by/ms/p50",
        "/fly_by/ms/p99",
        "/fly_by/ms/max",
        "/fly_by/triangles_mean",
        "/fly_by/evaluations_per_frame",
        "/fly_by/evaluations_saved",
        "/top_down/updates_per_second",
        "/camera_jump/frames_to_converge",
        "/memory/bytes_per_update",
        "/memory/bytes_per_active_vertex",
    ] {
        assert!(said.pointer(figure).and_then(Value::as_f64).is_some_and(|x| x > 0.0), "{figure} in {said}");
    }
    assert_eq!(said["top_down"]["updates"], said["updates"]);
    let words = bench.ok("bench scan.front").out;
    assert!(words.contains("updates/frame") && words.contains("camera jump"), "{words}");
}

#[test]
fn pipes_are_quiet() {
    let bench = Bench::new();
    let ran = bench.ok("sample knot -o knot.ply --triangles 2000");
    assert_eq!((ran.out.as_str(), ran.err.lines().count()), ("", 1), "{}", ran.err);
    let ran = bench.ok("build knot.ply -o knot.front");
    assert_eq!((ran.out.as_str(), ran.err.lines().count()), ("", 1), "{}", ran.err);
    let ran = bench.ok("extract knot.front -o out.ply --error 1%");
    assert_eq!((ran.out.as_str(), ran.err.lines().count()), ("", 1), "{}", ran.err);
    assert_eq!(bench.ok("info knot.front").err, "");
    let ran = bench.ok("build knot.ply -o knot.front --force --quiet");
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
    assert_eq!(bench.files(), ["knot.front", "knot.ply", "out.ply"]);
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let bench = Bench::new();
    let mut child = bench.command("completions bash").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert_eq!((child.wait().unwrap().code(), err.as_str()), (Some(0), ""));
}

#[test]
fn bad_usage_exits_with_2() {
    let bench = Bench::with_scan(1_500);
    for (line, says) in [
        ("", "Usage"),
        ("frobnicate", "unrecognized subcommand"),
        ("build scan.ply", "--output"),
        ("build scan.ply -o a.front --bits 9", "10..=24"),
        ("build scan.ply -o a.front --bits 12 --lossless", "cannot be used with"),
        ("build scan.ply -o a.front --threads 0", "--threads"),
        ("build scan.ply -o scan.ply --force", "is the input"),
        ("build scan.ply -o ./scan.ply", "is the input"),
        ("build scan.front -o a.front", "is a hierarchy already"),
        ("extract scan.front -o a.ply", "required"),
        ("extract scan.front -o a.ply --error 1% --ratio 0.5", "cannot be used with"),
        ("extract scan.front -o a.ply --error -1", "--error"),
        ("extract scan.front -o a.ply --error much", "is not a number"),
        ("extract scan.front -o a.ply --ratio 1.5", "0 to 1"),
        ("extract scan.front -o a.ply --eye 0,0,1", "--target"),
        ("extract scan.front -o a.ply --eye 0,0 --target 0,0,0", "X,Y,Z"),
        ("extract scan.front -o a.ply --error 1% --region cone:1,2,3", "sphere and box"),
        ("extract scan.front -o a.ply --ratio 0.1 --region sphere:0,0,0,1 --outside 1%", "cannot be used with"),
        ("extract scan.front -o a.png --error 1%", ".ply, .obj, .stl, .off or .glb"),
        ("extract scan.front -o . --error 1%", ".ply, .obj"),
        ("sample cube -o a.ply", "sphere"),
        ("sample sphere -o a.txt", ".ply, .obj"),
        ("sample sphere -o a.ply --triangles 0", "1 to"),
        ("sample sphere -o a.tif", "only terrain has them"),
        ("sample terrain -o a.dem", ".tif, .asc or .png"),
        ("completions tcsh", "possible values"),
    ] {
        let ran = bench.run(line);
        assert_eq!(ran.code, Some(2), "meshfront {line}\n{}", ran.err);
        assert!(ran.err.contains(says), "meshfront {line} does not say {says:?} but\n{}", ran.err);
    }
    assert_eq!(bench.files(), ["scan.front", "scan.ply"]);
}

#[test]
fn terrain_is_written_as_heights() {
    let bench = Bench::new();
    for name in ["t.tif", "t.asc", "t.png", "t.asc.gz"] {
        let ran = bench.ok(&format!("sample terrain -o {name} --triangles 5000"));
        assert!(ran.err.starts_with(&format!("{name}: 51 × 51 heights, 2,601 samples")), "{}", ran.err);
    }
    let magic = |name: &str| std::fs::read(bench.path(name)).unwrap()[..4].to_vec();
    assert_eq!(
        (&magic("t.tif")[..], &magic("t.png")[..], &magic("t.asc")[..]),
        (&b"II*\0"[..], &b"\x89PNG"[..], &b"ncol"[..])
    );
}

#[test]
fn existing_outputs_are_kept_unless_forced() {
    let bench = Bench::with_scan(1_500);
    for (line, output) in [
        ("build scan.ply -o keep.front", "keep.front"),
        ("extract scan.front -o keep.ply --error 1%", "keep.ply"),
        ("sample sphere -o keep.obj --triangles 100", "keep.obj"),
        ("sample terrain -o keep.tif --triangles 100", "keep.tif"),
    ] {
        std::fs::write(bench.path(output), "precious").unwrap();
        bench.run(line).failed(1, &[output, "exists already", "--force"]);
        assert_eq!(std::fs::read(bench.path(output)).unwrap(), b"precious");
        bench.ok(&format!("{line} --force"));
        assert!(std::fs::metadata(bench.path(output)).unwrap().len() > 100);
    }
    // Said before the input is even looked at: nobody waits a minute to hear it.
    bench.run("build not-there.ply -o keep.front").failed(1, &["keep.front", "exists already"]);
}

#[test]
fn bad_files_give_one_line() {
    let bench = Bench::with_scan(1_500);
    let put = |name: &str, bytes: &[u8]| std::fs::write(bench.path(name), bytes).unwrap();
    put("garbage.ply", &[0xa5; 3000]);
    put("garbage.obj", "v 1 2 3\nv 1 2\nf 1 2 3\n".as_bytes());
    put("empty.stl", b"");
    put("points.obj", b"v 0 0 0\nv 1 0 0\n");
    put("garbage.front", b"no hierarchy at all");
    let mut damaged = std::fs::read(bench.path("scan.front")).unwrap();
    put("short.front", &damaged[..damaged.len() / 2]);
    let middle = damaged.len() / 2;
    damaged[middle] ^= 0x10;
    put("damaged.front", &damaged);
    let before = bench.files();

    for (line, says) in [
        ("build not-there.ply -o a.front", vec!["not-there.ply", "cannot be read"]),
        ("build scan.png -o a.front", vec!["scan.png"]),
        ("build garbage.ply -o a.front", vec!["garbage.ply"]),
        ("build garbage.obj -o a.front", vec!["garbage.obj", "line 2"]),
        ("build empty.stl -o a.front", vec!["empty.stl"]),
        ("build points.obj -o a.front", vec!["points.obj", "no triangle"]),
        ("build scan.ply -o nowhere/a.front", vec!["nowhere", "no folder"]),
        ("info garbage.front", vec!["garbage.front", "not a .front file"]),
        ("info short.front", vec!["short.front", "bytes"]),
        ("extract damaged.front -o a.ply --error 1%", vec!["damaged.front", "damaged"]),
        ("extract scan.ply -o a.ply --error 1%", vec!["scan.ply", "meshfront build"]),
        ("compare scan.ply points.obj", vec!["points.obj", "no triangle"]),
        ("compare scan.ply not-there.obj", vec!["not-there.obj"]),
        ("bench garbage.front", vec!["garbage.front"]),
    ] {
        bench.run(line).failed(1, &says);
    }
    assert_eq!(bench.files(), before, "a failed command left something");
}

#[test]
fn help_has_examples_and_completions_know_the_commands() {
    let bench = Bench::new();
    for command in ["build", "info", "extract", "compare", "view", "bench", "sample", "completions"] {
        let help = bench.ok(&format!("{command} --help")).out;
        assert!(help.contains(&format!("  meshfront {command}")) && help.contains("Examples:"), "{help}");
    }
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = bench.ok(&format!("completions {shell}")).out;
        assert!(script.contains("extract") && script.contains("lossless"), "{shell}");
    }
}

/// A command that runs until it is interrupted.
#[cfg(unix)]
fn interrupt(child: &Child) {
    let pid = rustix::process::Pid::from_child(child);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
}

#[cfg(unix)]
#[test]
fn an_interrupted_build_leaves_nothing() {
    let bench = Bench::new();
    bench.ok("sample scan -o scan.ply --triangles 300000");
    // At several points of its way: reading, simplifying.
    for wait_ms in [100, 1000] {
        let mut child = bench.command("build scan.ply -o scan.front").stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(wait_ms));
        assert_eq!(child.try_wait().unwrap(), None, "the build was over before it could be interrupted");
        interrupt(&child);
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert_eq!(bench.files(), ["scan.ply"]);
    }
}

/// A viewer and where it serves.
struct Viewer {
    child: Child,
    address: String,
}

impl Viewer {
    /// `None` where the page was not built before the command: then it says so, which is checked.
    fn start(bench: &Bench, line: &str) -> Option<Viewer> {
        let mut child = bench.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut url = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut url).unwrap();
        let Some(address) = url.trim_end().strip_prefix("http://").and_then(|rest| rest.strip_suffix('/')) else {
            let mut err = String::new();
            child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
            assert_eq!(child.wait().unwrap().code(), Some(1));
            assert!(err.contains("run `cargo xtask web`"), "{err}");
            return None;
        };
        Some(Viewer { child, address: address.to_owned() })
    }
    /// Head and body of the answer.
    fn get(&self, path: &str, headers: &str) -> (String, Vec<u8>) {
        self.ask("GET", path, headers, b"")
    }
    fn ask(&self, method: &str, path: &str, headers: &str, content: &[u8]) -> (String, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        write!(stream, "{method} {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n").unwrap();
        stream.write_all(content).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
        (String::from_utf8(answer[..end].to_vec()).unwrap().to_lowercase(), answer[end + 4..].to_vec())
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn view_serves_the_page_and_the_model() {
    let bench = Bench::with_scan(1_500);
    let Some(viewer) = Viewer::start(&bench, "view scan.front --no-open --credit Nobody") else { return };
    let host = format!("Host: {}\r\n", viewer.address);
    let file = std::fs::read(bench.path("scan.front")).unwrap();

    let (head, body) = viewer.get("/", &host);
    assert!(head.starts_with("http/1.1 200") && head.contains("text/html"), "{head}");
    assert!(String::from_utf8_lossy(&body).contains("<html"));
    assert!(head.contains("cross-origin-opener-policy: same-origin") && head.contains("cache-control: no-cache"));

    let (head, body) = viewer.get("/model.front", &host);
    assert!(head.starts_with("http/1.1 200") && head.contains("accept-ranges: bytes"), "{head}");
    assert_eq!(body, file);
    let (head, body) = viewer.get("/model.front", &format!("{host}Range: bytes=100-299\r\n"));
    assert!(head.starts_with("http/1.1 206"), "{head}");
    assert!(head.contains(&format!("content-range: bytes 100-299/{}", file.len())), "{head}");
    assert_eq!(body, file[100..300]);
    let (head, _) = viewer.get("/model.front", &format!("{host}Range: bytes={}-\r\n", file.len() + 1));
    assert!(head.starts_with("http/1.1 416"), "{head}");

    let (head, body) = viewer.get("/model.json", &host);
    assert!(head.contains("application/json"), "{head}");
    let card: Value = serde_json::from_slice(&body).unwrap();
    let model = &card["models"][0];
    assert_eq!(
        (&card["name"], &card["credit"], &model["url"]),
        (&"scan.front".into(), &"Nobody".into(), &"model.front".into())
    );
    assert_eq!(model["source"]["triangles"], triangles(&bench, "scan.ply"));

    for path in ["/nothing", "/../Cargo.toml", "/model.front/x", "/%2e%2e/scan.ply"] {
        let (head, _) = viewer.get(path, &host);
        assert!(head.starts_with("http/1.1 404"), "{path}: {head}");
    }
    for foreign in
        ["Host: attacker.example\r\n", "Host: 127.0.0.1.attacker.example\r\n", "Host: localhost.\r\n", "Host: \r\n"]
    {
        let (head, body) = viewer.get("/model.front", foreign);
        assert!(head.starts_with("http/1.1 403"), "{foreign}: {head}");
        assert!(body.len() < 200);
    }
    for near in ["Host: localhost\r\n", "Host: LOCALHOST:9000\r\n", "Host: [::1]:80\r\n"] {
        assert!(viewer.get("/model.json", near).0.starts_with("http/1.1 200"), "{near}");
    }

    // The port is taken now.
    let port = viewer.address.rsplit_once(':').unwrap().1;
    bench.run(&format!("view scan.front --no-open --port {port}")).failed(1, &[port, "taken"]);
}

#[cfg(unix)]
#[test]
fn view_of_several_says_where_they_are() {
    let bench = Bench::with_scan(1_500);
    let call = "view scan.front scan.ply --no-open --at 0,0,0 --at -3,0.5,0,2";
    let Some(viewer) = Viewer::start(&bench, call) else { return };
    let host = format!("Host: {}\r\n", viewer.address);
    let card: Value = serde_json::from_slice(&viewer.get("/model.json", &host).1).unwrap();
    assert_eq!(card["name"], "scan.front, scan.ply");
    let second = &card["models"][1];
    assert_eq!((&second["at"], &second["scale"]), (&serde_json::json!([-3.0, 0.5, 0.0]), &serde_json::json!(2.0)));
    for model in card["models"].as_array().unwrap() {
        let (head, body) = viewer.get(&format!("/{}", model["url"].as_str().unwrap()), &host);
        assert!(head.starts_with("http/1.1 200") && body.len() > 1000, "{head}");
    }
    bench.run("view scan.front --no-open --at 0,0,0 --at 1,1,1").failed(2, &["--at", "2 times for 1 file"]);
    bench.run("view scan.front --no-open --at 1,1").failed(2, &["X,Y,Z"]);
    bench.run("view scan.front --no-open --at 1,1,1,0").failed(2, &["scale"]);
}

/// A mesh that is dropped on the page is sent, built and served; nobody else may ask for that.
#[cfg(unix)]
#[test]
fn view_builds_what_is_dropped_on_the_page() {
    let bench = Bench::with_scan(1_500);
    bench.ok("sample knot -o knot.ply --triangles 3000");
    let Some(viewer) = Viewer::start(&bench, "view scan.front --no-open") else { return };
    let host = format!("Host: {}\r\n", viewer.address);
    let card: Value = serde_json::from_slice(&viewer.get("/model.json", &host).1).unwrap();
    assert_eq!(card["build"], true);

    let build = |name: &str, content: &[u8], headers: &str| {
        let headers = format!("{headers}Content-Length: {}\r\n", content.len());
        viewer.ask("POST", &format!("/build?name={name}"), &headers, content)
    };
    let own = format!("{host}Origin: http://{}\r\nX-Meshfront: build\r\n", viewer.address);
    // Chunked, so one line may come in several pieces: only what is JSON counts.
    let lines = |body: Vec<u8>| -> Vec<Value> {
        let text = String::from_utf8(body).unwrap();
        text.lines().filter_map(|line| serde_json::from_str(line).ok()).filter(Value::is_object).collect()
    };

    let knot = std::fs::read(bench.path("knot.ply")).unwrap();
    let (head, body) = build("knot.ply", &knot, &own);
    assert!(head.starts_with("http/1.1 200") && head.contains("application/x-ndjson"), "{head}");
    let said = lines(body);
    let phases: Vec<&str> = said.iter().filter_map(|line| line["phase"].as_str()).collect();
    assert!(phases.contains(&"read") && phases.contains(&"write"), "{phases:?}");
    let fractions = said.iter().filter_map(|line| line["fraction"].as_f64());
    assert!(fractions.clone().count() > 0 && fractions.clone().all(|part| (0.0..=1.0).contains(&part)));
    let model = &said.last().unwrap()["model"];
    assert_eq!(
        (&model["name"], &model["source"]["triangles"]),
        (&"knot.ply".into(), &triangles(&bench, "knot.ply").into())
    );
    let url = format!("/{}", model["url"].as_str().unwrap());
    let (head, front) = viewer.get(&url, &host);
    assert!(head.starts_with("http/1.1 200"), "{head}");
    std::fs::write(bench.path("served.front"), front).unwrap();
    bench.ok("info served.front");

    // One sentence, without the folder that it lay in for the moment.
    let (_, body) = build("broken.ply", &knot[..knot.len() / 2], &own);
    let last = lines(body).pop().unwrap();
    let error = last["error"].as_str().unwrap();
    assert!(error.starts_with("broken.ply") && !error.contains("upload-"), "{last}");
    let (_, body) = build("notes.txt", b"hello", &own);
    let last = lines(body).pop().unwrap();
    assert!(last["error"].as_str().unwrap().contains("notes.txt"), "{last}");
    let (_, body) = build("..", &knot, &own);
    assert!(lines(body).pop().unwrap()["error"].is_string());

    let foreign = format!("{host}Origin: http://attacker.example\r\nX-Meshfront: build\r\n");
    let silent = format!("{host}Origin: http://{}\r\n", viewer.address);
    for headers in [foreign, silent, "Host: attacker.example\r\nX-Meshfront: build\r\n".into()] {
        assert!(build("knot.ply", &[], &headers).0.starts_with("http/1.1 403"), "{headers}");
    }
    for path in
        ["/dropped/0.front", "/dropped/9.front", "/dropped/1.front/..", "/dropped/1", "/dropped/", "/dropped/..%2fx"]
    {
        assert!(viewer.get(path, &host).0.starts_with("http/1.1 404"), "{path}");
    }
}

#[test]
fn view_of_a_mesh_builds_first_and_cleans_up() {
    let bench = Bench::new();
    bench.ok("sample scan -o scan.ply --triangles 1500");
    let temporary = bench.path("tmp");
    std::fs::create_dir(&temporary).unwrap();
    let mut child = bench.command("view scan.ply --no-open");
    let mut child = child.env("TMPDIR", &temporary).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut url = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut url).unwrap();
    let count = |folder: &Path| std::fs::read_dir(folder).unwrap().count();
    if !url.is_empty() {
        assert_eq!(count(&temporary), 1);
        interrupt(&child);
        let mut err = String::new();
        child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
        assert!(err.contains("meshfront build scan.ply"), "{err}");
        assert_eq!(child.wait().unwrap().code(), Some(0), "ending a viewer is no failure");
    } else {
        child.wait().unwrap();
    }
    assert_eq!(count(&temporary), 0);
    assert_eq!(bench.files(), ["scan.ply", "tmp"]);
}
