//! Pictures beside the numbers, as SVG: histograms over the steps of a run, and the error against what it cost.

mod curves;
mod histogram;
mod panels;
mod ticks;

pub use curves::{Axis, error_curves};
pub use histogram::{dihedral_histogram, error_histogram};
pub use panels::{Panel, panels};

use super::OutputError;
use super::atomic::write_atomic;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::fmt::Display;
use std::io;
use std::path::Path;

/// Where we draw.
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Distinguishable with every kind of colour vision: blue, vermillion, green, purple, orange, sky blue, black (Okabe and
/// Ito 2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
const GREY: RGBColor = RGBColor(110, 110, 110);
const PALE: RGBColor = RGBColor(225, 225, 225);

/// Sizes of text in units of the picture, which is about 900 wide.
const TITLE: u32 = 26;
const TEXT: u32 = 20;

/// Draws on a white page of `size` and writes it.
fn write_svg(
    path: &Path,
    size: (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> Result<(), Box<dyn std::error::Error>>,
) -> Result<(), OutputError> {
    let mut svg = String::new();
    render(&mut svg, size, draw).map_err(|e| OutputError::write(path, e))?;
    write_atomic(path, |w| w.write_all(svg.as_bytes()))
}

fn render(
    svg: &mut String,
    size: (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> Result<(), Box<dyn std::error::Error>>,
) -> io::Result<()> {
    let other = |e: &dyn Display| io::Error::other(e.to_string());
    let page = SVGBackend::with_string(svg, size).into_drawing_area();
    page.fill(&WHITE).map_err(|e| other(&e))?;
    draw(&page).map_err(|e| other(&e))?;
    page.present().map_err(|e| other(&e))
}

fn style<'a>(size: u32, horizontal: HPos, vertical: VPos) -> TextStyle<'a> {
    ("sans-serif", size).into_font().color(&BLACK).pos(Pos::new(horizontal, vertical))
}
