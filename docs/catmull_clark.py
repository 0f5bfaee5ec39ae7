#!/usr/bin/env python3
"""Measures what docs/catmull-clark.md tells and writes its tables.

    python3 docs/catmull_clark.py [--subsolid target/release/subsolid]

Needs the program built (cargo build --release). Takes some minutes.
"""

import argparse
import json
import math
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "catmull-clark.md"
ELEMENTS = ["hex8", "hex20", "hex27", "catmull-clark", "catmull-clark+"]
WIDENING = {"tube": 143 / 75, "shell": 0.8}
HOOP = {"tube": 5 / 3, "shell": 5 / 7}


def measured(program, command, scenario, *extra):
    with tempfile.TemporaryDirectory() as folder:
        line = [program, command, ROOT / "scenarios" / f"{scenario}.toml", "--output", folder, "--json", "-", "--quiet"]
        text = subprocess.run([*line, *extra], check=True, capture_output=True, text=True).stdout
    return json.loads(text)


def table(heads, rows):
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def bridge(program):
    found = measured(program, "compare", "bridge", "--elements", ",".join(ELEMENTS))["rows"]
    heads = ["element", "cells", "unknowns", "largest displacement", "compliance", "condition", "scaled", "CG", "CG, scaled",
             "numbers in a row"]

    def row(r):
        scale = [f"{r[key]:.1e}" for key in ("condition", "scaled_condition")]
        return [r["element"], str(r["cells"]), f"{r['free_dofs']:,}", f"{r['max_displacement']:.3f}", f"{r['compliance']:.3f}",
                *scale, str(r["iterations"]), str(r["scaled_iterations"]), f"{r['nonzeros'] / r['free_dofs']:.0f}"]

    return table(heads, [row(r) for r in found])


def round_body(program, name, meshes):
    rows = []
    for element in ELEMENTS:
        if element == "hex20":
            continue
        for cells in meshes:
            key = {"tube": "tube", "shell": "sphere-shell"}[name]
            step = measured(program, "run", name, "--set", f"mesh.{key}.cells={cells}", "--set",
                            f"analysis.element=\"{element}\"")["steps"][-1]
            volume = {"tube": math.pi * 3 / 4 * 0.5, "shell": math.pi / 6 * 7}[name]
            off = [step["quantities"][q]["value"] / exact[name] - 1
                   for q, exact in (("widening", WIDENING), ("hoop", HOOP))]
            rows.append([element, str(step["cells"]), f"{step['free_dofs']:,}", f"{100 * off[0]:+.4f}", f"{100 * off[1]:+.2f}",
                         f"{100 * step['error']['true_relative']:.2f}", f"{step['error']['effectivity']:.2f}",
                         f"{100 * (step['volume'] / volume - 1):+.4f}"])
    return table(["element", "cells", "unknowns", "u_r inside, %", "hoop stress inside, %", "energy error, %", "effectivity",
                  "volume, %"], rows)


def twist(program):
    rows = []
    for sides, what in ((3, "six cells"), (5, "ten cells"), (8, "ten edges")):
        for element in ("catmull-clark", "catmull-clark+"):
            steps = measured(program, "run", "twist", "--set", f"mesh.prism.sides={sides}", "--set",
                             f"analysis.element=\"{element}\"")["steps"]
            rows.append([f"{sides} ({what})", element] + [f"{s['strain_energy']:.6f}" for s in steps])
    return table(["quadrangles (at a vertex of the axis)", "element", "energy, step 0", "1", "2"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--subsolid", default=ROOT / "target" / "release" / "subsolid")
    program = parser.parse_args().subsolid
    tables = {
        "bridge": bridge(program),
        "tube": round_body(program, "tube", ["[2, 4, 1]", "[4, 8, 2]", "[8, 16, 4]"]),
        "shell": round_body(program, "shell", ["[2, 2]", "[4, 4]", "[8, 8]"]),
        "twist": twist(program),
    }
    text = PAGE.read_text()
    for name, lines in tables.items():
        begin, end = f"<!-- {name} -->\n", f"\n<!-- end of {name} -->"
        head, rest = text.split(begin)
        text = head + begin + lines + end + rest.split(end)[1]
    PAGE.write_text(text)


if __name__ == "__main__":
    main()
