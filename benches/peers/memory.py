#!/usr/bin/env python3
"""The peak memory of `subsolid run` beside what `subsolid check` forecasts, for solvers, elements, shapes and refinement.

    python3 benches/peers/memory.py --data DIR [--subsolid target/release/subsolid] [--levels 0 1 2 3] [--large]

DIR holds tripod.GiD.msh. "Peak" is what a run's report tells; "resident" is what the system tells of the process at its end, which is
never less than this script itself takes. `--large` adds the solution on a box of about five million cells, within 6 GB.
Exit code 1 if a forecast is off by more than 20 %.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

import ours
from solve import ROOT

OFF = 0.2
BOX = """
[mesh.box]
size = {size}
cells = {cells}

[materials.part]
youngs_modulus = 1000.0
poissons_ratio = 0.3

[supports.foot]
group = "z-min"
fix = ["x", "y", "z"]

[loads.top]
group = "z-max"
traction = [0.0, -1.0, 0.0]
{tables}
[output]
vtk = false
"""
ADAPTIVE = '[refine]\nsteps = 4\n'
GLOBAL = '[refine]\nstrategy = "global"\nsteps = {steps}\n'
RED = '[refine]\nscheme = "red"\nsteps = {steps}\n'
BISECTED = '[refine]\nscheme = "longest-edge"\nsteps = 6\n'


def tasks(args):
    """Names, scenarios."""
    for level in args.levels:
        mesh = args.work / f"tripod_L{level}.msh"
        for element, method, most in (("tet4", "auto", 4), ("tet10", "auto", 2), ("tet4", "direct", 2), ("tet10", "direct", 1)):
            if level <= most:
                tables = f'[analysis]\nelement = "{element}"\n\n[solver]\nmethod = "{method}"\n\n{ours.ONE_STEP}'
                yield f"tripod L{level}, {element}, {method}", ours.SCENARIO.format(mesh=mesh, tables=tables)
    mesh = args.work / "tripod_L0.msh"
    for element in ("tet4", "tet10"):
        head = f'[analysis]\nelement = "{element}"\n\n'
        ways = {"adaptive": ADAPTIVE, "global": GLOBAL.format(steps=2), "red": RED.format(steps=2), "bisected": BISECTED}
        for name, refine in ways.items():
            yield f"tripod, {element}, {name}", ours.SCENARIO.format(mesh=mesh, tables=head + refine)
        for name, size, cells in (("cube", [1, 1, 1], [24] * 3), ("plate", [8, 8, 0.25], [64, 64, 2]), ("beam", [1, 1, 64], [4, 4, 256])):
            yield f"{name}, {element}", BOX.format(size=[float(x) for x in size], cells=cells, tables=head + ours.ONE_STEP)
    if args.large:
        # 5,036,520 cells.
        yield "large cube, tet4", BOX.format(size=[1.0] * 3, cells=[94, 94, 95], tables=f'[analysis]\nelement = "tet4"\n\n{ours.ONE_STEP}')


def compared(program, text):
    """Forecast, peak and resident bytes, and the last step's record."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = Path(folder) / "scenario.toml"
        scenario.write_text(text)
        out, *_ = ours.measured([program, "check", scenario, "--quiet", "--json", "-"])
        steps = json.loads(out)["forecast"]["steps"]
        command = [program, "run", scenario, "--quiet", "--threads", 2, "--output", Path(folder) / "out"]
        _, wall, _, megabytes = ours.measured(command)
        report = json.loads((Path(folder) / "out" / "report.json").read_text())
    forecast = max(step["bytes"] for step in steps)
    return forecast, report["peak_memory_bytes"], megabytes * 2**20, report["steps"][-1], wall


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of tripod.GiD.msh")
    parser.add_argument("--subsolid", type=Path, default=ROOT / "target" / "release" / "subsolid")
    parser.add_argument("--work", type=Path, default=Path(tempfile.gettempdir()) / "subsolid-peers")
    parser.add_argument("--levels", type=int, nargs="+", default=[0, 1, 2, 3])
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--only", nargs="+", default=[], help="words of the names of cases")
    args = parser.parse_args()
    ours.make_meshes("tripod", args.work, sorted({0, *args.levels}), args.data, most_text=-1)
    print("| case | cells | nodes | edges | forecast MB | peak MB | resident MB | forecast / peak | s |\n" + "|---" * 9 + "|")
    off = []
    for name, text in tasks(args):
        if args.only and not any(word in name for word in args.only):
            continue
        forecast, peak, resident, step, wall = compared(args.subsolid, text)
        sizes = f"{step['cells']:,} | {step['nodes']:,} | {step['edges']:,}"
        numbers = " | ".join(f"{x / 1e6:.0f}" for x in (forecast, peak, resident))
        print(f"| {name} | {sizes} | {numbers} | {forecast / peak:.2f} | {wall:.1f} |", flush=True)
        if abs(forecast / peak - 1) > OFF:
            off.append(name)
    for name in off:
        print(f"OFF by more than {OFF:.0%}: {name}", file=sys.stderr)
    sys.exit(bool(off))


if __name__ == "__main__":
    main()
