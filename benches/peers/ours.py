"""Runs Subsolid beside the other programs: its scenarios, its whole process, its report."""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCENARIO = """
[mesh]
file = "{mesh}"

[features]
angle = 70

[materials.part]
youngs_modulus = 1000.0
poissons_ratio = 0.3

[supports.feet]
group = "fixed"
fix = ["x", "y", "z"]

[loads.top]
group = "load"
traction = [0.0, -1.0, 0.0]

{tables}
[output]
vtk = false
"""
ONE_STEP = '[refine]\nstrategy = "none"\n'


def make_meshes(name, folder, levels, data=None, most_text=3):
    """Makes them in a process of its own: the peak memory of a process counts that of the one that began it."""
    script = Path(__file__).resolve().parent / "meshes.py"
    options = ["--levels", *levels, "--most-text", most_text, *(["--data", data] if data else [])]
    subprocess.run([str(word) for word in (sys.executable, script, name, folder, *options)], check=True)


def measured(command, environment=None, timeout=None, allowed=(0,)):
    """Runs a command; its standard output, wall seconds, processor seconds, peak megabytes of its largest process.

    Raises `RuntimeError` with the end of what it wrote if it ends otherwise than `allowed` or takes longer than `timeout` seconds.
    """
    command = [str(word) for word in command]
    environment = os.environ | (environment or {})
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        start = time.perf_counter()
        process = subprocess.Popen(command, stdout=out, stderr=err, env=environment, start_new_session=True)
        status, usage = waited(process, timeout)
        wall = time.perf_counter() - start
        out.seek(0)
        err.seek(0)
        if status not in allowed:
            raise RuntimeError(err.read()[-400:].strip() or f"ended with status {status}")
        return out.read(), wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def waited(process, timeout):
    """Status and resources of a process at its end; its whole session is ended when the time is up."""
    until = time.perf_counter() + timeout if timeout else None
    while True:
        flags = os.WNOHANG if until else 0
        pid, status, usage = os.wait4(process.pid, flags)
        if pid:
            process.returncode = os.waitstatus_to_exitcode(status)
            return process.returncode, usage
        if time.perf_counter() > until:
            os.killpg(process.pid, 9)
            os.wait4(process.pid, 0)
            process.returncode = -9
            raise RuntimeError(f"took more than {timeout:g} s")
        time.sleep(0.001)


def run(program, mesh, tables=ONE_STEP, sets=(), threads=2):
    """The report of `subsolid run` on a mesh, with `tables` of its scenario and `sets` of its keys, and what it took."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = Path(folder) / "scenario.toml"
        scenario.write_text(SCENARIO.format(mesh=Path(mesh).resolve(), tables=tables))
        out = Path(folder) / "out"
        command = [program, "run", scenario, "--quiet", "--threads", threads, "--output", out]
        command += [word for key in sets for word in ("--set", key)]
        # 7: a tolerance was not reached, as in the time that a scenario allows.
        _, wall, processor, megabytes = measured(command, allowed=(0, 7))
        report = json.loads((out / "report.json").read_text())
    return report, {"process": wall, "processor": processor, "megabytes": megabytes}


def forecast(program, mesh, tables=ONE_STEP):
    """What `subsolid check --json` says of the same scenario."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = Path(folder) / "scenario.toml"
        scenario.write_text(SCENARIO.format(mesh=Path(mesh).resolve(), tables=tables))
        out, *_ = measured([program, "check", scenario, "--json", "-"])
    return json.loads(out)
