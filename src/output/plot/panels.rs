//! Several quantities against one, side by side, in double logarithmic scale.

use super::curves::{Run, draw_runs, logarithms, marked, padded};
use super::{Area, PALE, TEXT, TITLE, style, ticks, write_svg};
use crate::output::OutputError;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::path::Path;

/// One quantity: what it is called, and for each curve its name and points.
pub struct Panel<'a> {
    /// Its name and unit.
    pub title: &'a str,
    /// The curves, the same in all panels of a picture. Points that have no logarithm are left out.
    pub curves: Vec<(String, Vec<(f64, f64)>)>,
}

/// Draws up to four panels.
///
/// # Errors
/// [`OutputError::Write`] names `path`.
pub fn panels(path: &Path, x_label: &str, panels: &[Panel<'_>]) -> Result<(), OutputError> {
    write_svg(path, (1400, 1000), |page| {
        for (area, panel) in page.split_evenly((2, 2)).iter().zip(panels) {
            draw(area, x_label, panel)?;
        }
        Ok(())
    })
}

fn draw(area: &Area<'_>, x_label: &str, panel: &Panel<'_>) -> Result<(), Box<dyn std::error::Error>> {
    let runs: Vec<Run<'_>> =
        panel.curves.iter().map(|(name, points)| Run { name, points: logarithms(points) }).collect();
    let all = || runs.iter().flat_map(|r| &r.points);
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .margin_right(30)
        .caption(panel.title, style(TITLE, HPos::Center, VPos::Top))
        .set_label_area_size(LabelAreaPosition::Left, 90)
        .set_label_area_size(LabelAreaPosition::Bottom, 60)
        .build_cartesian_2d(marked(padded(all().map(|p| p.0))), marked(padded(all().map(|p| p.1))))?;
    chart
        .configure_mesh()
        .bold_line_style(PALE)
        .light_line_style(TRANSPARENT)
        .label_style(("sans-serif", TEXT))
        .x_label_formatter(&|x| ticks::number(10_f64.powf(*x)))
        .y_label_formatter(&|y| ticks::number(10_f64.powf(*y)))
        .x_desc(x_label)
        .draw()?;
    draw_runs(&mut chart, &runs, SeriesLabelPosition::LowerRight)
}
