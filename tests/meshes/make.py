"""Writes the files of this folder: one part in every format. Needs gmsh, meshio and vtk (pip install gmsh meshio vtk)."""

from pathlib import Path

import gmsh
import meshio
import vtk

here = Path(__file__).parent
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.add("part")
gmsh.model.occ.addBox(0, 0, 0, 1.9, 1.1, 0.9)
gmsh.model.occ.addBox(1.9, 0, 0, 1.1, 1.1, 0.9)
gmsh.model.occ.fragment([(3, 1)], [(3, 2)])
gmsh.model.occ.synchronize()
at = lambda x: [t for _, t in gmsh.model.getEntities(2) if abs(gmsh.model.occ.getCenterOfMass(2, t)[0] - x) < 1e-9]
gmsh.model.addPhysicalGroup(3, [1], 1, "steel")
gmsh.model.addPhysicalGroup(3, [2], 2, "rubber")
gmsh.model.addPhysicalGroup(2, at(0), 11, "held")
gmsh.model.addPhysicalGroup(2, at(3), 12, "pulled")
gmsh.option.setNumber("Mesh.MeshSizeMin", 0.9)
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.9)
gmsh.model.mesh.generate(3)


def save(name, **options):
    defaults = {"MshFileVersion": 4.1, "Binary": 0, "SaveGroupsOfElements": 1, "SaveElementTagType": 2}
    for key, value in (defaults | options).items():
        gmsh.option.setNumber("Mesh." + key, value)
    gmsh.write(str(here / name))


save("gmsh22.msh", MshFileVersion=2.2)
save("gmsh22_binary.msh", MshFileVersion=2.2, Binary=1)
save("gmsh41.msh")
save("gmsh41_binary.msh", Binary=1)
save("gmsh.inp")
save("gmsh.mesh")
save("gmsh.vtk")
save("gmsh_binary.vtk", Binary=1)

part = meshio.read(here / "gmsh22.msh")
part.write(here / "meshio.inp")
part.write(here / "meshio.mesh")
part.write(here / "meshio_ascii.vtk", binary=False)
part.write(here / "meshio.vtk")
part.write(here / "meshio_ascii.vtu", binary=False)
part.write(here / "meshio_raw.vtu", compression=None)
part.write(here / "meshio.vtu")

reader = vtk.vtkXMLUnstructuredGridReader()
reader.SetFileName(str(here / "meshio.vtu"))
reader.Update()
grid = reader.GetOutput()
grid.GetCellData().RemoveArray("gmsh:geometrical")


def save_vtu(name, mode, compressor, big_endian=False, header=64):
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(str(here / name))
    writer.SetInputData(grid)
    {"ascii": writer.SetDataModeToAscii, "inline": writer.SetDataModeToBinary}.get(mode, writer.SetDataModeToAppended)()
    writer.SetEncodeAppendedData(mode == "appended base64")
    {None: writer.SetCompressorTypeToNone, "zlib": writer.SetCompressorTypeToZLib, "lz4": writer.SetCompressorTypeToLZ4}[compressor]()
    (writer.SetByteOrderToBigEndian if big_endian else writer.SetByteOrderToLittleEndian)()
    (writer.SetHeaderTypeToUInt64 if header == 64 else writer.SetHeaderTypeToUInt32)()
    writer.Write()


save_vtu("vtk_ascii.vtu", "ascii", None)
save_vtu("vtk_inline.vtu", "inline", None)
save_vtu("vtk_inline_zlib.vtu", "inline", "zlib", header=32)
save_vtu("vtk_raw.vtu", "appended raw", None, big_endian=True)
save_vtu("vtk_raw_lz4.vtu", "appended raw", "lz4")
save_vtu("vtk_base64_zlib.vtu", "appended base64", "zlib")

for version, number in (("42", 42), ("51", 51)):
    for binary in (False, True):
        writer = vtk.vtkUnstructuredGridWriter()
        writer.SetFileName(str(here / f"vtk{version}{'_binary' if binary else ''}.vtk"))
        writer.SetInputData(grid)
        writer.SetFileVersion(number)
        (writer.SetFileTypeToBinary if binary else writer.SetFileTypeToASCII)()
        writer.Write()

gmsh.option.setNumber("Mesh.PartitionCreateTopology", 1)
gmsh.model.mesh.partition(2)
save("partitioned.msh")
save("partitioned_binary.msh", Binary=1)
gmsh.finalize()
