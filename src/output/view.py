"""Shows the results in this folder with ParaView: deformed, coloured by the von Mises stress, at the last step.

Usage: pvpython view.py [SCALE]     (displacements are multiplied by SCALE, default 1)
"""

import os
import sys

from paraview.simple import (
    ColorBy,
    GetActiveViewOrCreate,
    GetAnimationScene,
    Interact,
    PVDReader,
    ResetCamera,
    Show,
    WarpByVector,
)

folder = os.path.dirname(os.path.abspath(__file__))
results = PVDReader(FileName=os.path.join(folder, "results.pvd"))
scene = GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()
scene.GoToLast()

view = GetActiveViewOrCreate("RenderView")
deformed = WarpByVector(Input=results)
deformed.Vectors = ["POINTS", "displacement"]
deformed.ScaleFactor = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0
display = Show(deformed, view)
display.SetRepresentationType("Surface With Edges")
ColorBy(display, ("CELLS", "von_mises"))
display.RescaleTransferFunctionToDataRange(True)
display.SetScalarBarVisibility(view, True)
ResetCamera()
Interact()
