//! Why cells cannot be marked.

/// What is wrong with an error field or a parameter of marking.
#[derive(Debug, Clone, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum AdaptError {
    /// A parameter out of its range.
    #[error("marking: {name} is {value}, it must be {range}")]
    #[diagnostic(help("doerfler = 0.5 is a good start: the fewest cells that hold half of the squared error"))]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// An error that is no error.
    #[error("the estimated squared error of cell {cell} is {value}, it must be finite and not negative")]
    #[diagnostic(help(
        "the solution is not usable there: look at the cell's shape, its material and the solver's report"
    ))]
    NotAnError {
        /// Cell index.
        cell: usize,
        /// The value found.
        value: f64,
    },
}
