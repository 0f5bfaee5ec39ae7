//! The error against what it cost, in double logarithmic scale.

use super::ticks::{self, MarkedAxis};
use super::{Area, COLOURS, GREY, PALE, TEXT, TITLE, style, write_svg};
use crate::output::OutputError;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::ops::Range;
use std::path::Path;

/// What the error is plotted against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Unknowns; a line of slope -p/3 shows the best rate of elements of this degree p on smooth solutions.
    Unknowns(u8),
    /// Seconds since the start of the run.
    Seconds,
    /// Most memory held since the start of the run, in megabytes.
    Memory,
}

/// Curves of the relative error, `source` of which says whether it is estimated or true: for each run its name and, for each
/// step, what was paid and the error (a fraction, shown in percent). Points that have no logarithm are left out.
///
/// # Errors
/// [`OutputError::Write`] names `path`.
pub fn error_curves(
    path: &Path,
    axis: Axis,
    source: &str,
    runs: &[(String, Vec<(f64, f64)>)],
) -> Result<(), OutputError> {
    let runs: Vec<Run<'_>> = runs.iter().map(|(name, points)| Run { name, points: percent(points) }).collect();
    write_svg(path, (900, 620), |page| draw(page, axis, source, &runs))
}

/// A curve in decimal logarithms; the error in percent.
pub(super) struct Run<'a> {
    pub name: &'a str,
    pub points: Vec<(f64, f64)>,
}

/// Of what was paid and the errors in percent.
fn percent(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let points: Vec<(f64, f64)> = points.iter().map(|&(paid, error)| (paid, 100.0 * error)).collect();
    logarithms(&points)
}

/// Decimal logarithms of points that have them.
pub(super) fn logarithms(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let points = points.iter().map(|&(x, y)| (x.log10(), y.log10()));
    points.filter(|(x, y)| x.is_finite() && y.is_finite()).collect()
}

fn draw(page: &Area<'_>, axis: Axis, source: &str, runs: &[Run<'_>]) -> Result<(), Box<dyn std::error::Error>> {
    let all = || runs.iter().flat_map(|r| &r.points);
    let reference = match axis {
        Axis::Unknowns(degree) => reference(all().copied(), degree),
        Axis::Seconds | Axis::Memory => Vec::new(),
    };
    let x = padded(all().map(|p| p.0));
    let y = padded(all().chain(&reference).map(|p| p.1));
    let (title, x_label) = match axis {
        Axis::Unknowns(_) => ("Error against unknowns", "unknowns"),
        Axis::Seconds => ("Error against time", "seconds since the start"),
        Axis::Memory => ("Error against memory", "most memory held since the start, MB"),
    };
    let mut chart = ChartBuilder::on(page)
        .margin(16)
        .margin_right(40)
        .caption(title, style(TITLE, HPos::Center, VPos::Top))
        .set_label_area_size(LabelAreaPosition::Left, 90)
        .set_label_area_size(LabelAreaPosition::Bottom, 66)
        .build_cartesian_2d(marked(x), marked(y))?;
    chart
        .configure_mesh()
        .bold_line_style(PALE)
        .light_line_style(TRANSPARENT)
        .label_style(("sans-serif", TEXT))
        .x_label_formatter(&|x| ticks::number(10_f64.powf(*x)))
        .y_label_formatter(&|y| ticks::number(10_f64.powf(*y)))
        .x_desc(x_label)
        .y_desc(format!("{source} relative error, %"))
        .draw()?;
    if let (Axis::Unknowns(degree), [_, ..]) = (axis, &reference[..]) {
        chart
            .draw_series(DashedLineSeries::new(reference, 8, 6, GREY.stroke_width(2)))?
            .label(format!("slope -{degree}/3"))
            .legend(|(x, y)| DashedPathElement::new(vec![(x, y), (x + 36, y)], 8, 6, GREY.stroke_width(2)));
    }
    draw_runs(&mut chart, runs, SeriesLabelPosition::UpperRight)
}

/// A chart of logarithms.
pub(super) type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<MarkedAxis, MarkedAxis>>;

/// Draws curves with markers, and what they are called in a corner.
pub(super) fn draw_runs<'a>(
    chart: &mut Chart<'a>,
    runs: &[Run<'_>],
    corner: SeriesLabelPosition,
) -> Result<(), Box<dyn std::error::Error>> {
    for (i, run) in runs.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        chart.draw_series(LineSeries::new(run.points.iter().copied(), colour.stroke_width(3)))?.label(run.name).legend(
            move |(x, y)| {
                EmptyElement::at((x, y))
                    + PathElement::new(vec![(0, 0), (36, 0)], colour.stroke_width(3))
                    + marker(i, (18, 0), colour)
            },
        );
        chart.draw_series(run.points.iter().map(|&p| EmptyElement::at(p) + marker(i, (0, 0), colour)))?;
    }
    chart
        .configure_series_labels()
        .position(corner)
        .margin(14)
        .legend_area_size(46)
        .label_font(("sans-serif", TEXT))
        .background_style(WHITE)
        .border_style(PALE)
        .draw()?;
    Ok(())
}

/// A disc for the first run, a square for the second, and so on in turns, so that no reader depends on colour.
fn marker(run: usize, (x, y): (i32, i32), colour: RGBColor) -> Polygon<(i32, i32)> {
    let corners = if run.is_multiple_of(2) { 24 } else { 4 };
    let corner = |i: usize| {
        let angle = std::f64::consts::TAU * (i as f64 + 0.5) / corners as f64;
        let (sin, cos) = angle.sin_cos();
        (x + (7.0 * cos).round() as i32, y + (7.0 * sin).round() as i32)
    };
    Polygon::new((0..corners).map(corner).collect::<Vec<_>>(), colour.filled())
}

/// A line of slope -p/3, a little below the first point, as far as the curves reach to the right and down.
fn reference(points: impl Iterator<Item = (f64, f64)> + Clone, degree: u8) -> Vec<(f64, f64)> {
    let slope = f64::from(degree) / 3.0;
    let Some((x0, y0)) = points.clone().next() else { return Vec::new() };
    let (end, lowest) = points.fold((x0, y0), |(x, y), p| (x.max(p.0), y.min(p.1)));
    let y0 = y0 - 0.04;
    let length = (end - x0).min((y0 - lowest) / slope);
    if length > 0.0 { vec![(x0, y0), (x0 + length, y0 - slope * length)] } else { Vec::new() }
}

/// The range of the values with some room at both ends, at least half a decade.
pub(super) fn padded(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
    if low > high {
        return 0.0..1.0;
    }
    let room = (0.06 * (high - low)).max(0.25 - 0.5 * (high - low)).max(0.03);
    low - room..high + room
}

/// An axis of logarithms with the numbers they stand for.
pub(super) fn marked(range: Range<f64>) -> MarkedAxis {
    let numbers = ticks::logarithmic(10_f64.powf(range.start), 10_f64.powf(range.end));
    MarkedAxis { range, marks: numbers.iter().map(|x| x.log10()).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_enclose_the_curves() {
        let range = padded([2.0, 5.0].into_iter());
        assert!(range.start < 2.0 && range.end > 5.0);
        assert!(padded([1.0].into_iter()).end - padded([1.0].into_iter()).start >= 0.5);
        assert_eq!(padded(std::iter::empty()), 0.0..1.0);
    }

    #[test]
    fn the_reference_line_has_the_slope_of_its_degree_in_logarithms() {
        for degree in [1, 2] {
            let line = reference([(3.0, 1.5), (6.0, 0.0)].into_iter(), degree);
            let slope = (line[1].1 - line[0].1) / (line[1].0 - line[0].0);
            assert!((slope + f64::from(degree) / 3.0).abs() < 1e-12);
            assert!(reference(std::iter::once((1.0, 1.0)), degree).is_empty());
        }
    }

    #[test]
    fn points_without_a_logarithm_are_left_out() {
        assert_eq!(percent(&[(0.0, 0.1), (10.0, 0.0), (f64::NAN, 1.0), (10.0, 0.1)]), [(1.0, 1.0)]);
    }
}
