//! `xtask-bindgen MODULE.wasm OUT_DIR NAME`: writes `NAME.js`, `NAME.d.ts` and `NAME_bg.wasm` for a web page.
//!
//! A crate of its own, because its dependencies take far longer to compile than all other chores together.

use anyhow::{Context, bail};
use wasm_bindgen_cli_support::Bindgen;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [module, out_dir, name] = arguments.as_slice() else {
        bail!("usage: xtask-bindgen MODULE.wasm OUT_DIR NAME");
    };
    Bindgen::new()
        .input_path(module)
        .web(true)?
        .out_name(name)
        .typescript(true)
        .remove_producers_section(true)
        .generate(out_dir)
        .with_context(|| format!("cannot make JavaScript glue for {module}"))
}
