//! One histogram a step, one below the other on common axes.

use super::ticks::{self, MarkedAxis};
use super::{Area, COLOURS, PALE, TEXT, TITLE, style, write_svg};
use crate::output::OutputError;
use crate::output::table::figures;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};
use std::ops::Range;
use std::path::Path;

/// What the panels have in common.
struct Frame<'a> {
    title: &'a str,
    x_label: &'a str,
    range: Range<f64>,
    bins: usize,
    /// Positions of the numbers on the axis.
    ticks: Vec<f64>,
    /// The number written at a position.
    number: &'a dyn Fn(f64) -> String,
}

/// A panel: its caption and the percentage of cells in each bin.
struct Panel {
    caption: String,
    percent: Vec<f64>,
}

/// Histograms of the minimum dihedral angle of the cells, degrees; one label and the angles of all cells for each step.
///
/// # Errors
/// [`OutputError::Write`] names `path`.
pub fn dihedral_histogram(path: &Path, steps: &[(String, Vec<f64>)]) -> Result<(), OutputError> {
    let frame = Frame {
        title: "Shape of the cells",
        x_label: "minimum dihedral angle of a cell, degrees (regular tetrahedron: 70.5)",
        range: 0.0..75.0,
        bins: 30,
        ticks: (0..=7).map(|i| 10.0 * f64::from(i)).collect(),
        number: &|x| format!("{x:.0}"),
    };
    let panels = steps.iter().map(|(label, angles)| {
        let [worst, median, _] = summary(angles);
        let caption = format!("{label}: worst {}°, median {}°", figures(worst, 3), figures(median, 3));
        Panel { caption, percent: shares(angles, &frame) }
    });
    draw(path, &frame, &panels.collect::<Vec<_>>())
}

/// Histograms of the error indicator eta_K of the cells (energy norm) on a logarithmic axis; one label and the
/// indicators of all cells for each step, and the unit of energy if one was declared. Cells eight decades below the largest, or without error, count in the first bin.
///
/// # Errors
/// [`OutputError::Write`] names `path`.
pub fn error_histogram(path: &Path, steps: &[(String, Vec<f64>)], unit: Option<&str>) -> Result<(), OutputError> {
    let unit = unit.map_or(String::new(), |unit| format!(" ({unit})"));
    let x_label = format!("estimated error of a cell in the energy norm, square root of energy{unit}");
    let logarithms: Vec<Vec<f64>> = steps.iter().map(|(_, e)| e.iter().map(|x| x.log10()).collect()).collect();
    let range = decades(logarithms.iter().flatten().copied());
    let frame = Frame {
        title: "Error of the cells",
        x_label: &x_label,
        bins: 8 * (range.end - range.start) as usize,
        ticks: (range.start as i32..=range.end as i32).map(f64::from).collect(),
        range,
        number: &|x| ticks::number(10_f64.powf(x)),
    };
    let panels = steps.iter().zip(&logarithms).map(|((label, errors), logarithms)| {
        let [_, median, worst] = summary(errors);
        let caption = format!("{label}: median {}, largest {}", figures(median, 3), figures(worst, 3));
        Panel { caption, percent: shares(logarithms, &frame) }
    });
    draw(path, &frame, &panels.collect::<Vec<_>>())
}

/// Whole decades around the logarithms, at most eight and at least one.
fn decades(logarithms: impl Iterator<Item = f64>) -> Range<f64> {
    let finite = logarithms.filter(|x| x.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
    if low > high {
        return 0.0..1.0;
    }
    let high = high.floor() + 1.0;
    low.floor().max(high - 8.0)..high
}

/// Smallest, median and largest value.
fn summary(values: &[f64]) -> [f64; 3] {
    if values.is_empty() {
        return [f64::NAN; 3];
    }
    let mut values = values.to_vec();
    let middle = values.len() / 2;
    let (below, median, above) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let median = *median;
    let least = below.iter().copied().min_by(f64::total_cmp).unwrap_or(median);
    [least, median, above.iter().copied().max_by(f64::total_cmp).unwrap_or(median)]
}

/// Percentage of the values in each bin; values outside the range count in the bin at that end.
fn shares(values: &[f64], frame: &Frame<'_>) -> Vec<f64> {
    let Range { start, end } = frame.range;
    let mut percent = vec![0.0; frame.bins];
    for x in values {
        // The conversion saturates, and takes NaN and minus infinity to the first bin.
        let bin = ((x - start) / (end - start) * frame.bins as f64) as usize;
        percent[bin.min(frame.bins - 1)] += 100.0 / values.len() as f64;
    }
    percent
}

const WIDTH: u32 = 900;
const LEFT: u32 = 90;
const HEAD: u32 = 50;
const CAPTION: u32 = 34;
const PANEL: u32 = 150;
const FOOT: u32 = 70;

fn draw(path: &Path, frame: &Frame<'_>, panels: &[Panel]) -> Result<(), OutputError> {
    let body = panels.len() as u32 * PANEL;
    write_svg(path, (WIDTH, HEAD + body + FOOT), |page| {
        let centre = style(TITLE, HPos::Center, VPos::Center);
        page.draw(&Text::new(frame.title, (WIDTH as i32 / 2, HEAD as i32 / 2), centre))?;
        let upright = style(TEXT, HPos::Center, VPos::Center).transform(FontTransform::Rotate270);
        page.draw(&Text::new("share of the cells, %", (22, (HEAD + body / 2) as i32), upright))?;
        let highest = panels.iter().flat_map(|p| &p.percent).copied().fold(1.0, f64::max);
        for (i, panel) in panels.iter().enumerate() {
            let last = i + 1 == panels.len();
            let top = HEAD + i as u32 * PANEL;
            let area = page.clone().shrink((0, top), (WIDTH, PANEL + if last { FOOT } else { 0 }));
            draw_panel(&area, frame, panel, highest, last)?;
        }
        Ok(())
    })
}

/// One histogram; the last one carries the axis of all.
fn draw_panel(
    area: &Area<'_>,
    frame: &Frame<'_>,
    panel: &Panel,
    highest: f64,
    last: bool,
) -> Result<(), Box<dyn std::error::Error>> {
    let caption = style(TEXT, HPos::Left, VPos::Bottom);
    area.draw(&Text::new(panel.caption.as_str(), (LEFT as i32, CAPTION as i32 - 6), caption))?;
    let step = ticks::linear_step(highest);
    let marks = (0..=(highest / step) as usize).map(|i| i as f64 * step).collect();
    let mut chart = ChartBuilder::on(area)
        .margin_right(30)
        .margin_top(CAPTION)
        .margin_bottom(4)
        .set_label_area_size(LabelAreaPosition::Left, LEFT)
        .set_label_area_size(LabelAreaPosition::Bottom, if last { FOOT - 4 } else { 0 })
        .build_cartesian_2d(
            MarkedAxis { range: frame.range.clone(), marks: frame.ticks.clone() },
            MarkedAxis { range: 0.0..1.05 * highest, marks },
        )?;
    chart
        .configure_mesh()
        .bold_line_style(PALE)
        .light_line_style(TRANSPARENT)
        .label_style(("sans-serif", TEXT))
        .x_label_formatter(&|x| (frame.number)(*x))
        .y_label_formatter(&|y| ticks::tidy(*y).to_string())
        .x_desc(if last { frame.x_label } else { "" })
        .draw()?;
    let width = (frame.range.end - frame.range.start) / frame.bins as f64;
    let bars = panel.percent.iter().enumerate().filter(|(_, percent)| **percent > 0.0).map(|(i, &percent)| {
        let left = frame.range.start + i as f64 * width;
        Rectangle::new([(left + 0.06 * width, 0.0), (left + 0.94 * width, percent)], COLOURS[0].filled())
    });
    chart.draw_series(bars)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_is_counted_once() {
        let frame =
            Frame { title: "", x_label: "", range: 0.0..4.0, bins: 4, ticks: vec![], number: &|x| x.to_string() };
        let percent = shares(&[f64::NEG_INFINITY, -1.0, 0.5, 1.0, 3.999, 4.0, 9.0, 2.5], &frame);
        assert_eq!(percent, [37.5, 12.5, 12.5, 37.5]);
        assert_eq!(shares(&[], &frame), [0.0; 4]);
    }

    #[test]
    fn a_summary_is_that_of_the_sorted_values() {
        assert_eq!(summary(&[3.0, 1.0, 5.0, 2.0]), [1.0, 3.0, 5.0]);
        assert_eq!(summary(&[4.0]), [4.0; 3]);
        assert!(summary(&[])[1].is_nan());
    }

    #[test]
    fn decades_enclose_the_values_and_stop_at_eight() {
        assert_eq!(decades([-2.5, 0.3, f64::NEG_INFINITY].into_iter()), -3.0..1.0);
        assert_eq!(decades([-30.0, -1.0].into_iter()), -8.0..0.0);
        assert_eq!(decades([2.0].into_iter()), 2.0..3.0);
        assert_eq!(decades([f64::NEG_INFINITY].into_iter()), 0.0..1.0);
    }
}
