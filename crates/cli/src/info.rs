//! `meshfront info`: what is in a file.

use std::path::Path;

use anyhow::Result;
use glam::DVec2;
use meshfront::hierarchies::vertex_removal::encode::{Connectivity, entropy};
use meshfront::mesh::io::ReadReport;
use meshfront::mesh::io::height::is_height_format;
use meshfront::mesh::{Bounds, Unit};
use meshfront::{Hierarchy, RightTriangles, Survey, format, survey};
use serde_json::{Map, json};

use crate::args::Info;
use crate::progress::Phases;
use crate::{input, text};

pub fn run(args: &Info, quiet: bool) -> Result<()> {
    if input::is_front(&args.file)? { hierarchy(&args.file, args.json) } else { source(&args.file, args.json, quiet) }
}

fn hierarchy(path: &Path, as_json: bool) -> Result<()> {
    // Everything is checked, so that a file that `info` describes can be used.
    let hierarchy = input::hierarchy(path)?;
    let info = format::inspect_file(path)?;
    let (bounds, diagonal) = (hierarchy.bounds(), hierarchy.bounds().diagonal() as f64);
    let memory = hierarchy.memory_bytes();
    if as_json {
        let mut value = serde_json::to_value(&info)?;
        value["file"] = path.display().to_string().into();
        value["kind"] = "hierarchy".into();
        value["bounds"] = json!({ "min": bounds.min.to_array(), "max": bounds.max.to_array(), "diagonal": diagonal });
        value["memory_bytes"] = memory.into();
        value["base_triangles"] = hierarchy.base_triangles().into();
        value["base_error"] = hierarchy.base_error().into();
        value["updates"] = hierarchy.update_count().into();
        if let Hierarchy::VertexRemoval(h) = &hierarchy {
            value["connectivity"] = h.connectivity().name().into();
            value["connectivity_bits"] = Connectivity::ALL
                .iter()
                .map(|c| (c.name().to_owned(), c.mean_bits(h).into()))
                .collect::<Map<_, _>>()
                .into();
        }
        return text::print_json(&value);
    }
    let relative = |error: f32| if diagonal > 0.0 { text::percent(error as f64 / diagonal) } else { "0 %".into() };
    let base_error = hierarchy.base_error();
    let updates = hierarchy.update_count() as u64;
    let error = |e: f32| format!("{} ({} of the diagonal)", text::length(e as f64), relative(e));
    let precision = match (info.bits, info.grid_step) {
        (Some(bits), Some(step)) => format!("{bits} bits per coordinate, a grid of {}", text::length(step)),
        (None, Some(step)) => format!("heights in steps of {}", text::length(step)),
        _ => "lossless".into(),
    };
    let attributes = match (info.normals, info.colors) {
        (false, false) => "none",
        (true, false) => "normals",
        (false, true) => "colours",
        (true, true) => "normals, colours",
    };
    let per = |bytes: u64, n: u64| format!("{:.2}", bytes as f64 / n.max(1) as f64);
    let mut lines = vec![
        ("file", format!("{}: .front version {}, model {}", path.display(), info.version, info.model)),
        ("source", sizes(info.source_vertices, info.source_triangles)),
        ("base mesh", format!("{} triangles", text::count(hierarchy.base_triangles() as u64))),
        ("updates", text::count(updates)),
        ("positions", precision),
        ("attributes", attributes.into()),
        ("bounds", bounds_text(&bounds)),
        ("error, base mesh", error(base_error)),
        ("error, full mesh", error(info.floor_error)),
        (
            "size",
            format!(
                "{}, {} bytes per source vertex",
                text::bytes(info.bytes),
                per(info.bytes, info.source_vertices.into())
            ),
        ),
        ("first look", format!("{} hold the header and the base mesh", text::bytes(info.head_bytes))),
        ("pages", text::count(info.pages.len() as u64)),
        ("in memory", format!("{}, {} bytes per update", text::bytes(memory as u64), per(memory as u64, updates))),
    ];
    if let Hierarchy::RightTriangles(terrain) = &hierarchy {
        lines.extend(place(terrain));
    }
    if let Hierarchy::VertexRemoval(h) = &hierarchy {
        let bits = |c: Connectivity| {
            let published = c.published_bits().map_or(String::new(), |bits| format!(" ({bits} published)"));
            format!("{} {:.2}{published}", c.name(), c.mean_bits(h))
        };
        let all = Connectivity::ALL.map(bits).join(", ");
        let code = h.connectivity();
        lines.push((
            "triangulations",
            format!("{code} in this file; mean bits by code: {all}; entropy {:.2}", entropy(h)),
        ));
    }
    if let Hierarchy::VertexPair(h) = &hierarchy {
        let hidden = text::count(h.hidden_needs().len() as u64);
        lines.push((
            "dependencies",
            format!("implicit in the numbers of neighbours, but for {hidden} that no triangle shows"),
        ));
    }
    text::print(&rows(&lines))
}

/// Where a terrain is.
fn place(terrain: &RightTriangles) -> Vec<(&'static str, String)> {
    let (place, [columns, rows]) = (terrain.place(), terrain.samples());
    let DVec2 { x, y } = place.origin;
    let unit = |unit: Unit| format!("{unit:?}").to_lowercase();
    vec![
        ("samples", format!("{} × {}", text::count(columns), text::count(rows))),
        ("origin", format!("{x}, {y} ({}), where the mesh has 0, 0", unit(place.horizontal))),
        ("heights", format!("{} in the source; in the mesh metres times {}", unit(place.vertical), place.exaggeration)),
    ]
}

fn source(path: &Path, as_json: bool, quiet: bool) -> Result<()> {
    let phases = Phases::new(quiet);
    if is_height_format(path) {
        return heights(path, as_json, &phases);
    }
    let source = input::mesh(path, input::Seams::Keep, &phases)?;
    phases.start("survey");
    let survey = survey(&source.mesh);
    phases.finish();
    let (normals, colors) = (!source.mesh.vertex.normals.is_empty(), !source.mesh.vertex.colors.is_empty());
    if as_json {
        let mut value = survey_json(&survey);
        value["file"] = path.display().to_string().into();
        value["kind"] = "mesh".into();
        value["normals"] = normals.into();
        value["colors"] = colors.into();
        value["in_file"] = report_json(&source.report);
        return text::print_json(&value);
    }
    let mut lines = vec![
        ("file", format!("{}: {}", path.display(), source.report)),
        ("mesh", sizes(survey.vertices, survey.triangles)),
        ("components", text::count(survey.components as u64)),
        ("boundary edges", text::count(survey.boundary_edges as u64)),
        (
            "non-manifold",
            format!(
                "{} edges, {} vertices",
                text::count(survey.non_manifold_edges as u64),
                text::count(survey.non_manifold_vertices as u64)
            ),
        ),
        ("misoriented", format!("{} edges", text::count(survey.inconsistent_edges as u64))),
        ("area", text::length(survey.area)),
        ("normals", if normals { "yes" } else { "no" }.into()),
        ("colours", if colors { "yes" } else { "no" }.into()),
    ];
    if let Some(bounds) = survey.bounds {
        lines.push(("bounds", bounds_text(&bounds)));
    }
    text::print(&rows(&lines))
}

/// A height field.
fn heights(path: &Path, as_json: bool, phases: &Phases) -> Result<()> {
    let source = input::heights(path, phases)?;
    phases.finish();
    let field = &source.field;
    let there = field.heights.iter().filter(|h| !h.is_nan());
    let (low, high) = there.fold((f32::MAX, f32::MIN), |(low, high), &h| (low.min(h), high.max(h)));
    let metres = field.spacing_metres();
    if as_json {
        return text::print_json(&json!({
            "file": path.display().to_string(),
            "kind": "heights",
            "columns": field.columns,
            "rows": field.rows,
            "missing": field.missing(),
            "lowest": low,
            "highest": high,
            "step": field.step,
            "origin": field.origin.to_array(),
            "spacing": field.spacing.to_array(),
            "spacing_metres": metres.to_array(),
            "horizontal": format!("{:?}", field.horizontal).to_lowercase(),
            "vertical": format!("{:?}", field.vertical).to_lowercase(),
        }));
    }
    text::print(&rows(&[
        ("file", format!("{}: {}", path.display(), source.report)),
        ("samples", format!("{} × {}", text::count(field.columns), text::count(field.rows))),
        ("missing", text::count(field.missing() as u64)),
        ("heights", format!("{low} to {high}")),
        ("origin", format!("{}, {} (north-west)", field.origin.x, field.origin.y)),
        ("spacing", format!("{} × {} metres", text::length(metres.x), text::length(metres.y))),
    ]))
}

fn survey_json(survey: &Survey) -> serde_json::Value {
    json!({
        "vertices": survey.vertices,
        "triangles": survey.triangles,
        "edges": survey.edges,
        "components": survey.components,
        "boundary_edges": survey.boundary_edges,
        "non_manifold_edges": survey.non_manifold_edges,
        "non_manifold_vertices": survey.non_manifold_vertices,
        "inconsistent_edges": survey.inconsistent_edges,
        "area": survey.area,
        "bounds": survey.bounds.map(|b| json!({
            "min": b.min.to_array(), "max": b.max.to_array(), "diagonal": b.diagonal(),
        })),
    })
}

fn report_json(report: &ReadReport) -> serde_json::Value {
    json!({
        "format": report.format.to_string(),
        "bytes": report.bytes,
        "vertices": report.vertices_in_file,
        "faces": report.faces_in_file,
        "polygons_triangulated": report.polygons_triangulated,
        "faces_too_small": report.faces_too_small,
        "normals_repaired": report.normals_repaired,
        "primitives_skipped": report.primitives_skipped,
        "vertices_welded": report.cleaned.vertices_welded,
        "vertices_unreferenced": report.cleaned.vertices_unreferenced,
        "triangles_degenerate": report.cleaned.triangles_degenerate,
        "triangles_duplicate": report.cleaned.triangles_duplicate,
    })
}

fn sizes(vertices: impl TryInto<u64>, triangles: impl TryInto<u64>) -> String {
    format!("{} vertices, {} triangles", text::count(vertices), text::count(triangles))
}

fn bounds_text(bounds: &Bounds) -> String {
    let point = |p: glam::Vec3| p.to_array().map(|x| text::length(x as f64)).join(", ");
    format!("({}) to ({}), diagonal {}", point(bounds.min), point(bounds.max), text::length(bounds.diagonal() as f64))
}

fn rows(lines: &[(&str, String)]) -> String {
    lines.iter().map(|(name, value)| format!("{name:<18}{value}\n")).collect()
}
