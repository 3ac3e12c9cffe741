//! Tells the command which Embree it is linked with, for `--version`, and which commit it was built from, for
//! `telamon measure`.
#![allow(clippy::print_stdout, reason = "it is how a build script talks to cargo")]

use std::env;
use std::process::Command;

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
    // Of release builds only: figures come from them, and others would be rebuilt after each commit.
    if env::var_os("PROFILE").is_some_and(|profile| profile == "release")
        && let Some(commit) = commit()
    {
        println!("cargo::rustc-env=TELAMON_COMMIT={commit}");
    }
}

/// The commit of this folder, with a `+` if files differ from it; `None` where the folder is no checkout of its
/// own.
fn commit() -> Option<String> {
    // What a crate was copied into says nothing of the crate.
    if !git(&["rev-parse", "--show-prefix"])?.is_empty() {
        return None;
    }
    // Where git writes down every commit and checkout.
    println!("cargo::rerun-if-changed={}", git(&["rev-parse", "--git-path", "logs/HEAD"])?);
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    let changed = !git(&["status", "--porcelain", "--untracked-files=no"])?.is_empty();
    Some(if changed { commit + "+" } else { commit })
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
