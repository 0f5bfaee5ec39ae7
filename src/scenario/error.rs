//! What can be wrong with a scenario, with the place in its text.

use miette::{Diagnostic, NamedSource, SourceSpan};
use std::{ops::Range, path::PathBuf};

/// Why a scenario cannot be used.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum ScenarioError {
    /// The file cannot be opened, or is not UTF-8.
    #[error("cannot read scenario {path}", path = path.display())]
    #[diagnostic(help("{help}"))]
    Unreadable {
        /// The file asked for.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
        /// What to do.
        help: String,
    },
    /// A mesh in place of a scenario.
    #[error("{path} is a {format} mesh, not a scenario", path = path.display())]
    #[diagnostic(help(
        "look at it with `subsolid inspect`, refine it with `subsolid subdivide`, or name it in a scenario's [mesh]"
    ))]
    Mesh {
        /// The file.
        path: PathBuf,
        /// Its format.
        format: &'static str,
    },
    /// The text is not TOML, or a key or value is not what a scenario takes.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Invalid(Box<Invalid>),
}

/// A fault in the text of a scenario or in a `--set` override.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("{place}: {message}")]
pub struct Invalid {
    /// `file:line:column`, or `--set key=value`.
    pub place: String,
    /// Path of the key, such as `supports.feet.plane.normal`; empty if the text is not TOML.
    pub key: String,
    /// What is wrong.
    pub message: String,
    /// The text that holds the fault.
    #[source_code]
    pub source_code: NamedSource<String>,
    /// Where in `source_code`.
    #[label("{label}")]
    pub span: SourceSpan,
    /// What is at `span`.
    pub label: String,
    /// What to do.
    #[help]
    pub help: Option<String>,
}

/// A fault before the place and the key are looked up.
#[derive(Debug, Clone)]
pub(super) struct Fault {
    /// Bytes of the document.
    pub span: Range<usize>,
    /// A phrase that follows the key, such as "must be positive".
    pub problem: String,
    /// What stands at the span.
    pub label: String,
    /// What to do.
    pub help: Option<String>,
}

impl Fault {
    pub(super) fn new(span: Range<usize>, problem: impl Into<String>, label: impl Into<String>) -> Self {
        Self { span, problem: problem.into(), label: label.into(), help: None }
    }

    pub(super) fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
}
