//! From a source mesh to a multiresolution hierarchy
