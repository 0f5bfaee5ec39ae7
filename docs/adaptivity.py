#!/usr/bin/env python3
"""Writes docs/adaptivity.md: the true error at equal degrees of freedom, and the time to an error, of every scheme and optimiser.

    cargo build --release && python3 docs/adaptivity.py --data FOLDER

FOLDER holds `tripod.GiD.msh` (see README.md); without `--data` it is the one named by SUBSOLID_DATA. Needs nothing but
Python, and some ten minutes. Times are those of the machine it runs on.
"""

import argparse
import json
import math
import os
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

PRISM = """[mesh.l-prism]
cells = 2
[materials.a]
youngs_modulus = 1.0
poissons_ratio = 0.3
[exact]
solution = "l-prism"
[supports.outer]
any = [{ group = "x-min" }, { group = "x-max" }, { group = "y-min" }, { group = "y-max" }]
fix = "exact"
[supports.z]
any = [{ group = "z-min" }, { group = "z-max" }]
fix = ["z"]
"""

FICHERA = """[mesh.fichera]
cells = 2
[materials.a]
youngs_modulus = 1000.0
poissons_ratio = 0.3
[supports.foot]
group = "z-min"
fix = ["x", "y", "z"]
[loads.shear]
group = "z-max"
traction = [0.0, -1.0, 0.0]
"""

TRIPOD = """[mesh]
file = "tripod.GiD.msh"
[features]
angle = 70
[materials.a]
youngs_modulus = 1000.0
poissons_ratio = 0.3
[supports.feet]
plane = { normal = [0.0, 1.0, 0.0], offset = -10.0, tolerance = 1e-5 }
fix = ["x", "y", "z"]
[loads.top]
plane = { normal = [0.0, 1.0, 0.0], offset = 13.0 }
traction = [0.0, -1.0, 0.0]
"""

# Name, scenario, reference energy (none: the solution is known), element, degrees of freedom, and the error of which times are told.
CASES = [
    ("L-prism P1 24k", PRISM, None, "tet4", 24e3, 8.0),
    ("L-prism P2 30k", PRISM, None, "tet10", 30e3, 3.5),
    ("Fichera P1 24k", FICHERA, 0.020793, "tet4", 24e3, 13.0),
    ("Fichera P2 45k", FICHERA, 0.020793, "tet10", 45e3, 5.0),
    ("tripod P1 40k", TRIPOD, 8.3204, "tet4", 40e3, 20.0),
    ("tripod P2 80k", TRIPOD, 8.3204, "tet10", 80e3, 6.0),
]

NONE, QUALITY = "mode = \"paper\"", "objective = \"quality\""
PLAIN, DIRECTED = "directions = false", "directions = true"

ROWS = [
    ("red, all cells", "red", NONE),
    ("red, all cells, error", "red", DIRECTED),
    ("bisection", "longest-edge", NONE),
    ("bisection, quality", "longest-edge", QUALITY),
    ("bisection, error without directions", "longest-edge", PLAIN),
    ("**bisection, error**", "longest-edge", DIRECTED),
    ("sqrt(3), the paper's operations", "sqrt3", NONE),
    ("sqrt(3), quality", "sqrt3", QUALITY),
    ("sqrt(3), error without directions", "sqrt3", PLAIN),
    ("**sqrt(3), error** (default)", "sqrt3", DIRECTED),
]

# NGSolve 6.2.2608 on the same problems with the same marking (averaging estimator), by its own bisection.
PEERS = [
    ("NGSolve's bisection", "8.58 / 4.32 / 14.3 / 5.37 / 23.1 / 6.61"),
    ("NGSolve's bisection, `onlyonce`", "8.15 / 3.62 / 13.6 / 4.38 / 22.3 / 6.02"),
]


def run(program, data, case, scheme, optimise):
    """The steps of a run: degrees of freedom, true relative error in percent, seconds of computing so far."""
    _, text, energy, element, dofs, _ = case
    # Degrees of freedom a cell, about: the run ends by a mesh beyond those asked for.
    cells = 1.05 * dofs / (0.6 if element == "tet4" else 4.4)
    refine = f'scheme = "{scheme}"\nsteps = 20\noptimise = {{ {optimise} }}\nstop.max_cells = {round(cells)}'
    text += f'[analysis]\nelement = "{element}"\n[refine]\n{refine}\n[output]\nvtk = false\nreport = false\n'
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "case.toml").write_text(text)
        command = [program, "run", "case.toml", "--quiet", "--json", "-"]
        environment = dict(os.environ, SUBSOLID_DATA=str(data))
        report = json.loads(subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True).stdout)
    steps, seconds = [], 0.0
    for step in report["steps"]:
        seconds += step["seconds"]["total"] - step["seconds"]["write"]
        error = step["error"]["true_relative"] if energy is None else math.sqrt(1 - step["strain_energy"] / energy)
        steps.append((step["dofs"], 100 * error, seconds))
    return steps


def between(steps, column, value, other):
    """What is in column `other` where `column` has `value`, by logarithms between two steps; None beyond the run."""
    for a, b in zip(steps, steps[1:]):
        if min(a[column], b[column]) <= value <= max(a[column], b[column]):
            part = math.log(value / a[column]) / math.log(b[column] / a[column])
            return math.exp((1 - part) * math.log(a[other]) + part * math.log(b[other]))
    return None


# Over fewer steps one lucky one can make a slope steeper than theory allows.
FEWEST = 4


def slope(steps, least):
    """Slope of the error in the degrees of freedom from `least` of these on, by least squares of the logarithms, and over how
    many steps."""
    points = [(math.log(s[0]), math.log(s[1])) for s in steps if s[0] >= least]
    if len(points) < FEWEST:
        return "too few"
    x, y = (sum(p[i] for p in points) / len(points) for i in (0, 1))
    squares = sum((p[0] - x) ** 2 for p in points)
    return f"{sum((p[0] - x) * (p[1] - y) for p in points) / squares:.2f} ({len(points)})"


def table(head, rows):
    lines = ["| | " + " | ".join(head) + " |", "|---|" + "---|" * len(head)]
    return "\n".join(lines + [f"| {name} | " + " | ".join(cells) + " |" for name, cells in rows])


def measure(program, data):
    """The three tables: errors, slopes, seconds."""
    errors, slopes, seconds = [], [], []
    for name, scheme, optimise in ROWS:
        runs = [(case, run(program, data, case, scheme, optimise)) for case in CASES]
        number = lambda x, form: "-" if x is None else format(x, form)
        errors.append((name, [number(between(s, 0, case[4], 1), ".3g") for case, s in runs]))
        slopes.append((name, [slope(s, case[4] / 8) for case, s in runs]))
        seconds.append((name, [number(between(s, 1, case[5], 2), ".2g") for case, s in runs]))
        print(name, errors[-1][1], slopes[-1][1], seconds[-1][1], flush=True)
    errors[2:2] = [(name, row.split(" / ")) for name, row in PEERS]
    heads = [case[0] for case in CASES]
    to = [f"{case[0].rsplit(' ', 1)[0]}, {case[5]:g} %" for case in CASES]
    return table(heads, errors), table(heads, slopes), table(to, seconds)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=os.environ.get("SUBSOLID_DATA"), help="folder with tripod.GiD.msh")
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/subsolid")
    options = parser.parse_args()
    if not options.data or not (Path(options.data) / "tripod.GiD.msh").is_file():
        parser.error("no tripod.GiD.msh by --data or SUBSOLID_DATA")
    tables = measure(options.program.resolve(), Path(options.data).resolve())
    page = ROOT / "docs/adaptivity.md"
    parts = page.read_text().split("<!-- table -->")
    for i, text in enumerate(tables):
        parts[2 * i + 1] = f"\n{text}\n"
    page.write_text("<!-- table -->".join(parts))


if __name__ == "__main__":
    main()
