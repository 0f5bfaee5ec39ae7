"""NGSolve on two threads.   with_ngsolve.py MESH.npz [--solver sparsecholesky|pardiso|mg] [--refine K]

`mg` is its geometric multigrid: the mesh given is refined K times by NGSolve itself, whose octahedra are cut along other
diagonals, so that its energies differ.
"""

import ngsolve as ng
import numpy as np
from ngmesh import build
from task import LAMBDA, MU, POISSON, TRACTION, YOUNG, Timer, arguments, largest, load_mesh, report

# NGSolve stops on the preconditioned residual; with 1e-9 the true one was 2.8e-8.
TOLERANCE = 1e-10

args = arguments(__doc__, solver="sparsecholesky", refine=0)
ng.ngsglobals.msg_level = 0
ng.SetNumThreads(2)
timer = Timer()
with ng.TaskManager():
    mesh = build(*load_mesh(args.mesh))
    timer.lap("load")
    geometric = args.solver == "mg"
    # Its hand-written integrator on blocks of three is several times faster than the symbolic form.
    space = ng.VectorH1(mesh, order=1, dirichlet="fixed") if geometric else ng.H1(mesh, order=1, dirichlet="fixed", dim=3)
    u, v = space.TnT()
    form = ng.BilinearForm(space) if geometric else ng.BilinearForm(space, symmetric=True)
    if geometric:
        strain = [ng.Sym(ng.Grad(w)) for w in (u, v)]
        form += (2 * MU * ng.InnerProduct(*strain) + LAMBDA * ng.div(u) * ng.div(v)) * ng.dx
    else:
        form += ng.BFI("elasticity", coef=[YOUNG, POISSON])
    load = ng.LinearForm(space)
    load += ng.InnerProduct(ng.CF(TRACTION), v) * ng.ds("load")
    preconditioner = (
        ng.Preconditioner(form, "multigrid", smoother="block", coarsetype="direct") if geometric else None
    )
    solution = ng.GridFunction(space)
    for level in range(args.refine + 1):
        if level:
            mesh.ngmesh.Refine()
            space.Update()
            solution.Update()
            timer.lap("load")
        form.Assemble()
        timer.lap("assemble")
    load.Assemble()
    timer.lap("assemble")
    iterations = 0
    if geometric:
        inverse = ng.CGSolver(form.mat, preconditioner.mat, tol=TOLERANCE, maxiter=5000)
    else:
        inverse = form.mat.Inverse(space.FreeDofs(), inverse=args.solver)
    solution.vec.data = inverse * load.vec
    timer.lap("solve")
    if geometric:
        iterations = inverse.GetSteps()
    rest = load.vec.CreateVector()
    rest.data = load.vec - form.mat * solution.vec
    rest.data = ng.Projector(space.FreeDofs(), True) * rest
    values = np.array(solution.vec.FV().NumPy())
    values = values.reshape(3, -1).T if geometric else values.reshape(-1, 3)
    report(
        timer,
        version=ng.__version__,
        iterations=iterations,
        residual=ng.Norm(rest) / ng.Norm(load.vec),
        energy=0.5 * ng.InnerProduct(load.vec, solution.vec),
        largest=largest(values),
    )
