//! `report.html`: a page that shows a run, or several beside each other, in any browser and without a network.
//!
//! The page is a template (built from `report/` by its script, with its program inside) and data: the report and the scenario
//! as JSON, and for each step what is drawn of it. Of a step, surfaces are drawn, and inner cells up to a limit; numbers
//! become codes of 16 bits between the least and the largest of their kind, are compressed, and stand in the page as text.

mod again;
mod cells;
mod edges;
mod encode;
mod pick;
mod shown;
mod write;

pub use again::OldStep;
pub use pick::{Mark, Steps};
pub use shown::{Shown, Solved};
pub use write::{PageRun, write_page};
