"""A mesh of NGSolve from points, tetrahedra, boundary triangles and their marks."""

import netgen.meshing as nm
import numpy as np
from ngsolve import Mesh


def build(points, tets, faces, marks):
    mesh = nm.Mesh(dim=3)
    mesh.AddPoints(np.ascontiguousarray(points))
    for mark, name in ((1, "fixed"), (2, "load"), (3, "free")):
        mesh.Add(nm.FaceDescriptor(surfnr=mark, domin=1, domout=0, bc=mark))
        mesh.SetBCName(mark - 1, name)
    mesh.SetMaterial(1, "solid")
    mesh.AddElements(dim=3, index=1, data=np.ascontiguousarray(tets[:, [0, 1, 3, 2]]), base=0)
    for mark in (1, 2, 3):
        if (marks == mark).any():
            mesh.AddElements(dim=2, index=mark, data=np.ascontiguousarray(faces[marks == mark]), base=0)
    return Mesh(mesh)
