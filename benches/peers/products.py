#!/usr/bin/env python3
"""What a solution costs in products with the stiffness matrix, on the tripod at L3: runs `cargo bench --bench products`.

    python3 benches/peers/products.py --data DIR [--level 3] [--repeat 5]

DIR holds tripod.GiD.msh. On one thread and on two; writes the table into docs/performance.md, between its markers, or prints it.
"""

import argparse
import subprocess
import tempfile
from pathlib import Path

import ours
from solve import ROOT, processor_name, publish

MARKS = ("<!-- products: begin -->", "<!-- products: end -->")


def measured(mesh, threads, repeat):
    """Names and figures that the benchmark prints."""
    command = ["cargo", "bench", "--bench", "products", "--", "--mesh", mesh, "--threads", threads, "--repeat", repeat]
    out = subprocess.run([str(word) for word in command], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    rows = [line for line in out.splitlines() if line[36:].strip() and line[36:].split()[1] in ("ms", "GB/s")]
    return {row[:36].strip(): row[36:].split() for row in rows}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of tripod.GiD.msh")
    parser.add_argument("--work", type=Path, default=Path(tempfile.gettempdir()) / "subsolid-peers")
    parser.add_argument("--level", type=int, default=3)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--print", action="store_true", help="print the table instead of writing it")
    args = parser.parse_args()
    ours.make_meshes("tripod", args.work, [args.level], args.data, most_text=-1)
    mesh = args.work / f"tripod_L{args.level}.msh"
    one, two = (measured(mesh, threads, args.repeat) for threads in (1, 2))
    lines = ["| | 1 thread | products | 2 threads | products |", "|---|---|---|---|---|"]
    for name in one:
        cells = [f"{' '.join(found[name][:2])} | {''.join(found[name][2:3])}" for found in (one, two)]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    text = "\n".join([f"L{args.level}, {processor_name()}, best of {args.repeat}:", "", *lines, ""])
    publish(args, MARKS, text)


if __name__ == "__main__":
    main()
