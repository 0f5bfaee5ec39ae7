#!/usr/bin/env python3
"""Writes docs/table-1.md: Table 1 of Burkhart, Hamann and Umlauf (2010) beside ours, with the histograms.

    cargo build --release
    python3 docs/table_1.py --data FOLDER [--levels 1 2] [--threads 2]

The folder holds `tripod.GiD.msh` (see README.md); without `--data` it is the one named by SUBSOLID_DATA. Needs nothing but
Python; the comparison with other mesh improvers at its end needs the wheels that `benches/peers/meshers.py` names, and
is replaced by their names where they are missing.
"""

import argparse
import math
import os
import re
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "benches/peers"))

import meshers  # noqa: E402

FEATURE_ANGLE = 70
SELECTED = 284

# Table 1: nodes, edges, tets, worst, average, best angle, average and largest valence.
INPUT = (967, 4621, 2799, 7.4, 42.0, 64.1, 8, 50)
UNIFORM = {1: (5476, 31521, 23480, 6.1, 36.1, 65.2, 12, 150), 2: (34086, 202809, 161028, 4.9, 28.4, 65.7, 16, 223)}
ADAPTIVE = {1: (5910, 6292, 4074, 6.8, 38.3, 64.1, 9, 114), 2: (7658, 16410, 12089, 5.9, 30.6, 65.5, 16, 165)}

# What Table 1 cannot have meant, by (row, column).
DOUBTFUL = {
    ("input", "valence"): 1,
    ("uniform 1", "valence"): 1,
    ("uniform 2", "valence"): 1,
    ("adaptive 1", "valence"): 1,
    ("adaptive 2", "valence"): 1,
    ("adaptive 1", "nodes"): 2,
    ("adaptive 2", "nodes"): 2,
    ("input", "angles"): 3,
}

# Section 7's list of the elementary steps of the first step: stage of `subdivide --frames`, the paper's count.
STAGES = {
    "input": "2,799",
    "1-4 splits": "11,196",
    "2-3 flips": "21,096 [4]",
    "boundary 1-3 splits": "",
    "boundary flips": "",
}

HEAD = """\
| mesh | nodes | edges | tets | boundary faces | worst / average / best angle | average valence | largest valence | vertices \
above valence 50 | tets per second |
|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|"""

NOTES = """\
Entries of the paper that cannot be right as they stand:

1. *Average valences 8, 12, 16.* A mesh of V nodes, E edges and T tetrahedra has 4 T / V tetrahedra and 2 E / V edges at a
   vertex on average. By the paper's own counts that is 11.6 and 9.6 for the input, 17.2 and 11.5 after one step, 18.9 and
   11.9 after two; neither reading gives its column. (The largest valences count tetrahedra: 50 in the input is that of
   this mesh.) The text on the second example has the *largest* valence grow from 8 to 16, where the table has 114 and 165.
2. *Nodes of example 2.* For a solid with one handle, as the tripod is, V - E + F - T = 0, so E = V + T + B / 2 with B boundary
   faces. The input and both steps of example 1 fulfil it exactly; example 2's 5,910 nodes exceed what its 6,292 edges and
   4,074 tetrahedra allow. 284 cells with 56 boundary faces split once give 967 + 284 + 56 = 1,307 nodes and exactly the
   6,292 edges printed; likewise 7,658 does not go with 16,410 edges and 12,089 tetrahedra.
3. *Angles of the input.* 7.4 / 42.0 / 64.1 differ a little from those of this file, GetFEM's tripod, whose counts are the paper's
   to the last digit.
4. *21,096 tetrahedra after the 2-3 flips* (section 7, list). Its own formula, n_b + 3 (4 n - n_b) / 2 with n = 2,799 and n_b = 1,710,
   gives 15,939; 11,196 splits and one more for each of 4,743 flips as well. Ours are fewer by the flips refused because they
   would have made an inverted tetrahedron.
"""


def tripod_cells(path):
    """Centroids of the cells of a GiD file, from their four corners."""
    points, centroids, section = {}, [], None
    for line in path.read_text().splitlines():
        words = line.split()
        name = line.strip().lower()
        if name in ("coordinates", "elements"):
            section = name
        elif name.startswith("end"):
            section = None
        elif section == "coordinates":
            points[words[0]] = [float(x) for x in words[1:4]]
        elif section == "elements":
            corners = [points[w] for w in words[1:5]]
            centroids.append([sum(c) / 4 for c in zip(*corners)])
    return centroids


def compact_selection(path):
    """Numbers of the cells nearest to the one farthest along z: the end of a leg."""
    centroids = tripod_cells(path)
    centre = max(centroids, key=lambda c: c[2])
    order = sorted(range(len(centroids)), key=lambda t: (math.dist(centroids[t], centre), t))
    return sorted(order[:SELECTED])


def paper_row(label, key, entries, faces):
    """A row of Table 1 as printed, doubtful entries marked."""
    nodes, edges, tets, worst, average, best, valence, largest = entries
    mark = lambda column, text: text + (f" [{DOUBTFUL[key, column]}]" if (key, column) in DOUBTFUL else "")
    share = "less than 2 %" if key == "uniform 2" else ""
    cells = [
        label,
        mark("nodes", f"{nodes:,}"),
        f"{edges:,}",
        f"{tets:,}",
        faces,
        mark("angles", f"{worst} / {average} / {best}"),
        mark("valence", f"{valence}"),
        f"{largest}",
        share,
        "",
    ]
    return "| " + " | ".join(cells) + " |"


def our_row(label, report, timed=True):
    """A row of ours from the JSON of `subdivide`."""
    q = report["quality"]
    cells = [
        label,
        f"{report['nodes']:,}",
        f"{report['edges']:,}",
        f"{report['cells']:,}",
        f"{report['boundary_faces']:,}",
        f"{q['worst']:.2f} / {q['average']:.1f} / {q['best']:.1f}",
        f"{q['average_valence']:.1f}",
        f"{q['max_valence']}",
        f"{100 * q['valence_above_50']:.2f} %",
        f"{report['cells'] / report['seconds']:,.0f}" if timed else "",
    ]
    return "| " + " | ".join(cells) + " |"


class Runs:
    """The reports of all meshes asked for, each made once."""

    def __init__(self, options, mesh, folder):
        self.options, self.mesh, self.folder, self.made = options, mesh, Path(folder), {}
        self.cells = self.folder / "cells.txt"
        self.cells.write_text("".join(f"{t}\n" for t in compact_selection(mesh)))

    def report(self, steps, mode="paper", boundary="approximating", adaptive=False, measure="min-sine", frames=None):
        """What `subdivide` says of a mesh."""
        key = (steps, mode, boundary, adaptive, measure, frames)
        if key not in self.made:
            words = ["--steps", steps, "--optimise", mode, "--boundary", boundary, "--feature-angle", FEATURE_ANGLE]
            words += ["--measure", measure] if mode == "paper" else []
            words += ["--select", self.cells] if adaptive else []
            words += ["--frames", frames] if frames else []
            out = self.folder / "mesh.vtu"
            run = lambda: meshers.subdivide(self.options.subsolid, self.mesh, out, *words, threads=self.options.threads)
            # The other measures are slow, and their seconds beside the point.
            repeat = self.options.repeat if measure == "min-sine" and not frames else 1
            self.made[key] = min((run() for _ in range(repeat)), key=lambda report: report["seconds"])
            print(*key[:3], measure, "284 cells" if adaptive else "all cells", file=sys.stderr)
        return self.made[key]


MODES = [("paper", "approximating"), ("best", "approximating"), ("paper", "fixed"), ("best", "fixed")]


def uniform_table(runs, levels):
    """Example 1, the paper beside ours."""
    lines = [HEAD, paper_row("**input**, the paper", "input", INPUT, "1,710"), our_row("input, ours", runs.report(0), False)]
    for level in levels:
        if level in UNIFORM:
            faces = f"{1710 * 3**level:,}"
            lines.append(paper_row(f"**step {level}**, the paper", f"uniform {level}", UNIFORM[level], faces))
        for mode, boundary in MODES:
            lines.append(our_row(f"step {level}, {mode} mode, {boundary}", runs.report(level, mode, boundary)))
    return "\n".join(lines)


def adaptive_table(runs, levels):
    """Example 2, the paper beside ours."""
    lines = [HEAD]
    for level in levels:
        if level in ADAPTIVE:
            lines.append(paper_row(f"**step {level}**, the paper", f"adaptive {level}", ADAPTIVE[level], ""))
        for mode in ("paper", "best"):
            lines.append(our_row(f"step {level}, {mode} mode, approximating", runs.report(level, mode, adaptive=True)))
    return "\n".join(lines)


def measure_table(runs, levels):
    """The measures that the paper names, as what drives its operations."""
    lines = [HEAD]
    for level in levels:
        for measure in ("min-sine", "min-dihedral", "min-solid-angle", "edge-ratio"):
            lines.append(our_row(f"step {level}, `{measure}`", runs.report(level, measure=measure)))
    return "\n".join(lines)


def stage_table(runs):
    """Cells after each elementary stage of the first step, the paper beside ours."""
    frames = runs.folder / "frames"
    runs.report(1, frames=frames)
    lines = ["| after | the paper | ours |", "|---|--:|--:|"]
    for file in sorted(frames.glob("frame_*.vtu")):
        with file.open(errors="ignore") as text:
            cells = int(re.search(r'NumberOfCells="(\d+)"', text.read(4000)).group(1))
        name = re.sub(r"^frame_\d+_(step_1_)?", "", file.stem)
        stage = next((s for s in STAGES if re.sub(r"\W", "_", s) == name), None)
        if stage:
            lines.append(f"| {stage} | {STAGES[stage]} | {cells:,} |")
    lines.append(f"| all optimisation | 23,480 | {runs.report(1)['cells']:,} |")
    return "\n".join(lines)


# ---- histograms ----

WIDTH, HEIGHT, GAP, LEFT, TOP = 270, 150, 34, 46, 56
COLOURS = {"input": "#999999", "paper mode": "#d55e00", "best mode": "#0072b2"}


def step_line(counts, top):
    """The outline of a histogram in the box of a panel, as SVG path data; shares up to `top`."""
    total = sum(counts)
    path = f"M0,{HEIGHT}"
    for i, count in enumerate(counts):
        y = HEIGHT * (1 - count / total / top)
        path += f"V{y:.1f}H{WIDTH * (i + 1) / len(counts):.1f}"
    return path + f"V{HEIGHT}"


def panel(title, histograms, top):
    """The parts of one panel."""
    out = [f'<text x="0" y="-7" class="t">{title}</text>']
    for degrees in range(0, 73, 12):
        x = WIDTH * degrees / 72
        out.append(f'<line x1="{x:.1f}" y1="0" x2="{x:.1f}" y2="{HEIGHT}" class="g"/>')
        out.append(f'<text x="{x:.1f}" y="{HEIGHT + 14}" class="m">{degrees}</text>')
    for percent in range(0, int(100 * top) + 1, 4):
        y = HEIGHT * (1 - percent / 100 / top)
        out.append(f'<text x="-6" y="{y + 4:.1f}" class="e">{percent} %</text>')
    for name, counts in histograms:
        fill = COLOURS[name] if name == "input" else "none"
        out.append(f'<path d="{step_line(counts, top)}" stroke="{COLOURS[name]}" fill="{fill}" fill-opacity="0.25"/>')
    return out


def histograms(runs, levels):
    """The picture: a row of panels a level, a column an example."""
    start = runs.report(0)["dihedral_counts"]
    columns = [("all cells, approximating", {}), ("all cells, fixed", {"boundary": "fixed"})]
    columns.append((f"{SELECTED} cells, approximating", {"adaptive": True}))
    grid = {}
    for level in levels:
        for title, words in columns:
            lines = [("input", start)]
            for mode in ("paper", "best"):
                lines.append((f"{mode} mode", runs.report(level, mode, **words)["dihedral_counts"]))
            grid[level, title] = lines
    top = max(max(c) / sum(c) for lines in grid.values() for _, c in lines)
    top = 0.04 * math.ceil(top / 0.04)
    across, down = LEFT + WIDTH + GAP // 2, HEIGHT + GAP + 22
    size = (across * len(columns) + GAP, TOP + down * len(levels))
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size[0]} {size[1]}" font-family="sans-serif" font-size="11">',
        "<style>.t{font-size:13px}.m{text-anchor:middle}.e{text-anchor:end}.g{stroke:#ddd;stroke-width:0.6}"
        "path{stroke-width:1.4}</style>",
        f'<rect width="{size[0]}" height="{size[1]}" fill="white"/>',
    ]
    for i, (name, colour) in enumerate(COLOURS.items()):
        x = LEFT + 130 * i
        out.append(f'<rect x="{x}" y="9" width="16" height="10" fill="{colour}"/><text x="{x + 22}" y="18" class="t">{name}</text>')
    caption = "share of the cells by minimum dihedral angle (degrees)"
    out.append(f'<text x="{size[0] - GAP}" y="18" class="t e">{caption}</text>')
    for row, level in enumerate(levels):
        for column, (title, _) in enumerate(columns):
            out.append(f'<g transform="translate({LEFT + across * column},{TOP + down * row})">')
            out += panel(f"step {level}, {title}", grid[level, title], top) + ["</g>"]
    return "\n".join([*out, "</svg>", ""])


def improvers(options, mesh):
    """The comparison with other programs, or what it lacks."""
    rows, missing = meshers.compare(options.subsolid, mesh, options.levels, FEATURE_ANGLE, options.threads, options.repeat)
    text = meshers.table(rows) if rows else ""
    if missing:
        text += f"\n\nNot measured for want of Python wheels: `pip install {' '.join(missing)}`."
    return text.strip()


def page(runs, options, mesh):
    """The text of table-1.md."""
    threads = f"{options.threads} threads" if options.threads > 1 else "one thread"
    return f"""\
# Table 1 of Burkhart, Hamann and Umlauf (2010) beside ours

Written by `python3 docs/table_1.py --data FOLDER`, where FOLDER holds the tripod ([README](../README.md#the-papers-tripod)). The
numbers but for the times are the same wherever it is run. *Angles* are the minimum dihedral angles of the tetrahedra in degrees;
*valence* is the number of tetrahedra at a vertex; feature edges are those above {FEATURE_ANGLE} degrees. *Paper mode*
(`--optimise paper`) has the published operations alone, *best mode* (`--optimise best`) all of them. The paper's boundary is the
approximating one; *fixed* keeps the surface, and halves its edges. *Tets per second*: output tetrahedra over the seconds of all
refinement and optimisation from the input on, with {threads}, on the machine that wrote this page: compare within a table only.

## Example 1: all cells

{uniform_table(runs, options.levels)}

## Example 2: {SELECTED} cells

The paper does not say which cells it chose. Ours are the {SELECTED} nearest to the end of a leg, and in the second step all that
was refined in it; the counts depend on such a choice.

{adaptive_table(runs, options.levels)}

## The elementary steps

Tetrahedra after each stage of the first step, as `subsolid subdivide --frames` writes them for ParaView.

{stage_table(runs)}

## The measures

Section 2.3 of the paper names other measures of a cell beside the minimum sine of its dihedral angles, and section 7 expects lower
valences of solid angles. `--measure` lets each of them drive the published operations, on the approximating boundary; angles
and valences are told alike for all. The edge ratio is blind to flat cells, as the paper says.

{measure_table(runs, options.levels)}

## Notes

{NOTES}
## Histograms

![Histograms of the minimum dihedral angles](figures/table-1.svg)

The pictures of the models are in [figures.md](figures.md).

## Beside other mesh improvers

The same model with its surface kept, all in one run by `benches/peers/meshers.py`. Ours starts from the coarse mesh, the others
from its red refinement. Seconds of ours are those of all refinement and optimisation, with {threads}; of the others, those of
the optimiser's call alone, on their one thread. *Times ours* is the ratio of the seconds. *Processor seconds* are those of all
threads together, ours with reading and writing; they hardly change when the machine is busy.

{improvers(options, mesh)}
"""


def arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("SUBSOLID_DATA"), help="folder with tripod.GiD.msh")
    parser.add_argument("--levels", type=int, nargs="+", default=[1, 2], help="refinement steps")
    parser.add_argument("--threads", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--repeat", type=int, default=1, help="measure so often, and take the least time")
    parser.add_argument("--subsolid", type=Path, default=ROOT / "target/release/subsolid", help="the program")
    parser.add_argument("--out", type=Path, default=ROOT / "docs", help="folder for table-1.md and figures/table-1.svg")
    options = parser.parse_args()
    if not options.data or not (Path(options.data) / "tripod.GiD.msh").is_file():
        parser.error("name the folder that holds tripod.GiD.msh by --data or SUBSOLID_DATA (README.md says where it is from)")
    if not options.subsolid.is_file():
        parser.error(f"{options.subsolid} does not exist: cargo build --release")
    return options


def main():
    """Measures and writes."""
    options = arguments()
    mesh = Path(options.data) / "tripod.GiD.msh"
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(options, mesh, folder)
        text = page(runs, options, mesh)
        picture = histograms(runs, options.levels)
    (options.out / "figures").mkdir(parents=True, exist_ok=True)
    (options.out / "figures/table-1.svg").write_text(picture)
    (options.out / "table-1.md").write_text(text)
    print(options.out / "table-1.md")


if __name__ == "__main__":
    main()
