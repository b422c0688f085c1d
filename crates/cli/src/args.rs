//! What may stand on the command line. Every value is checked here, so that commands see only what they can use.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::{ArgGroup, Args, Parser, Subcommand, ValueHint};
use glam::Vec3;
use meshfront::hierarchies::vertex_removal::Connectivity;
use meshfront::mesh::sample::Sample;
use meshfront::refine::criteria::Shape;
use meshfront::simplify::metrics::MetricChoice;
use meshfront::simplify::{Pairs, VertexPairOptions};

/// Multiresolution meshes: build one, look at it from anywhere, take meshes of any size out of it.
#[derive(Parser)]
#[command(name = "meshfront", version, propagate_version = true, arg_required_else_help = true)]
#[command(after_help = "\
Examples:
  meshfront view scan.ply                        look at a mesh, refined for where you look from
  meshfront build scan.ply -o scan.front         make a hierarchy once, to open quickly ever after
  meshfront extract scan.front -o small.glb --error 0.1%
                                                 a mesh at most 0.1 % of the diagonal away from the scan
  meshfront compare scan.ply small.glb           and the measurement that proves it")]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    /// Say nothing but errors on the terminal
    #[arg(short, long, global = true)]
    pub quiet: bool,
}

#[derive(Subcommand)]
pub enum Command {
    Build(Build),
    Info(Info),
    Extract(Extract),
    Compare(Compare),
    View(View),
    Bench(Bench),
    Study(Study),
    Sample(MakeSample),
    Completions(Completions),
}

/// Read a mesh or heights, build the hierarchy with measured errors, and write it
///
/// SOURCE is a mesh (OFF, OBJ, PLY, STL, glTF or GLB, also as .gz) or heights over a grid (GeoTIFF, PNG of 8 or 16 bits,
/// USGS DEM or ESRI ASCII grid, the last two also as .gz).
#[derive(Args)]
#[command(after_help = "\
Examples:
  meshfront build dragon.ply.gz -o dragon.front
  meshfront build part.stl -o part.front --bits 20     finer coordinates, a larger file
  meshfront build part.stl -o part.front --lossless    every coordinate as it was
  meshfront build machine.glb -o machine.front --model vertex_pair    many parts: they join
  meshfront build helens.dem -o helens.front --exaggeration 1.5")]
pub struct Build {
    #[arg(value_hint = ValueHint::FilePath)]
    pub source: PathBuf,
    /// The .front file to write
    #[arg(short, long, value_name = "FILE.front", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    #[command(flatten)]
    pub recipe: Recipe,
    /// Replace the output if it exists
    #[arg(short, long)]
    pub force: bool,
}

/// How to build.
#[derive(Args, Clone, Copy)]
pub struct Recipe {
    /// The multiresolution model
    #[arg(long, value_name = "NAME", value_enum, default_value_t = Choice::Auto)]
    pub model: Choice,
    #[command(flatten)]
    pub precision: Precision,
    #[command(flatten)]
    pub pairing: Pairing,
    /// Vertex removal only: how the file says which triangulation each polygon has [default: turned, the smallest]
    #[arg(long, value_name = "CODE", value_enum, help_heading = "Vertex removal")]
    pub connectivity: Option<Code>,
    /// Heights only: how many times too high to make the terrain
    #[arg(long, value_name = "F", default_value_t = 1.0, value_parser = exaggeration)]
    pub exaggeration: f32,
    #[command(flatten)]
    pub threads: Threads,
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
#[value(rename_all = "snake_case")]
pub enum Choice {
    /// Right triangles for heights, edge collapse for 2-manifolds, vertex pairs for what is none and has many flaws or parts
    Auto,
    /// Any mesh, non-manifold ones too; as a mesh, heights as well
    EdgeCollapse,
    /// Heights over a grid: errors are the true vertical distance
    RightTriangles,
    /// Any mesh, of many parts too: topology changes, parts join, and a few triangles are left
    VertexPair,
    /// 2-manifolds, with or without boundary: the vertices of all levels are those of the source
    VertexRemoval,
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// A number in a table of all patterns: 13 bits (Klein and Gumhold)
    Table,
    /// The number among the triangulations of its polygon (Andújar and De Floriani)
    Index,
    /// A bit for each corner: whether it is cut off next (De Floriani and others)
    Ears,
    /// Two bits a triangle: whether others are to its left and to its right (Taubin and others)
    Sides,
    /// As index, turned to the least number
    Turned,
}

impl Code {
    pub fn connectivity(self) -> Connectivity {
        match self {
            Code::Table => Connectivity::Table,
            Code::Index => Connectivity::Index,
            Code::Ears => Connectivity::Ears,
            Code::Sides => Connectivity::Sides,
            Code::Turned => Connectivity::Turned,
        }
    }
}

/// How vertex pairs merge.
#[derive(Args, Clone, Copy)]
#[command(next_help_heading = "Vertex pairs")]
pub struct Pairing {
    /// What goes first: all merges that keep the topology, or whatever is cheapest [default: equal]
    #[arg(long, value_name = "ORDER", value_enum)]
    pub pairs: Option<PairOrder>,
    /// What a merge costs at the least: distance from the source's planes, or how far vertices travel [default: quadric]
    #[arg(long, value_name = "NAME", value_enum)]
    pub metric: Option<Cost>,
    /// Faces end where their mean normals differ by more: vertices there may join others in space [default: 30]
    #[arg(long, value_name = "DEG", value_parser = degrees)]
    pub patch_angle: Option<f32>,
    /// The longest way across which vertices join that no edge joins, as a share of the diagonal; 0%: none [default: 10%]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub longest_join: Option<f32>,
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
pub enum PairOrder {
    /// For as long as there is an edge whose collapse keeps the topology, nothing else merges
    GeometryFirst,
    /// All pairs by their cost
    Equal,
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
pub enum Cost {
    /// Mean distance from the planes of the triangles that a vertex stands for
    Quadric,
    /// Radius of a ball around the vertices that it stands for
    Length,
}

impl Pairing {
    pub const PLAIN: Pairing = Pairing { pairs: None, metric: None, patch_angle: None, longest_join: None };

    /// An option that was given, if any.
    pub fn given(self) -> Option<&'static str> {
        let all = [
            ("--pairs", self.pairs.is_some()),
            ("--metric", self.metric.is_some()),
            ("--patch-angle", self.patch_angle.is_some()),
            ("--longest-join", self.longest_join.is_some()),
        ];
        all.into_iter().find(|option| option.1).map(|option| option.0)
    }

    pub fn options(self, bits: Option<u32>) -> VertexPairOptions {
        let plain = VertexPairOptions::default();
        VertexPairOptions {
            bits,
            pairs: match self.pairs {
                None => plain.pairs,
                Some(PairOrder::GeometryFirst) => Pairs::GeometryFirst,
                Some(PairOrder::Equal) => Pairs::Equal,
            },
            metric: match self.metric {
                None => plain.metric,
                Some(Cost::Quadric) => MetricChoice::Quadric,
                Some(Cost::Length) => MetricChoice::Length,
            },
            patch_angle: self.patch_angle.map_or(plain.patch_angle, f32::to_radians),
            longest_virtual: self.longest_join.unwrap_or(plain.longest_virtual),
            ..plain
        }
    }
}

#[derive(Args, Clone, Copy)]
pub struct Precision {
    /// Bits per coordinate on the longest side of the bounding box; what rounding moves is part of the promised error
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(10..=24))]
    pub bits: u32,
    /// Keep 32-bit floating-point coordinates as they are
    #[arg(long, conflicts_with = "bits")]
    pub lossless: bool,
}

#[derive(Args, Clone, Copy)]
pub struct Threads {
    /// Threads to compute with [default: one per core]; the result is the same for any number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

impl Recipe {
    /// As if nothing had been asked for.
    pub const PLAIN: Recipe = Recipe {
        model: Choice::Auto,
        precision: Precision { bits: 16, lossless: false },
        pairing: Pairing::PLAIN,
        connectivity: None,
        exaggeration: 1.0,
        threads: Threads { threads: None },
    };
}

impl Precision {
    /// `None`: lossless.
    pub fn bits(self) -> Option<u32> {
        (!self.lossless).then_some(self.bits)
    }
}

fn exaggeration(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("a positive number; 1 leaves heights as they are".into()),
    }
}

impl Threads {
    pub fn pool(self) -> anyhow::Result<rayon::ThreadPool> {
        Ok(rayon::ThreadPoolBuilder::new().num_threads(self.threads.map_or(0, usize::from)).build()?)
    }
}

/// Say what is in a file: a hierarchy or a mesh
#[derive(Args)]
#[command(after_help = "\
Examples:
  meshfront info dragon.front
  meshfront info scan.ply --json | jq .triangles")]
pub struct Info {
    #[arg(value_hint = ValueHint::FilePath)]
    pub file: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Take a mesh out of a hierarchy: as close as asked, as small as asked, or right for one view
///
/// With --error, --triangles or --ratio the mesh is equally good everywhere; with --eye it is as good as --pixels asks
/// where it is seen, and coarse elsewhere. --region limits either to a part of space.
#[derive(Args)]
#[command(group(ArgGroup::new("goal").args(["error", "triangles", "ratio", "eye"]).required(true)))]
#[command(after_help = "\
Examples:
  meshfront extract dragon.front -o close.ply --error 0.05%
  meshfront extract dragon.front -o small.glb --triangles 20000
  meshfront extract dragon.front -o tenth.obj --ratio 0.1
  meshfront extract dragon.front -o seen.ply --eye 0,0.1,0.4 --target 0,0.1,0 --pixels 1
  meshfront extract dragon.front -o head.ply --error 0.01% --region sphere:-0.08,0.15,0,0.03 --outside 1%")]
pub struct Extract {
    /// A .front file
    #[arg(value_hint = ValueHint::FilePath)]
    pub file: PathBuf,
    /// The mesh to write: .ply, .obj, .stl, .off or .glb
    #[arg(short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// Replace the output if it exists
    #[arg(short, long)]
    pub force: bool,

    /// Greatest distance of the source from the mesh: in mesh units, or 0.1% of the bounding box's diagonal
    #[arg(long, value_name = "E", value_parser = tolerance, help_heading = "Equally good everywhere")]
    pub error: Option<Tolerance>,
    /// The best mesh of at most so many triangles
    #[arg(long, value_name = "N", help_heading = "Equally good everywhere")]
    pub triangles: Option<usize>,
    /// The best mesh with at most this share of the source's triangles, 0 to 1
    #[arg(long, value_name = "R", value_parser = ratio, help_heading = "Equally good everywhere")]
    pub ratio: Option<f64>,

    /// Where the eye is, in mesh space
    #[arg(long, value_name = "X,Y,Z", value_parser = point, requires = "target", allow_hyphen_values = true)]
    #[arg(help_heading = "Right for one view")]
    pub eye: Option<Vec3>,
    /// What it looks at
    #[arg(long, value_name = "X,Y,Z", value_parser = point, requires = "eye", allow_hyphen_values = true)]
    #[arg(help_heading = "Right for one view")]
    pub target: Option<Vec3>,
    /// Which way is up
    #[arg(long, value_name = "X,Y,Z", value_parser = point, requires = "eye", allow_hyphen_values = true)]
    #[arg(help_heading = "Right for one view", default_value = "0,1,0")]
    pub up: Vec3,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEG", value_parser = degrees, requires = "eye", default_value = "45")]
    #[arg(help_heading = "Right for one view")]
    pub fov: f32,
    /// Width of the picture in pixels [default: 16/9 of the height]
    #[arg(long, value_name = "PX", requires = "eye", value_parser = clap::value_parser!(u32).range(1..))]
    #[arg(help_heading = "Right for one view")]
    pub width: Option<u32>,
    /// Height of the picture in pixels
    #[arg(long, value_name = "PX", requires = "eye", value_parser = clap::value_parser!(u32).range(1..))]
    #[arg(help_heading = "Right for one view", default_value_t = 1080)]
    pub height: u32,
    /// How many pixels wrong it may be
    #[arg(long, value_name = "P", requires = "eye", value_parser = positive, default_value = "1")]
    #[arg(help_heading = "Right for one view")]
    pub pixels: f32,

    /// Be that good only in sphere:X,Y,Z,RADIUS or box:X0,Y0,Z0,X1,Y1,Z1
    #[arg(long, value_parser = region, help_heading = "In a part of space", allow_hyphen_values = true)]
    pub region: Option<Shape>,
    /// Error allowed outside of the region [default: any]
    #[arg(long, value_name = "E", value_parser = tolerance, requires = "region")]
    #[arg(help_heading = "In a part of space", conflicts_with_all = ["triangles", "ratio"])]
    pub outside: Option<Tolerance>,
}

/// Measure the distance between two surfaces, both ways
///
/// Points on each surface (all vertices, and --samples spread over the area) are measured against the other surface.
/// Relative figures are relative to the diagonal of A's bounding box. A .front stands for its finest mesh.
#[derive(Args)]
#[command(after_help = "\
Examples:
  meshfront compare scan.ply small.glb
  meshfront compare scan.ply scan.front --samples 5000000 --json")]
pub struct Compare {
    #[arg(value_hint = ValueHint::FilePath)]
    pub a: PathBuf,
    #[arg(value_hint = ValueHint::FilePath)]
    pub b: PathBuf,
    /// Points spread over the area of each surface
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = at_most_a_billion)]
    pub samples: usize,
    #[command(flatten)]
    pub threads: Threads,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Open hierarchies or meshes in the browser, side by side under one triangle budget
///
/// Serves on this machine alone, until Ctrl-C. A mesh is made into a hierarchy first, which is kept only while it is
/// looked at; so is one that is dropped on the page. Several files are shown where their coordinates say, each turned so that its up
/// is up, unless `--at` says where.
#[derive(Args)]
#[command(after_help = "\
Examples:
  meshfront view dragon.front
  meshfront view scan.ply
  meshfront view dragon.front --port 8080 --no-open
  meshfront view hill.front statue.front --at 0,0,0 --at 120,35,-80,0.5     the statue on the hill, half as large")]
pub struct View {
    /// .front files, or meshes
    #[arg(value_name = "FILE_OR_SOURCE", value_hint = ValueHint::FilePath, required = true)]
    pub files: Vec<PathBuf>,
    /// Where the origin of a file is shown, y being up, and how many times larger: once per file, in their order
    #[arg(long, value_name = "X,Y,Z[,SCALE]", value_parser = place, allow_hyphen_values = true)]
    pub at: Vec<Place>,
    /// Port on 127.0.0.1; 0 takes any free one
    #[arg(long, default_value_t = 0)]
    pub port: u16,
    /// Only print the address
    #[arg(long)]
    pub no_open: bool,
    /// A line to show with the model: whose it is
    #[arg(long, value_name = "TEXT")]
    pub credit: Option<String>,
}

/// Measure the engine on a hierarchy: a fly-by, full refinement, a camera jump
///
/// The fly-by is 600 frames around and up to the model at 1024 × 1024 and 1 pixel, with frustum and orientation.
#[derive(Args)]
#[command(after_help = "\
Examples:
  meshfront bench dragon.front
  meshfront bench dragon.front --json > bench.json")]
pub struct Bench {
    #[arg(value_hint = ValueHint::FilePath)]
    pub file: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Measure what could have been done otherwise
#[derive(Args)]
pub struct Study {
    #[command(subcommand)]
    pub of: StudyOf,
}

#[derive(Subcommand)]
pub enum StudyOf {
    Dependencies(StudyDependencies),
}

/// Compare five rules of dependency on the same edge collapses: memory, forced updates, triangles, errors, foldovers, time
///
/// A flight around the mesh and up to it, the same for all rules. Forced are updates that are applied although nothing of
/// them is wrong by more than the tolerance.
#[derive(Args)]
pub struct StudyDependencies {
    #[arg(value_hint = ValueHint::FilePath)]
    pub mesh: PathBuf,
    /// Tolerance of the flight, pixels
    #[arg(long, value_name = "PX", default_value_t = 1.0, value_parser = tolerance_px)]
    pub tolerance: f32,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub threads: Threads,
}

/// Make a mesh by procedure, of any size
#[derive(Args)]
#[command(after_help = "\
Examples:
  meshfront sample terrain -o terrain.ply --triangles 2000000
  meshfront sample terrain -o terrain.tif --triangles 2000000     as heights, 30 m apart
  meshfront sample scan -o scan.ply && meshfront view scan.ply")]
pub struct MakeSample {
    /// sphere, knot, terrain (fractal), scan (noise and holes as a scanner makes them), or assembly (200 machine parts)
    #[arg(value_parser = clap::builder::PossibleValuesParser::new(Sample::ALL.map(Sample::name)))]
    pub name: String,
    /// The mesh to write: .ply, .obj, .stl, .off or .glb; terrain also as heights: .tif, .asc or .png
    #[arg(short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// About how many triangles; as heights, two for four neighbouring samples
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = sample_size)]
    pub triangles: usize,
    /// Replace the output if it exists
    #[arg(short, long)]
    pub force: bool,
}

/// Print a completion script for a shell
#[derive(Args)]
#[command(after_help = "\
Examples:
  meshfront completions bash > ~/.local/share/bash-completion/completions/meshfront
  meshfront completions zsh > ~/.zfunc/_meshfront
  meshfront completions fish > ~/.config/fish/completions/meshfront.fish")]
pub struct Completions {
    pub shell: clap_complete::Shell,
}

/// A distance as people give it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// Mesh units.
    Absolute(f32),
    /// A fraction of the bounding box's diagonal.
    OfDiagonal(f32),
}

impl Tolerance {
    pub fn in_mesh_units(self, diagonal: f32) -> f32 {
        match self {
            Tolerance::Absolute(error) => error,
            Tolerance::OfDiagonal(share) => share * diagonal,
        }
    }
}

fn number(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(format!("{text:?} is not a number")),
    }
}

fn numbers<const N: usize>(text: &str, expected: &str) -> Result<[f32; N], String> {
    let all = text.split(',').map(number).collect::<Result<Vec<f32>, String>>()?;
    all.try_into().map_err(|all: Vec<f32>| format!("{} numbers where {expected} has {N}", all.len()))
}

/// Where a model is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    pub at: Vec3,
    pub scale: f32,
}

fn place(text: &str) -> Result<Place, String> {
    if text.matches(',').count() == 2 {
        return Ok(Place { at: point(text)?, scale: 1.0 });
    }
    let [x, y, z, scale] = numbers(text, "X,Y,Z,SCALE")?;
    if scale > 0.0 { Ok(Place { at: Vec3::new(x, y, z), scale }) } else { Err("a scale is above 0".into()) }
}

fn point(text: &str) -> Result<Vec3, String> {
    numbers(text, "X,Y,Z").map(Vec3::from_array)
}

fn not_negative(text: &str) -> Result<f32, String> {
    number(text).and_then(|x| if x >= 0.0 { Ok(x) } else { Err(format!("{x} is negative")) })
}

fn positive(text: &str) -> Result<f32, String> {
    number(text).and_then(|x| if x > 0.0 { Ok(x) } else { Err(format!("{x} is not positive")) })
}

fn tolerance(text: &str) -> Result<Tolerance, String> {
    match text.strip_suffix('%') {
        Some(percent) => not_negative(percent).map(|x| Tolerance::OfDiagonal(x / 100.0)),
        None => not_negative(text).map(Tolerance::Absolute),
    }
}

fn ratio(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (0.0..=1.0).contains(&x) => Ok(x),
        _ => Err(format!("{text:?} is not a number from 0 to 1")),
    }
}

fn degrees(text: &str) -> Result<f32, String> {
    number(text)
        .and_then(|x| if x > 0.0 && x < 180.0 { Ok(x) } else { Err(format!("{x} degrees is not between 0 and 180")) })
}

fn share(text: &str) -> Result<f32, String> {
    let percent = text.strip_suffix('%').ok_or_else(|| format!("{text:?} is not a share such as 10%"))?;
    not_negative(percent).map(|x| x / 100.0)
}

fn region(text: &str) -> Result<Shape, String> {
    let (kind, rest) = text.split_once(':').ok_or("expected sphere:X,Y,Z,RADIUS or box:X0,Y0,Z0,X1,Y1,Z1")?;
    match kind {
        "sphere" => {
            let [x, y, z, radius] = numbers(rest, "sphere:X,Y,Z,RADIUS")?;
            if radius < 0.0 {
                return Err(format!("the radius {radius} is negative"));
            }
            Ok(Shape::Sphere { center: Vec3::new(x, y, z), radius })
        }
        "box" => {
            let [x0, y0, z0, x1, y1, z1] = numbers(rest, "box:X0,Y0,Z0,X1,Y1,Z1")?;
            let (a, b) = (Vec3::new(x0, y0, z0), Vec3::new(x1, y1, z1));
            Ok(Shape::Box { min: a.min(b), max: a.max(b) })
        }
        _ => Err(format!("no region is called {kind:?}: there are sphere and box")),
    }
}

fn count_in(text: &str, range: RangeInclusive<usize>) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(n) if range.contains(&n) => Ok(n),
        _ => Err(format!("{text:?} is not a whole number from {} to {}", range.start(), range.end())),
    }
}

fn tolerance_px(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(px) if px > 0.0 && px.is_finite() => Ok(px),
        _ => Err(format!("{text:?} is not a number of pixels above 0")),
    }
}

fn at_most_a_billion(text: &str) -> Result<usize, String> {
    count_in(text, 0..=1_000_000_000)
}

/// Ids are 32 bits wide, and a closed mesh has half as many vertices as triangles.
fn sample_size(text: &str) -> Result<usize, String> {
    count_in(text, 1..=1_000_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn commands_are_well_formed() {
        Cli::command().debug_assert();
    }

    #[test]
    fn tolerances_are_absolute_or_a_percentage() {
        assert_eq!(tolerance("0.25"), Ok(Tolerance::Absolute(0.25)));
        assert_eq!(tolerance("50%").unwrap().in_mesh_units(8.0), 4.0);
        for bad in ["", "%", "-1", "1e39", "nan", "0.1 percent"] {
            assert!(tolerance(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn regions_are_spheres_and_boxes() {
        assert_eq!(region("sphere:-1,2,3,4"), Ok(Shape::Sphere { center: Vec3::new(-1.0, 2.0, 3.0), radius: 4.0 }));
        let corners_in_any_order = region("box:1,0,5,-1,2,-3").unwrap();
        assert_eq!(corners_in_any_order, Shape::Box { min: Vec3::new(-1.0, 0.0, -3.0), max: Vec3::new(1.0, 2.0, 5.0) });
        for bad in ["sphere", "sphere:1,2,3", "sphere:0,0,0,-1", "cube:0,0,0,1", "box:1,2,3", "box:a,b,c,d,e,f"] {
            assert!(region(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_view_may_lie_on_the_negative_side() {
        let command = ["meshfront", "extract", "a.front", "-o", "b.ply", "--eye", "-1,2,3", "--target", "-.5,0,0"];
        let Command::Extract(extract) = Cli::parse_from(command).command else { panic!() };
        assert_eq!(extract.eye, Some(Vec3::new(-1.0, 2.0, 3.0)));
    }
}
