//! What the command says to people, on standard error: warnings and failures, with the line of the
//! scene file that they are about.

use std::collections::HashSet;
use std::error::Error;
use std::fmt::{self, Display, Formatter};
use std::io::{self, IsTerminal, Write};

use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteHandlerOpts,
    NamedSource, ReportHandler, Severity, SourceCode, ThemeCharacters, ThemeStyles,
};
use telamon::load::{LoadError, Problem, Warning};

/// Why a command ends without having done what was asked for.
#[derive(Debug)]
pub(crate) struct Failure(Vec<Message>);

/// Something to be shown.
#[derive(Debug)]
struct Message {
    text: String,
    severity: Severity,
    help: Option<String>,
    place: Option<(NamedSource<String>, LabeledSpan)>,
}

impl Failure {
    /// All that is wrong with a scene.
    pub(super) fn of_scene(error: &LoadError) -> Self {
        let messages = error.problems().iter().map(|p| Message::about_scene(p, Severity::Error));
        let more = (error.more() > 0)
            .then(|| Message::new(format!("and {} more problems", error.more()), Severity::Error));
        Self(messages.chain(more).collect())
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

/// Writes a line. If nobody can read it, nobody misses it.
pub(super) fn say(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

impl Message {
    fn new(text: impl Into<String>, severity: Severity) -> Self {
        Self { text: text.into(), severity, help: None, place: None }
    }

    fn about_scene(problem: &Problem, severity: Severity) -> Self {
        let Some(position) = &problem.position else {
            // Nothing to show but the file's name.
            let text = problem.to_string();
            return Self { help: problem.help.clone(), ..Self::new(text, severity) };
        };
        let name = problem.path.display().to_string();
        let span = LabeledSpan::new_with_span(None, position.span.clone());
        Self {
            help: problem.help.clone(),
            place: Some((NamedSource::new(name, position.source.to_string()), span)),
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
        self.place.as_ref().map(|(source, _)| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let (_, span) = self.place.as_ref()?;
        Some(Box::new(std::iter::once(span.clone())))
    }
}
