"""Reads the .vtu files and the collection of a run with VTK and checks what they promise.

Usage: python tests/read_back.py DIR...

Needs VTK's Python wheel (pip install vtk). Fails on any error or warning of VTK, on a missing or misnamed array, and on
values that are not finite. Fields other than those of the mesh may be missing; those present must have the right shape.
"""

import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

TENSOR = ["XX", "YY", "ZZ", "XY", "YZ", "XZ"]
# name: (components, kind of number, must it be there)
POINT_ARRAYS = {"displacement": (3, "f8", False), "stress": (6, "f8", False), "von_mises": (1, "f8", False)}
CELL_ARRAYS = {
    "region": (1, "i4", True),
    "refinement_level": (1, "u1", True),
    "quality": (1, "f8", True),
    "stress": (6, "f8", False),
    "von_mises": (1, "f8", False),
    "error_indicator": (1, "f8", False),
    "marked": (1, "u1", False),
    "regular": (1, "u1", False),
}
# Hexahedra: nodes along an edge.
HEXAHEDRA = {(vtk.VTK_HEXAHEDRON, 8): 2, (vtk.VTK_LAGRANGE_HEXAHEDRON, 27): 3, (vtk.VTK_LAGRANGE_HEXAHEDRON, 64): 4}


def collect_messages():
    messages = []
    window = vtk.vtkOutputWindow()
    window.SetDisplayModeToNever()

    def remember(_window, _event, text):
        messages.append(text)

    remember.CallDataType = vtk.VTK_STRING
    for event in ("ErrorEvent", "WarningEvent", "TextEvent", "MessageEvent"):
        window.AddObserver(event, remember)
    vtk.vtkOutputWindow.SetInstance(window)
    return messages


def arrays_of(data):
    return {data.GetArrayName(i): data.GetArray(i) for i in range(data.GetNumberOfArrays())}


def check_arrays(where, data, expected, tuples):
    present = arrays_of(data)
    for name, (_, _, needed) in expected.items():
        assert name in present or not needed, f"{where}: {name} is missing"
    for name, array in present.items():
        assert name in expected, f"{where}: unexpected array {name}"
        components, kind, _ = expected[name]
        values = vtk_to_numpy(array)
        assert array.GetNumberOfComponents() == components, f"{where}: {name} has {array.GetNumberOfComponents()} components"
        assert array.GetNumberOfTuples() == tuples, f"{where}: {name} has {array.GetNumberOfTuples()} values for {tuples}"
        assert values.dtype == np.dtype(kind), f"{where}: {name} is {values.dtype}"
        assert np.isfinite(values).all(), f"{where}: {name} is not finite"
        if components == 6:
            names = [array.GetComponentName(i) for i in range(6)]
            assert names == TENSOR, f"{where}: components of {name} are {names}"
    return {name: vtk_to_numpy(array) for name, array in present.items()}


def check_file(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0, f"{path}: error code {reader.GetErrorCode()}"
    grid = reader.GetOutput()
    assert grid.GetNumberOfPoints() > 0 and grid.GetNumberOfCells() > 0, f"{path}: empty"
    check_arrays(f"{path}: points", grid.GetPointData(), POINT_ARRAYS, grid.GetNumberOfPoints())
    cells = check_arrays(f"{path}: cells", grid.GetCellData(), CELL_ARRAYS, grid.GetNumberOfCells())
    if "displacement" in arrays_of(grid.GetPointData()):
        vectors = grid.GetPointData().GetVectors()
        assert vectors is not None and vectors.GetName() == "displacement", f"{path}: displacement is not active"
    time = grid.GetFieldData().GetArray("TimeValue")
    assert time is not None and time.GetNumberOfTuples() == 1, f"{path}: no TimeValue"
    check_names(path, grid, cells)
    check_cells(path, grid, cells)
    return time.GetValue(0)


def check_names(path, grid, cells):
    """The field data name every region, and the faces of every group are faces of cells."""
    fields = grid.GetFieldData()
    names = {fields.GetArrayName(i): fields.GetAbstractArray(i) for i in range(fields.GetNumberOfArrays())}
    regions = names["region_names"]
    assert cells["region"].max() < regions.GetNumberOfValues(), f"{path}: a region without a name"
    texts = [regions.GetValue(i) for i in range(regions.GetNumberOfValues())]
    assert all(texts) and all(text.isprintable() for text in texts), f"{path}: regions {texts}"
    if "group_faces" in names:
        rows = vtk_to_numpy(names["group_faces"])
        assert rows.shape[1] == 4 and rows[:, 0].max() < names["group_names"].GetNumberOfValues(), f"{path}: groups"
        assert rows[:, 1:].max() < grid.GetNumberOfPoints(), f"{path}: group_faces"
    for i in range(names["units"].GetNumberOfValues() if "units" in names else 0):
        assert len(names["units"].GetValue(i).split(" ", 1)) == 2, f"{path}: units"


def check_cells(path, grid, cells):
    kinds = {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}
    if not kinds & {vtk.VTK_TETRA, vtk.VTK_QUADRATIC_TETRA}:
        check_hexahedra(path, grid, cells)
        return
    nodes = {vtk.VTK_TETRA: 4, vtk.VTK_QUADRATIC_TETRA: 10}
    assert len(kinds) == 1 and kinds <= set(nodes), f"{path}: not all tetrahedra of one kind"
    points = vtk_to_numpy(grid.GetPoints().GetData())
    assert points.dtype == np.float64 and np.isfinite(points).all(), f"{path}: points"
    tets = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, nodes[kinds.pop()])
    assert tets.min() >= 0 and tets.max() < len(points), f"{path}: a cell uses a point that does not exist"
    a, b, c, d = (points[tets[:, i]] for i in range(4))
    volumes = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)
    assert (volumes > 0).all(), f"{path}: {(volumes <= 0).sum()} cells are not positive"
    assert (cells["quality"] > 0).all() and (cells["quality"] < 70.53).all(), f"{path}: quality"
    if "marked" in cells:
        assert set(np.unique(cells["marked"])) <= {0, 1}, f"{path}: marked"


def check_hexahedra(path, grid, cells):
    """Nodes lie where VTK's parametric coordinates have them: near those of the trilinear cell, in which no order is mixed up."""
    kinds = {(grid.GetCellType(i), grid.GetCell(i).GetNumberOfPoints()) for i in range(grid.GetNumberOfCells())}
    assert len(kinds) == 1 and kinds <= set(HEXAHEDRA), f"{path}: not all hexahedra of one kind: {kinds}"
    assert (cells["quality"] > 0).all() and (cells["quality"] <= 90.0001).all(), f"{path}: quality"
    for i in range(grid.GetNumberOfCells()):
        cell = grid.GetCell(i)
        count = cell.GetNumberOfPoints()
        points = np.array([cell.GetPoints().GetPoint(k) for k in range(count)])
        at = np.array(cell.GetParametricCoords()).reshape(-1, 3)[:count] if count > 8 else CORNERS
        assert np.linalg.det(points[[1, 3, 4]] - points[0]) > 0, f"{path}: cell {i} is twisted"
        side = [[1 - t, t] for t in at.T]
        shape = [side[0][x] * side[1][y] * side[2][z] for x, y, z in CORNERS.astype(int)]
        off = np.linalg.norm(np.array(shape).T @ points[:8] - points, axis=1).max()
        size = np.linalg.norm(points[1] - points[0])
        assert off < 0.3 * size, f"{path}: cell {i}: a node is {off} off, the edge is {size} long"


CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)


def check_collection(path, times):
    entries = ElementTree.parse(path).getroot().findall("./Collection/DataSet")
    listed = {entry.get("file"): float(entry.get("timestep")) for entry in entries}
    assert listed == times, f"{path}: lists {listed}, the folder holds {times}"
    assert list(listed.values()) == sorted(listed.values()), f"{path}: times are not sorted"


def check_folder(folder, messages):
    times = {path.name: check_file(path) for path in sorted(folder.glob("*.vtu"))}
    assert times, f"{folder}: no .vtu file"
    collection = folder / "results.pvd"
    if collection.exists():
        check_collection(collection, times)
    assert not messages, f"{folder}: VTK said: {messages}"
    print(f"{folder}: {len(times)} files read back")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    messages = collect_messages()
    for folder in sys.argv[1:]:
        check_folder(Path(folder), messages)


if __name__ == "__main__":
    main()
