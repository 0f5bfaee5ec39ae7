#!/usr/bin/env python3
"""Meshes lever.step into lever.msh with Gmsh, and names what the scenario speaks of.

    pip install gmsh==4.15.2
    python mesh.py [SIZE]               SIZE: largest edge of a tetrahedron, in the units of the file (4)
"""

import math
import sys
from pathlib import Path

import gmsh

HERE = Path(__file__).resolve().parent


def cylinders(radius):
    """The surfaces that are cylinders of a radius."""
    found = []
    for _, surface in gmsh.model.getEntities(2):
        if gmsh.model.getType(2, surface) == "Cylinder":
            lo, hi = gmsh.model.getParametrizationBounds(2, surface)
            # The curvature of a cylinder is one over its radius.
            (curvature,) = gmsh.model.getCurvature(2, surface, [(a + b) / 2 for a, b in zip(lo, hi)])
            if math.isclose(1 / curvature, radius, rel_tol=1e-6):
                found.append(surface)
    assert found, f"no cylinder of radius {radius}"
    return found


gmsh.initialize(interruptible=False)
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("General.NumThreads", 1)
gmsh.model.occ.importShapes(str(HERE / "lever.step"))
gmsh.model.occ.synchronize()

# Surfaces that get a name are the scenario's groups, volumes its regions.
gmsh.model.addPhysicalGroup(2, cylinders(6.0), name="shaft")
gmsh.model.addPhysicalGroup(2, cylinders(4.0), name="pin")
gmsh.model.addPhysicalGroup(3, [tag for _, tag in gmsh.model.getEntities(3)], name="lever")

gmsh.option.setNumber("Mesh.MeshSizeMax", float(sys.argv[1]) if len(sys.argv) > 1 else 4.0)
gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 16)  # edges to a full circle
gmsh.option.setNumber("Mesh.OptimizeNetgen", 1)
gmsh.model.mesh.generate(3)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
gmsh.write(str(HERE / "lever.msh"))
print(f"lever.msh: {len(gmsh.model.mesh.getElementsByType(4)[0])} tetrahedra")
gmsh.finalize()
