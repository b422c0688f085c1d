//! `meshfront extract`: a mesh out of a hierarchy, and what is promised of it.

use anyhow::{Result, bail};
use meshfront::compare::Surface;
use meshfront::refine::criteria::{Region, Scale, Uniform};
use meshfront::refine::{Camera, Criterion, Request, ViewOptions, view};
use meshfront::{Extracted, Hierarchy, extract, extract_cells, with_model};

use crate::args::{Extract, Tolerance};
use crate::progress::Phases;
use crate::{input, output, text};

pub fn run(args: &Extract, quiet: bool) -> Result<()> {
    output::check_mesh_name(&args.output)?;
    output::check(&args.output, &[&args.file], args.force)?;
    let phases = Phases::new(quiet);
    phases.start("read");
    let hierarchy = input::hierarchy(&args.file)?;
    phases.start("refine");
    let wanted = Wanted::of(args, &hierarchy);
    let extracted = match wanted.request.max_cells {
        Some(most) if args.region.is_none() => with_model!(&hierarchy, h => extract_cells(h, most)),
        _ => with_model!(&hierarchy, h => extract(h, &wanted.criterion, &wanted.request)),
    };
    if let Some(most) = wanted.request.max_cells
        && extracted.mesh.triangles.len() > most
    {
        let least = text::count(hierarchy.base_triangles() as u64);
        bail!("{}: {most} triangles cannot be had: the base mesh has {least}", args.file.display());
    }
    let promise = promise(args, &hierarchy, &extracted);
    phases.start("write");
    let length = output::write_mesh(&args.output, &extracted.mesh, args.force)?;
    phases.finish();
    if !quiet {
        let triangles = extracted.mesh.triangles.len();
        let share = triangles as f64 / hierarchy.source().triangles.max(1) as f64;
        eprintln!(
            "{}: {} triangles ({} of the source), {}; {promise}",
            args.output.display(),
            text::count(triangles as u64),
            text::percent(share),
            text::bytes(length)
        );
    }
    Ok(())
}

/// The command line as the engine understands it.
struct Wanted {
    criterion: Box<dyn Criterion>,
    request: Request,
}

impl Wanted {
    fn of(args: &Extract, hierarchy: &Hierarchy) -> Wanted {
        let diagonal = hierarchy.bounds().diagonal();
        // Tolerances are divided by each other below: an error of exactly 0 is as good as one far below rounding.
        let least = f32::MIN_POSITIVE.max(1e-12 * diagonal);
        let mesh_units = |t: Tolerance| t.in_mesh_units(diagonal).max(least);
        let (criterion, request): (Box<dyn Criterion>, Request) = if let Some(error) = args.error {
            (Box::new(Uniform), Request::tolerance(mesh_units(error)))
        } else if let Some(camera) = camera(args, diagonal) {
            (Box::new(view(&camera, ViewOptions::default())), Request::tolerance(args.pixels))
        } else {
            let of_source = |ratio: f64| (ratio * hierarchy.source().triangles as f64) as usize;
            let most = args.triangles.or(args.ratio.map(of_source));
            (Box::new(Uniform), Request { max_cells: most, ..Request::tolerance(0.0) })
        };
        let Some(shape) = args.region else { return Wanted { criterion, request } };
        // One tolerance for both sides: outside, errors count by how much larger they may be there.
        let factor = args.outside.map_or(0.0, |outside| request.tolerance / mesh_units(outside));
        let outside = Scale { inner: Uniform, factor };
        Wanted { criterion: Box::new(Region { shape, inside: criterion, outside }), request }
    }
}

fn camera(args: &Extract, diagonal: f32) -> Option<Camera> {
    let (eye, target) = (args.eye?, args.target?);
    let height = args.height as f32;
    Some(Camera {
        eye,
        target,
        up: args.up,
        fov_y: args.fov.to_radians(),
        width_px: args.width.map_or(height * 16.0 / 9.0, |width| width as f32),
        height_px: height,
        // Nearer than this nothing could be told apart anyway.
        near: (1e-3 * diagonal).max(f32::MIN_POSITIVE),
    })
}

/// What the file may be relied on for, in words.
fn promise(args: &Extract, hierarchy: &Hierarchy, extracted: &Extracted) -> String {
    let diagonal = hierarchy.bounds().diagonal();
    let floor = hierarchy.floor_error();
    let length = |error: f32| {
        let share = if diagonal > 0.0 { (error / diagonal) as f64 } else { 0.0 };
        format!("{} ({} of the diagonal)", text::length(error as f64), text::percent(share))
    };
    let everywhere = length(extracted.error);
    let place = if args.region.is_some() { " inside the region" } else { "" };
    let mut promise = if let Some(camera) = camera(args, diagonal) {
        // Rounding is part of every update's error; where all updates are applied it is all that is left.
        let nearest = Surface::new(&extracted.mesh).map_or(0.0, |surface| surface.distance(camera.eye) as f32);
        let pixels_per_radian = camera.height_px / (2.0 * (0.5 * camera.fov_y).tan());
        let rounding = floor * pixels_per_radian / (nearest - floor).max(camera.near);
        format!(
            "at most {:.3} px wrong where it is seen{place}, {everywhere} anywhere",
            extracted.criterion_error.max(rounding)
        )
    } else if args.region.is_some() {
        let inside = length(extracted.criterion_error.max(floor));
        format!("the source is within {inside}{place}, within {everywhere} anywhere")
    } else {
        format!("the source is within {everywhere}")
    };
    if args.error.is_some_and(|error| error.in_mesh_units(diagonal) < floor) {
        promise += "; coordinates are rounded, so closer it cannot be: build with more --bits, or --lossless";
    }
    promise
}
