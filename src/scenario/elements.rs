//! `[analysis]` as written -> elements, and what goes with them.

use super::error::Fault;
use super::numbers::{Checked, integer};
use super::raw::*;
use super::spanned::Spanned;
use super::*;
use crate::subdiv::options::Scheme;
use std::ops::Range;

/// The element of tetrahedra, and that of hexahedra if it is one.
pub(super) fn elements(raw: Option<RawAnalysis>, body: &MeshSource) -> Checked<(Element, Option<Hexes>)> {
    let Some(raw) = raw else { return Ok((Element::default(), None)) };
    let kind = raw.element.as_ref().map_or(Ok(Element::default()), |e| e.get_ref().kind());
    let smooth = kind.is_err_and(HexElement::is_smooth);
    let idle = |span: Range<usize>, of: &str, element: &str| {
        let help = format!("leave it out, or set analysis.element = \"{element}\"");
        Err(Fault::new(span, format!("is for {of}"), "not with this element").help(help))
    };
    match (&raw.masks, &raw.points, &raw.splits) {
        (Some(masks), ..) if kind.is_ok() => return idle(masks.span(), "Catmull-Clark solids", "catmull-clark"),
        (_, Some(points), _) if kind.is_ok() => return idle(points.span(), "hexahedra", "hex27"),
        (.., Some(splits)) if kind.is_ok() => return idle(splits.span(), "Catmull-Clark solids", "catmull-clark"),
        _ => {}
    }
    if let Some(interpolate) = raw.interpolate.as_ref().filter(|_| kind.is_ok()) {
        return idle(interpolate.span(), "Catmull-Clark solids", "catmull-clark");
    }
    // The vertices of generated bodies lie on them.
    let is_round = matches!(body, MeshSource::Shape(shape) if shape.is_curved());
    let interpolate = smooth && raw.interpolate.map_or(is_round, Spanned::into_inner);
    // Fewer leave displacements that no point sees.
    let fewest = match kind {
        Err(HexElement::Hex8 | HexElement::Hex20) | Ok(_) => 2,
        Err(_) => 3,
    };
    let points = raw.points.map(|n| integer(&n, fewest..=10)).transpose()?;
    let splits = raw.splits.map(|n| integer(&n, 0..=3)).transpose()?.unwrap_or(1);
    let options =
        HexOptions { masks: raw.masks.map(|m| *m.get_ref()).unwrap_or_default(), points, splits: splits as u32 };
    Ok((kind.unwrap_or_default(), kind.err().map(|element| Hexes { element, options, curved: false, interpolate })))
}

/// `analysis.smooth`.
pub(super) fn smooth(raw: Option<Table<RawSmooth>>, analysis: Option<&RawAnalysis>) -> Checked<Option<Smooth>> {
    let Some(Table { span, value: raw }) = raw else { return Ok(None) };
    let element = analysis.and_then(|a| a.element.as_ref());
    if element.is_none_or(|e| e.get_ref().kind() != Ok(Element::Tet4)) {
        let fault = Fault::new(span, "is for four-node cells", "with these alone");
        return Err(fault.help("set analysis.element = \"tet4\""));
    }
    let steps = raw.steps.map(|n| integer(&n, 0..=5)).transpose()?.unwrap_or(2);
    Ok(Some(Smooth { steps, octahedra: raw.octahedra.unwrap_or_default(), basis: raw.basis.unwrap_or_default() }))
}

/// Refuses what does not go with `analysis.smooth`.
pub(super) fn check_smooth(
    smooth: Option<Smooth>,
    refine: &Refine,
    written: Option<Range<usize>>,
    adapt: Option<&Table<RawAdapt>>,
) -> Checked<()> {
    if smooth.is_none() {
        return Ok(());
    }
    if let Some(goal) = adapt.and_then(|t| t.value.goal.as_ref()) {
        return Err(Fault::new(goal.span(), "does not go with analysis.smooth", "no dual problem").help("leave it out"));
    }
    let is_red = refine.options.scheme == Scheme::Red && refine.strategy == Strategy::Global;
    if refine.strategy == Strategy::None || is_red {
        return Ok(());
    }
    let fault = Fault::new(
        written.unwrap_or(0..0),
        "refines the control mesh of a smooth solid in part",
        "not with analysis.smooth",
    );
    Err(fault.help("leave it out, or set scheme = \"red\": it splits all cells of the control mesh in eight"))
}

/// What becomes of mid-side nodes; curved edges need elements with nodes on them.
pub(super) fn midside(midside: Option<Spanned<Midside>>, element: Element) -> Checked<Midside> {
    let Some(midside) = midside else { return Ok(Midside::default()) };
    if *midside.get_ref() == Midside::Curved && element == Element::Tet4 {
        let fault = Fault::new(midside.span(), "curves the edges of ten-node elements only", "without these");
        return Err(fault.help("leave out analysis.element = \"tet4\""));
    }
    Ok(*midside.get_ref())
}

/// Warnings of materials that linear elements make too stiff.
pub(super) fn locking(materials: &[Material], element: Element, hexes: Option<Hexes>) -> Vec<String> {
    let (kind, better) = match hexes.map(|h| h.element) {
        None if element == Element::Tet4 => {
            ("linear tetrahedra lock", "ten-node ones do not (analysis.element = \"tet10\")")
        }
        Some(HexElement::Hex8) => (
            "trilinear hexahedra lock",
            "triquadratic ones hardly do (analysis.element = \"hex27\"), and their error is seen",
        ),
        _ => return Vec::new(),
    };
    let stiff = materials.iter().filter(|m| m.poissons_ratio > 0.49);
    let warning = |m: &Material| {
        format!(
            "materials.{}: poissons_ratio = {} is nearly incompressible; {kind} (too stiff) above 0.49: {better}",
            m.name, m.poissons_ratio
        )
    };
    stiff.map(warning).collect()
}
