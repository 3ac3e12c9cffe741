//! README.md says what is so: its table of scene elements is written by this test, its commands are
//! understood, its paths exist.
//!
//! `TELAMON_UPDATE_README=1 cargo test --test readme` rewrites the table.

mod support;

use std::collections::BTreeSet;
use std::fs;
use std::process::{Command, Stdio};

use support::pictures::in_package;
use telamon::load::plugins::{Category, Plugin, supported};

const BEGIN: &str = "<!-- supported:begin -->\n";
const END: &str = "<!-- supported:end -->\n";

fn readme() -> String {
    fs::read_to_string(in_package("README.md")).expect("is there")
}

/// The table of all that a scene file can name.
fn table() -> String {
    let mut text = String::from(
        "| Element | What it is | Properties, with what holds if they are not given |\n|---|---|---|\n",
    );
    for plugin in supported() {
        let (tag, name, help) = (plugin.category().tag(), plugin.name, plugin.help);
        text += &format!("| `<{tag} type=\"{name}\">` | {help} | {} |\n", contents(plugin));
    }
    text
}

/// The properties of a plugin, and the objects that it takes.
fn contents(plugin: &Plugin) -> String {
    let properties = plugin.properties.iter().map(|p| format!("`{}` ({})", p.name, p.default));
    let parts = plugin.parts.iter().map(|p| format!("`<{}>`", p.category.tag()));
    let all = properties.chain(parts).collect::<Vec<_>>().join(", ");
    // A bar would end the cell.
    all.replace('|', "\\|")
}

#[test]
fn the_table_lists_what_is_supported() {
    let text = readme();
    let (before, rest) = text.split_once(BEGIN).expect("a beginning");
    let (listed, after) = rest.split_once(END).expect("an end");
    let expected = table();
    if std::env::var_os("TELAMON_UPDATE_README").is_some() {
        let text = format!("{before}{BEGIN}{expected}{END}{after}");
        fs::write(in_package("README.md"), text).expect("writable");
        return;
    }
    let update = "run TELAMON_UPDATE_README=1 cargo test --test readme";
    assert!(listed == expected, "README.md is out of date: {update}\n{expected}");
    for category in Category::ALL {
        assert!(listed.contains(&format!("| `<{} type=", category.tag())), "{category:?}");
    }
}

/// The commands of the fenced blocks and between backquotes.
fn commands() -> BTreeSet<String> {
    let text = readme();
    let fences = text.split("\n```").skip(1).step_by(2);
    let blocks = fences.filter(|f| f.starts_with("sh ")).flat_map(|f| f.lines().skip(1));
    let commands = blocks.flat_map(|line| line.split("&&")).chain(text.split('`').skip(1));
    let commands = commands.map(str::trim);
    let ours = |c: &&str| ["cargo ", "telamon "].iter().any(|name| c.starts_with(name));
    commands.filter(ours).filter(|c| !c.contains('\n')).map(str::to_owned).collect()
}

/// Runs a program for its help alone, which it gives only if it understands what stands before.
fn understands(program: &str, arguments: &[&str], help: &str) -> Result<(), String> {
    let output = Command::new(program)
        .args(arguments)
        .arg(help)
        .current_dir(in_package(""))
        .stdin(Stdio::null())
        .output()
        .expect("starts");
    if output.status.success() {
        return Ok(());
    }
    Err(String::from_utf8_lossy(&output.stderr).into_owned())
}

/// What is wrong with a command, if anything is.
fn check(command: &str) -> Result<(), String> {
    const TELAMON: &str = env!("CARGO_BIN_EXE_telamon");
    let words: Vec<_> = command.split_whitespace().collect();
    let missing = |name: &str| Err(format!("there is no {name}"));
    if let Some(scene) = words.iter().find(|w| w.ends_with(".xml"))
        && !in_package(scene).exists()
    {
        return missing(scene);
    }
    if words[0] == "telamon" {
        return understands(TELAMON, &words[1..], "--help");
    }
    let end = words.iter().position(|w| *w == "--").unwrap_or(words.len());
    understands(env!("CARGO"), &words[1..end], "-h")?;
    match words.iter().position(|w| *w == "--example").map(|i| words[i + 1]) {
        Some(name) if in_package(&format!("examples/{name}/main.rs")).exists() => Ok(()),
        Some(name) => missing(name),
        // What follows the `--` of `cargo test` is for the test program.
        None if end < words.len() && words[1] == "run" => {
            understands(TELAMON, &words[end + 1..], "--help")
        }
        None => Ok(()),
    }
}

#[test]
fn commands_are_understood() {
    let commands = commands();
    assert!(commands.len() >= 4, "{commands:?}");
    for command in &commands {
        check(command).unwrap_or_else(|told| panic!("{command}: {told}"));
    }
    for wrong in [
        "telamon paint",
        "telamon render scenes/none.xml",
        "cargo test --everything",
        "cargo run --example none",
        "cargo run -- render --colour",
    ] {
        assert!(check(wrong).is_err(), "{wrong}");
    }
}

/// The first words of the lines of the map.
fn map(text: &str) -> Vec<&str> {
    let (_, map) = text.split_once("## Where things are").expect("the map");
    let map = map.split("```").nth(1).expect("in a fenced block");
    map.lines().filter_map(|line| line.split_whitespace().next()).collect()
}

#[test]
fn the_map_is_the_house() {
    let text = readme();
    let map = map(&text);
    for path in &map {
        assert!(in_package(path).exists(), "README.md names {path}");
        assert_eq!(path.ends_with('/'), in_package(path).is_dir(), "{path}");
    }
    let names = |folder: &str| {
        let entries = fs::read_dir(in_package(folder)).expect("is there").flatten();
        entries.map(|e| (e.file_name().to_string_lossy().into_owned(), e.path().is_dir()))
    };
    for (name, _) in names("src").filter(|(name, _)| name != "lib.rs") {
        let path = format!("src/{name}");
        assert!(map.iter().any(|p| p.trim_end_matches('/') == path), "the map lacks {path}");
    }
    // What is built, and the pictures of the README itself, are no rooms.
    let no_room = |name: &str| name.starts_with('.') || ["target", "docs", "src"].contains(&name);
    for (name, _) in names("").filter(|(name, is_folder)| *is_folder && !no_room(name)) {
        let folder = format!("{name}/");
        assert!(map.iter().any(|p| p.starts_with(&folder)), "the map lacks {folder}");
    }
}

#[test]
fn files_that_are_named_exist() {
    let text = readme();
    let folders = ["src/", "scenes/", "tests/", "examples/", "benches/", "sys/"];
    let quoted = text.split('`').filter(|q| !q.contains(char::is_whitespace));
    let paths: Vec<_> = quoted.filter(|q| folders.iter().any(|f| q.starts_with(f))).collect();
    assert!(paths.len() > 10, "{paths:?}");
    for path in paths {
        assert!(in_package(path).exists(), "README.md names {path}");
    }
}
