//! What the command says to people, on standard error: warnings and failures, with the line of the
//! scene file that they are about.

use std::collections::HashSet;
use std::error::Error;
use std::fmt::{self, Display, Formatter};
use std::io::{self, IsTerminal, Write};
use std::path::Path;

use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteHandlerOpts,
    ReportHandler, Severity, SourceCode, ThemeCharacters, ThemeStyles,
};
use telamon::load::{LoadError, Problem, Warning};

use super::excerpt::Excerpt;

/// Why a command ends without having done what was asked for.
#[derive(Debug)]
pub(crate) struct Failure(Vec<Message>);

/// Something to be shown.
#[derive(Debug)]
struct Message {
    text: String,
    severity: Severity,
    help: Option<String>,
    place: Option<Excerpt>,
}

impl Failure {
    /// All that is wrong with a scene.
    pub(super) fn of_scene(error: &LoadError) -> Self {
        let messages = error.problems().iter().map(|p| Message::about_scene(p, Severity::Error));
        let more = (error.more() > 0)
            .then(|| Message::new(format!("and {} more problems", error.more()), Severity::Error));
        Self(messages.chain(more).collect())
    }

    /// All that is wrong with a mesh. Places in the scene that was made of it are no help: nobody wrote it.
    pub(super) fn of_mesh(mesh: &Path, error: &LoadError) -> Self {
        Self(
            error
                .problems()
                .iter()
                .map(|p| Message::about_mesh(mesh, p, Severity::Error))
                .collect(),
        )
    }

    /// One thing that is wrong.
    pub(super) fn new(text: impl Into<String>) -> Self {
        Self(vec![Message::new(text, Severity::Error)])
    }

    /// Several failures as one; `None` if there is none.
    pub(super) fn all(failures: impl IntoIterator<Item = Self>) -> Option<Self> {
        let messages: Vec<_> = failures.into_iter().flat_map(|f| f.0).collect();
        (!messages.is_empty()).then_some(Self(messages))
    }

    pub(crate) fn show(&self) {
        self.0.iter().for_each(show);
    }
}

impl<E: Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::new(error.to_string())
    }
}

/// Shows a warning.
pub(super) fn warn(text: impl Into<String>) {
    show(&Message::new(text, Severity::Warning));
}

/// Shows a warning, and what can be done about it.
pub(super) fn warn_with_help(text: impl Into<String>, help: impl Into<String>) {
    show(&Message { help: Some(help.into()), ..Message::new(text, Severity::Warning) });
}

/// Shows each of the loader's warnings once.
pub(super) fn warn_of_scene(warnings: &[Warning]) {
    let mut seen = HashSet::new();
    for warning in warnings.iter().filter(|w| seen.insert(w.to_string())) {
        show(&Message::about_scene(warning, Severity::Warning));
    }
}

/// Shows each of the loader's warnings about a mesh once.
pub(super) fn warn_of_mesh(mesh: &Path, warnings: &[Warning]) {
    let mut seen = HashSet::new();
    for warning in warnings.iter().filter(|w| seen.insert(&w.message)) {
        show(&Message::about_mesh(mesh, warning, Severity::Warning));
    }
}

/// Writes a line. If nobody can read it, nobody misses it.
pub(super) fn say(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

impl Message {
    fn new(text: impl Into<String>, severity: Severity) -> Self {
        Self { text: text.into(), severity, help: None, place: None }
    }

    fn about_mesh(mesh: &Path, problem: &Problem, severity: Severity) -> Self {
        let (mesh, message) = (mesh.display().to_string(), &problem.message);
        let text =
            if message.starts_with(&mesh) { message.clone() } else { format!("{mesh}: {message}") };
        Self { help: problem.help.clone(), ..Self::new(text, severity) }
    }

    fn about_scene(problem: &Problem, severity: Severity) -> Self {
        let Some(position) = &problem.position else {
            // Nothing to show but the file's name.
            let text = problem.to_string();
            return Self { help: problem.help.clone(), ..Self::new(text, severity) };
        };
        let name = problem.path.display().to_string();
        Self {
            help: problem.help.clone(),
            place: Some(Excerpt::new(name, position)),
            ..Self::new(problem.message.clone(), severity)
        }
    }
}

fn show(message: &Message) {
    let text = Rendered(message).to_string();
    // Miette indents by two; what other programs read begins where lines begin.
    let text = if io::stderr().is_terminal() { text.as_str() } else { text.trim_start() };
    let _ = write!(io::stderr(), "{text}");
}

/// A message as text for standard error.
struct Rendered<'a>(&'a Message);

impl Display for Rendered<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if io::stderr().is_terminal() {
            return MietteHandlerOpts::new().build().debug(self.0, f);
        }
        // For files and other programs: no colours, one line for one sentence, words for symbols.
        let theme = GraphicalTheme {
            characters: ThemeCharacters {
                error: "error:".to_owned(),
                warning: "warning:".to_owned(),
                ..ThemeCharacters::ascii()
            },
            styles: ThemeStyles::none(),
        };
        GraphicalReportHandler::new_themed(theme)
            .with_links(false)
            .with_wrap_lines(false)
            .render_report(f, self.0)
    }
}

impl Display for Message {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Error for Message {}

impl Diagnostic for Message {
    fn severity(&self) -> Option<Severity> {
        Some(self.severity)
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        self.help.as_ref().map(|h| Box::new(h) as Box<dyn Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.place.as_ref().map(|excerpt| excerpt as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.place.as_ref()?.span();
        Some(Box::new(std::iter::once(LabeledSpan::new_with_span(None, span))))
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;
    use std::sync::Arc;

    use telamon::load::Position;

    use super::*;

    fn rendered(source: &Arc<str>, span: std::ops::Range<usize>) -> String {
        let before = &source[..span.start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let position = Position {
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            source: Arc::clone(source),
            span,
        };
        let (path, message) = (PathBuf::from("a.xml"), "it is wrong".to_owned());
        let problem = Problem { path, position: Some(position), message, help: None };
        let message = Message::about_scene(&problem, Severity::Error);
        let place = format!("[a.xml:{}", problem.position.expect("given").line);
        let text = Rendered(&message).to_string();
        assert!(text.contains(&place), "{place}: {text}");
        text
    }

    /// Every stretch of a text with everything that makes columns and bytes differ.
    #[test]
    fn every_place_can_be_shown() {
        for text in
            ["", "\n", "a", "a\n", "\r\n", "\té界\u{301}\r\n\n\ta\rb\u{1f600}\x1b[1m\u{0}c\n\n"]
        {
            let source = Arc::from(text);
            let places: Vec<_> = (0..=text.len()).filter(|&i| text.is_char_boundary(i)).collect();
            for &start in &places {
                for &end in places.iter().filter(|&&end| end >= start) {
                    rendered(&source, start..end);
                }
            }
        }
    }

    /// Rust's own padding ends at column 65535.
    #[test]
    fn a_place_far_to_the_right_can_be_shown() {
        for width in [65_000, 65_534, 65_535, 65_536, 70_000, 1 << 20] {
            let source = Arc::from(format!("{}<shape/>\n", "é".repeat(width)));
            let start = 2 * width;
            let text = rendered(&source, start..start + 6);
            assert!(text.contains(&format!("[a.xml:1:{}]", width + 1)), "{text}");
            let line = format!("1 | …{}<shape/>\n", "é".repeat(60));
            assert!(text.contains(&line), "{text}");
            let marks = format!("{}^^^", " ".repeat(61));
            assert!(text.contains(&marks), "{text}");
        }
    }
}
