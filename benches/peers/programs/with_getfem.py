"""GetFEM, solved by MUMPS.   with_getfem.py MESH_22.msh"""

import getfem
import numpy as np
from task import FIXED_AT, LAMBDA, LOADED_AT, MU, TRACTION, Timer, arguments, largest, report

FIXED, LOADED = 1, 2

args = arguments(__doc__)
getfem.util_trace_level(0)
timer = Timer()
mesh = getfem.Mesh("import", "gmsh", args.mesh)
mesh.optimize_structure()
timer.lap("load")
outer = set(map(tuple, mesh.outer_faces().T))
for region, y in ((FIXED, FIXED_AT), (LOADED, LOADED_AT)):
    near = mesh.faces_from_pid(np.nonzero(abs(mesh.pts()[1] - y) < 1e-5)[0])
    mesh.set_region(region, np.array([f for f in map(tuple, near.T) if f in outer]).T)
space = getfem.MeshFem(mesh, 3)
space.set_classical_fem(1)
quadrature = getfem.MeshIm(mesh, 1)
model = getfem.Model("real")
model.add_fem_variable("u", space)
model.add_initialized_data("lambda", LAMBDA)
model.add_initialized_data("mu", MU)
model.add_isotropic_linearized_elasticity_brick(quadrature, "u", "lambda", "mu")
model.add_Dirichlet_condition_with_simplification("u", FIXED)
model.add_initialized_data("t", list(TRACTION))
model.add_source_term_brick(quadrature, "u", "t", LOADED)
model.assembly()
timer.lap("assemble")
# Assembles a second time.
model.solve("lsolver", "mumps")
timer.lap("solve")
density = "0.5*(lambda*sqr(Trace(Grad_u))+2*mu*(Sym(Grad_u):Sym(Grad_u)))"
report(
    timer,
    version=getattr(getfem, "__version__", ""),
    iterations=0,
    energy=float(getfem.asm("generic", quadrature, 0, density, -1, model)),
    largest=largest(model.variable("u").reshape(-1, 3)),
)
