#!/usr/bin/env python3
"""Linear elasticity on the tripod's levels: Subsolid and every other program that is installed, one after another.

    python3 benches/peers/solve.py --data DIR [--subsolid target/release/subsolid] [--levels 0 1 2 3] [--repeat 3]

DIR holds tripod.GiD.msh. Makes the meshes in `--work` (kept there for the next time), runs the programs in turn, as many
rounds as `--repeat` says, and writes the medians as tables into docs/performance.md, between its markers; `--print` prints
them instead. `--only` takes words, and runs the programs whose name holds one. A program that is not installed is skipped
aloud; one that takes longer than `--slow` seconds runs once. Programs run with the first of `--python` that has their
modules. Also checks the energies and displacements of Subsolid with `solver.tolerance = 1e-11` against all digits known:
exit code 1 if one differs by more than 1e-8, or another program's energy by more than its own residual explains.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import ours

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PAGE = ROOT / "docs" / "performance.md"
MARKS = ("<!-- solve.py: begin -->", "<!-- solve.py: end -->")

# Strain energy and largest displacement on four-node cells: CHOLMOD, PARDISO and MUMPS agree on all digits.
KNOWN = {
    0: (6.3823301878, 0.126521862),
    1: (7.5627413988, 0.149441123),
    2: (8.0724806961, 0.159452217),
    3: (8.2430119812, 0.162860759),
}
QUADRATIC = {0: 8.199222821864, 1: 8.2835275110, 2: 8.3064921969}
SIZES = {0: (2799, 2901), 1: (22392, 16764), 2: (179136, 110964), 3: (1433088, 800376), 4: (11464704, 6072120)}

ONE_THREAD = {"OMP_NUM_THREADS": "1"}
TWO_RANKS = ["mpirun", "--allow-run-as-root", "--bind-to", "none", "-n", "2"]


class Peer:
    """A program: its script and options, the module or command it needs, and the highest level it is asked for."""

    def __init__(self, name, script, suffix, options=(), needs=(), most=3, environment=None, launch=(), own_meshes=False):
        self.name, self.script, self.suffix, self.options = name, script, suffix, list(options)
        self.needs, self.most, self.environment, self.launch = needs, most, environment or {}, list(launch)
        self.own_meshes = own_meshes

    def command(self, python, folder, level):
        start, options = level, self.options
        if self.own_meshes:
            start, options = 0, [*options, "--refine", str(level)]
        mesh = folder / f"tripod_L{start}{self.suffix}"
        return [*self.launch, python, HERE / "programs" / self.script, mesh, *options]


DOLFINX = ("dolfinx", "petsc4py", "mpi4py", "numpy")
PEERS = [
    Peer("NGSolve, Cholesky", "with_ngsolve.py", ".npz", needs=("ngsolve",), most=2),
    Peer("NGSolve, PARDISO", "with_ngsolve.py", ".npz", ["--solver", "pardiso"], ("ngsolve", "pypardiso"), 2),
    Peer("NGSolve, geometric multigrid (a)", "with_ngsolve.py", ".npz", ["--solver", "mg"], ("ngsolve",), own_meshes=True),
    Peer("DOLFINx, MUMPS", "with_dolfinx.py", ".npz", ["--solver", "mumps"], DOLFINX, 2, ONE_THREAD),
    Peer("DOLFINx, GAMG", "with_dolfinx.py", ".npz", ["--solver", "gamg"], DOLFINX, 3, ONE_THREAD),
    Peer("DOLFINx, MUMPS, 2 ranks", "with_dolfinx.py", ".npz", ["--solver", "mumps"], DOLFINX, 2, ONE_THREAD, TWO_RANKS),
    Peer("DOLFINx, GAMG, 2 ranks", "with_dolfinx.py", ".npz", ["--solver", "gamg"], DOLFINX, 3, ONE_THREAD, TWO_RANKS),
    Peer("scikit-fem, pyamg", "with_skfem.py", ".npz", ["--solver", "pyamg"], ("skfem", "pyamg"), 3, ONE_THREAD),
    Peer("scikit-fem, CHOLMOD", "with_skfem.py", ".npz", ["--solver", "cholmod"], ("skfem", "sksparse"), 2),
    Peer("SciPy, PARDISO", "with_scipy.py", ".npz", ["--solver", "pardiso"], ("scipy", "pypardiso"), 2),
    Peer("MFEM, Gauss-Seidel", "with_mfem.py", "_22.msh", needs=("mfem",), most=2),
    Peer("GetFEM, MUMPS", "with_getfem.py", "_22.msh", needs=("getfem",), most=2),
    Peer("CalculiX, SPOOLES (b)", "with_calculix.py", ".npz", needs=("numpy", "!ccx"), most=2),
    Peer("FreeFEM (b)", "with_freefem.py", ".mesh", needs=("!FreeFem++",), most=2),
]


def python_for(peer, pythons):
    """The first interpreter that has all a program needs, or what is missing."""
    for command in (need[1:] for need in peer.needs if need[0] == "!"):
        if not any((Path(folder) / command).exists() for folder in os.environ["PATH"].split(":")):
            return None, f"no command {command}"
    if peer.launch and not any((Path(folder) / peer.launch[0]).exists() for folder in os.environ["PATH"].split(":")):
        return None, f"no command {peer.launch[0]}"
    modules = [need for need in peer.needs if need[0] != "!"]
    code = "import importlib.util as u, sys; sys.exit(any(u.find_spec(m) is None for m in sys.argv[1:]))"
    for python in pythons:
        try:
            if subprocess.run([python, "-c", code, *modules], capture_output=True).returncode == 0:
                return python, None
        except FileNotFoundError:
            continue
    return None, f"no Python with {' and '.join(modules)}"


def of_peer(peer, python, folder, level, timeout):
    """The figures of one run of another program."""
    out, wall, _, megabytes = ours.measured(peer.command(python, folder, level), peer.environment, timeout)
    found = json.loads([line for line in out.splitlines() if line.startswith("{")][-1])
    seconds = found["seconds"]
    return {
        **{stage: seconds.get(stage) for stage in ("load", "assemble", "solve")},
        "total": sum(seconds.values()),
        "process": wall,
        "megabytes": max(megabytes, found["megabytes"]),
        "energy": found["energy"],
        "largest": found["largest"],
        "iterations": found["iterations"],
    }


def of_ours(program, folder, level, element="tet4", tolerance=None):
    """The figures of one run of Subsolid. What is neither assembly nor solution counts as loading; the total is that of
    its whole process, with the error estimate."""
    solver = f"tolerance = {tolerance}\n" if tolerance else ""
    tables = f'[analysis]\nelement = "{element}"\n\n[solver]\n{solver}\n{ours.ONE_STEP}'
    report, process = ours.run(program, folder / f"tripod_L{level}.msh", tables)
    step = report["steps"][-1]
    seconds = step["seconds"]
    return {
        "load": process["process"] - seconds["assemble"] - seconds["solve"] - seconds["estimate"],
        "assemble": seconds["assemble"],
        "solve": seconds["solve"],
        "total": process["process"],
        "process": process["process"],
        "megabytes": process["megabytes"],
        "energy": step["strain_energy"],
        "largest": step["max_displacement"],
        "iterations": step["solver"]["iterations"],
    }


def rounds(args, peers):
    """Figures of each program, a list a level: level -> name -> runs."""
    found = {level: {} for level in args.levels}
    for level in args.levels:
        tasks = [("**Subsolid**", lambda level=level: of_ours(args.subsolid, args.work, level))]
        if level in QUADRATIC:
            tasks.append(
                ("**Subsolid, ten-node cells** (c)", lambda level=level: of_ours(args.subsolid, args.work, level, "tet10"))
            )
        for peer, python in peers:
            if level <= peer.most:
                task = lambda peer=peer, python=python, level=level: of_peer(
                    peer, python, args.work, level, args.timeout
                )
                tasks.append((peer.name, task))
        for number in range(args.repeat):
            for name, task in tasks:
                runs = found[level].setdefault(name, [])
                if number and (not runs or runs[0]["process"] > args.slow):
                    continue
                try:
                    runs.append(task())
                    print(f"L{level} round {number + 1} {name}: {shown(runs[-1])}", file=sys.stderr, flush=True)
                except RuntimeError as error:
                    print(f"L{level} {name} FAILED: {error}", file=sys.stderr, flush=True)
    return found


def shown(figures):
    return ", ".join(f"{k} {v:.4g}" for k, v in figures.items() if isinstance(v, float))


def table(level, found):
    """The medians at one level as Markdown, the fastest first."""
    cells, dofs = SIZES[level]
    median = {name: medians(runs) for name, runs in found.items() if runs}
    own = median["**Subsolid**"]["process"] if "**Subsolid**" in median else None
    lines = [
        f"### L{level}: {cells:,} tetrahedra, {dofs:,} degrees of freedom",
        "",
        "| program | load | assemble | solve | total | times ours | process | peak MB | iterations | strain energy | runs |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, m in sorted(median.items(), key=lambda item: item[1]["total"]):
        ratio = f"{m['total'] / own:.1f}" if own else ""
        stages = " | ".join(seconds(m[stage]) for stage in ("load", "assemble", "solve", "total"))
        iterations = m["iterations"] or "direct"
        lines.append(
            f"| {name} | {stages} | {ratio} | {seconds(m['process'])} | {m['megabytes']:.0f} | {iterations} "
            f"| {m['energy']:.10f} | {len(found[name])} |"
        )
    return "\n".join([*lines, ""])


def medians(runs):
    """Of each figure; of times the median, of memory too."""
    keys = runs[0].keys()
    return {k: None if runs[0][k] is None else statistics.median([run[k] for run in runs]) for k in keys}


def seconds(value):
    if value is None:
        return ""
    return f"{value:.3f}" if value < 0.1 else f"{value:.2f}" if value < 10 else f"{value:.1f}"


def wrong_energies(found):
    """What differs from the energies known by more than a solution to a residual of 1e-8 may."""
    faults = []
    for level, programs in found.items():
        for name, runs in programs.items():
            if not runs or "(a)" in name or level not in KNOWN:
                continue
            known = QUADRATIC[level] if "ten-node" in name else KNOWN[level][0]
            # CalculiX writes seven digits.
            allowed = 1e-6 if "(b)" in name else 1e-8
            if abs(runs[0]["energy"] - known) > allowed * known:
                faults.append(f"L{level} {name}: energy {runs[0]['energy']:.12f}, known {known}")
    return faults


def check_digits(args):
    """Energies and displacements at `solver.tolerance = 1e-11` against those known; returns a table and faults."""
    lines = ["| level | strain energy | known | largest displacement | known |", "|---|---|---|---|---|"]
    faults = []
    for level in (level for level in args.levels if level in KNOWN):
        found = of_ours(args.subsolid, args.work, level, tolerance="1e-11")
        energy, largest = KNOWN[level]
        lines.append(f"| L{level} | {found['energy']:.12f} | {energy} | {found['largest']:.11f} | {largest} |")
        if abs(found["energy"] - energy) > 1e-8 or abs(found["largest"] - largest) > 1e-8:
            faults.append(f"L{level}: energy {found['energy']:.12f}, displacement {found['largest']:.12f}")
        if level in QUADRATIC:
            found = of_ours(args.subsolid, args.work, level, "tet10", "1e-11")
            lines.append(f"| L{level}, ten-node cells | {found['energy']:.12f} | {QUADRATIC[level]} | {found['largest']:.11f} | |")
            if abs(found["energy"] - QUADRATIC[level]) > (1e-10 if level == 0 else 1e-8):
                faults.append(f"L{level}, ten-node cells: energy {found['energy']:.14f}")
    return "\n".join([*lines, ""]), faults


def publish(args, marks, text):
    """Puts a text between two lines of the page, or prints it if the command line asks for that."""
    if args.print:
        print(text)
        return
    before, rest = PAGE.read_text().split(marks[0])
    PAGE.write_text(f"{before}{marks[0]}\n\n{text}\n{marks[1]}{rest.split(marks[1])[1]}")


def processor_name():
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":")[1].strip()
    return "an unknown processor"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of tripod.GiD.msh")
    parser.add_argument("--subsolid", type=Path, default=ROOT / "target" / "release" / "subsolid")
    parser.add_argument("--work", type=Path, default=Path(tempfile.gettempdir()) / "subsolid-peers")
    parser.add_argument("--levels", type=int, nargs="+", default=[0, 1, 2, 3])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--only", nargs="+", default=[], help="words of the names of programs")
    parser.add_argument("--python", nargs="+", default=[sys.executable, "/usr/bin/python3"])
    parser.add_argument("--slow", type=float, default=60.0, help="seconds above which a program runs once")
    parser.add_argument("--timeout", type=float, default=600.0)
    parser.add_argument("--print", action="store_true", help="print the tables instead of writing them")
    args = parser.parse_args()
    ours.make_meshes("tripod", args.work, sorted({0, *args.levels}), args.data)
    peers = []
    for peer in PEERS:
        if args.only and not any(word.lower() in peer.name.lower() for word in args.only):
            continue
        python, missing = python_for(peer, args.python)
        if python is None:
            print(f"SKIPPED {peer.name}: {missing}", file=sys.stderr)
            continue
        peers.append((peer, python))
        try:
            # Not counted: forms are compiled at first use, and files read into memory.
            of_peer(peer, python, args.work, 0, args.timeout)
        except RuntimeError as error:
            print(f"SKIPPED {peer.name}: {error}", file=sys.stderr)
            peers.pop()
    digits, faults = check_digits(args)
    found = rounds(args, peers)
    faults += wrong_energies(found)
    head = f"{processor_name()}, {os.cpu_count()} processors, {args.repeat} rounds, medians; seconds.\n"
    text = "\n".join([head, *(table(level, found[level]) for level in args.levels), digits])
    publish(args, MARKS, text)
    for fault in faults:
        print(f"WRONG: {fault}", file=sys.stderr)
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
