"""What the programs have in common: the problem, the timer, and the one line of JSON that each prints.

E = 1000, nu = 0.3; faces marked 1 are fixed, those marked 2 bear the traction (0, -1, 0). Residual 1e-8.
"""

import argparse
import json
import resource
import sys
import time

YOUNG, POISSON = 1e3, 0.3
LAMBDA, MU = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))
TRACTION = (0.0, -1.0, 0.0)
RESIDUAL = 1e-8
FIXED_AT, LOADED_AT = -10.0, 13.0  # y of the tripod's feet and top


def arguments(doc, **choices):
    """`mesh`, and options given by their defaults."""
    parser = argparse.ArgumentParser(description=doc)
    parser.add_argument("mesh")
    for name, default in choices.items():
        parser.add_argument(f"--{name.replace('_', '-')}", type=type(default), default=default)
    return parser.parse_args()


class Timer:
    """Wall and processor seconds of the stages; imports are done when it starts."""

    def __init__(self):
        self.seconds, self.processor = {}, {}
        self.last = time.perf_counter(), time.process_time()

    def lap(self, stage):
        now = time.perf_counter(), time.process_time()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now[0] - self.last[0]
        self.processor[stage] = self.processor.get(stage, 0.0) + now[1] - self.last[1]
        self.last = now


def report(timer, **figures):
    """Prints the figures: seconds of load, assemble and solve, and whatever else is known."""
    figures["seconds"] = {k: round(v, 4) for k, v in timer.seconds.items()}
    figures["processor"] = {k: round(v, 4) for k, v in timer.processor.items()}
    figures.setdefault("megabytes", peak_megabytes())
    print(json.dumps(figures), flush=True)


def peak_megabytes():
    """Of this process, or of its largest child."""
    who = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return max(resource.getrusage(w).ru_maxrss for w in who) / 1024


def note(text):
    print(f"# {text}", file=sys.stderr, flush=True)


def load_mesh(path):
    """Points, tetrahedra, boundary triangles, their marks."""
    import numpy as np

    data = np.load(path)
    return data["X"], data["T"], data["F"], data["M"]


def largest(displacements):
    """The largest length among rows."""
    import numpy as np

    return float(np.linalg.norm(displacements, axis=1).max())


def stiffness(points, tets):
    """The matrix of all components, three a node, from vectorised gradients."""
    import numpy as np
    import scipy.sparse as sp

    corners = points[tets]
    jacobians = corners[:, 1:] - corners[:, :1]
    gradients = np.empty((len(tets), 4, 3))
    gradients[:, 1:] = np.linalg.inv(jacobians).transpose(0, 2, 1)
    gradients[:, 0] = -gradients[:, 1:].sum(axis=1)
    volumes = np.abs(np.linalg.det(jacobians)) / 6
    products = np.einsum("eai,ebi->eab", gradients, gradients)
    blocks = LAMBDA * np.einsum("eai,ebj->eaibj", gradients, gradients)
    blocks += MU * np.einsum("eaj,ebi->eaibj", gradients, gradients)
    for i in range(3):
        blocks[:, :, i, :, i] += MU * products
    blocks *= volumes[:, None, None, None, None]
    unknowns = (3 * tets[:, :, None].astype(np.int32) + np.arange(3, dtype=np.int32)).reshape(len(tets), 12)
    rows, columns = np.repeat(unknowns, 12, axis=1).ravel(), np.tile(unknowns, (1, 12)).ravel()
    return sp.coo_matrix((blocks.ravel(), (rows, columns)), shape=(3 * len(points),) * 2).tocsr()


def load_vector(points, faces, marks):
    """Forces of the traction at the nodes."""
    import numpy as np

    loaded = faces[marks == 2]
    a, b, c = (points[loaded[:, i]] for i in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    forces = np.zeros((len(points), 3))
    for k in range(3):
        np.add.at(forces, loaded[:, k], areas[:, None] / 3 * np.array(TRACTION))
    return forces.ravel()


def fixed_components(faces, marks):
    import numpy as np

    return (3 * np.unique(faces[marks == 1])[:, None] + np.arange(3)).ravel()


def rigid_motions(points):
    """The six rigid motions as columns."""
    import numpy as np

    x, y, z = (points - points.mean(axis=0)).T
    motions = np.zeros((len(points), 3, 6))
    motions[:, 0, 0] = motions[:, 1, 1] = motions[:, 2, 2] = 1
    motions[:, 0, 3], motions[:, 1, 3] = -y, x
    motions[:, 1, 4], motions[:, 2, 4] = -z, y
    motions[:, 2, 5], motions[:, 0, 5] = -x, z
    return motions.reshape(3 * len(points), 6)


def solve(solver, matrix, forces, motions):
    """The solution of the free components' equations, and iterations: by pyamg, CHOLMOD with METIS, or PARDISO."""
    import scipy.sparse as sp

    if solver == "pardiso":
        import pypardiso

        upper = sp.triu(matrix, format="csr")
        upper.sort_indices()
        return pypardiso.PyPardisoSolver(mtype=2).solve(upper, forces).ravel(), 0
    if solver == "cholmod":
        from sksparse.cholmod import cholesky

        return cholesky(matrix.tocsc(), ordering_method="metis", mode="auto")(forces), 0
    import pyamg
    from pyamg.krylov import cg

    sweep = ("block_gauss_seidel", {"sweep": "symmetric"})
    # The default coarse solver is a dense pseudo-inverse of thousands of unknowns, so the coarsest level is kept small.
    levels = pyamg.smoothed_aggregation_solver(
        matrix.tobsr((3, 3)),
        B=motions,
        symmetry="symmetric",
        strength=("symmetric", {"theta": 0.08}),
        smooth=("jacobi", {"omega": 4.0 / 3.0}),
        presmoother=sweep,
        postsmoother=sweep,
        max_coarse=50,
        coarse_solver="splu",
        improve_candidates=None,
    )
    residuals = []
    solution, _ = cg(
        matrix, forces, tol=RESIDUAL, M=levels.aspreconditioner(cycle="V"), maxiter=1000, residuals=residuals
    )
    return solution, len(residuals) - 1
