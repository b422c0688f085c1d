//! The `meshfront` command.
fn main() {}
