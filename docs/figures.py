#!/usr/bin/env python3
"""Makes the figures of Burkhart, Hamann and Umlauf (2010) from meshes that `subsolid` writes.

    cargo build --release
    pip install vtk numpy pillow
    python3 docs/figures.py [--data FOLDER] [--out docs/figures]

Figures 1 (elementary stages), 8 (one crease), 9 (one corner) and 10 (adaptive, interpolating) are of small solids made here;
12 and 13 (the tripod, all cells and 284 of them) need the folder that holds `tripod.GiD.msh`, by `--data` or SUBSOLID_DATA.
The hue of a cell goes from red (minimum dihedral angle 0 degrees) to green (71).
"""

import argparse
import colorsys
import os
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.util.vtkConstants import VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonCore import vtkIdList
from vtkmodules.vtkFiltersCore import vtkExtractCells, vtkFeatureEdges, vtkTubeFilter
from vtkmodules.vtkFiltersGeneral import vtkShrinkFilter
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkFiltersSources import vtkLineSource, vtkSphereSource
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer

ROOT = Path(__file__).resolve().parents[1]
sys.path += [str(ROOT / "benches/peers"), str(ROOT / "docs")]

import meshers  # noqa: E402
import render  # noqa: E402
import table_1  # noqa: E402

RED, PLAIN, GREY = (0.85, 0.15, 0.12), (0.80, 0.84, 0.89), (0.88, 0.88, 0.88)
BEST = 71.0
# Direction from the part to the camera, what points up, magnification.
CUBE_VIEW = ((1.0, -1.5, 0.8), (0, 0, 1), 0.95)
COLUMN_VIEW = ((1.0, -1.5, 0.5), (0, 0, 1), 0.88)
TRIPOD_VIEW = ((-0.25, 1.0, -0.35), (1, 0, 0), 1.3)
# The half that is cut away lies on this side of small solids.
CUT = (0.6, -0.8, 0)


def hue(t):
    """From red (0) to green (1)."""
    return colorsys.hsv_to_rgb(t / 3, 0.9, 0.92)


# ---- meshes ----


def bricks(count):
    """Points and tetrahedra of a box of unit cubes, each of twelve tetrahedra around its centre."""
    nx, ny, nz = (n + 1 for n in count)
    at = lambda x, y, z: (x * ny + y) * nz + z
    points = [(x, y, z) for x in range(nx) for y in range(ny) for z in range(nz)]
    tets = []
    for x, y, z in np.ndindex(*count):
        centre = len(points)
        points.append((x + 0.5, y + 0.5, z + 0.5))
        for axis in range(3):
            for side in (0, 1):
                # The square's corners in a circle; its diagonal joins the first and the third, alike on opposite sides.
                square = [list(np.insert(corner, axis, side)) for corner in ((0, 0), (1, 0), (1, 1), (0, 1))]
                a, b, c, d = (at(x + i, y + j, z + k) for i, j, k in square)
                tets += [(a, b, c, centre), (a, c, d, centre)]
    points = np.array(points, dtype=float)
    p = points[np.array(tets)]
    positive = np.einsum("ij,ij->i", np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), p[:, 3] - p[:, 0]) > 0
    return points, [t if ok else (t[1], t[0], t[2], t[3]) for t, ok in zip(tets, positive)]


def write_gid(path, points, tets):
    """A GiD file."""
    lines = ["MESH dimension 3 ElemType Tetrahedra Nnode 4", "Coordinates"]
    lines += [f"{i} {x!r} {y!r} {z!r}" for i, (x, y, z) in enumerate(points.tolist(), 1)]
    lines += ["End Coordinates", "Elements"]
    lines += [f"{i} " + " ".join(str(v + 1) for v in tet) for i, tet in enumerate(tets, 1)]
    path.write_text("\n".join([*lines, "End Elements", ""]))
    return path


def read(path):
    """The grid of a file."""
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def values(grid, name):
    """A cell array as numpy."""
    return vtk_to_numpy(grid.GetCellData().GetArray(name))


def with_changes(grid):
    """The grid of a frame with the cell array `changed`: new, or at a vertex that moved."""
    moved = vtk_to_numpy(grid.GetPointData().GetArray("moved")).astype(bool)
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
    changed = numpy_to_vtk((values(grid, "new") > 0) | moved[cells].any(axis=1), deep=True, array_type=VTK_UNSIGNED_CHAR)
    changed.SetName("changed")
    grid.GetCellData().AddArray(changed)
    return grid


# ---- pictures ----


def surface(source):
    """The boundary of what a filter or a grid gives."""
    boundary = vtkGeometryFilter()
    if source.IsA("vtkDataObject"):
        boundary.SetInputData(source)
    else:
        boundary.SetInputConnection(source.GetOutputPort())
    boundary.Update()
    return boundary.GetOutput()


def exploded(grid, factor=0.72):
    """Every cell shrunk to its centre."""
    shrink = vtkShrinkFilter()
    shrink.SetInputData(grid)
    shrink.SetShrinkFactor(factor)
    return surface(shrink)


def cut_away(grid, normal, share=0.5):
    """The cells whose centres lie in the lower `share` of the grid's extent along `normal`."""
    points = vtk_to_numpy(grid.GetPoints().GetData())
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
    height = points @ np.asarray(normal, dtype=float)
    limit = height.min() + share * (height.max() - height.min())
    kept = vtkIdList()
    for cell in np.flatnonzero(height[cells].mean(axis=1) <= limit):
        kept.InsertNextId(int(cell))
    extract = vtkExtractCells()
    extract.SetInputData(grid)
    extract.SetCellList(kept)
    return surface(extract)


def actor_of(mesh, array=None, lut=None, colour=PLAIN, line=0.8):
    """A mesh with its edges, in one colour or coloured by a cell array."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    if array:
        mapper.SetScalarModeToUseCellFieldData()
        mapper.SetColorModeToMapScalars()
        mapper.SelectColorArray(array)
        mapper.SetLookupTable(lut)
        mapper.UseLookupTableScalarRangeOn()
    else:
        mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetColor(*colour)
    look.SetInterpolationToFlat()
    look.SetEdgeVisibility(line > 0)
    look.SetEdgeColor(0.15, 0.15, 0.2)
    look.SetLineWidth(line)
    look.SetEdgeOpacity(min(1.0, 1.4 * line))
    # Shading must not change what a colour says.
    look.SetAmbient(0.75 if array else 0.45)
    look.SetDiffuse(0.25 if array else 0.6)
    return actor


def red_tubes(source, radius):
    """Lines as red tubes."""
    tube = vtkTubeFilter()
    tube.SetInputConnection(source.GetOutputPort())
    tube.SetRadius(radius)
    tube.SetNumberOfSides(8)
    return red(tube)


def red(source):
    """What a source gives, in red."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*RED)
    actor.GetProperty().SetAmbient(0.6)
    return actor


def feature_edges(grid, angle, radius):
    """Edges of the boundary above an angle, as red tubes."""
    edges = vtkFeatureEdges()
    edges.SetInputData(surface(grid))
    edges.BoundaryEdgesOff()
    edges.NonManifoldEdgesOff()
    edges.ManifoldEdgesOff()
    edges.FeatureEdgesOn()
    edges.SetFeatureAngle(angle)
    edges.ColoringOff()
    return red_tubes(edges, radius)


def panel(title, actors, view, bounds, lut=None):
    """A renderer with a title that shows the box of `bounds` from a direction, so that all panels have one scale."""
    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    for actor in actors:
        renderer.AddActor(actor)
    renderer.AddViewProp(render.text(title, 15, 0.5, 0.925))
    camera = renderer.GetActiveCamera()
    centre = [(bounds[i] + bounds[i + 1]) / 2 for i in (0, 2, 4)]
    direction, up, zoom = view
    camera.SetFocalPoint(*centre)
    camera.SetPosition(*(c + d for c, d in zip(centre, direction)))
    camera.SetViewUp(*up)
    renderer.ResetCamera(bounds)
    camera.SetWindowCenter(0, 0.08 if lut is None else -0.1)
    camera.Zoom(zoom if lut is None else 0.93 * zoom)
    renderer.ResetCameraClippingRange()
    if lut is not None:
        renderer.AddViewProp(angle_bar(lut))
        renderer.AddViewProp(render.text("minimum dihedral angle, degrees", 11, 0.5, 0.095))
    return renderer


def angle_bar(lut):
    """The scale of the angles."""
    bar = render.colour_bar(lut, "", 420)
    bar.SetNumberOfLabels(3)
    bar.SetLabelFormat("{:.0f}" if render.vtk_formats_with_braces() else "%.0f")
    bar.GetPositionCoordinate().SetValue(0.2, 0.01)
    bar.SetWidth(0.6)
    bar.SetHeight(0.09)
    return bar


def quality_table():
    """The colours of the angles."""
    return render.table(hue, 0.0, BEST)


# ---- the figures ----


class Maker:
    """Runs the program and writes pictures."""

    def __init__(self, options, folder):
        self.options, self.folder = options, Path(folder)

    def mesh(self, path, steps, *words):
        """The grid of a mesh after so many steps."""
        out = self.folder / "mesh.vtu"
        meshers.subdivide(self.options.subsolid, path, out, "--steps", steps, "--optimise", "paper", *words)
        return read(out)

    def list(self, name, lines):
        """A file of numbers."""
        path = self.folder / name
        path.write_text("".join(f"{line}\n" for line in lines))
        return path

    def write(self, name, rows, width=330, height=None):
        """A picture, with 256 colours: a third of the bytes of one with all."""
        path = self.options.out / f"{name}.png"
        render.write(rows, path, width, height)
        picture = Image.open(path).convert("RGB")
        picture.quantize(256, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(path, optimize=True)


def three_steps(maker, name, words, mark):
    """Figures 8 and 9: three steps, exploded above, cut away with the quality below. `mark` is drawn in red."""
    path = write_gid(maker.folder / "cube.msh", *bricks((1, 1, 1)))
    grids = [maker.mesh(path, n, "--feature-angle", 180, *words) for n in range(4)]
    bounds, lut = grids[0].GetBounds(), quality_table()
    titles = ["input", "one step", "two steps", "three steps"]
    upper, lower = [], []
    for n, (title, grid) in enumerate(zip(titles, grids)):
        cells = f"{title}: {grid.GetNumberOfCells():,} cells"
        thin = 0.8 if n < 3 else 0.4
        upper.append(panel(cells, [actor_of(exploded(grid), line=thin), mark()], CUBE_VIEW, bounds))
        half = cut_away(grid, CUT, 0.6) if n else surface(grid)
        lower.append(panel("quality", [actor_of(half, "quality", lut, line=thin), mark()], CUBE_VIEW, bounds, lut))
    maker.write(name, [upper, lower], 300)


def figure_8(maker):
    """One sharp crease: an edge of a cube whose other edges are smooth."""
    edges = maker.list("crease.txt", ["0 1"])

    def mark():
        line = vtkLineSource()
        line.SetPoint1(0, 0, 0)
        line.SetPoint2(0, 0, 1)
        return red_tubes(line, 0.018)

    three_steps(maker, "figure-8", ("--edges", edges), mark)


def figure_9(maker):
    """One sharp corner: a vertex of a cube whose other vertices are smooth."""
    corners = maker.list("corner.txt", ["1"])

    def mark():
        ball = vtkSphereSource()
        ball.SetCenter(0, 0, 1)
        ball.SetRadius(0.035)
        return red(ball)

    three_steps(maker, "figure-9", ("--corners", corners), mark)


def figure_10(maker):
    """Two adaptive steps with the interpolating boundary: the bottom of a column is refined twice."""
    points, tets = bricks((1, 1, 4))
    path = write_gid(maker.folder / "column.msh", points, tets)
    low = np.flatnonzero(points[np.array(tets)].mean(axis=1)[:, 2] < 1)
    words = ("--select", maker.list("low.txt", low), "--boundary", "interpolating", "--feature-angle", 180)
    grids = [maker.mesh(path, n, *words) for n in range(3)]
    bounds, lut = grids[-1].GetBounds(), quality_table()
    levels = render.table(lambda t: [GREY, (0.99, 0.75, 0.45), RED][round(2 * t)], 0, 2)
    upper, lower = [], []
    for title, grid in zip(["input", "one step", "two steps"], grids):
        cells = f"{title}: {grid.GetNumberOfCells():,} cells"
        coloured = actor_of(exploded(grid, 0.8), "refinement_level", levels)
        upper.append(panel(cells, [coloured], COLUMN_VIEW, bounds))
        half = cut_away(grid, CUT, 0.55)
        lower.append(panel("quality", [actor_of(half, "quality", lut)], COLUMN_VIEW, bounds, lut))
    maker.write("figure-10", [upper, lower], 300, 420)


def tripod(maker, name, words, chosen):
    """Figures 12 and 13: the tripod whole, cut away, and the quality in the cut. `chosen` marks refined cells in red."""
    path = Path(maker.options.data) / "tripod.GiD.msh"
    words = ("--feature-angle", table_1.FEATURE_ANGLE, *words)
    grids = [maker.mesh(path, n, *words) for n in range(3)]
    bounds, lut = grids[0].GetBounds(), quality_table()
    refined = render.table(lambda t: RED if t > 0.4 else PLAIN, 0, 2)
    rows = [[], [], []]
    for n, (title, grid) in enumerate(zip(["input", "one step", "two steps"], grids)):
        look = {"line": [0.7, 0.4, 0 if not chosen else 0.25][n]}
        shown = dict(look, array="refinement_level", lut=refined) if chosen and n else look
        half = cut_away(grid, (0, 1, 0), 0.6)
        creases = feature_edges(grids[0], table_1.FEATURE_ANGLE, 0.22)
        cells = f"{title}: {grid.GetNumberOfCells():,} cells"
        rows[0].append(panel(cells, [actor_of(surface(grid), **shown), creases], TRIPOD_VIEW, bounds))
        rows[1].append(panel("cut away", [actor_of(half, **shown)], TRIPOD_VIEW, bounds))
        quality = actor_of(half, "quality", lut, **look)
        rows[2].append(panel("quality in the cut", [quality], TRIPOD_VIEW, bounds, lut))
    maker.write(name, rows, 380, 340)


def figure_12(maker):
    """Two uniform steps of the tripod."""
    tripod(maker, "figure-12", (), False)


def figure_13(maker):
    """Two adaptive steps of the tripod."""
    cells = table_1.compact_selection(Path(maker.options.data) / "tripod.GiD.msh")
    tripod(maker, "figure-13", ("--select", maker.list("leg.txt", cells)), True)


def figure_1(maker):
    """The elementary stages of one step; cells that a stage made, or whose vertices it moved, in red."""
    path = write_gid(maker.folder / "cube.msh", *bricks((1, 1, 1)))
    frames = maker.folder / "frames"
    maker.mesh(path, 1, "--feature-angle", 180, "--frames", frames)
    wanted = ["input", "1_4_splits", "2_3_flips", "boundary_1_3_splits", "boundary_flips"]
    wanted += ["edge_removals", "boundary_smoothing", "smoothing"]
    files = [sorted(frames.glob(f"frame_*{name}.vtu")) for name in wanted]
    files = [found[0] for found in files[:-1]] + [files[-1][-1]]
    titles = ["input", "1-4 splits", "2-3 flips", "boundary 1-3 splits", "boundary edge flips"]
    titles += ["edge removals", "boundary smoothing", "end of the step"]
    new = render.table(lambda t: RED if t > 0.5 else PLAIN, 0, 1)
    grids = [with_changes(read(file)) for file in files]
    bounds = grids[0].GetBounds()
    panels = []
    for title, grid in zip(titles, grids):
        cells = f"{title}: {grid.GetNumberOfCells():,}"
        panels.append(panel(cells, [actor_of(exploded(grid), "changed", new)], CUBE_VIEW, bounds))
    maker.write("figure-1", [panels[:4], panels[4:]], 300)


def main():
    """Makes what can be made."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("SUBSOLID_DATA"), help="folder with tripod.GiD.msh")
    parser.add_argument("--only", nargs="+", help="numbers of figures")
    parser.add_argument("--subsolid", type=Path, default=ROOT / "target/release/subsolid", help="the program")
    parser.add_argument("--out", type=Path, default=ROOT / "docs/figures", help="folder of the pictures")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    figures = {"1": figure_1, "8": figure_8, "9": figure_9, "10": figure_10}
    if options.data and (Path(options.data) / "tripod.GiD.msh").is_file():
        figures |= {"12": figure_12, "13": figure_13}
    else:
        print("no tripod.GiD.msh by --data or SUBSOLID_DATA: without Figures 12 and 13", file=sys.stderr)
    with tempfile.TemporaryDirectory() as folder:
        for number, figure in figures.items():
            if not options.only or number in options.only:
                figure(Maker(options, folder))


if __name__ == "__main__":
    main()
