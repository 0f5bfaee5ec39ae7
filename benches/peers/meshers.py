#!/usr/bin/env python3
"""Mesh improvers on one model, in one run: ours against red refinement improved by Gmsh's Netgen optimiser and by mmg3d.

    pip install numpy vtk gmsh mmgpy
    cargo build --release
    python3 benches/peers/meshers.py MESH [--levels 1 2] [--feature-angle 70] [--json FILE]

All keep the surface: ours is `subsolid subdivide --boundary fixed --optimise best`; the peers start from our red refinement
of the same mesh, Gmsh with the surface in an entity that it may not touch, mmg3d with `-nosurf -optim`. Angles are the
minimum dihedral angles of the tetrahedra, computed here for all alike.

Seconds: ours are those of all refinement and optimisation, from the coarse mesh, as `subdivide` reports them, with
`--threads 2` unless told otherwise; the peers' are those of the optimiser's call alone, without reading, without red
refinement and without converting meshes. Gmsh and mmg3d use one thread whatever they are given. Processor seconds, of all
threads together, hardly change when the machine is busy; ours are those of the whole process. Wheels that are missing are
named, and the rest is measured.
"""

import argparse
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WHEELS = ("numpy", "vtk", "gmsh", "mmgpy")


def missing_wheels():
    """The wheels that cannot be imported."""
    return [name for name in WHEELS if importlib.util.find_spec(name) is None]


def subdivide(binary, mesh, out, *options, threads=2):
    """Runs `subsolid subdivide`; gives what it reports, with the seconds of the whole process as `process`, and those that
    its processors worked as `processor`."""
    command = [str(binary), "subdivide", str(mesh), "-o", str(out), "--threads", str(threads), "-q", "--json", "-"]
    start, used = time.perf_counter(), children_seconds()
    done = subprocess.run([*command, *map(str, options)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(command)} failed:\n{done.stderr}")
    took = {"process": time.perf_counter() - start, "processor": children_seconds() - used}
    return json.loads(done.stdout) | took


def children_seconds():
    """Processor seconds of all programs run so far."""
    times = os.times()
    return times.children_user + times.children_system


class Timer:
    """Wall and processor seconds of a block."""

    def __enter__(self):
        self.start = time.perf_counter(), time.process_time()
        return self

    def __exit__(self, *_):
        self.seconds = time.perf_counter() - self.start[0]
        self.processor = time.process_time() - self.start[1]


def read_vtu(path):
    """Points (n, 3) and tetrahedra (m, 4) of a file."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
    return vtk_to_numpy(grid.GetPoints().GetData()).copy(), cells.copy()


def min_dihedral_angles(points, tets):
    """The smallest dihedral angle of each tetrahedron, in degrees."""
    import numpy as np

    p = points[tets]
    faces = [(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)]
    normals = [np.cross(p[:, j] - p[:, i], p[:, k] - p[:, i]) for i, j, k in faces]
    least = np.full(len(tets), 180.0)
    for i in range(4):
        for j in range(i):
            a, b = normals[i], normals[j]
            # Between outward normals lies the supplement of the dihedral angle.
            sine = np.linalg.norm(np.cross(a, b), axis=1)
            angle = np.degrees(np.arctan2(sine, -np.einsum("ij,ij->i", a, b)))
            least = np.minimum(least, angle)
    return least


def boundary_faces(tets):
    """The triangles that belong to one tetrahedron only, oriented outwards."""
    import numpy as np

    faces = np.concatenate([tets[:, list(f)] for f in ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[first[count == 1]]


def improve_with_gmsh(points, tets):
    """Gmsh's Netgen optimiser on the volume; points, tetrahedra, what it took."""
    import gmsh
    import numpy as np

    gmsh.initialize(["gmsh", "-v", "1"])
    faces = boundary_faces(tets)
    on_surface = np.unique(faces)
    inside = np.setdiff1d(np.arange(len(points)), on_surface)
    surface, volume = gmsh.model.addDiscreteEntity(2), gmsh.model.addDiscreteEntity(3, -1, [1])
    for entity, nodes in (((2, surface), on_surface), ((3, volume), inside)):
        gmsh.model.mesh.addNodes(*entity, nodes + 1, points[nodes].ravel())
    gmsh.model.mesh.addElementsByType(surface, 2, [], faces.ravel() + 1)
    gmsh.model.mesh.addElementsByType(volume, 4, [], tets.ravel() + 1)
    last = gmsh.model.mesh.getMaxElementTag()
    with Timer() as timer:
        gmsh.model.mesh.optimize("Netgen", force=True)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    place = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    place[tags] = np.arange(len(tags))
    elements, corners = gmsh.model.mesh.getElementsByType(4)
    gmsh.finalize()
    # Of a discrete entity Gmsh keeps the old elements beside the new ones, whose tags are larger.
    new = elements > last
    return coordinates.reshape(-1, 3), place[corners.astype(np.int64)].reshape(-1, 4)[new], timer


def improve_with_mmg(points, tets):
    """mmg3d -nosurf -optim; points, tetrahedra, what it took."""
    import mmgpy
    import numpy as np

    mesh = mmgpy.MmgMesh3D()
    faces = boundary_faces(tets)
    mesh.set_mesh_size(vertices=len(points), tetrahedra=len(tets), triangles=len(faces))
    mesh.set_vertices(np.ascontiguousarray(points))
    mesh.set_tetrahedra(np.ascontiguousarray(tets, dtype=np.int32))
    mesh.set_triangles(np.ascontiguousarray(faces, dtype=np.int32))
    with Timer() as timer:
        mesh.remesh(optim=1, nosurf=1, verbose=-1)
    return mesh.get_vertices(), mesh.get_tetrahedra().astype(np.int64), timer


def volume(points, tets):
    """Volume of the mesh."""
    import numpy as np

    p = points[tets]
    return np.einsum("ij,ij->i", np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), p[:, 3] - p[:, 0]).sum() / 6.0


def row(level, name, points, tets):
    """What the table shows of a mesh; times are added later."""
    angles = min_dihedral_angles(points, tets)
    return {
        "level": level,
        "name": name,
        "tets": len(tets),
        "worst": float(angles.min()),
        "average": float(angles.mean()),
        "volume": float(volume(points, tets)),
        "boundary_faces": len(boundary_faces(tets)),
        "seconds": None,
        "processor": None,
        "note": "",
    }


def at_level(binary, mesh, level, angle, threads, repeat, missing, out):
    """The rows of a level. All improvers run in turn, `repeat` times, so that a machine that is busy meanwhile is so for all."""
    common = ("--steps", level, "--feature-angle", angle)
    subdivide(binary, mesh, out, "--scheme", "red", "--optimise", "paper", *common, threads=threads)
    red = read_vtu(out)
    peers = [("gmsh", "red + Gmsh's Netgen optimiser", improve_with_gmsh)]
    peers += [("mmgpy", "red + mmg3d -nosurf -optim", improve_with_mmg)]
    rows = {}

    def took(name, points, tets, seconds, processor, note=""):
        known = rows.setdefault(name, row(level, name, points, tets))
        known["processor"] = min(processor, known["processor"] or processor)
        if not known["seconds"] or seconds < known["seconds"]:
            known |= {"seconds": seconds, "note": note}

    for _ in range(repeat):
        for wheel, name, improve in peers:
            if wheel not in missing:
                points, tets, timer = improve(*red)
                took(name, points, tets, timer.seconds, timer.processor)
        ours = subdivide(binary, mesh, out, "--boundary", "fixed", "--optimise", "best", *common, threads=threads)
        note = f"whole process {ours['process']:.2f}"
        took("sqrt(3), fixed, best", *read_vtu(out), ours["seconds"], ours["processor"], note)
    return [row(level, "red refinement", *red), *rows.values()]


def compare(binary, mesh, levels, angle, threads=2, repeat=1):
    """The rows of the table, and the wheels that were missing. Times are the least of `repeat` calls."""
    missing = missing_wheels()
    if {"numpy", "vtk"} & set(missing):
        return [], missing
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "mesh.vtu"
        rows = [at_level(binary, mesh, level, angle, threads, repeat, missing, out) for level in levels]
    return sum(rows, []), missing


def table(rows):
    """The rows as Markdown, the seconds also as multiples of ours at their level."""
    lines = [
        "| level | mesh | tets | worst / average angle | seconds | times ours | tets per second | processor seconds |",
        "|---|---|--:|--:|--:|--:|--:|--:|",
    ]
    ours = {r["level"]: r["seconds"] for r in rows if r["name"].startswith("sqrt(3)")}
    for r in rows:
        timed = [""] * 4
        if r["seconds"]:
            timed = [
                f"{r['seconds']:.2f}" + (f" ({r['note']})" if r["note"] else ""),
                f"{r['seconds'] / ours[r['level']]:.1f}",
                f"{r['tets'] / r['seconds']:,.0f}",
                f"{r['processor']:.2f}",
            ]
        cells = [f"{r['level']}", r["name"], f"{r['tets']:,}", f"{r['worst']:.2f} / {r['average']:.2f}", *timed]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main():
    """Measures, prints, writes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", type=Path, help="mesh file, such as tripod.GiD.msh")
    parser.add_argument("--levels", type=int, nargs="+", default=[1, 2], help="refinement steps")
    parser.add_argument("--feature-angle", type=float, default=70)
    parser.add_argument("--threads", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--repeat", type=int, default=1, help="take the least time of so many calls")
    parser.add_argument("--subsolid", type=Path, default=ROOT / "target/release/subsolid")
    parser.add_argument("--json", type=Path, help="write the rows here too")
    options = parser.parse_args()
    rows, missing = compare(options.subsolid, options.mesh, options.levels, options.feature_angle, options.threads, options.repeat)
    if missing:
        print(f"not measured for want of Python wheels: pip install {' '.join(missing)}")
    if rows:
        print(table(rows))
    if options.json:
        options.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
