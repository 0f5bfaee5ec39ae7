"""MFEM, serial: conjugate gradients with Gauss-Seidel, the best its wheel has.   with_mfem.py MESH_22.msh"""

import importlib.metadata

import mfem.ser as mfem
import numpy as np
from task import LAMBDA, MU, TRACTION, Timer, arguments, largest, report

# It stops on the preconditioned residual.
TOLERANCE = 3e-9

args = arguments(__doc__)
timer = Timer()
mesh = mfem.Mesh(args.mesh, 1, 1)
timer.lap("load")
elements = mfem.H1_FECollection(1, 3)
space = mfem.FiniteElementSpace(mesh, elements, 3, mfem.Ordering.byVDIM)
fixed = mfem.intArray()
space.GetEssentialTrueDofs(mfem.intArray([1, 0, 0]), fixed)
traction = mfem.VectorArrayCoefficient(3)
for axis, value in enumerate(TRACTION):
    traction.Set(axis, mfem.PWConstCoefficient(mfem.Vector([0.0, value, 0.0])))
load = mfem.LinearForm(space)
load.AddBoundaryIntegrator(mfem.VectorBoundaryLFIntegrator(traction))
solution = mfem.GridFunction(space)
solution.Assign(0.0)
load.Assemble()
form = mfem.BilinearForm(space)
form.AddDomainIntegrator(
    mfem.ElasticityIntegrator(mfem.ConstantCoefficient(LAMBDA), mfem.ConstantCoefficient(MU))
)
form.Assemble()
matrix, rhs, found = mfem.SparseMatrix(), mfem.Vector(), mfem.Vector()
form.FormLinearSystem(fixed, solution, load, matrix, found, rhs)
timer.lap("assemble")
smoother = mfem.GSSmoother(matrix)
solver = mfem.CGSolver()
solver.SetOperator(matrix)
solver.SetPreconditioner(smoother)
solver.SetRelTol(TOLERANCE)
solver.SetMaxIter(20000)
solver.SetPrintLevel(0)
solver.Mult(rhs, found)
timer.lap("solve")
rest = mfem.Vector(rhs.Size())
matrix.Mult(found, rest)
rest -= rhs
form.RecoverFEMSolution(found, load, solution)
values = solution.GetDataArray()
report(
    timer,
    version=importlib.metadata.version("mfem"),
    iterations=solver.GetNumIterations(),
    residual=rest.Norml2() / rhs.Norml2(),
    energy=0.5 * float(np.dot(load.GetDataArray(), values)),
    largest=largest(values.reshape(-1, 3)),
)
