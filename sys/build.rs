//! Finds Embree, compiles the shim, writes the bindings and publishes what was found.
//!
//! The build script of a direct dependent reads `DEP_EMBREE_VERSION` (`3.13.5`), `DEP_EMBREE_MAJOR`
//! (`3`) and, if `EMBREE_DIR` chose the library, `DEP_EMBREE_LIB_DIR`, which programs need as rpath.

#![allow(clippy::print_stdout, reason = "it is how a build script talks to cargo")]

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

/// What to do about a failure; every message ends with it.
const HELP: &str = "
  Debian, Ubuntu:    apt-get install libembree-dev libclang-dev gcc libc6-dev
  Embree elsewhere:  EMBREE_DIR=/absolute/path of the folder with its include/ and lib/
  without Embree:    cargo build --no-default-features";

struct Embree {
    version: String,
    major: u32,
    include: PathBuf,
    /// Set if the linker would not look there of its own accord.
    lib_dir: Option<PathBuf>,
}

fn main() {
    for file in ["wrapper.h", "shim.h", "shim.c", "bare.h", "bare.c"] {
        println!("cargo::rerun-if-changed={file}");
    }
    println!("cargo::rerun-if-env-changed=EMBREE_DIR");
    // Cargo shows such an error by itself, without the log of a script that ended badly.
    if let Err(message) = build() {
        for line in (message + HELP).lines() {
            println!("cargo::error={line}");
        }
    }
}

fn build() -> Result<(), String> {
    let embree = find()?;
    // Before the shim: a compiler's complaint would bury the plainer message.
    generate_bindings(&embree)?;
    compile_shim(&embree)?;

    println!("cargo::rustc-link-lib=dylib=embree{}", embree.major);
    println!("cargo::metadata=version={}", embree.version);
    println!("cargo::metadata=major={}", embree.major);
    if let Some(dir) = embree.lib_dir.as_ref().map(|dir| dir.display()) {
        println!("cargo::rustc-link-search=native={dir}");
        println!("cargo::rustc-link-arg=-Wl,-rpath,{dir}");
        println!("cargo::metadata=lib_dir={dir}");
    }
    Ok(())
}

/// Embree 4 before 3; of one version, that in `/usr/local` before that in `/usr`.
fn find() -> Result<Embree, String> {
    let elsewhere = env::var_os("EMBREE_DIR").filter(|dir| !dir.is_empty());
    let prefixes = match &elsewhere {
        Some(dir) => vec![PathBuf::from(dir)],
        None => vec!["/usr/local".into(), "/usr".into()],
    };
    let header = |major| {
        let include = folder_with(&prefixes, "include", &format!("embree{major}/rtcore.h"))?;
        Some((major, include))
    };
    let (major, include) = header(4).or_else(|| header(3)).ok_or_else(|| {
        format!("no include/embree4/rtcore.h or include/embree3/rtcore.h in {prefixes:?}")
    })?;
    let version = supported_version(&include.join(format!("embree{major}/rtcore_config.h")))?;
    let lib_dir =
        folder_with(&prefixes, "lib", &format!("libembree{major}.so")).ok_or_else(|| {
            format!("Embree's header is there, but no lib/libembree{major}.so in {prefixes:?}")
        })?;
    Ok(Embree { version, major, include, lib_dir: elsewhere.is_some().then_some(lib_dir) })
}

/// Looks in `kind` itself and in Debian's subfolder for the architecture.
fn folder_with(prefixes: &[PathBuf], kind: &str, file: &str) -> Option<PathBuf> {
    let multiarch = env::var("CARGO_CFG_TARGET_ARCH").ok()? + "-linux-gnu";
    let dirs = prefixes.iter().map(|prefix| prefix.join(kind));
    dirs.flat_map(|dir| [dir.join(&multiarch), dir]).find(|dir| dir.join(file).exists())
}

fn supported_version(config: &Path) -> Result<String, String> {
    // An upgrade of the package must rebuild the bindings.
    println!("cargo::rerun-if-changed={}", config.display());
    let text = fs::read_to_string(config).map_err(|e| format!("{}: {e}", config.display()))?;
    let version = text
        .lines()
        .find_map(|line| line.trim().strip_prefix("#define RTC_VERSION_STRING"))
        .map(|value| value.trim().trim_matches('"'))
        .ok_or_else(|| format!("{} does not tell its version", config.display()))?;
    if !version.starts_with("3.13.") && !version.starts_with("4.") {
        return Err(format!("Embree {version} was found; supported are 3.13 and 4"));
    }
    Ok(version.to_owned())
}

fn generate_bindings(embree: &Embree) -> Result<(), String> {
    // bindgen panics if it cannot open libclang; it uses the one that is open already.
    clang_sys::load().map_err(|e| format!("libclang, needed to read Embree's header: {e}"))?;
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo did not set OUT_DIR")?);
    let bindings = bindgen::Builder::default()
        .header("shim.h")
        .clang_arg(format!("-DTELAMON_EMBREE_MAJOR={}", embree.major))
        .clang_arg(format!("-I{}", embree.include.display()))
        .allowlist_item("(rtc|RTC|telamon_|Shim).*")
        // Newtypes: a code that the header does not list is a number, not undefined behaviour.
        .newtype_enum("RTC.*")
        .bitfield_enum("RTC.*Flags")
        .derive_default(true)
        .generate_comments(false)
        .generate_cstr(true)
        .layout_tests(true)
        .rust_target(bindgen::RustTarget::stable(89, 0).map_err(|e| e.to_string())?)
        .rust_edition(bindgen::RustEdition::Edition2024)
        .formatter(bindgen::Formatter::None)
        .generate()
        .map_err(|e| format!("Embree {}'s header: {e}", embree.version))?;
    fs::write(out.join("bindings.rs"), bindings.to_string()).map_err(|e| e.to_string())
}

fn compile_shim(embree: &Embree) -> Result<(), String> {
    let mut build = cc::Build::new();
    if env::var_os("CARGO_FEATURE_BARE").is_some() {
        build.file("bare.c");
    }
    build
        .file("shim.c")
        .std("gnu11")
        .define("TELAMON_EMBREE_MAJOR", embree.major.to_string().as_str())
        .include(&embree.include)
        .try_compile("telamon_embree_shim")
        .map_err(|e| format!("shim.c could not be compiled: {e}"))
}
