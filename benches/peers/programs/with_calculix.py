"""CalculiX with four-node elements (C3D4).   with_calculix.py MESH.npz [--folder DIR] [--solver SPOOLES]

It reads, assembles, solves and recovers stresses in one process, whose wall time counts as its solution; its input is
text, which is written before. Its results have seven digits, and the largest displacement is that of the loaded face.
"""

import os
import re
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from task import POISSON, YOUNG, Timer, arguments, largest, load_mesh, load_vector, report

SIDES = ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3))
THREADS = "2"


def write_input(path, points, tets, faces, marks, solver):
    count = len(points)

    def key(triangles):
        a, b, c = np.sort(triangles, axis=1).astype(np.int64).T
        return (a * count + b) * count + c

    loaded = key(faces[marks == 2])
    with open(path, "w") as file:
        file.write("*NODE, NSET=NALL\n")
        np.savetxt(file, np.column_stack([np.arange(1, count + 1), points]), fmt="%d,%.12g,%.12g,%.12g")
        file.write("*ELEMENT, TYPE=C3D4, ELSET=EALL\n")
        np.savetxt(file, np.column_stack([np.arange(1, len(tets) + 1), tets + 1]), fmt="%d", delimiter=",")
        for name, mark in (("FIX", 1), ("TOP", 2)):
            file.write(f"*NSET, NSET={name}\n")
            np.savetxt(file, np.unique(faces[marks == mark]) + 1, fmt="%d,")
        file.write(f"*MATERIAL, NAME=M\n*ELASTIC\n{YOUNG:g},{POISSON:g}\n*SOLID SECTION, ELSET=EALL, MATERIAL=M\n")
        file.write(f"*BOUNDARY\nFIX,1,3\n*STEP\n*STATIC, SOLVER={solver}\n*DLOAD\n")
        # The top is level: pressure is the traction.
        for k, side in enumerate(SIDES):
            cells = np.nonzero(np.isin(key(tets[:, side]), loaded))[0] + 1
            np.savetxt(file, cells, fmt=f"%d,P{k + 1},1.0")
        file.write("*NODE PRINT, NSET=TOP\nU\n*END STEP\n")


def run(folder, args):
    points, tets, faces, marks = load_mesh(args.mesh)
    job = Path(folder) / "job"
    write_input(job.with_suffix(".inp"), points, tets, faces, marks, args.solver)
    names = ("OMP_NUM_THREADS", "CCX_NPROC_EQUATION_SOLVER", "CCX_NPROC_STIFFNESS")
    environment = os.environ | dict.fromkeys(names, THREADS)
    timer = Timer()
    start = time.perf_counter()
    done = subprocess.run(["ccx", "job"], cwd=folder, env=environment, capture_output=True, text=True, check=True)
    timer.seconds["solve"] = time.perf_counter() - start
    moved = {}
    for words in map(str.split, job.with_suffix(".dat").read_text().splitlines()):
        if len(words) == 4 and words[0].isdigit():
            moved[int(words[0]) - 1] = [float(x) for x in words[1:]]
    forces = load_vector(points, faces, marks).reshape(-1, 3)
    version = re.search(r"Version ([\d.]+)", done.stdout)
    report(
        timer,
        version=version.group(1) if version else "",
        iterations=0,
        energy=0.5 * sum(float(forces[i] @ u) for i, u in moved.items()),
        largest=largest(np.array(list(moved.values()))),
    )


args = arguments(__doc__, solver="SPOOLES", folder="")
if args.folder:
    run(args.folder, args)
else:
    with tempfile.TemporaryDirectory() as folder:
        run(folder, args)
