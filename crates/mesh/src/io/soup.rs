//! What every reader fills: columns, triangles, and polygons that wait for the positions to be complete.

use glam::Vec3;

use super::error::{Fail, ReadErrorKind};
use crate::triangulate::Triangulator;
use crate::{TriangleMesh, VertexId};

/// More corners than faces of real meshes have: bounds the time and memory that one face can take.
const MOST_CORNERS: usize = 65_535;

/// Vertices and faces as they stand in a file, indices checked by the reader.
#[derive(Default)]
pub(super) struct Soup {
    pub mesh: TriangleMesh,
    /// Vertices in the file, also those that no face uses and that the reader may leave out of `mesh`.
    pub vertices_in_file: u64,
    pub faces_in_file: u64,
    /// Faces with fewer than three corners: points and lines.
    pub faces_too_small: u64,
    /// glTF: primitives that are points or lines.
    pub primitives_skipped: u64,
    /// Polygons of four or more corners: first triangle in `mesh.triangles` and number of corners. Until
    /// [`Soup::triangulate`] they lie there as a fan about their first corner, from which the corners can be read back.
    polygons: Vec<(usize, u32)>,
}

impl Soup {
    /// No faces yet, of a file with so many vertices.
    pub fn new(vertices_in_file: u64) -> Soup {
        Soup { vertices_in_file, ..Soup::default() }
    }

    /// Whether a face may have so many corners; to be asked before they are collected.
    #[inline]
    pub fn check_corners(corners: usize) -> Result<(), ReadErrorKind> {
        if corners <= MOST_CORNERS {
            return Ok(());
        }
        let what = format!("a face of more than {MOST_CORNERS} corners");
        Err(ReadErrorKind::Unsupported { what, remedy: "triangulate the mesh in the program that made it" })
    }

    /// A face of any number of corners.
    #[inline]
    pub fn push_face(&mut self, corners: &[u32]) {
        self.faces_in_file += 1;
        let id = |i: usize| VertexId(corners[i]);
        match corners.len() {
            3 => self.mesh.triangles.push([id(0), id(1), id(2)]),
            0..3 => self.faces_too_small += 1,
            n => {
                self.polygons.push((self.mesh.triangles.len(), n as u32));
                self.mesh.triangles.extend((1..n - 1).map(|i| [id(0), id(i), id(i + 1)]));
            }
        }
    }

    /// Number of polygons with four or more corners.
    pub fn polygons(&self) -> u64 {
        self.polygons.len() as u64
    }

    /// Replaces the fans by triangulations. Needs all positions.
    pub fn triangulate(&mut self) {
        let mut triangulator = Triangulator::default();
        let mut corners = Vec::new();
        let mut points = Vec::new();
        for &(first, n) in &self.polygons {
            let fan = &mut self.mesh.triangles[first..first + n as usize - 2];
            corners.clear();
            corners.extend([fan[0][0], fan[0][1]]);
            corners.extend(fan.iter().map(|t| t[2]));
            points.clear();
            points.extend(corners.iter().map(|v| self.mesh.positions[v.ix()]));
            for (slot, local) in fan.iter_mut().zip(triangulator.triangulate(&points)) {
                *slot = local.map(|i| corners[i as usize]);
            }
        }
    }

    /// Makes normals unit vectors (those within rounding of one keep their bits) and gives vertices whose normal is
    /// zero or not finite the mean normal of their triangles. Returns how many those were.
    pub fn repair_normals(&mut self) -> u64 {
        let normals = &mut self.mesh.vertex.normals;
        let mut bad = Vec::new();
        for (i, n) in normals.iter_mut().enumerate() {
            let length = n.length();
            if (length - 1.0).abs() <= 1e-4 {
                continue;
            }
            // In double precision neither tiny nor huge components vanish or overflow.
            let unit = n.as_dvec3().try_normalize().map(|u| u.as_vec3());
            match unit {
                Some(unit) if n.is_finite() => *n = unit,
                _ => {
                    *n = Vec3::ZERO;
                    bad.push(i);
                }
            }
        }
        if bad.is_empty() {
            return 0;
        }
        let mut sums = vec![Vec3::ZERO; normals.len()];
        for corners in &self.mesh.triangles {
            let [a, b, c] = corners.map(|v| self.mesh.positions[v.ix()].as_dvec3());
            let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
            corners.iter().for_each(|v| sums[v.ix()] += normal);
        }
        for &i in &bad {
            self.mesh.vertex.normals[i] = sums[i].try_normalize().unwrap_or(Vec3::Z);
        }
        bad.len() as u64
    }

    /// Refuses meshes that 32-bit ids cannot name.
    pub fn check_size(&self) -> Result<(), Fail> {
        // The highest id stays free as a mark for "none".
        let too_many = |n: usize| n >= u32::MAX as usize;
        if too_many(self.mesh.positions.len()) {
            return Err(Fail::file(ReadErrorKind::TooMany("vertices")));
        }
        if too_many(self.mesh.triangles.len()) {
            return Err(Fail::file(ReadErrorKind::TooMany("triangles")));
        }
        Ok(())
    }
}
