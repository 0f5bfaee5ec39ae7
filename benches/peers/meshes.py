#!/usr/bin/env python3
"""Meshes of the comparisons: the tripod and the Fichera corner at levels of uniform red refinement, in every program's format.

    python3 benches/peers/meshes.py tripod OUT --data DIR [--levels 0 1 2 3]     # DIR holds tripod.GiD.msh
    python3 benches/peers/meshes.py fichera OUT [--cells 2] [--levels 0]

Level 0 of the tripod is the corners of its ten-node tetrahedra, of the Fichera corner, [-1, 1]^3 without [0, 1]^3, so many
cubes of six tetrahedra along a unit length. A level cuts each cell of the one before into eight, the octahedron in its
middle along its SHORTEST diagonal (another choice gives another energy). Faces are 1 fixed, 2 loaded, 3 free: of the tripod
the feet (y = -10) and the top (y = 13), of the corner z = -1 and z = 1.

Writes `OUT/NAME_L0.npz` (points X, tetrahedra T, boundary triangles F outwards, their numbers M), `.msh` (Gmsh 4.1
binary), `_22.msh` (Gmsh 2.2 text) and `.mesh` (Medit), and so on. Text is not written above level `--most-text`.
"""

import argparse
import itertools
from pathlib import Path

import numpy as np

FACES = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))
EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


def read_gid(path):
    """Points and tetrahedra of a GiD file, corners only."""
    points, tets, section = {}, [], None
    for line in Path(path).read_text().splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] in ("Coordinates", "Elements"):
            section = words[0]
        elif words[0].lower() in ("end", "mesh"):
            section = None
        elif section == "Coordinates":
            points[int(words[0])] = [float(x) for x in words[1:4]]
        elif section == "Elements":
            tets.append([int(x) for x in words[1:5]])
    tets = np.array(tets)
    used, place = np.unique(tets, return_inverse=True)
    points = np.array([points[k] for k in used])
    return points, oriented(points, place.reshape(tets.shape).astype(np.int32))


def fichera(cells):
    """Points and tetrahedra of [-1, 1]^3 without [0, 1]^3."""
    side = 2 * cells + 1
    points = np.array(list(itertools.product(range(side), repeat=3)), float) / cells - 1
    tets = []
    for cube in itertools.product(range(2 * cells), repeat=3):
        if min(cube) >= cells:
            continue
        for axes in itertools.permutations(range(3)):
            corners = [np.array(cube)]
            for axis in axes:
                corners.append(corners[-1] + (np.arange(3) == axis))
            tets.append([(c[0] * side + c[1]) * side + c[2] for c in corners])
    used, place = np.unique(tets, return_inverse=True)
    points = points[used]
    return points, oriented(points, place.reshape(len(tets), 4).astype(np.int32))


def volumes(points, tets):
    a, b, c, d = (points[tets[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def oriented(points, tets):
    """The tetrahedra with positive volumes."""
    tets = tets.copy()
    wrong = volumes(points, tets) < 0
    tets[wrong, 2], tets[wrong, 3] = tets[wrong, 3].copy(), tets[wrong, 2].copy()
    return tets


def boundary(tets):
    """The triangles that belong to one tetrahedron only, outwards."""
    faces = np.concatenate([tets[:, f] for f in FACES])
    corners = np.sort(faces, axis=1).astype(np.int64)
    count = int(tets.max()) + 1
    key = (corners[:, 0] * count + corners[:, 1]) * count + corners[:, 2]
    _, first, uses = np.unique(key, return_index=True, return_counts=True)
    return faces[first[uses == 1]].astype(np.int32)


def marked(points, faces, axis, fixed, load):
    """1 for faces on the plane `fixed` of the axis, 2 on the plane `load`, else 3."""
    along = points[faces][:, :, axis]
    marks = np.full(len(faces), 3, np.int32)
    for mark, plane in ((1, fixed), (2, load)):
        marks[(abs(along - plane) < 1e-5).all(axis=1)] = mark
    return marks


def red(points, tets):
    """Uniform red refinement, octahedra along their shortest diagonals."""
    count = len(points)
    edges = np.concatenate([np.sort(tets[:, e], axis=1) for e in EDGES]).astype(np.int64)
    keys, place = np.unique(edges[:, 0] * count + edges[:, 1], return_inverse=True)
    points = np.concatenate([points, 0.5 * (points[keys // count] + points[keys % count])])
    a, b, c, d = tets.T
    ab, ac, ad, bc, bd, cd = (place.reshape(6, len(tets)) + count).astype(np.int32)
    finer = [np.stack(t, 1) for t in ((a, ab, ac, ad), (ab, b, bc, bd), (ac, bc, c, cd), (ad, bd, cd, d))]
    # The diagonals, and the four edges around each.
    rings = (((ab, cd), (ac, bc, bd, ad)), ((ac, bd), (ab, ad, cd, bc)), ((ad, bc), (ab, bd, cd, ac)))
    shortest = np.stack([((points[p] - points[q]) ** 2).sum(axis=1) for (p, q), _ in rings]).argmin(axis=0)
    for k, ((p, q), ring) in enumerate(rings):
        own = shortest == k
        for i in range(4):
            finer.append(np.stack((p[own], q[own], ring[i][own], ring[(i + 1) % 4][own]), 1))
    return points, oriented(points, np.concatenate(finer).astype(np.int32))


def write_npz(path, points, tets, faces, marks):
    np.savez(path, X=points, T=tets, F=faces, M=marks)


def write_gmsh2(path, points, tets, faces, marks):
    with open(path, "w") as file:
        file.write('$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n2 1 "fixed"\n2 2 "load"\n')
        file.write(f'2 3 "free"\n3 1 "solid"\n$EndPhysicalNames\n$Nodes\n{len(points)}\n')
        np.savetxt(file, np.column_stack([np.arange(1, len(points) + 1), points]), fmt="%d %.17g %.17g %.17g")
        file.write(f"$EndNodes\n$Elements\n{len(faces) + len(tets)}\n")
        one = np.ones(len(faces), int)
        ids = np.arange(1, len(faces) + 1)
        np.savetxt(file, np.column_stack([ids, 2 * one, 2 * one, marks, marks, faces + 1]), fmt="%d")
        one = np.ones(len(tets), int)
        ids = np.arange(len(faces) + 1, len(faces) + len(tets) + 1)
        np.savetxt(file, np.column_stack([ids, 4 * one, 2 * one, one, one, tets + 1]), fmt="%d")
        file.write("$EndElements\n")


def write_gmsh4(path, points, tets, faces, marks):
    """Gmsh 4.1 binary."""
    box = np.concatenate([points.min(axis=0), points.max(axis=0)])
    blocks = [(2, mark, 2, faces[marks == mark]) for mark in (1, 2, 3)] + [(3, 1, 4, tets)]
    total = len(faces) + len(tets)
    with open(path, "wb") as file:

        def put(kind, *values):
            file.write(np.array(values, kind).tobytes())

        file.write(b"$MeshFormat\n4.1 1 8\n")
        put("<i4", 1)
        file.write(b'\n$EndMeshFormat\n$PhysicalNames\n4\n2 1 "fixed"\n2 2 "load"\n2 3 "free"\n3 1 "solid"\n')
        file.write(b"$EndPhysicalNames\n$Entities\n")
        put("<u8", 0, 0, 3, 1)
        # Three surfaces and the volume that they bound, each its own physical group.
        for tag, bounds in ((1, ()), (2, ()), (3, ()), (1, (1, 2, 3))):
            put("<i4", tag)
            put("<f8", *box)
            put("<u8", 1)
            put("<i4", tag)
            put("<u8", len(bounds))
            put("<i4", *bounds)
        file.write(b"\n$EndEntities\n$Nodes\n")
        put("<u8", 1, len(points), 1, len(points))
        put("<i4", 3, 1, 0)
        put("<u8", len(points))
        file.write(np.arange(1, len(points) + 1, dtype="<u8").tobytes() + points.astype("<f8").tobytes())
        file.write(b"\n$EndNodes\n$Elements\n")
        put("<u8", len(blocks), total, 1, total)
        first = 1
        for dimension, entity, kind, cells in blocks:
            put("<i4", dimension, entity, kind)
            put("<u8", len(cells))
            ids = np.arange(first, first + len(cells))
            file.write(np.column_stack([ids, cells.astype(np.int64) + 1]).astype("<u8").tobytes())
            first += len(cells)
        file.write(b"\n$EndElements\n")


def write_medit(path, points, tets, faces, marks):
    with open(path, "w") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n")
        np.savetxt(file, np.column_stack([points, np.zeros(len(points))]), fmt="%.17g %.17g %.17g %d")
        file.write(f"Tetrahedra\n{len(tets)}\n")
        np.savetxt(file, np.column_stack([tets + 1, np.ones(len(tets), int)]), fmt="%d")
        file.write(f"Triangles\n{len(faces)}\n")
        np.savetxt(file, np.column_stack([faces + 1, marks]), fmt="%d")
        file.write("End\n")


def write(stem, mesh, text):
    """Writes the files of one mesh that are not there yet; those of text only if asked to."""
    writers = {".npz": write_npz, ".msh": write_gmsh4}
    if text:
        writers |= {"_22.msh": write_gmsh2, ".mesh": write_medit}
    for suffix, writer in writers.items():
        path = Path(f"{stem}{suffix}")
        if not path.exists():
            # Renamed when it is complete: a run that was cut short leaves no half of a mesh.
            part = path.with_name(f"part_{path.name}")
            writer(part, *mesh)
            part.rename(path)


def make(name, folder, levels, data=None, cells=2, most_text=3):
    """Writes the meshes; what is there already is kept."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    missing = [k for k in levels if not all(Path(f"{folder}/{name}_L{k}{s}").exists() for s in suffixes(k, most_text))]
    if not missing:
        return
    if name == "tripod":
        points, tets = read_gid(Path(data) / "tripod.GiD.msh")
        planes = (1, -10, 13)
    else:
        points, tets = fichera(cells)
        planes = (2, -1, 1)
    for level in range(max(missing) + 1):
        if level:
            points, tets = red(points, tets)
        if level in missing:
            faces = boundary(tets)
            marks = marked(points, faces, *planes)
            write(f"{folder}/{name}_L{level}", (points, tets, faces, marks), level <= most_text)


def suffixes(level, most_text):
    return (".npz", ".msh", "_22.msh", ".mesh") if level <= most_text else (".npz", ".msh")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", choices=("tripod", "fichera"))
    parser.add_argument("out", type=Path)
    parser.add_argument("--data", type=Path, help="folder of tripod.GiD.msh")
    parser.add_argument("--cells", type=int, default=2, help="of the Fichera corner along a unit length")
    parser.add_argument("--levels", type=int, nargs="+", default=[0, 1, 2, 3])
    parser.add_argument("--most-text", type=int, default=3, help="the highest level written as text too")
    args = parser.parse_args()
    if args.name == "tripod" and args.data is None:
        parser.error("the tripod needs --data")
    make(args.name, args.out, args.levels, args.data, args.cells, args.most_text)


if __name__ == "__main__":
    main()
