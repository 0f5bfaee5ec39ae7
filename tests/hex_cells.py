#!/usr/bin/env python3
"""Checks that the three kinds of cells that show hexahedra show the same body and displacement.

    python3 tests/hex_cells.py LAGRANGE.vtu BEZIER.vtu LINEAR.vtu
"""

import sys

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import reference
from vtkmodules.vtkCommonDataModel import VTK_BEZIER_HEXAHEDRON, VTK_HEXAHEDRON, VTK_LAGRANGE_HEXAHEDRON
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


def read(path):
    """A grid."""
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def at(grid, t, place):
    """Position and displacement at a place of a cell."""
    cell = grid.GetCell(t)
    x, weights = [0.0] * 3, [0.0] * cell.GetNumberOfPoints()
    cell.EvaluateLocation(reference(0), place, x, weights)
    field = vtk_to_numpy(grid.GetPointData().GetArray("displacement"))
    points = [cell.GetPointId(i) for i in range(cell.GetNumberOfPoints())]
    return np.array(x), np.array(weights) @ field[points]


def main():
    """Compares them at random places."""
    lagrange, bezier, linear = map(read, sys.argv[1:])
    size, cells = lagrange.GetLength(), lagrange.GetNumberOfCells()
    kinds = [bezier.GetCellType(t) for t in range(cells)]
    if bezier.GetNumberOfCells() != cells or set(kinds) != {VTK_BEZIER_HEXAHEDRON, VTK_LAGRANGE_HEXAHEDRON}:
        sys.exit("the file has not both Bezier and Lagrange cells")
    if linear.GetNumberOfCells() != 27 * cells or linear.GetCellType(0) != VTK_HEXAHEDRON:
        sys.exit("the file has not 27 linear cells for each element")
    largest = np.abs(vtk_to_numpy(lagrange.GetPointData().GetArray("displacement"))).max()
    random = np.random.default_rng(1)
    for t in random.permutation(cells)[:200]:
        place = random.random(3)
        (x, u), (y, v) = at(lagrange, t, place), at(bezier, t, place)
        if np.linalg.norm(x - y) > 1e-9 * size or np.linalg.norm(u - v) > 1e-9 * largest:
            sys.exit(f"cell {t} is another as a Bezier cell: {x} {y} {u} {v}")
        # Corners of the small cells are points of the large ones.
        small = 27 * t + int(random.integers(27))
        corner = np.array([small % 3, small // 3 % 3, small // 9 % 3]) / 3
        (x, u), (y, v) = at(lagrange, t, corner), at(linear, small, np.zeros(3))
        if np.linalg.norm(x - y) > 1e-9 * size or np.linalg.norm(u - v) > 1e-9 * largest:
            sys.exit(f"linear cell {small} is not where it should be: {x} {y} {u} {v}")
    print(f"{kinds.count(VTK_BEZIER_HEXAHEDRON)} Bezier cells of {cells}, {linear.GetNumberOfCells()} linear cells: the same body")


if __name__ == "__main__":
    main()
