#!/usr/bin/env python3
"""Measures what docs/tet-oct.md tells of analysis on smooth solids and writes its tables.

    python3 docs/tet_oct.py [--subsolid target/release/subsolid]

Needs the program built (cargo build --release). Takes some minutes.
"""

import argparse
import json
import math
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "tet-oct.md"
MESHES = {"cantilever": ["[6, 1, 1]", "[12, 2, 1]", "[24, 4, 2]", "[48, 8, 4]"], "cube": ["[2, 2, 2]", "[4, 4, 4]", "[8, 8, 8]", "[16, 16, 16]"]}
# One finer for plain four-node cells, so that there is something to compare with.
FINEST = {"cantilever": "[96, 16, 8]", "cube": "[32, 32, 32]"}
KINDS = [("tet4", None), ("control", 1), ("control", 2), ("control", 3), ("nodes", 1)]
PLAIN = ["analysis.element=\"tet4\"", "refine={ strategy = \"none\" }", "adapt={}"]
SCENARIO = {"cantilever": "cantilever", "cube": "verification/cube-tet4-1"}


def steps(program, scenario, settings):
    with tempfile.TemporaryDirectory() as folder:
        line = [program, "run", ROOT / "scenarios" / f"{SCENARIO[scenario]}.toml", "--output", folder, "--json", "-", "--quiet"]
        for setting in [*settings, "output.vtk=false", "expect={}"]:
            line += ["--set", setting]
        text = subprocess.run(line, check=True, capture_output=True, text=True).stdout
    return json.loads(text)["steps"]


def table(heads, rows):
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def settings(kind, k, cells):
    smooth = [] if k is None else [f"analysis.smooth={{ steps = {k}, basis = \"{kind}\" }}"]
    return [*PLAIN, f"mesh.box.cells={cells}", *smooth]


def unknowns_for(points, error):
    """Unknowns at which a curve of (unknowns, error) has that error, between its points on a log-log scale."""
    for (n, e), (m, f) in zip(points, points[1:]):
        if f <= error <= e:
            share = math.log(e / error) / math.log(e / f)
            return math.exp(math.log(n) + share * math.log(m / n))
    return None


def measure(program, scenario, error_of):
    curves = {}
    for kind, k in KINDS:
        for cells in MESHES[scenario] + ([FINEST[scenario]] if k is None else []):
            is_large = k == 3 or kind == "nodes" or (k == 2 and scenario == "cube")
            if is_large and cells == MESHES[scenario][-1]:
                continue
            step = steps(program, scenario, settings(kind, k, cells))[-1]
            error, seconds = error_of(step), step["seconds"]["total"]
            found = step["free_dofs"], error, step["solver"]["nonzeros"], seconds, step["error"]["relative"] / error
            curves.setdefault((kind, k), []).append((cells, *found))
            print(scenario, kind, k, cells, *found, flush=True)
    plain = [(n, e) for _, n, e, *_ in curves["tet4", None]]
    rows = []
    for (kind, k), points in curves.items():
        name = "tet4" if k is None else f"{kind}, k = {k}"
        before = None
        for cells, n, e, nonzeros, seconds, estimated in points:
            order = "" if before is None else f"{-3 * math.log(e / before[1]) / math.log(n / before[0]):.2f}"
            wanted = unknowns_for(plain, e) if k is not None else None
            ratio = "" if wanted is None else f"{wanted / n:.1f}"
            rows.append([name, cells, f"{n:,}", f"{100 * e:.2f}", order, ratio, f"{nonzeros:,}", f"{seconds:.2f}", f"{estimated:.2f}"])
            before = n, e
    heads = ["unknowns are", "bricks", "unknowns", "error in energy, %", "order", "tet4 needs, times", "numbers stored", "seconds", "estimated / true error"]
    return table(heads, rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--subsolid", type=Path, default=ROOT / "target" / "release" / "subsolid")
    program = parser.parse_args().subsolid
    fine = ["analysis.element=\"tet10\"", "refine.steps=12", "refine.stop={ relative_error = 0.004, max_cells = 150000 }"]
    last = steps(program, "cantilever", fine)[-1]
    energy = last["strain_energy"]
    # The error of a lower bound: what the estimate says is missing is added.
    energy += 0.5 * last["error"]["energy"] ** 2
    print("reference", energy, last["error"]["relative"], flush=True)
    tables = [
        measure(program, "cantilever", lambda step: math.sqrt(max(1 - step["strain_energy"] / energy, 0))),
        measure(program, "cube", lambda step: step["error"]["true_relative"]),
    ]
    parts = PAGE.read_text().split("<!-- table -->")
    assert len(parts) == 2 * len(tables) + 1
    for i, text in enumerate(tables):
        parts[2 * i + 1] = f"\n{text}\n"
    PAGE.write_text("<!-- table -->".join(parts))


main()
