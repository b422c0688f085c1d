//! Multiresolution meshes: build, extract, refine per view
