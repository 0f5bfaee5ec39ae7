"""DOLFINx and PETSc, on one rank or, by mpirun, on two.   with_dolfinx.py MESH.npz [--solver gamg|mumps]"""

import dolfinx
import numpy as np
import ufl
from dolfinx import fem, la
from dolfinx import mesh as meshes
from mpi4py import MPI
from petsc4py import PETSc
from task import (
    FIXED_AT,
    LAMBDA,
    LOADED_AT,
    MU,
    RESIDUAL,
    TRACTION,
    Timer,
    arguments,
    largest,
    load_mesh,
    peak_megabytes,
    report,
)

OPTIONS = {
    "mumps": {"mat_mumps_icntl_7": 5},  # METIS
    "gamg": {
        "ksp_norm_type": "unpreconditioned",
        "pc_gamg_type": "agg",
        "pc_gamg_threshold": 0.01,
        "pc_gamg_coarse_eq_limit": 500,
        "mg_levels_ksp_type": "chebyshev",
        "mg_levels_pc_type": "jacobi",
        "mg_levels_ksp_max_it": 2,
    },
}


def near_null_space(space, comm):
    """The six rigid motions, orthonormal: without them GAMG takes ten times the iterations."""
    x, y, z = space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local].T
    vectors = [la.create_petsc_vector(space.dofmap.index_map, space.dofmap.index_map_bs) for _ in range(6)]
    turns = ((0, -y, 1, x), (1, -z, 2, y), (0, z, 2, -x))
    for k, vector in enumerate(vectors):
        rows = vector.array.reshape(-1, 3)
        if k < 3:
            rows[:, k] = 1
        else:
            i, a, j, b = turns[k - 3]
            rows[:, i], rows[:, j] = a, b
    for i, vector in enumerate(vectors):
        for other in vectors[:i]:
            vector.axpy(-vector.dot(other), other)
        vector.normalize()
    return PETSc.NullSpace().create(vectors=vectors, comm=comm)


args = arguments(__doc__, solver="gamg")
timer = Timer()
comm = MPI.COMM_WORLD
points, tets = np.zeros((0, 3)), np.zeros((0, 4), np.int64)
if comm.rank == 0:
    points, tets, _, _ = load_mesh(args.mesh)
cell = ufl.Cell("tetrahedron", geometric_dimension=3)
domain = ufl.Mesh(ufl.VectorElement("Lagrange", cell, 1))
mesh = meshes.create_mesh(comm, tets.astype(np.int64), points, domain)
timer.lap("load")
space = fem.VectorFunctionSpace(mesh, ("CG", 1))
bottom, top = (
    meshes.locate_entities_boundary(mesh, 2, lambda x, y=y: np.isclose(x[1], y, atol=1e-5)) for y in (FIXED_AT, LOADED_AT)
)
tags = meshes.meshtags(mesh, 2, np.sort(top), np.full(len(top), 2, np.int32))
ds = ufl.Measure("ds", domain=mesh, subdomain_data=tags)
u, v = ufl.TrialFunction(space), ufl.TestFunction(space)


def strain(w):
    return ufl.sym(ufl.grad(w))


stress = 2 * MU * strain(u) + LAMBDA * ufl.tr(strain(u)) * ufl.Identity(3)
compiled = {"cffi_extra_compile_args": ["-O3", "-march=native"]}
form = fem.form(ufl.inner(stress, strain(v)) * ufl.dx, jit_params=compiled)
traction = fem.Constant(mesh, PETSc.ScalarType(TRACTION))
load = fem.form(ufl.dot(traction, v) * ds(2), jit_params=compiled)
fixed = fem.dirichletbc(np.zeros(3), fem.locate_dofs_topological(space, 2, bottom), space)
timer.lap("assemble")
matrix = fem.petsc.assemble_matrix(form, bcs=[fixed])
matrix.assemble()
matrix.setOption(PETSc.Mat.Option.SPD, True)
forces = fem.petsc.assemble_vector(load)
forces.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
rhs = forces.copy()
fem.petsc.set_bc(rhs, [fixed])
timer.lap("assemble")
solver = PETSc.KSP().create(comm)
solver.setOperators(matrix)
options = PETSc.Options()
for name, value in OPTIONS[args.solver].items():
    options[name] = value
if args.solver == "mumps":
    solver.setType("preonly")
    solver.getPC().setType("cholesky")
    solver.getPC().setFactorSolverType("mumps")
else:
    solver.setType("cg")
    solver.setTolerances(rtol=RESIDUAL, max_it=10000)
    matrix.setNearNullSpace(near_null_space(space, comm))
    solver.getPC().setType("gamg")
solver.setFromOptions()
solution = rhs.duplicate()
solver.solve(rhs, solution)
timer.lap("solve")
rest = rhs.duplicate()
matrix.mult(solution, rest)
rest.axpy(-1.0, rhs)
values = solution.array.reshape(-1, 3)
figures = {
    "version": f"{dolfinx.__version__}, PETSc {'.'.join(map(str, PETSc.Sys.getVersion()))}",
    "iterations": solver.getIterationNumber() if args.solver == "gamg" else 0,
    "residual": rest.norm() / rhs.norm(),
    "energy": 0.5 * forces.dot(solution),
    "largest": comm.allreduce(largest(values) if len(values) else 0.0, op=MPI.MAX),
    "megabytes": comm.allreduce(peak_megabytes(), op=MPI.SUM),
}
timer.seconds = {k: comm.allreduce(s, op=MPI.MAX) for k, s in timer.seconds.items()}
timer.processor = {k: comm.allreduce(s, op=MPI.SUM) for k, s in timer.processor.items()}
if comm.rank == 0:
    report(timer, **figures)
