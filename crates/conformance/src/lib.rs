//! The suite that every hierarchy passes
