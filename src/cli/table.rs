//! Text in columns.

use telamon::memory::readable;

/// Rows with their cells padded to common widths, two spaces apart and indented by two. Columns whose
/// index is in `right` are flush right, as numbers are.
pub(super) fn table(rows: &[Vec<String>], right: &[usize]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            line += "  ";
            line += &if right.contains(&column) {
                format!("{cell:>width$}")
            } else {
                format!("{cell:<width$}")
            };
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

/// A number of bytes with three digits.
pub(super) fn bytes(count: usize) -> String {
    readable(count as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows =
            [vec!["a".to_owned(), "10".to_owned()], vec!["größer".to_owned(), "9".to_owned()]];
        assert_eq!(table(&rows, &[1]), "  a       10\n  größer   9\n");
        assert_eq!(table(&[], &[]), "");
    }
}
