//! The classes of bad input, faults and load of `docs/errors.md`: a test for each, named after it (some stand beside the sources they
//! are about), and a check that the page names them all.
#![allow(clippy::unwrap_used)]

#[path = "errors/catalogue.rs"]
mod catalogue;
#[path = "errors/model.rs"]
mod model;
#[path = "errors/rough.rs"]
mod rough;
#[path = "errors/run.rs"]
mod run;
#[path = "errors/scenario.rs"]
mod scenario;
#[path = "errors/syntax.rs"]
mod syntax;
#[path = "errors/topology.rs"]
mod topology;
