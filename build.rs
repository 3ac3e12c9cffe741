//! Tells the command which Embree it is linked with, for `--version`.
#![allow(clippy::print_stdout, reason = "it is how a build script talks to cargo")]

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let embree = if env::var_os("CARGO_FEATURE_EMBREE").is_some() {
        // Published by `embree-sys` through its `links` key.
        let Ok(version) = env::var("DEP_EMBREE_VERSION") else {
            println!("cargo::error=embree-sys did not say which version of Embree it links");
            return;
        };
        format!("Embree {version}")
    } else {
        "without Embree".to_owned()
    };
    println!("cargo::rustc-env=TELAMON_EMBREE={embree}");
}
