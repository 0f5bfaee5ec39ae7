"""NGSolve's adaptive loop: averaged stresses as estimate, Doerfler marking, bisection; a line of JSON each step.

adaptive_ngsolve.py MESH.npz [--order 1|2] [--mark 0.3] [--goal ENERGY] [--most-seconds S]

Order 1 is solved by its geometric multigrid, order 2 by its sparse Cholesky factorisation: what was fastest for each. Ends
at the energy `--goal`, or when the time is up. Seconds count from the mesh in memory: imports are done.
"""

import json
import time

import ngsolve as ng
import numpy as np
from ngmesh import build
from task import LAMBDA, MU, TRACTION, arguments, load_mesh, peak_megabytes

# NGSolve stops on the preconditioned residual.
TOLERANCE = 1e-10

args = arguments(__doc__, order=1, mark=0.3, goal=float("inf"), most_seconds=120.0)
ng.ngsglobals.msg_level = 0
ng.SetNumThreads(2)
start = time.perf_counter()
mesh = build(*load_mesh(args.mesh))
space = ng.VectorH1(mesh, order=args.order, dirichlet="fixed")
u, v = space.TnT()
form = ng.BilinearForm(space, symmetric=True)
strains = [ng.Sym(ng.Grad(w)) for w in (u, v)]
# `BFI("elasticity")` is faster, but gives a wrong matrix once the mesh is bisected (6.2.2608).
form += (2 * MU * ng.InnerProduct(*strains) + LAMBDA * ng.div(u) * ng.div(v)) * ng.dx
load = ng.LinearForm(space)
load += ng.InnerProduct(ng.CF(TRACTION), v) * ng.ds("load")
preconditioner = ng.Preconditioner(form, "multigrid", smoother="block") if args.order == 1 else None
solution = ng.GridFunction(space)
tensors = ng.MatrixValued(ng.H1(mesh, order=args.order), symmetric=True)
averaged = ng.GridFunction(tensors)
strain = ng.Sym(ng.Grad(solution))
stress = 2 * MU * strain + LAMBDA * ng.Trace(strain) * ng.Id(3)
off = stress - averaged
complementary = (off - LAMBDA / (3 * LAMBDA + 2 * MU) * ng.Trace(off) * ng.Id(3)) / (2 * MU)
density = ng.InnerProduct(complementary, off)
step = 0
with ng.TaskManager():
    while True:
        if step:
            for each in (space, solution, tensors, averaged):
                each.Update()
        form.Assemble()
        load.Assemble()
        if preconditioner is None:
            inverse = form.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky")
        else:
            inverse = ng.CGSolver(form.mat, preconditioner.mat, tol=TOLERANCE, maxiter=2000)
        solution.vec.data = inverse * load.vec
        energy = 0.5 * ng.InnerProduct(load.vec, solution.vec)
        averaged.Set(stress)
        squared = ng.Integrate(density, mesh, ng.VOL, element_wise=True).NumPy()
        order = np.argsort(-squared)
        shares = np.cumsum(squared[order])
        marked = int(np.searchsorted(shares, args.mark * shares[-1])) + 1
        seconds = time.perf_counter() - start
        line = {
            "version": ng.__version__,
            "step": step,
            "cells": mesh.GetNE(ng.VOL),
            "dofs": space.ndof,
            "seconds": round(seconds, 4),
            "energy": energy,
            "megabytes": round(peak_megabytes()),
        }
        print(json.dumps(line), flush=True)
        if energy >= args.goal or seconds > args.most_seconds:
            break
        flags = np.zeros(mesh.GetNE(ng.VOL), bool)
        flags[order[:marked]] = True
        mesh.ngmesh.Elements3D().NumPy()["refine"] = flags
        mesh.Refine(mark_surface_elements=False)
        step += 1
