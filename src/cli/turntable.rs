//! Names of the pictures that go around a mesh.

use super::values::Output;

/// `name` with a number in the place of `%d`, or of `%03d` for three digits or more; `None` if it has no such place, or
/// more than one.
fn numbered(name: &str, number: u32) -> Option<String> {
    let (before, rest) = name.split_once('%')?;
    let (digits, after) = rest.split_once('d')?;
    let width = match digits {
        "" => 0,
        _ => digits.strip_prefix('0')?.parse::<usize>().ok().filter(|width| *width <= 20)?,
    };
    (!after.contains('%')).then(|| format!("{before}{number:0width$}{after}"))
}

/// The files of one picture, counted from 0; `None` if one of them has no place for the number.
pub(super) fn outputs(patterns: &[Output], number: u32) -> Option<Vec<Output>> {
    let output = |pattern: &Output| {
        let path = numbered(pattern.path.to_str()?, number)?;
        Some(Output { path: path.into(), format: pattern.format })
    };
    patterns.iter().map(output).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_their_place() {
        for (pattern, expected) in [
            ("a%d.png", Some("a7.png")),
            ("b/%03d.exr", Some("b/007.exr")),
            ("%01d.png", Some("7.png")),
            ("a.png", None),
            ("a%3d.png", None),
            ("a%0d.png", None),
            ("a%099d.png", None),
            ("%d%d.png", None),
            ("%s.png", None),
        ] {
            assert_eq!(numbered(pattern, 7).as_deref(), expected, "{pattern}");
        }
    }
}
