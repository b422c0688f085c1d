//! The .front file: bytes to validated hierarchy and back
