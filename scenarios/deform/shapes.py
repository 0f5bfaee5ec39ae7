#!/usr/bin/env python3
"""Makes the shapes of the bundled deformations: pattern.obj, rings and rods that fill a cylinder, and figure.obj, a little man."""

from math import cos, pi, sin
from pathlib import Path

FOLDER = Path(__file__).parent


class Shape:
    """Vertices and quadrilaterals."""

    def __init__(self):
        self.points, self.faces = [], []

    def grid(self, rows, columns, point):
        """A surface of rows x columns quadrilaterals, closed in the direction of the columns."""
        first = len(self.points)
        self.points += [point(r / rows, 2 * pi * c / columns) for r in range(rows + 1) for c in range(columns)]
        for r in range(rows):
            for c in range(columns):
                d = (c + 1) % columns
                self.faces.append([first + columns * i + j for i, j in [(r, c), (r, d), (r + 1, d), (r + 1, c)]])

    def torus(self, height, radius, thickness, columns=30, rows=6):
        def point(share, angle):
            across = radius + thickness * cos(2 * pi * share)
            return across * cos(angle), across * sin(angle), height + thickness * sin(2 * pi * share)

        self.grid(rows, columns, point)

    def capsule(self, start, end, radii, columns=14, rows=10):
        """A rod with round ends between two points, of one radius at each."""
        axis = [b - a for a, b in zip(start, end)]
        length = sum(x * x for x in axis) ** 0.5
        axis = [x / length for x in axis]
        helper = [0, 0, 1] if abs(axis[2]) < 0.9 else [1, 0, 0]
        u = cross(axis, helper)
        size = sum(x * x for x in u) ** 0.5
        u = [x / size for x in u]
        v = cross(axis, u)

        def point(share, angle):
            # A quarter of the rows for each end.
            if share < 0.25:
                turn, along, radius = 2 * pi * share, 0, radii[0]
            elif share > 0.75:
                turn, along, radius = 2 * pi * (share - 0.5), length, radii[1]
            else:
                turn, along = pi / 2, length * (2 * share - 0.5)
                radius = radii[0] + (radii[1] - radii[0]) * (2 * share - 0.5)
            z = along - radius * cos(turn)
            across = radius * max(sin(turn), 1e-3)
            return tuple(
                start[i] + z * axis[i] + across * (cos(angle) * u[i] + sin(angle) * v[i]) for i in range(3)
            )

        self.grid(rows, columns, point)

    def write(self, name, comment, shift=(0, 0, 0)):
        lines = [f"# {comment}"]
        lines += [f"v {x + shift[0]:.5f} {y + shift[1]:.5f} {z + shift[2]:.5f}" for x, y, z in self.points]
        lines += ["f " + " ".join(str(v + 1) for v in face) for face in self.faces]
        (FOLDER / name).write_text("\n".join(lines) + "\n")


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def pattern():
    shape = Shape()
    for layer in range(5):
        for radius in (0.25, 0.5, 0.75):
            shape.torus(0.25 + 3.5 * layer / 4, radius, 0.04)
    for spoke in range(8):
        x, y = cos(pi * spoke / 4), sin(pi * spoke / 4)
        for radius in (0.25, 0.5, 0.75):
            shape.capsule((radius * x, radius * y, 0.25), (radius * x, radius * y, 3.75), (0.03, 0.03), columns=6, rows=14)
    shape.write("pattern.obj", "Test pattern in a cylinder of radius 1 and length 4, made by shapes.py")


def figure():
    shape = Shape()
    shape.capsule((0, 0, 1.75), (0, 0, 2.75), (0.33, 0.38), rows=16, columns=20)
    shape.capsule((0, 0, 3.35), (0, 0, 3.5), (0.3, 0.28), columns=20)
    shape.capsule((0, 0, 2.9), (0, 0, 3.2), (0.12, 0.12))
    for side in (-1, 1):
        shape.capsule((0.42 * side, 0, 2.75), (1.0 * side, 0, 2.4), (0.14, 0.12))
        shape.capsule((1.0 * side, 0, 2.4), (1.45 * side, 0, 2.0), (0.12, 0.1))
        shape.capsule((0.2 * side, 0, 1.6), (0.3 * side, 0, 0.95), (0.19, 0.15))
        shape.capsule((0.3 * side, 0, 0.95), (0.35 * side, 0, 0.35), (0.15, 0.11))
        shape.capsule((0.35 * side, 0, 0.3), (0.38 * side, -0.25, 0.25), (0.1, 0.09))
        shape.capsule((0.1 * side, -0.27, 3.5), (0.1 * side, -0.28, 3.51), (0.04, 0.04), rows=8, columns=8)
    shape.write("figure.obj", "A little man in a box of 4 x 1.2 x 4.4, made by shapes.py", (2, 0.6, 0.1))


pattern()
figure()
