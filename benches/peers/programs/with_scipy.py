"""No finite element package: a matrix assembled by NumPy and handed to PARDISO, CHOLMOD or pyamg.

with_scipy.py MESH.npz [--solver pardiso|cholmod|pyamg]
"""

import numpy as np
import scipy
from task import Timer, arguments, fixed_components, largest, load_mesh, load_vector, report, rigid_motions, solve, stiffness

args = arguments(__doc__, solver="pardiso")
timer = Timer()
points, tets, faces, marks = load_mesh(args.mesh)
timer.lap("load")
forces = load_vector(points, faces, marks)
free = np.setdiff1d(np.arange(len(forces)), fixed_components(faces, marks))
matrix = stiffness(points, tets)[free][:, free].tocsr()
timer.lap("assemble")
found, iterations = solve(args.solver, matrix, forces[free], rigid_motions(points)[free])
timer.lap("solve")
displacement = np.zeros(len(forces))
displacement[free] = found
report(
    timer,
    version=scipy.__version__,
    iterations=iterations,
    residual=float(np.linalg.norm(matrix @ found - forces[free]) / np.linalg.norm(forces[free])),
    energy=float(0.5 * forces @ displacement),
    largest=largest(displacement.reshape(-1, 3)),
)
