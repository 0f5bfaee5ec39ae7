//! Pictures of solids as SVG: a row of panels, each a solid seen from above its front.

use glam::DVec3;
use std::fmt::Write as _;

/// Side of a panel in pixels, and panels in a row.
const SIDE: f64 = 190.0;
const COLUMNS: usize = 5;

/// A solid to be shown: what is written under it, and its surface, triangles counter-clockwise seen from outside.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// The words.
    pub title: String,
    /// The surface.
    pub surface: Vec<[DVec3; 3]>,
}

/// The picture, as the text of an SVG file. Faces turned away are left out, the others painted from back to front.
#[must_use]
pub fn picture(panels: &[Panel]) -> String {
    let (columns, rows) = (panels.len().clamp(1, COLUMNS), panels.len().div_ceil(COLUMNS));
    let (width, height) = (SIDE * columns as f64, (SIDE + 24.0) * rows as f64);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for (i, panel) in panels.iter().enumerate() {
        let (x, y) = (SIDE * (i % COLUMNS) as f64, (SIDE + 24.0) * (i / COLUMNS) as f64);
        paint(&mut svg, panel, x, y);
    }
    svg + "</svg>\n"
}

fn paint(svg: &mut String, panel: &Panel, x: f64, y: f64) {
    let depth = DVec3::new(0.45, -0.75, 0.48).normalize();
    let right = DVec3::Z.cross(depth).normalize();
    let up = depth.cross(right);
    let light = (depth + 0.6 * up - 0.5 * right).normalize();
    let flat = |p: DVec3| (p.dot(right), p.dot(up));
    let all = || panel.surface.iter().flatten().map(|p| flat(*p));
    let reach = all().map(|(u, v)| u.abs().max(v.abs())).fold(0.0, f64::max);
    let scale = 0.46 * SIDE / reach.max(f64::MIN_POSITIVE);
    let mut faces: Vec<(f64, f64, &[DVec3; 3])> = Vec::new();
    for face in &panel.surface {
        let [a, b, c] = *face;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        if normal.dot(depth) > 0.0 {
            faces.push(((a + b + c).dot(depth), normal.dot(light).max(0.0), face));
        }
    }
    faces.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Writing to a string cannot fail.
    let _ = writeln!(svg, "<g stroke=\"#26435c\" stroke-width=\"0.5\" stroke-linejoin=\"round\">");
    for (_, bright, face) in faces {
        let points: Vec<String> = face
            .iter()
            .map(|p| {
                let (u, v) = flat(*p);
                format!("{:.1},{:.1}", x + 0.5 * SIDE + scale * u, y + 0.5 * SIDE - scale * v)
            })
            .collect();
        let [r, g, b] = [110.0, 165.0, 205.0].map(|c| (c * (0.55 + 0.65 * bright)).min(255.0) as u8);
        let _ = writeln!(svg, "<polygon points=\"{}\" fill=\"rgb({r},{g},{b})\"/>", points.join(" "));
    }
    let _ = writeln!(
        svg,
        "</g>\n<text x=\"{}\" y=\"{}\" font-family=\"sans-serif\" font-size=\"12\" text-anchor=\"middle\">{}</text>",
        x + 0.5 * SIDE,
        y + SIDE + 10.0,
        panel.title
    );
}
