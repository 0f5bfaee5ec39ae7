#!/usr/bin/env python3
"""Our sparse Cholesky factorisation beside CHOLMOD's, both ordered by METIS: processor seconds of ordering, factorisation
and solution of the same equations.

    python3 benches/peers/direct.py --data DIR [--subsolid target/release/subsolid] [--levels 1 2] [--repeat 3]

CHOLMOD by scikit-sparse (`programs/with_scipy.py`) on one thread of its BLAS and on two; its assembly is not counted. Ours is the
processor time of `subsolid run` with `solver.method = "direct"` less that of a run with multigrid, whose solution is added
back as the wall time of its report: what both have in common is cancelled. The shortest times, as a table between the markers of
docs/performance.md; `--print` prints it instead. CHOLMOD is slow without an optimised BLAS (`apt install libopenblas0-pthread`).
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

import ours
from solve import HERE, ROOT, Peer, publish, python_for

MARKS = ("<!-- direct.py: begin -->", "<!-- direct.py: end -->")
TABLES = f"""[analysis]
element = "tet4"

[solver]
method = "{{method}}"

{ours.ONE_STEP}"""


def cholmod(python, mesh, threads):
    """Processor and wall seconds of the solution, and the energy."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    environment = dict.fromkeys(names, str(threads))
    out, *_ = ours.measured([python, HERE / "programs" / "with_scipy.py", mesh, "--solver", "cholmod"], environment)
    found = json.loads([line for line in out.splitlines() if line.startswith("{")][-1])
    return found["processor"]["solve"], found["seconds"]["solve"], found["energy"]


def subsolid(program, mesh, method):
    """Wall seconds of the solution on one thread, which are its processor seconds where nothing else runs, those of the
    whole process, and the energy."""
    report, process = ours.run(program, mesh, TABLES.format(method=method), threads=1)
    step = report["steps"][-1]
    return step["seconds"]["solve"], process["processor"], step["strain_energy"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of tripod.GiD.msh")
    parser.add_argument("--subsolid", type=Path, default=ROOT / "target" / "release" / "subsolid")
    parser.add_argument("--work", type=Path, default=Path(tempfile.gettempdir()) / "subsolid-peers")
    parser.add_argument("--levels", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--python", nargs="+", default=[sys.executable, "/usr/bin/python3"])
    parser.add_argument("--print", action="store_true", help="print the table instead of writing it")
    args = parser.parse_args()
    ours.make_meshes("tripod", args.work, args.levels, args.data, most_text=-1)
    python, missing = python_for(Peer("CHOLMOD", "", "", needs=("scipy", "sksparse")), args.python)
    if python is None:
        sys.exit(f"SKIPPED CHOLMOD: {missing}")
    lines = ["| level | ours | CHOLMOD, 1 thread | CHOLMOD, 2 threads | ours / CHOLMOD |", "|---|---|---|---|---|"]
    for level in args.levels:
        stem = args.work / f"tripod_L{level}"
        own, theirs = [], ([], [])
        for _ in range(args.repeat):
            _, direct, energy = subsolid(args.subsolid, f"{stem}.msh", "direct")
            wall, iterative, _ = subsolid(args.subsolid, f"{stem}.msh", "amg-cg")
            own.append(direct - iterative + wall)
            for threads, times in enumerate(theirs, start=1):
                processor, _, other = cholmod(python, f"{stem}.npz", threads)
                times.append(processor)
                if abs(other - energy) > 1e-8 * energy:
                    sys.exit(f"L{level}: energies differ, {energy} and {other}")
        best = min(own), min(theirs[0]), min(theirs[1])
        lines.append(f"| L{level} | {best[0]:.2f} s | {best[1]:.2f} s | {best[2]:.2f} s | {best[0] / best[1]:.2f} |")
    text = "\n".join([*lines, ""])
    publish(args, MARKS, text)


if __name__ == "__main__":
    main()
