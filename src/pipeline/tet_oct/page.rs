//! What `subsolid smoothness` prints, and the page that it writes.

use super::smoothness::{EdgeRecord, FaceRecord, SmoothnessReport, VertexRecord};
use std::fmt::Write as _;
use std::path::Path;

/// What is printed.
pub(super) fn summary(report: &SmoothnessReport, folder: &Path) -> String {
    let face = &report.face;
    let mut text = format!(
        "faces: eigenvalues 1, 1/2 x3, 1/4 x6 to {:.1e}; joint spectral radius below {} with {} factors\n",
        face_deviation(face),
        face.factors.map_or_else(|| "nothing".to_owned(), |k| format!("{:.4} < 1/4", face.bounds[k - 1])),
        face.factors.unwrap_or(face.bounds.len()),
    );
    for edge in &report.edges {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", edge_line(edge));
    }
    for vertex in &report.vertices {
        let kind = if vertex.random { "random" } else { "all" };
        let _ = writeln!(
            text,
            "vertices with {} neighbours, {kind}: {} of {} pass; lambda3 - lambda4 at least {:.4}",
            vertex.degree, vertex.passed, vertex.count, vertex.gap
        );
    }
    let _ = writeln!(text, "maps written to {}", folder.display());
    text
}

fn edge_line(edge: &EdgeRecord) -> String {
    let shown = edge.factors.map_or_else(|| "not shown".to_owned(), |k| format!("shown with {k} factors"));
    format!(
        "edges of {} tetrahedra: lambda1 {:.4}, lambda3 {:.4}, rho {:.4}: {shown}",
        edge.valence, edge.lambda1, edge.lambda3, edge.rho
    )
}

/// How far the ten leading eigenvalues are from 1, 1/2 and 1/4.
fn face_deviation(face: &FaceRecord) -> f64 {
    let expected = [1.0].into_iter().chain([0.5; 3]).chain([0.25; 6]);
    face.eigenvalues.iter().zip(expected).map(|(got, want)| (got - want).abs()).fold(0.0, f64::max)
}

/// The page, in Markdown; its pictures lie in the folder `beside` it.
pub(super) fn page(report: &SmoothnessReport, beside: &str) -> String {
    let all = || report.vertices.iter().filter(|v| !v.random);
    let (count, passed): (usize, usize) = all().fold((0, 0), |(c, p), v| (c + v.count, p + v.passed));
    [
        INTRODUCTION.to_owned(),
        face_section(&report.face),
        edge_section(&report.edges, beside),
        vertex_section(&report.vertices, beside),
        differences(report, count, passed),
    ]
    .join("\n")
}

const INTRODUCTION: &str = "\
# How smooth tetrahedral/octahedral subdivision is

Written by `subsolid smoothness --markdown docs/smoothness.md`, which repeats appendix A of Schaefer, Hakenberg and Warren,
*Smooth subdivision of tetrahedral meshes* (2004), by machine. The base cells are split linearly three times; then the matrices of one step
of subdivision are taken around a face, an edge or a vertex of the base mesh, where the mesh looks the same at all scales. A vertex of the
finer mesh is identified with the one at twice its distance by their linear places. Inside tetrahedra this proves how smooth the limit
is, and across faces for the values on the face, which are all that the 40 vertices below carry; for edges and vertices the paper conjectures that
its conditions suffice, and \"C1\" and \"pass\" mean below that they hold.

**Inside a tetrahedron** the mesh is uniform. Split and smoothing have the mask 25/48, 11/288 (twelve times) and 1/288 (six times), an
eighth of the linear mask convolved with itself, so the limit is twice continuously differentiable (C2). `tests/tet_oct.rs` holds the masks to
1e-15.
";

fn face_section(face: &FaceRecord) -> String {
    let mut text = format!(
        "## Across a face: C2\n\n\
         Eigenvalues of the 19 vertices around one on the face: 1, 1/2 (three times), 1/4 (six times) to {:.1e}, then {:.4}. A patch of the \
         face,\ntwo triangles, depends on {} vertices; its four matrices map quadratic polynomials to quadratic polynomials (residual {:.1e}). Bounds on \
         the\njoint spectral radius of what is left, from products of k matrices in the infinity norm and an orthonormal basis:\n\n\
         | k |",
        face_deviation(face),
        face.eigenvalues[10],
        face.support,
        face.quadratics,
    );
    (1..=face.bounds.len()).for_each(|k| text += &format!(" {k} |"));
    text += "\n|---|";
    face.bounds.iter().for_each(|_| text += "---|");
    text += "\n| bound |";
    face.bounds.iter().for_each(|bound| text += &format!(" {bound:.3} |"));
    text += &match face.factors {
        Some(k) => format!(
            "\n\nFrom k = {k} it is below 1/4, by {:.3} there: the limit is C2 across faces.\n",
            0.25 - face.bounds[k - 1]
        ),
        None => "\n\nNone of these is below 1/4.\n".to_owned(),
    };
    text
}

const EDGES: &str = "\
## Along an edge: C1 for three to ten tetrahedra

Both matrices commute with the rotation around the edge; their Fourier blocks are bounded one by one. lambda1 is the double eigenvalue across
the edge, that along it is 1/2, lambda3 the smaller one. rho is the largest spectral radius found in the remainder, a bound from below on its
joint spectral radius; the bound from above is the one with k factors, and has to be below lambda3. The leading eigenvectors of frequencies 2
and up do not change along the edge, so both matrices have them in common, and their eigenvalues count as they are; \"direct k\" is what is
needed where they are left in the blocks. How many factors it takes depends on the norm; here it is the infinity norm in an orthonormal basis of each
block. The worst shape is that of the cells of the characteristic map after two steps (volume over that of a
regular tetrahedron with the longest edge; negative if one is inverted).

| n | lambda1 | lambda3 | rho | bound | k | direct k | lambda3 - bound | worst shape | C1 |
|---|---|---|---|---|---|---|---|---|---|
";

fn edge_section(edges: &[EdgeRecord], beside: &str) -> String {
    let mut text = EDGES.to_owned();
    let or_none = |k: Option<usize>| k.map_or_else(|| "none".to_owned(), |k| k.to_string());
    for e in edges {
        let _ = writeln!(
            text,
            "| {} | {:.4} | {:.4} | {:.4} | {:.4} | {} | {} | {:+.4} | {:.4} | {} |",
            e.valence,
            e.lambda1,
            e.lambda3,
            e.rho,
            e.bound,
            or_none(e.factors),
            or_none(e.direct_factors),
            e.lambda3 - e.bound,
            e.worst[2],
            if e.passes { "yes" } else { "not shown" },
        );
    }
    let _ = writeln!(
        text,
        "\nTheir characteristic maps after one step (figure 11 of the paper):\n\n![Characteristic maps of edges]({beside}/edges.svg)"
    );
    text
}

const VERTICES: &str = "\
## At a vertex

The tetrahedra at a vertex are the cones over a triangulation of the sphere. There are 1, 1, 2, 5, 14, 50 and 233 with 4 to 10 vertices, up to
numbering and reflection, 306 in all; above, random ones (by ten times as many flips of random edges as vertices). The matrix of the vertex
and its neighbours is similar to a symmetric one, so its eigenvalues are real. A configuration passes if 1 > lambda1 >= lambda2 >= lambda3 >
lambda4 and no cell of its characteristic map is inverted after two steps.

| neighbours | tetrahedra | configurations | pass | lambda1 | lambda3 | least lambda3 - lambda4 | worst shape |
|---|---|---|---|---|---|---|---|
";

fn vertex_section(vertices: &[VertexRecord], beside: &str) -> String {
    let mut text = VERTICES.to_owned();
    for v in vertices {
        let _ = writeln!(
            text,
            "| {} | {} | {}{} | {} | {:.4} to {:.4} | {:.4} to {:.4} | {:.4} | {:.4} |",
            v.degree,
            2 * v.degree - 4,
            v.count,
            if v.random { " random" } else { "" },
            v.passed,
            v.lambda1[0],
            v.lambda1[1],
            v.lambda3[0],
            v.lambda3[1],
            v.gap,
            v.worst,
        );
    }
    let _ = writeln!(
        text,
        "\nThe nine with up to seven neighbours, after one step (figure 12 of the paper), with the numbers of tetrahedra at the edges from the \
         vertex:\n\n![Characteristic maps of vertices]({beside}/vertices.svg)\n\n\
         ### Those that do not pass\n\n\
         Of all configurations with up to ten neighbours. Where the worst shape is negative a cell of the map of the three eigenvectors is inverted. \
         In some of\nthem, such as the first, the map folds everywhere: the third bends one of the others instead of being a coordinate of its own, and the \
         fourth\nis what is missing. In others only cells next to the vertex are inverted, of which the limit knows nothing, so that more may pass than are \
         counted.\n\n\
         | neighbours | number | tetrahedra at the edges | lambda1 to lambda4 | worst shape |\n|---|---|---|---|---|"
    );
    for v in vertices.iter().filter(|v| !v.random) {
        for f in &v.failures {
            let valences: Vec<String> = f.valences.iter().map(ToString::to_string).collect();
            let eigenvalues: Vec<String> = f.eigenvalues.iter().map(|x| format!("{x:.4}")).collect();
            let (degree, number) = (v.degree, f.number);
            let _ = writeln!(
                text,
                "| {degree} | {number} | {} | {} | {:.4} |",
                valences.join(" "),
                eigenvalues.join(" "),
                f.worst
            );
        }
    }
    text
}

fn differences(report: &SmoothnessReport, count: usize, passed: usize) -> String {
    let edge = |n: usize| report.edges.iter().find(|e| e.valence == n);
    let mut text = "## Where this differs from the paper\n\n".to_owned();
    if let Some(k) = report.face.factors {
        let _ = writeln!(
            text,
            "- **Faces.** The paper prints a bound of 0.238 from 9 factors, in a basis that it does not give; here {:.3} from {k}. The conclusion is \
             the same.",
            report.face.bounds[k - 1]
        );
    }
    if let Some(e) = edge(3).filter(|e| e.passes) {
        let _ = writeln!(
            text,
            "- **Edges of three tetrahedra.** The paper found no number of factors for them and saw deformations that are not smooth. In Fourier \
             blocks {} factors\n  show the bound {:.4} below lambda3 = {:.4}: the condition holds with a thin margin. What the paper saw is the shape: lambda1 = \
             {:.3} across the edge\n  against 1/2 along it, so cells become flat needles there.",
            e.factors.unwrap_or_default(),
            e.bound,
            e.lambda3,
            e.lambda1
        );
    }
    if let Some(e) = edge(10).filter(|e| e.passes) {
        let _ = writeln!(
            text,
            "- **Edges of ten tetrahedra.** The paper passes them by a direct bound. Ours stays above 1/2 in the blocks as they are; with the common \
             eigenvector of\n  frequency 2 ({:.4}) taken out, the margin is {:.4}.",
            e.rho,
            e.lambda3 - e.bound
        );
    }
    for e in report.edges.iter().filter(|e| e.valence > 10 && !e.passes) {
        let _ = writeln!(
            text,
            "- **Edges of {} tetrahedra**, which the paper does not treat, fail: rho = {:.4} exceeds lambda3 = {:.4}, so functions of frequency 2 fall more \
             slowly than\n  the coordinate along the edge.",
            e.valence, e.rho, e.lambda3
        );
    }
    let _ = writeln!(
        text,
        "- **Vertices.** The paper reports that all configurations \"for valences 4 through 10\" and random ones above pass. With valence as the number of \
         tetrahedra\n  these are the nine with up to seven neighbours, which pass here too. Of all {count} with up to ten neighbours, {passed} pass; the \
         {} others,\n  all with eight neighbours or more, are listed above, most of them with maps that fold.",
        count - passed
    );
    text
}
