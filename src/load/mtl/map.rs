//! Textures of materials.

use super::{parse, shortened};

/// A picture over the surface.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::load) struct Map {
    /// As the file names it.
    pub(in crate::load) file: String,
    /// `-s`, across and up.
    pub(in crate::load) scale: [f64; 2],
    /// `-o`, across and up.
    pub(in crate::load) offset: [f64; 2],
    /// `-clamp`: the picture once.
    pub(in crate::load) clamp: bool,
    /// `-bm`: the factor of a bump map.
    pub(in crate::load) bump: f64,
}

impl Map {
    /// The rest of a line: options, then the name, which may have spaces. `None` if there is nothing.
    pub(super) fn parse(text: &str) -> Result<Option<Self>, String> {
        let mut map = Self {
            file: String::new(),
            scale: [1.0; 2],
            offset: [0.0; 2],
            clamp: false,
            bump: 1.0,
        };
        let mut rest = text.trim();
        while rest.starts_with('-') {
            let (option, after) = split(rest);
            rest = after;
            match option {
                "-s" => map.scale = pair(option, &mut rest, 1.0)?,
                "-o" => map.offset = pair(option, &mut rest, 0.0)?,
                "-t" => drop(pair(option, &mut rest, 0.0)?),
                "-bm" => map.bump = value(option, &mut rest)?,
                "-boost" | "-texres" => drop(value(option, &mut rest)?),
                "-mm" => {
                    value(option, &mut rest)?;
                    value(option, &mut rest)?;
                }
                "-clamp" => {
                    let (word, after) = split(rest);
                    (map.clamp, rest) = (word == "on", after);
                }
                "-blendu" | "-blendv" | "-cc" | "-imfchan" | "-type" => rest = split(rest).1,
                _ => {
                    let option = shortened(option);
                    return Err(format!("unknown option `{option}` of a texture"));
                }
            }
        }
        map.file = rest.to_owned();
        Ok((!rest.is_empty()).then_some(map))
    }
}

/// The first word, and what comes behind it.
fn split(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

fn value(option: &str, rest: &mut &str) -> Result<f64, String> {
    let (word, after) = split(rest);
    *rest = after;
    parse(option, word)
}

/// Up to three numbers, of which the third is for textures with depth.
fn pair(option: &str, rest: &mut &str, default: f64) -> Result<[f64; 2], String> {
    let mut values = [value(option, rest)?, default, default];
    for value in &mut values[1..] {
        let (word, after) = split(rest);
        // A name may begin with digits, but is the last word.
        match word.parse() {
            Ok(number) if !after.is_empty() => (*value, *rest) = (number, after),
            _ => break,
        }
    }
    Ok([values[0], values[1]])
}
