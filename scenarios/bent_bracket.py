#!/usr/bin/env python3
"""Makes `bent_bracket.msh` (Gmsh 2.2, text): a bracket bent from plate, with a bolt hole in each leg, of 256 hexahedra.

    python3 scenarios/bent_bracket.py > scenarios/bent_bracket.msh

Needed only to change the part: the mesh is kept beside this script. Lengths in millimetres; z points up.

        z
        |__
        |  |      two square legs of 48 x 48, 8 thick, joined by a bend of inner radius 12;
        |()|      in the middle of each leg a hole of radius 7, in a square of cells around it.
        |  |
         \\  \\____________
          \\_____ () _____|  x

The faces of the bend and of the holes turn by less than 23 degrees from cell to cell, so that Catmull-Clark subdivision
rounds them and keeps all other edges. Five cells meet along the four corners of the square around each hole.
"""

from math import cos, pi, sin

LEG, THICK, INNER, HOLE = 48.0, 8.0, 12.0, 7.0
GRID, BEND, LAYERS = 6, 4, 2  # cells along a leg, along the bend, through the thickness
STEP = LEG / GRID
CENTRE = INNER + THICK  # x and z of the bend's axis

nodes, cells, quads = {}, [], {}


def node(place):
    return nodes.setdefault(tuple(round(x, 9) + 0.0 for x in place), len(nodes) + 1)


def add(column, groups):
    """Cells under a quadrilateral: `column(k)` has its corners in layer k, `groups` the names of some of its sides."""
    for k in range(LAYERS):
        upper, lower = [[node(p) for p in column(n)] for n in (k, k + 1)]
        cells.append(lower + upper)
        for side, name in groups.items():
            a, b = side, (side + 1) % 4
            quads.setdefault(name, []).append([lower[a], lower[b], upper[b], upper[a]])
    quads.setdefault("inside", []).append([node(p) for p in column(0)])
    quads.setdefault("outside", []).append([node(p) for p in column(LAYERS)])


def around(step, ring):
    """A point of the rings around a hole: sixteen steps from the direction of u; ring 0 is the hole, ring 2 a square."""
    angle, side, t = pi / 8 * step, (step + 2) // 4 % 4, (step + 2) % 4 - 2
    square = [(2, t), (-t, 2), (-2, -t), (t, -2)][side]
    return tuple((1 - ring / 2) * HOLE * c + ring / 2 * STEP * s for c, s in zip((cos(angle), sin(angle)), square))


def leg(name, place):
    """A leg over u, v in its middle plane."""

    def patch(corners, groups):
        add(lambda k: [place(CENTRE + LEG / 2 + u, v, THICK * (1 - k / LAYERS)) for u, v in corners], groups)

    def at(i, j):
        return -LEG / 2 + STEP * i, -LEG / 2 + STEP * j

    for i in range(GRID):
        for j in range(GRID):
            if not (1 <= i < GRID - 1 and 1 <= j < GRID - 1):
                corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
                patch(corners, {1: name + "-end"} if i == GRID - 1 else {})
    for step in range(16):
        for ring in range(2):
            corners = [around(step, ring), around(step, ring + 1), around(step + 1, ring + 1), around(step + 1, ring)]
            patch(corners, {3: name + "-hole"} if ring == 0 else {})


def bend():
    def at(s, j, k):
        angle, r = pi / 2 * s / BEND, INNER + THICK * k / LAYERS
        return CENTRE - r * sin(angle), -LEG / 2 + STEP * j, CENTRE - r * cos(angle)

    for s in range(BEND):
        for j in range(GRID):
            add(lambda k: [at(s, j, k), at(s, j + 1, k), at(s + 1, j + 1, k), at(s + 1, j, k)], {})


def is_positive(cell):
    a, b, d, e = (places[cell[i]] for i in (0, 1, 3, 4))
    x, y, z = ([p - q for p, q in zip(o, a)] for o in (b, d, e))
    return sum((x[i - 2] * y[i - 1] - x[i - 1] * y[i - 2]) * z[i] for i in range(3)) > 0


leg("base", lambda x, y, z: (x, y, z))
leg("wall", lambda x, y, z: (z, y, x))
bend()

places = {n: p for p, n in nodes.items()}
names = sorted(quads)
elements = [(3, tag, quad) for tag, name in enumerate(names, 1) for quad in quads[name]]
elements += [(5, 1, cell if is_positive(cell) else cell[4:] + cell[:4]) for cell in cells]
lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names) + 1)]
lines += [f'2 {tag} "{name}"' for tag, name in enumerate(names, 1)] + ['3 1 "plate"', "$EndPhysicalNames"]
lines += ["$Nodes", str(len(places))]
lines += [" ".join([str(n), *(f"{x:.12g}" for x in places[n])]) for n in sorted(places)]
lines += ["$EndNodes", "$Elements", str(len(elements))]
lines += [" ".join(map(str, [i, kind, 2, tag, tag, *own])) for i, (kind, tag, own) in enumerate(elements, 1)]
print("\n".join([*lines, "$EndElements"]))
