#!/usr/bin/env python3
"""CalculiX and Subsolid on the same .inp file of the bundled bracket: the same displacement to five digits.

    apt install calculix-ccx                # or another package that brings the command ccx
    cargo build --release
    python3 benches/peers/calculix.py [--folder DIR]
    python3 benches/peers/calculix.py --reference [--levels 2]

Writes `bracket.inp` from `scenarios/bracket.msh`: nodes, C3D4 elements, the nodes of the bolt holes as a set, the faces of
the bearing as a surface, and the load as forces at nodes. A force spread evenly over faces of linear elements gives each
corner a third of its face's share; CalculiX is told just that (`*CLOAD`), since its own face loads are pressures. Then runs
`ccx` and `subsolid run` on this file and compares the strain energy, the largest displacement, and the displacement of the
nodes that move most. Exit code 1 if a figure differs by more than 1e-5.

`--reference` computes what `scenarios/bracket.toml` is pinned to: CalculiX with ten-node tetrahedra (C3D10, straight
edges) on the same polyhedron, whose cells are refined 0, 1, ... times by `subsolid subdivide --scheme red`.
"""

import argparse
import json
import math
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MESH = ROOT / "scenarios" / "bracket.msh"
YOUNG, POISSON = 210_000.0, 0.3
FORCE = (2000.0, 0.0, -6000.0)
HELD, LOADED = "bolt-holes", "bearing"
# Corners of the faces S1 to S4 of a tetrahedron, and the edges of its mid-side nodes, in the order of Abaqus.
SIDES = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
TOLERANCE = 1e-5


def read_msh(path):
    """Nodes by id, tetrahedra, and the triangles of each physical surface, of a Gmsh 4.1 text file."""
    lines = path.read_text().split("\n")
    section = {line: i for i, line in enumerate(lines) if line.startswith("$") and not line.startswith("$End")}
    names = {}
    for line in lines[section["$PhysicalNames"] + 2 :]:
        if line.startswith("$"):
            break
        dim, tag, name = line.split(maxsplit=2)
        names[int(dim), int(tag)] = name.strip('"')
    at = section["$Entities"] + 1
    counts = [int(x) for x in lines[at].split()]
    groups = {}  # (dimension, entity) -> names
    at += 1 + counts[0]
    for dim, count in zip((1, 2, 3), counts[1:]):
        for line in lines[at : at + count]:
            words = line.split()
            tags = [int(x) for x in words[8 : 8 + int(words[7])]]
            groups[dim, int(words[0])] = [names[dim, t] for t in tags]
        at += count
    nodes, at = {}, section["$Nodes"] + 2
    while not lines[at].startswith("$"):
        count = int(lines[at].split()[3])
        ids = [int(x) for x in lines[at + 1 : at + 1 + count]]
        for i, line in zip(ids, lines[at + 1 + count : at + 1 + 2 * count]):
            nodes[i] = tuple(float(x) for x in line.split())
        at += 1 + 2 * count
    tets, triangles, at = [], {}, section["$Elements"] + 2
    while not lines[at].startswith("$"):
        dim, entity, kind, count = (int(x) for x in lines[at].split())
        rows = [tuple(int(x) for x in line.split()[1:]) for line in lines[at + 1 : at + 1 + count]]
        if kind == 4:
            tets += rows
        elif kind == 2:
            for name in groups[dim, entity]:
                triangles.setdefault(name, []).extend(rows)
        at += 1 + count
    return nodes, tets, triangles


def refined(folder, level):
    """The bracket after `level` red refinements, in the same form; groups are found by the planes of faces of the first."""
    if level == 0:
        return read_msh(MESH)
    out = folder / f"red_{level}.vtu"
    command = ["subdivide", MESH, "-o", out, "--scheme", "red", "--steps", level, "--optimise", "paper", "-q"]
    subsolid(*command)
    return read_vtu(out)


def read_vtu(path):
    """The same of a .vtu file of ours, by VTK: groups are in its field data."""
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    points = vtk_to_numpy(grid.GetPoints().GetData())
    nodes = {i + 1: tuple(float(x) for x in p) for i, p in enumerate(points)}
    tets = [tuple(int(v) + 1 for v in t) for t in vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)]
    fields = grid.GetFieldData()
    names = fields.GetAbstractArray("group_names")
    triangles = {}
    for group, *face in vtk_to_numpy(fields.GetArray("group_faces")).tolist():
        triangles.setdefault(names.GetValue(group), []).append(tuple(v + 1 for v in face))
    return nodes, tets, triangles


def with_midsides(nodes, tets):
    """The nodes with one more in the middle of each edge, and ten-node tetrahedra."""
    nodes, middles, quadratic = dict(nodes), {}, []
    first = max(nodes) + 1
    for tet in tets:
        row = list(tet)
        for a, b in EDGES:
            key = (min(tet[a], tet[b]), max(tet[a], tet[b]))
            if key not in middles:
                middles[key] = first + len(middles)
                nodes[middles[key]] = tuple((x + y) / 2 for x, y in zip(nodes[key[0]], nodes[key[1]]))
            row.append(middles[key])
        quadratic.append(tuple(row))
    return nodes, quadratic, middles


def area(nodes, face):
    """Of a triangle."""
    a, b, c = (nodes[v] for v in face)
    u, v = [y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)]
    return 0.5 * math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def shares(nodes, faces, middles):
    """The part of a force, spread evenly over faces, that each node gets."""
    areas = [area(nodes, face) for face in faces]
    total, got = sum(areas), {}
    for face, size in zip(faces, areas):
        # Linear: the corners. Quadratic: the mid-side nodes, the corners get nothing.
        edges = [(min(p), max(p)) for p in ((face[0], face[1]), (face[1], face[2]), (face[2], face[0]))]
        for node in [middles[e] for e in edges] if middles else face:
            got[node] = got.get(node, 0.0) + size / total / 3
    return got


def write_inp(path, nodes, tets, triangles, middles):
    """The whole job; Subsolid reads its mesh, its set and its surface, and passes over the rest."""
    held = {v for face in triangles[HELD] for v in face}
    held |= {m for face in triangles[HELD] for e, m in edges_of(face, middles)}
    surface = {frozenset(face) for face in triangles[LOADED]}
    forces = shares(nodes, triangles[LOADED], middles)
    kind = "C3D10" if middles else "C3D4"
    with open(path, "w") as f:
        f.write("*NODE, NSET=ALL\n")
        # CalculiX takes fields of at most twenty characters.
        f.writelines(f"{i}, {x:.12g}, {y:.12g}, {z:.12g}\n" for i, (x, y, z) in nodes.items())
        f.write(f"*ELEMENT, TYPE={kind}, ELSET=SOLID\n")
        f.writelines(f"{i}, {', '.join(map(str, tet))}\n" for i, tet in enumerate(tets, 1))
        f.write("*NSET, NSET=BOLT-HOLES\n")
        f.writelines(f"{v},\n" for v in sorted(held))
        f.write("*SURFACE, NAME=BEARING, TYPE=ELEMENT\n")
        for i, tet in enumerate(tets, 1):
            for s, side in enumerate(SIDES, 1):
                if frozenset(tet[c] for c in side) in surface:
                    f.write(f"{i}, S{s}\n")
        f.write(f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{YOUNG!r}, {POISSON!r}\n*SOLID SECTION, ELSET=SOLID, MATERIAL=STEEL\n")
        f.write("*BOUNDARY\nBOLT-HOLES, 1, 3\n*STEP\n*STATIC\n*CLOAD\n")
        for node, share in sorted(forces.items()):
            f.writelines(f"{node}, {c}, {share * x:.12g}\n" for c, x in enumerate(FORCE, 1) if x)
        f.write("*NODE PRINT, NSET=ALL\nU\n*END STEP\n")
    return forces


def edges_of(face, middles):
    """The edges of a triangle that have a mid-side node, with it."""
    edges = ((min(p), max(p)) for p in ((face[0], face[1]), (face[1], face[2]), (face[2], face[0])))
    return [(e, middles[e]) for e in edges if e in middles]


def ccx(folder, job):
    """Runs CalculiX; gives its version and the displacement of each node."""
    env = dict(os.environ, OMP_NUM_THREADS="2", CCX_NPROC_EQUATION_SOLVER="2")
    done = subprocess.run(["ccx", job], cwd=folder, env=env, capture_output=True, text=True)
    rows = (line.split() for line in (folder / f"{job}.dat").read_text().splitlines())
    found = {int(r[0]): tuple(map(float, r[1:])) for r in rows if len(r) == 4 and r[0].isdigit()}
    if done.returncode or not found:
        sys.exit(f"ccx failed:\n{done.stdout[-2000:]}{done.stderr}")
    version = re.search(r"Version ([\d.]+\d)", done.stdout)
    return version.group(1) if version else "?", found


def subsolid(*arguments):
    """Runs our program; gives what it prints."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    command = [str(target / "release" / "subsolid"), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(command)} failed:\n{done.stderr}")
    return done.stdout


def energy(forces, displacement):
    """Half the work of the load."""
    return 0.5 * sum(s * sum(f * u for f, u in zip(FORCE, displacement[n])) for n, s in forces.items())


def largest(displacement):
    """Length of the largest displacement."""
    return max(math.hypot(*u) for u in displacement.values())


def scenario(nodes, chosen):
    """The same problem for us, with the displacement at chosen nodes."""
    text = '[mesh]\nfile = "bracket.inp"\n[analysis]\nelement = "tet4"\n'
    text += '[materials.steel]\nyoungs_modulus = %r\npoissons_ratio = %r\n' % (YOUNG, POISSON)
    text += '[supports.bolts]\ngroup = "BOLT-HOLES"\nfix = ["x", "y", "z"]\n'
    text += '[loads.shaft]\ngroup = "BEARING"\nforce = [%r, %r, %r]\n[solver]\ntolerance = 1e-10\n' % FORCE
    for node in chosen:
        for axis in "xyz":
            point = ", ".join(repr(x) for x in nodes[node])
            text += f'[quantities.u{axis}-{node}]\nvalue = "u{axis}"\npoint = [{point}]\n'
    return text


def compare(folder):
    """Prints the table; gives the largest relative difference."""
    nodes, tets, triangles = read_msh(MESH)
    forces = write_inp(folder / "bracket.inp", nodes, tets, triangles, {})
    version, theirs = ccx(folder, "bracket")
    chosen = sorted(theirs, key=lambda n: -math.hypot(*theirs[n]))[:3]
    (folder / "bracket.toml").write_text(scenario(nodes, chosen))
    report = json.loads(subsolid("run", folder / "bracket.toml", "--output", folder / "results", "--json", "-"))
    step = report["steps"][0]
    rows = [("strain energy", energy(forces, theirs), step["strain_energy"], None)]
    rows.append(("largest displacement", largest(theirs), step["max_displacement"], None))
    for node in chosen:
        size = math.hypot(*theirs[node])
        for c, axis in enumerate("xyz"):
            ours = step["quantities"][f"u{axis}-{node}"]["value"]
            rows.append((f"u{axis} of node {node}", theirs[node][c], ours, size))
    print(f"{len(tets)} C3D4 elements, {len(nodes)} nodes; CalculiX {version}, {report['program']}\n")
    print(f"{'':24}{'CalculiX':>16}{'Subsolid':>16}{'difference':>14}")
    worst = 0.0
    for name, a, b, size in rows:
        # Components are measured by the displacement of their node.
        difference = abs(a - b) / (size or abs(a))
        worst = max(worst, difference)
        print(f"{name:24}{a:16.7e}{b:16.7e}{difference:14.1e}")
    return worst


def reference(folder, levels):
    """Prints energy and displacement of ten-node tetrahedra."""
    print(f"{'refined':>8}{'C3D10':>10}{'nodes':>10}{'strain energy':>16}{'largest displ.':>16}")
    for level in range(levels):
        nodes, tets, triangles = refined(folder, level)
        nodes, tets, middles = with_midsides(nodes, tets)
        forces = write_inp(folder / f"level_{level}.inp", nodes, tets, triangles, middles)
        _, displacement = ccx(folder, f"level_{level}")
        size = largest(displacement)
        print(f"{level:8}{len(tets):10}{len(nodes):10}{energy(forces, displacement):16.7e}{size:16.7e}", flush=True)


def main():
    """Compares, or makes the reference."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--folder", type=Path, help="keep the files here")
    parser.add_argument("--reference", action="store_true", help="ten-node tetrahedra; levels above 1 need pip install vtk")
    parser.add_argument("--levels", type=int, default=2)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.folder or Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        if options.reference:
            return reference(folder, options.levels)
        worst = compare(folder)
    print(f"\nlargest difference {worst:.1e}, {TOLERANCE:.0e} is allowed")
    return int(worst > TOLERANCE)


if __name__ == "__main__":
    sys.exit(main())
