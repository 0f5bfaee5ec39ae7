#!/usr/bin/env python3
"""Seconds to an accuracy: NGSolve's adaptive loops beside `subsolid run`, from the same coarse meshes.

    python3 benches/peers/adaptive.py --data DIR [--subsolid target/release/subsolid] [--repeat 3] [--set KEY=VALUE]

On the tripod (DIR holds tripod.GiD.msh; its surface stays as it is) and on the Fichera corner; linear and quadratic elements.
Accuracy is that of the energy: the error is sqrt((E_ref - E) / E_ref). For each error asked, the seconds at the end of the
first step that reaches the energy, estimate included: NGSolve's from the mesh in memory, ours of the whole process. Subsolid
runs once for each error asked, with `refine.stop.relative_error` that much, or a little less where the energy is not reached
then, since estimates may be low; else with the defaults of scenarios, and whatever `--set` says. Writes the medians as a table into
docs/performance.md, between its markers; `--print` prints it instead.
"""

import argparse
import json
import statistics
import sys
import tempfile
from pathlib import Path

import ours
from solve import HERE, ROOT, Peer, processor_name, publish, python_for

MARKS = ("<!-- adaptive.py: begin -->", "<!-- adaptive.py: end -->")

# Errors asked, in percent, and their energies. The tripod's reference is 8.3204 +- 0.0015, Fichera's 0.020793 +- 0.000004,
# both from fits to adaptive quadratic elements up to a million unknowns.
GOALS = {
    "tripod": {20: 7.9876, 10: 8.2372, 5: 8.2996},
    "fichera": {10: 0.020585, 5: 0.020741},
}
# Parts of the error asked that our loop is told to reach, until its energy is: found in the first round.
PARTS = (1.0, 0.95, 0.9, 0.85, 0.8, 0.7)

# The smallest error, in percent, that linear elements are asked for.
LEAST_LINEAR = {"tripod": 20, "fichera": 10}


def goals(problem, order):
    return {p: e for p, e in GOALS[problem].items() if order == 2 or p >= LEAST_LINEAR[problem]}


def reached(steps, energies):
    """Seconds, degrees of freedom and number of the first step that reaches each energy; None where none does."""
    first = {}
    for percent, energy in energies.items():
        found = (s for s in steps if s["energy"] >= energy)
        first[percent] = next(found, None)
    return first


def of_ngsolve(python, args, problem, order):
    mesh = args.work / f"{problem}_L0.npz"
    goal = max(goals(problem, order).values())
    script = HERE / "programs" / "adaptive_ngsolve.py"
    options = ["--order", order, "--goal", goal, "--most-seconds", args.most_seconds]
    out, *_ = ours.measured([python, script, mesh, *options])
    return [json.loads(line) for line in out.splitlines() if line.startswith("{")]


def of_subsolid(args, problem, order, percent, parts):
    """Steps with the seconds since the process began, what is outside of the loop counted at its beginning. `parts` are what to
    tell of the error asked, and are left with the first that suffices."""
    while True:
        steps = told(args, problem, order, parts[0] * percent / 100)
        if len(parts) == 1 or steps[-1]["energy"] >= GOALS[problem][percent]:
            del parts[1:]
            return steps
        del parts[0]


def told(args, problem, order, error):
    tables = (
        f'[analysis]\nelement = "{"tet4" if order == 1 else "tet10"}"\n\n'
        f"[refine]\n\n[refine.stop]\nrelative_error = {error}\nseconds = {args.most_seconds}\n"
    )
    report, process = ours.run(args.subsolid, args.work / f"{problem}_L0.msh", tables, args.set)
    seconds, steps = process["process"] - report["seconds_total"], []
    for step in report["steps"]:
        seconds += step["seconds"]["total"]
        figures = {key: step[key] for key in ("step", "cells", "dofs")}
        steps.append({**figures, "seconds": seconds, "energy": step["strain_energy"], "told": error})
    return steps


def say(number, problem, order, name, steps):
    told = ", ".join(f"{s['dofs']} dofs {s['energy']:.6g} {s['seconds']:.2f} s" for s in steps)
    print(f"round {number + 1} {problem} order {order} {name}: {told}", file=sys.stderr, flush=True)


def table(found):
    """Medians of the rounds as Markdown: found[problem, order] is two lists of first steps."""
    lines = [
        "| problem | elements | error asked | NGSolve: s | dofs | steps | ours: s | dofs | steps | told | ours / NGSolve |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for (problem, order), (theirs, own) in found.items():
        for percent in goals(problem, order):
            cells, times = [], []
            for runs in (theirs, own):
                steps = [run[percent] for run in runs]
                if not steps or any(s is None for s in steps):
                    cells.append("not reached | | " if steps else "not run | | ")
                    times.append(None)
                    continue
                times.append(statistics.median(s["seconds"] for s in steps))
                cells.append(f"{times[-1]:.2f} | {steps[0]['dofs']:,} | {steps[0]['step']}")
            ratio = f"{times[1] / times[0]:.2f}" if all(times) else ""
            told = own[0][percent]
            cells.append(f"{told['told']:.3g}" if told else "")
            kind = "linear" if order == 1 else "quadratic"
            lines.append(f"| {problem} | {kind} | {percent} % | {' | '.join(cells)} | {ratio} |")
    return "\n".join([*lines, ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of tripod.GiD.msh")
    parser.add_argument("--subsolid", type=Path, default=ROOT / "target" / "release" / "subsolid")
    parser.add_argument("--work", type=Path, default=Path(tempfile.gettempdir()) / "subsolid-peers")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--problems", nargs="+", default=list(GOALS), choices=list(GOALS))
    parser.add_argument("--orders", nargs="+", type=int, default=[1, 2], choices=[1, 2])
    parser.add_argument("--set", action="append", default=[], help="a key of our scenario, as of `subsolid run`")
    parser.add_argument("--most-seconds", type=float, default=120.0)
    parser.add_argument("--python", nargs="+", default=[sys.executable, "/usr/bin/python3"])
    parser.add_argument("--ours-only", action="store_true")
    parser.add_argument("--print", action="store_true", help="print the table instead of writing it")
    args = parser.parse_args()
    ours.make_meshes("tripod", args.work, [0], args.data)
    ours.make_meshes("fichera", args.work, [0])
    python, missing = python_for(Peer("NGSolve", "", "", needs=("ngsolve",)), args.python)
    if python is None:
        print(f"SKIPPED NGSolve: {missing}", file=sys.stderr)
    found = {(problem, order): ([], []) for problem in args.problems for order in args.orders}
    parts = {}
    for number in range(args.repeat):
        for (problem, order), (theirs, own) in found.items():
            if python and not args.ours_only:
                steps = of_ngsolve(python, args, problem, order)
                theirs.append(reached(steps, goals(problem, order)))
                say(number, problem, order, "NGSolve", steps)
            own.append({})
            for percent, energy in goals(problem, order).items():
                kept = parts.setdefault((problem, order, percent), list(PARTS))
                steps = of_subsolid(args, problem, order, percent, kept)
                own[-1] |= reached(steps, {percent: energy})
                say(number, problem, order, f"Subsolid, {percent} % ({steps[0]['told']:.3g} told)", steps)
    head = f"{processor_name()}, {args.repeat} rounds, medians.\n"
    if args.set:
        head += f"Ours with `{' '.join(args.set)}`.\n"
    text = f"{head}\n{table(found)}"
    publish(args, MARKS, text)


if __name__ == "__main__":
    main()
