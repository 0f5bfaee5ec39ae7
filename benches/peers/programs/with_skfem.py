"""scikit-fem, solved by pyamg, CHOLMOD or PARDISO.   with_skfem.py MESH.npz [--solver pyamg|cholmod|pardiso]"""

import importlib.metadata

import numpy as np
from skfem import Basis, ElementTetP1, ElementVector, FacetBasis, LinearForm, MeshTet, condense
from skfem.models.elasticity import linear_elasticity
from task import (
    FIXED_AT,
    LAMBDA,
    LOADED_AT,
    MU,
    Timer,
    arguments,
    largest,
    load_mesh,
    report,
    rigid_motions,
    solve,
)

args = arguments(__doc__, solver="pyamg")
timer = Timer()
points, tets, _, _ = load_mesh(args.mesh)
mesh = MeshTet(np.ascontiguousarray(points.T), np.ascontiguousarray(tets.T.astype(np.int64)))
timer.lap("load")
element = ElementVector(ElementTetP1())
basis = Basis(mesh, element, intorder=1)
on = [np.intersect1d(np.nonzero((abs(mesh.p[1][mesh.facets] - y) < 1e-5).all(axis=0))[0], mesh.boundary_facets())
      for y in (FIXED_AT, LOADED_AT)]
fixed = basis.get_dofs(on[0]).all()
matrix = linear_elasticity(LAMBDA, MU).assemble(basis)
forces = LinearForm(lambda v, w: -v[1]).assemble(FacetBasis(mesh, element, facets=on[1], intorder=1))
# `enforce` clears rows only, and would leave an unsymmetric matrix.
condensed, rhs, displacement, free = condense(matrix, forces, D=fixed)
condensed = condensed.tocsr()
timer.lap("assemble")
found, iterations = solve(args.solver, condensed, rhs, np.delete(rigid_motions(points), fixed, axis=0))
timer.lap("solve")
displacement[free] = found
report(
    timer,
    version=importlib.metadata.version("scikit-fem"),
    iterations=iterations,
    residual=float(np.linalg.norm(condensed @ found - rhs) / np.linalg.norm(rhs)),
    energy=float(0.5 * forces @ displacement),
    largest=largest(displacement.reshape(-1, 3)),
)
