//! What a viewer does in every frame: move the front to the new view, upload the slots that changed, draw.
//!
//!     cargo run --release --example follow_a_camera

use meshfront::mesh::sample;
use meshfront::{EdgeCollapseOptions, Front, Request, TriangleModel, edge_collapse, fly_by};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // One hierarchy, shared and never changed; a front for each viewer.
    let hierarchy = edge_collapse(&sample::scan(50_000), &EdgeCollapseOptions::default(), &())?;
    let mut front = Front::new(&hierarchy);

    // One pixel, at most 20,000 triangles, and at most two milliseconds a frame: what is left over goes on in the next.
    let request = Request { max_cells: Some(20_000), deadline_us: Some(2_000), ..Request::tolerance(1.0) };
    for frame in (0..fly_by::FRAMES).step_by(60) {
        let criterion = fly_by::criterion(hierarchy.bounds(), frame);
        let outcome = front.adapt(&hierarchy, &criterion, &request);

        // A renderer copies these slots of `positions`, `normals` and `triangles` to the same places on the GPU.
        let changes = &front.mesh().buffers.changes;
        println!(
            "frame {frame:3}: {:6} triangles, {:5} updates, {:6} vertex and {:6} triangle slots to upload, {:.2} px{}",
            outcome.cells,
            outcome.refined + outcome.coarsened,
            changes.vertices.len(),
            changes.triangles.len(),
            outcome.error_px,
            if outcome.settled { "" } else { ", more to come" }
        );
        front.mesh_mut().buffers.clear_changes();
    }
    Ok(())
}
