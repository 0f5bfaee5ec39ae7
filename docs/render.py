#!/usr/bin/env python3
"""Renders a results folder to pictures, without a screen.

    pip install vtk numpy
    python docs/render.py FOLDER [--step N] [--out FOLDER] [--warp X] [--view X Y Z] [--up X Y Z] [--width PIXELS]

The folder is that of a run, such as results/bracket/, or one of the two of a comparison, results/bracket/adaptive/.

VTK may say that it found no X server; it then renders without one. Reads `step_NNN.vtu` (the last one unless told
otherwise) and writes

- `von_mises.png`: the deformed part, coloured by von Mises stress, with the mesh's edges;
- `error_indicator.png`: the error of each cell by hue, from green (low) to red (high) as in Figure 6 of Burkhart,
  Hamann and Umlauf (2011);
- `refined.png`: refined cells in red, as in the same figure; at step 0 the cells selected for refinement;
- `sheet.png`: the three side by side.
"""

import argparse
import colorsys
import sys
from pathlib import Path

import vtkmodules.vtkRenderingFreeType  # noqa: F401  (registers the fonts)
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the renderer)
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkCommonDataModel import VTK_BEZIER_HEXAHEDRON, VTK_LAGRANGE_HEXAHEDRON
from vtkmodules.vtkFiltersCore import vtkExtractEdges
from vtkmodules.vtkFiltersGeneral import vtkWarpVector
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter, vtkUnstructuredGridGeometryFilter
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkTextActor,
    vtkWindowToImageFilter,
)
from vtkmodules.util.numpy_support import vtk_to_numpy

# Yellow to dark red, falling in lightness, so that the mesh's dark edges show where the stress is low: the points of
# ColorBrewer's YlOrRd.
HEAT = ["ffffcc", "ffeda0", "fed976", "feb24c", "fd8d3c", "fc4e2a", "e31a1c", "bd0026", "800026"]
COLOURS = 256


def arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="folder with step_NNN.vtu")
    parser.add_argument("--step", type=int, help="which step (default: the last)")
    parser.add_argument("--out", type=Path, help="where the pictures go (default: the results folder)")
    parser.add_argument("--warp", type=float, help="magnification of the displacement (default: shows 5 %% of the size)")
    parser.add_argument("--view", type=float, nargs=3, default=(1.0, -0.85, 0.6), help="direction from part to camera")
    parser.add_argument("--up", type=float, nargs=3, default=(0, 0, 1), help="what points up")
    parser.add_argument("--width", type=int, default=640, help="pixels a panel")
    return parser.parse_args()


def read(folder, step):
    """The grid of a step and its number."""
    files = sorted(folder.glob("step_*.vtu"))
    if step is not None:
        files = [f for f in files if f.stem == f"step_{step:03d}"]
    if not files:
        sys.exit(f"{folder}: no step_{'*' if step is None else f'{step:03d}'}.vtu")
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(files[-1]))
    reader.Update()
    return reader.GetOutput(), int(files[-1].stem.split("_")[1])


def cell_array(grid, name):
    """A cell array as numpy."""
    array = grid.GetCellData().GetArray(name)
    if array is None:
        sys.exit(f"the file has no cell array {name!r}")
    return vtk_to_numpy(array)


def round_down(x):
    """To one leading digit: 873.2 gives 800."""
    if x < 1:
        return x
    power = 10.0 ** (len(str(int(x))) - 1)
    return x // power * power


def magnification(grid):
    """Shows the largest displacement as 5 % of the part's size."""
    largest = (vtk_to_numpy(grid.GetPointData().GetArray("displacement")) ** 2).sum(axis=1).max() ** 0.5
    return round_down(0.05 * grid.GetLength() / largest) if largest > 0 else 1.0


def surface(grid, warp):
    """The boundary of the deformed grid, cell arrays kept; curved cells in small pieces."""
    grid.GetPointData().SetActiveVectors("displacement")
    deformed = vtkWarpVector()
    deformed.SetInputData(grid)
    deformed.SetInputArrayToProcess(0, 0, 0, 0, "displacement")
    deformed.SetScaleFactor(warp)
    boundary = vtkGeometryFilter()
    boundary.SetInputConnection(deformed.GetOutputPort())
    boundary.SetNonlinearSubdivisionLevel(3 if is_curved(grid) else 1)
    boundary.Update()
    return boundary.GetOutput(), edges(deformed) if is_curved(grid) else None


def is_curved(grid):
    """Whether the cells are Lagrange or Bezier ones."""
    return grid.GetCellType(0) in (VTK_LAGRANGE_HEXAHEDRON, VTK_BEZIER_HEXAHEDRON)


def edges(deformed):
    """The curved edges of boundary cells as lines."""
    faces = vtkUnstructuredGridGeometryFilter()
    faces.SetInputConnection(deformed.GetOutputPort())
    lines = vtkExtractEdges()
    lines.SetInputConnection(faces.GetOutputPort())
    lines.UseAllPointsOn()
    lines.Update()
    return lines.GetOutput()


def table(colour, lo, hi):
    """A lookup table from a function of [0, 1] to red, green, blue."""
    lut = vtkLookupTable()
    lut.SetNumberOfTableValues(COLOURS)
    lut.SetTableRange(lo, hi)
    for i in range(COLOURS):
        lut.SetTableValue(i, *colour(i / (COLOURS - 1)), 1.0)
    return lut


def heat(t):
    """Interpolated between the map's points."""
    at = t * (len(HEAT) - 1)
    low = min(int(at), len(HEAT) - 2)
    a, b = ([int(HEAT[i][j : j + 2], 16) / 255 for j in (0, 2, 4)] for i in (low, low + 1))
    return tuple(x + (at - low) * (y - x) for x, y in zip(a, b))


def green_to_red(t):
    """Hue from 120 degrees (low) to 0 degrees (high): the caption of the paper's Figure 6; its text has it reversed."""
    return colorsys.hsv_to_rgb((1 - t) / 3, 0.85, 0.92)


def grey_or_red(t):
    """Two colours."""
    return (0.85, 0.2, 0.15) if t > 0.5 else (0.82, 0.83, 0.85)


def pictures(grid, step):
    """Name, title, cell array, lookup table, and whether a colour bar makes sense, of each picture."""
    smooth = grid.GetPointData().GetArray("von_mises")
    stress = cell_array(grid, "von_mises") if smooth is None else vtk_to_numpy(smooth)
    error = cell_array(grid, "error_indicator")
    # A few cells at a singular edge would leave the rest in one colour.
    limit = sorted(stress)[int(0.995 * (len(stress) - 1))]
    made = [
        ("von_mises", f"von Mises stress (largest {stress.max():.3g})", "von_mises", table(heat, 0, limit), True),
        ("error_indicator", "Estimated error of each cell", "error_indicator", table(green_to_red, 0, error.max()), True),
    ]
    refined = "refinement_level" if cell_array(grid, "refinement_level").max() > 0 else "marked"
    if grid.GetCellData().HasArray(refined):
        title = "Refined cells" if refined == "refinement_level" else "Cells selected for refinement"
        share = (cell_array(grid, refined) > 0).mean()
        title = f"{title}: {share:.0%} of {len(error):,}, step {step}"
        made.append(("refined", title, refined, table(grey_or_red, 0, 1), False))
    return made


def text(content, size, x, y, centred=True):
    """A line of text at a relative position."""
    actor = vtkTextActor()
    actor.SetInput(content)
    style = actor.GetTextProperty()
    style.SetFontSize(size)
    style.SetColor(0.1, 0.1, 0.1)
    if centred:
        style.SetJustificationToCentered()
    actor.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    actor.SetPosition(x, y)
    return actor


def colour_bar(lut, width):
    """A horizontal colour bar; its title is a text of ours."""
    bar = vtkScalarBarActor()
    bar.SetLookupTable(lut)
    bar.SetOrientationToHorizontal()
    bar.SetNumberOfLabels(4)
    bar.SetLabelFormat("{:.3g}" if vtk_formats_with_braces() else "%.3g")
    bar.UnconstrainedFontSizeOn()
    style = bar.GetLabelTextProperty()
    style.SetColor(0.1, 0.1, 0.1)
    style.SetFontSize(width // 40)
    style.ItalicOff()
    style.BoldOff()
    style.ShadowOff()
    # VTK puts the title of a horizontal bar right above its numbers, without room of their own: it gets a line of its own below.
    bar.SetTextPositionToSucceedScalarBar()
    bar.GetPositionCoordinate().SetValue(0.15, 0.055)
    bar.SetWidth(0.7)
    bar.SetHeight(0.09)
    return bar


def vtk_formats_with_braces():
    """VTK 9.6 went from printf's to std::format's way of writing formats."""
    from vtkmodules.vtkCommonCore import vtkVersion

    return (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) >= (9, 6)


def panel(shown, picture, options, warp):
    """A renderer that shows one picture of a surface, with its own edges or given ones."""
    (mesh, lines), (_, title, array, lut, bar) = shown, picture
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    if mesh.GetPointData().HasArray(array):
        mapper.SetScalarModeToUsePointFieldData()
    else:
        mapper.SetScalarModeToUseCellFieldData()
    mapper.SetColorModeToMapScalars()  # else bytes, such as `marked`, are taken for grey levels
    mapper.SelectColorArray(array)
    mapper.SetLookupTable(lut)
    mapper.UseLookupTableScalarRangeOn()
    actor = vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetInterpolationToFlat()
    look.SetEdgeVisibility(lines is None)
    look.SetEdgeColor(0.2, 0.2, 0.25)
    look.SetLineWidth(0.7)
    look.SetAmbient(0.5)
    look.SetDiffuse(0.55)
    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddActor(actor)
    if lines is not None:
        renderer.AddActor(line_actor(lines))
    renderer.AddViewProp(text(title, min(options.width // 26, int(1.7 * options.width / len(title))), 0.5, 0.94))
    if bar:
        renderer.AddViewProp(colour_bar(lut, options.width))
    below = f"{array} (displacement x {warp:g})" if bar else f"displacement x {warp:g}"
    renderer.AddViewProp(text(below, options.width // 34, 0.5, 0.015))
    aim(renderer, mesh, options)
    return renderer


def line_actor(lines):
    """Dark lines, a little in front of the surface that they lie in."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(lines)
    mapper.ScalarVisibilityOff()
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0, -4)
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.2, 0.2, 0.25)
    actor.GetProperty().SetLineWidth(1.2)
    return actor


def aim(renderer, mesh, options):
    """Points the camera at the part, which fills the panel but for the title and the colour bar."""
    camera = renderer.GetActiveCamera()
    centre = mesh.GetCenter()
    camera.SetFocalPoint(*centre)
    camera.SetPosition(*(c + d for c, d in zip(centre, options.view)))
    camera.SetViewUp(*options.up)
    renderer.ResetCamera()
    camera.SetWindowCenter(0, -0.1)
    camera.Zoom(0.95)


def write(rows, path, width, height=None):
    """Renders rows of panels, each of the given size (square by default), into a file."""
    columns, height = max(len(row) for row in rows), height or width
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(4)
    window.SetSize(width * columns, height * len(rows))
    for j, row in enumerate(rows):
        for i, renderer in enumerate(row):
            bottom = 1 - (j + 1) / len(rows)
            renderer.SetViewport(i / columns, bottom, (i + 1) / columns, bottom + 1 / len(rows))
            window.AddRenderer(renderer)
    window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    writer = vtkPNGWriter()
    writer.SetFileName(str(path))
    writer.SetInputConnection(image.GetOutputPort())
    writer.SetCompressionLevel(9)
    writer.Write()
    print(path)


def main():
    """Reads, renders, writes."""
    options = arguments()
    grid, step = read(options.results, options.step)
    out = options.out or options.results
    out.mkdir(parents=True, exist_ok=True)
    warp = options.warp if options.warp is not None else magnification(grid)
    mesh = surface(grid, warp)
    made = pictures(grid, step)
    for picture in made:
        write([[panel(mesh, picture, options, warp)]], out / f"{picture[0]}.png", options.width)
    write([[panel(mesh, picture, options, warp) for picture in made]], out / "sheet.png", options.width)


if __name__ == "__main__":
    main()
