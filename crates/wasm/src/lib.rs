//! The engine as WebAssembly
