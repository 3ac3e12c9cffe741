use std::fs;
use std::path::Path;

use crate::document::{document, figure};
use crate::read;

/// The document and its plots are what the program makes of the runs that are stored.
#[test]
fn the_document_says_what_was_measured() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let all = read(root).expect("all sections were measured");
    let text = |name: &str| fs::read_to_string(root.join("docs").join(name)).expect("is there");
    assert!(text("the-trade.md") == document(&all), "write it again with `--write`");
    for (section, measured) in &all {
        for (trial, measured) in section.trials.iter().zip(measured) {
            let plot = text(&format!("the-trade/{}.svg", trial.name));
            assert!(
                plot == figure(trial, measured),
                "{}: write it again with `--write`",
                trial.name
            );
        }
    }
}
