"""FreeFEM with its default direct solver.   with_freefem.py MESH.mesh

Its clock counts the seconds of all threads, so that the wall time of its process counts as its solution.
"""

import re
import subprocess
import tempfile
import time
from pathlib import Path

from task import LAMBDA, MU, Timer, arguments, report

PROGRAM = """
verbosity = 0;
mesh3 Th = readmesh3("{mesh}");
fespace Vh(Th, [P1, P1, P1]);
real lam = {lam:.17g}, mu = {mu:.17g};
Vh [u1, u2, u3];
macro eps(u, v, w) [dx(u), dy(v), dz(w), (dz(v)+dy(w))/sqrt(2.), (dz(u)+dx(w))/sqrt(2.), (dy(u)+dx(v))/sqrt(2.)] // EOM
macro div(u, v, w) (dx(u) + dy(v) + dz(w)) // EOM
varf a([u1,u2,u3], [v1,v2,v3]) =
    int3d(Th, qfV=qfV1)(lam*div(u1,u2,u3)*div(v1,v2,v3) + 2.*mu*(eps(u1,u2,u3)'*eps(v1,v2,v3))) + on(1, u1=0, u2=0, u3=0);
varf l([u1,u2,u3], [v1,v2,v3]) = int2d(Th, 2)(-v2) + on(1, u1=0, u2=0, u3=0);
varf force([u1,u2,u3], [v1,v2,v3]) = int2d(Th, 2)(-v2);
matrix A = a(Vh, Vh, sym=0, tgv=-2);
real[int] b = l(0, Vh, tgv=-2);
real[int] f = force(0, Vh);
set(A, solver=sparsesolver);
real[int] x = A^-1*b;
real e = 0.5*(f'*x), um = 0;
for (int i = 0; i < Vh.ndof/3; i++) um = max(um, sqrt(x[3*i]^2 + x[3*i+1]^2 + x[3*i+2]^2));
real[int] r = A*x;
r -= b;
cout.precision(15);
cout << "FOUND " << e << " " << um << " " << r.l2/b.l2 << endl;
"""

args = arguments(__doc__)
with tempfile.TemporaryDirectory() as folder:
    script = Path(folder) / "task.edp"
    script.write_text(PROGRAM.format(mesh=Path(args.mesh).resolve(), lam=LAMBDA, mu=MU))
    timer = Timer()
    start = time.perf_counter()
    command = ["FreeFem++", "-nw", "-v", "0", str(script)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder, check=True)
    timer.seconds["solve"] = time.perf_counter() - start
energy, displaced, residual = map(float, re.search(r"FOUND (.*)", done.stdout).group(1).split())
version = re.search(r"version\s*:?\s*([\d.]+)", done.stdout)
report(
    timer,
    version=version.group(1) if version else "",
    iterations=0,
    residual=residual,
    energy=energy,
    largest=displaced,
)
