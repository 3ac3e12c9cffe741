//! The lines of a file around a place in it, as diagnostics show them: long ones are cut, since Miette
//! can draw nothing beyond column 65535 and nobody would find it there.

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};
use telamon::load::Position;

/// Characters that are shown of a line before a place, and from it on.
const BEFORE: usize = 60;
const AFTER: usize = 100;

/// Stands where something was cut off.
const CUT: char = '…';

/// The line of a place and the two around it.
#[derive(Debug)]
pub(super) struct Excerpt {
    /// Name of the file.
    name: String,
    text: String,
    /// The place, within `text`: as much of it as stands on its first line and is shown.
    span: SourceSpan,
    /// Number of the first line that is shown, from 0.
    first_line: usize,
    /// Number of the place's column, from 0.
    column: usize,
}

impl Excerpt {
    pub(super) fn new(name: String, position: &Position) -> Self {
        let source: &str = &position.source;
        let (start, end) = (position.span.start, position.span.end);
        let line_start = source[..start].rfind('\n').map_or(0, |i| i + 1);
        let line_end = source[start..].find('\n').map_or(source.len(), |i| start + i);
        let mut text = String::new();
        let has_line_before = line_start > 0;
        if has_line_before {
            let before = &source[..line_start - 1];
            push_head(&mut text, &before[before.rfind('\n').map_or(0, |i| i + 1)..]);
            text.push('\n');
        }
        push_tail(&mut text, &source[line_start..start]);
        let shown_start = text.len();
        // The cut is no part of the place.
        let length = push_head(&mut text, &source[start..end.min(line_end)]);
        if end <= line_end {
            push_head(&mut text, &source[end..line_end]);
        }
        if let Some(after) = source.get(line_end + 1..).filter(|after| !after.is_empty()) {
            text.push('\n');
            push_head(&mut text, after.split('\n').next().unwrap_or_default());
        }
        Self {
            name,
            text,
            span: (shown_start, length).into(),
            first_line: position.line - 1 - usize::from(has_line_before),
            column: position.column - 1,
        }
    }

    /// The place, within this excerpt.
    pub(super) fn span(&self) -> SourceSpan {
        self.span
    }
}

/// Appends the beginning of a line, and returns the bytes that this takes without the sign of a cut.
fn push_head(text: &mut String, line: &str) -> usize {
    let before = text.len();
    let mut chars = line.strip_suffix('\r').unwrap_or(line).chars();
    text.extend(chars.by_ref().take(AFTER).map(printable));
    let length = text.len() - before;
    text.extend(chars.next().map(|_| CUT));
    length
}

/// Appends the end of a line.
fn push_tail(text: &mut String, line: &str) {
    let start = line.char_indices().rev().nth(BEFORE - 1).map_or(0, |(i, _)| i);
    text.extend((start > 0).then_some(CUT));
    text.extend(line[start..].chars().map(printable));
}

/// What a terminal takes for a command, and Miette for the end of a line, is shown as a question mark.
fn printable(c: char) -> char {
    if c.is_control() && c != '\t' { char::REPLACEMENT_CHARACTER } else { c }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let contents = self.text.read_span(span, lines_before, lines_after)?;
        // Without lines around it, it is the place's own line and column that are asked for.
        let column = if lines_before == 0 { self.column } else { contents.column() };
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            contents.data(),
            *contents.span(),
            contents.line() + self.first_line,
            column,
            contents.line_count(),
        )))
    }
}

#[cfg(test)]
mod tests {
    use std::ops::Range;
    use std::sync::Arc;

    use super::*;

    fn excerpt(source: &str, span: Range<usize>) -> Excerpt {
        let before = &source[..span.start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let position = Position {
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            source: Arc::from(source),
            span,
        };
        Excerpt::new("a.xml".to_owned(), &position)
    }

    fn shown(excerpt: &Excerpt) -> &str {
        &excerpt.text[excerpt.span.offset()..][..excerpt.span.len()]
    }

    #[test]
    fn short_lines_are_whole() {
        let source = "one\ntwo\nthree\nfour";
        let at = source.find("hre").expect("there");
        let excerpt = excerpt(source, at..at + 3);
        assert_eq!(excerpt.text, "two\nthree\nfour");
        assert_eq!(shown(&excerpt), "hre");
        assert_eq!((excerpt.first_line, excerpt.column), (1, 1));
    }

    #[test]
    fn long_lines_are_cut_around_the_place() {
        let source = format!("{0}\n{1}place{1}\n{0}", "x".repeat(500), "é".repeat(500));
        let at = source.find("place").expect("there");
        let at_word = excerpt(&source, at..at + 5);
        let around = format!("{}…", "x".repeat(AFTER));
        let line = format!("…{}place{}…", "é".repeat(BEFORE), "é".repeat(AFTER));
        assert_eq!(at_word.text, format!("{around}\n{line}\n{around}"));
        assert_eq!(shown(&at_word), "place");
        assert_eq!((at_word.first_line, at_word.column), (0, 500));
        let long = excerpt(&source, at - 500..at + 5);
        assert_eq!(shown(&long), "é".repeat(AFTER));
    }

    #[test]
    fn what_is_no_text_is_not_sent_to_the_terminal() {
        let source = "a\tb\x1b[2J\rc\r\nd\r\n";
        let excerpt = excerpt(source, 0..source.len());
        assert_eq!(excerpt.text, "a\tb\u{fffd}[2J\u{fffd}c\nd");
        assert_eq!(shown(&excerpt), "a\tb\u{fffd}[2J\u{fffd}c");
    }
}
