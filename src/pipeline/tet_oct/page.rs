//! What `subsolid smoothness` prints, and the page that it writes.

use super::smoothness::{EdgeRecord, FaceRecord, FailedVertex, SmoothnessReport, Verdict, VertexRecord};
use std::fmt::Write as _;
use std::path::Path;

/// What is printed.
pub(super) fn summary(report: &SmoothnessReport, folder: &Path) -> String {
    let face = &report.face;
    let mut text = format!(
        "faces: eigenvalues 1, 1/2 x3, 1/4 x6 to {:.1e}; joint spectral radius below {} with {} factors\n",
        face_deviation(face),
        face.at.factors.map_or_else(|| "nothing".to_owned(), |k| format!("{:.4} < 1/4", face.at.bounds[k - 1])),
        face.at.factors.unwrap_or(face.at.bounds.len()),
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
finer mesh is identified with the one at twice its distance by their linear places. Inside tetrahedra and across faces this proves how smooth the
limit is; for edges and vertices the paper conjectures that its conditions suffice, and \"C1\" and \"pass\" mean below that they hold.

**Inside a tetrahedron** the mesh is uniform. Split and smoothing have the mask 25/48, 11/288 (twelve times) and 1/288 (six times), an
eighth of the linear mask convolved with itself, so the limit is twice continuously differentiable (C2). `tests/tet_oct.rs` holds the masks to
1e-15.
";

fn face_section(face: &FaceRecord) -> String {
    let mut text = format!(
        "## Across a face: C2\n\n\
         Eigenvalues of the 19 vertices around one on the face: 1, 1/2 (three times), 1/4 (six times) to {:.1e}, then {:.4}. A patch of the \
         face,\ntwo triangles, has values that depend on {} vertices; those in the cells at it, and so the derivatives across the face, depend on {}. \
         Its four\nmatrices map quadratic polynomials to quadratic polynomials (residuals {:.1e} and {:.1e}). Bounds on the joint spectral radius of what is \
         left,\nfrom products of k matrices in the infinity norm and an orthonormal basis:\n\n\
         | k |",
        face_deviation(face),
        face.eigenvalues[10],
        face.on.support,
        face.at.support,
        face.on.quadratics,
        face.at.quadratics,
    );
    let factors = face.on.bounds.len().max(face.at.bounds.len());
    (1..=factors).for_each(|k| text += &format!(" {k} |"));
    text += "\n|---|";
    (1..=factors).for_each(|_| text += "---|");
    for (name, patch) in [("on the patch", &face.on), ("in the cells at it", &face.at)] {
        text += &format!("\n| {name} |");
        let bound = |k: usize| patch.bounds.get(k).map_or_else(|| "-".to_owned(), |bound| format!("{bound:.3}"));
        (0..factors).for_each(|k| text += &format!(" {} |", bound(k)));
    }
    text += "\n\n";
    for (name, patch) in [("On the patch", &face.on), ("In the cells at it", &face.at)] {
        text += &match patch.factors {
            Some(k) => format!(
                "{name} {k} factors suffice for a bound below 1/4, with a margin of {:.4}. ",
                0.25 - patch.bounds[k - 1]
            ),
            None => format!("{name} no bound is below 1/4. "),
        };
    }
    text.truncate(text.trim_end().len());
    text.push('\n');
    text
}

const EDGES: &str = "\
## Along an edge: C1 for three to ten tetrahedra

Both matrices commute with the rotation around the edge; their Fourier blocks are bounded one by one. lambda1 is the double eigenvalue across
the edge, that along it is 1/2, lambda3 the smaller one. rho is the largest spectral radius found in the remainder, a bound from below on its
joint spectral radius; the bound from above is the one with k factors, and has to be below lambda3. The leading eigenvectors of frequencies 2
and up do not change along the edge, so both matrices have them in common, and their eigenvalues count as they are; \"direct k\" is what is
needed where they are left in the blocks. How many factors it takes depends on the norm; here it is the infinity norm in an orthonormal basis of each
block. The worst shape is that of the cells of the characteristic map (volume over that of a regular tetrahedron with the longest edge; negative if one
is inverted), after four steps in the annulus between one and two edges of the split mesh from the middle: the map repeats itself at all scales.

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
            e.worst,
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
and its neighbours is similar to a symmetric one, so its eigenvalues are real; lambda4 is the largest of the others of it and of the next ring of
vertices, which is 1/6. A configuration passes if 1 > lambda1 >= lambda2 >= lambda3 > lambda4 and no cell of its characteristic map is inverted,
after four steps between one and two edges of the split mesh from the vertex. Where some are, but fewer with each step, what is within three layers
of these is subdivided further, up to eight steps. That is a test at a resolution, not a proof. An edge from the vertex with eleven or twelve
tetrahedra does not fulfil its own condition, even where the vertex passes.

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
         Of all configurations with up to ten neighbours. \"Inverted\" is the part of the cells of the annulus that is inverted, or has no volume, after the \
         last two\nof the steps. Where more than half of it stays with the last step the map folds: one of the three eigenvectors bends another instead of being a \
         coordinate of\nits own, or the map turns back far from the vertex. Else whether the limit folds is not decided. Where lambda3 =\nlambda4 there is no map.\n\n\
         | neighbours | number | tetrahedra at the edges | lambda1 to lambda4 | worst shape | steps | inverted | |\n|---|---|---|---|---|---|---|---|"
    );
    for v in vertices.iter().filter(|v| !v.random) {
        v.failures.iter().for_each(|f| text += &failure_row(v.degree, f));
    }
    text
}

fn failure_row(degree: usize, f: &FailedVertex) -> String {
    let valences: Vec<String> = f.valences.iter().map(ToString::to_string).collect();
    let eigenvalues: Vec<String> = f.eigenvalues.iter().map(|x| format!("{x:.4}")).collect();
    let [before, last] = f.inverted.map(|part| format!("{part:.1e}"));
    let verdict = match f.verdict {
        Verdict::NoMap => "lambda3 = lambda4",
        Verdict::Folds => "folds",
        Verdict::Undecided => "not decided",
    };
    format!(
        "| {degree} | {} | {} | {} | {:.1e} | {} | {before}, {last} | {verdict} |\n",
        f.number,
        valences.join(" "),
        eigenvalues.join(" "),
        f.worst,
        f.steps
    )
}

fn differences(report: &SmoothnessReport, count: usize, passed: usize) -> String {
    let edge = |n: usize| report.edges.iter().find(|e| e.valence == n);
    let mut text = "## Where this differs from the paper\n\n".to_owned();
    if let Some(k) = report.face.on.factors {
        let _ = writeln!(
            text,
            "- **Faces.** The paper prints a bound of 0.238 from 9 factors, in a basis that it does not give; here {:.3} from {k}. The conclusion is \
             the same,\n  and the cells at the face, which the paper's 40 vertices leave out, confirm it.",
            report.face.on.bounds[k - 1]
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
            "- **Edges of {} tetrahedra**, which the paper does not treat, do not fulfil the condition: rho = {:.4}, of functions of frequency 2, exceeds\n  \
             lambda3 = {:.4}.",
            e.valence, e.rho, e.lambda3
        );
    }
    let failures = || report.vertices.iter().filter(|v| !v.random).flat_map(|v| &v.failures);
    let of = |verdict: Verdict| failures().filter(|f| f.verdict == verdict).count();
    let random = || report.vertices.iter().filter(|v| v.random);
    let (random_count, random_passed): (usize, usize) = random().fold((0, 0), |(c, p), v| (c + v.count, p + v.passed));
    let _ = writeln!(
        text,
        "- **Vertices.** The paper reports that all configurations \"for valences 4 through 10\" and random ones above pass. With valence as the number of \
         tetrahedra\n  these are the nine with up to seven neighbours, which pass here too. Of all {count} with up to ten neighbours, {passed} pass; of the \
         {} others,\n  all with eight neighbours or more, {} fold, {} have lambda3 = lambda4 and {} are not decided. Of {random_count} random ones above, \
         {random_passed} pass.",
        count - passed,
        of(Verdict::Folds),
        of(Verdict::NoMap),
        of(Verdict::Undecided),
    );
    text
}
