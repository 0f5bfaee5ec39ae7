"""Writes the curved_* files of this folder: a round bar of curved ten-node cells in every format that has them. Needs gmsh
and meshio (pip install gmsh meshio)."""

from pathlib import Path

import gmsh
import meshio

here = Path(__file__).parent
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.add("bar")
gmsh.model.occ.addCylinder(0, 0, 0, 2, 0, 0, 0.7)
gmsh.model.occ.synchronize()
gmsh.model.addPhysicalGroup(3, [1], 1, "steel")
gmsh.option.setNumber("Mesh.MeshSizeMin", 1)
gmsh.option.setNumber("Mesh.MeshSizeMax", 1)
gmsh.option.setNumber("Mesh.SecondOrderLinear", 0)
gmsh.model.mesh.generate(3)
gmsh.model.mesh.setOrder(2)


def save(name, version=4.1, binary=0):
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.write(str(here / name))


save("curved22.msh", 2.2)
save("curved41_binary.msh", binary=1)
save("curved.inp")
save("curved.mesh")
save("curved.vtk")
meshio.read(here / "curved22.msh").write(here / "curved.vtu")
gmsh.finalize()
