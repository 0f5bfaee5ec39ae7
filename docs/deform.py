#!/usr/bin/env python3
"""Draws docs/figures/deformation.png, the poses of the bundled deformations: `pip install vtk numpy`, then

    subsolid deform scenarios/deform/cylinder.toml && subsolid deform scenarios/deform/figure.toml
    python3 docs/deform.py
"""

import sys
from pathlib import Path

import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the renderer)
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter

FRAMES = [("cylinder", frame) for frame in (0, 8, 16, 24, 32)] + [("figure", frame) for frame in (0, 10, 20)]
VIEWS = {"cylinder": ((0.6, -1, 0.45), (0, 0, 2.9), 3.3), "figure": ((0.75, -1, 0.4), (2.2, 0.2, 2.1), 2.3)}
COLOURS = {"cylinder": (0.85, 0.55, 0.25), "figure": (0.35, 0.6, 0.8)}


def surface(file):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(file))
    outside = vtkGeometryFilter()
    outside.SetInputConnection(reader.GetOutputPort())
    normals = vtkPolyDataNormals()
    normals.SetInputConnection(outside.GetOutputPort())
    normals.Update()
    return normals.GetOutput()


def main(results):
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(1500, 800)
    for i, (name, frame) in enumerate(FRAMES):
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(surface(results / name / f"frame_{frame:03}.vtu"))
        mapper.ScalarVisibilityOff()
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(COLOURS[name])
        renderer = vtkRenderer()
        renderer.SetBackground(1, 1, 1)
        row, column = (1, i) if name == "cylinder" else (0, i - 5)
        width = 5 if name == "cylinder" else 3
        renderer.SetViewport(column / width, row / 2, (column + 1) / width, (row + 1) / 2)
        renderer.AddActor(actor)
        camera = renderer.GetActiveCamera()
        direction, focus, scale = VIEWS[name]
        camera.SetFocalPoint(focus)
        camera.SetPosition(*[f + 10 * d for f, d in zip(focus, direction)])
        camera.SetViewUp(0, 0, 1)
        camera.ParallelProjectionOn()
        camera.SetParallelScale(scale)
        renderer.ResetCameraClippingRange()
        window.AddRenderer(renderer)
    window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    writer = vtkPNGWriter()
    writer.SetFileName(str(Path(__file__).parent / "figures" / "deformation.png"))
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()


main(Path(sys.argv[1] if len(sys.argv) > 1 else "results"))
