#!/usr/bin/env python3
"""The robustness campaign: makes models, compares three global and three adaptive steps on each, and writes docs/robustness.md.

    python3 docs/robustness.py [--models 3000] [--first 1] [--jobs 2] [--subsolid target/release/subsolid] [--keep DIR]

Needs the program built and Gmsh's wheel (pip install gmsh). Each model has a number, which makes the same model everywhere; those that fail are kept in DIR
with their scenario.
"""

import argparse
import collections
import concurrent.futures
import hashlib
import json
import math
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "robustness.md"
# Limits of one program run: seconds of computing, seconds in all, bytes.
COMPUTING = 300
SECONDS = 3600
BYTES = 6 << 30
# Relative change of the volume beyond rounding, and beyond what moving vertices on faces makes that are tilted by less than 3e-4.
ROUNDING, TILTED = 1e-12, 1e-7
# A tenth of the models is run on these numbers of threads too.
THREADS = [1, 2, 8]
FORMATS = ["msh", "msh2", "msh-binary", "inp", "mesh", "vtk"]


def primitive(occ, rng):
    """A random solid of about unit size near the origin: its tag."""
    at = [rng.uniform(-0.5, 0.5) for _ in range(3)]
    size = [rng.uniform(0.4, 1.5) for _ in range(3)]
    kind = rng.choice(["box", "sphere", "cylinder", "cone", "torus", "wedge"])
    if kind == "box":
        return occ.addBox(*at, *size)
    if kind == "sphere":
        return occ.addSphere(*at, 0.5 * size[0])
    if kind == "cylinder":
        return occ.addCylinder(*at, *size, rng.uniform(0.15, 0.5))
    if kind == "cone":
        return occ.addCone(*at, *size, rng.uniform(0.3, 0.6), rng.uniform(0.05, 0.25))
    if kind == "torus":
        return occ.addTorus(*at, rng.uniform(0.4, 0.7), rng.uniform(0.1, 0.3))
    return occ.addWedge(*at, *size, -1, rng.uniform(0.1, 0.9) * size[0])


def make(number, folder):
    """Meshes a random body of one to three primitives; its file's name."""
    import gmsh

    rng = random.Random(number)
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    occ = gmsh.model.occ
    bodies = [(3, primitive(occ, rng)) for _ in range(rng.randint(1, 3))]
    while len(bodies) > 1:
        join = rng.choice([occ.fuse, occ.fuse, occ.cut, occ.intersect, occ.fragment])
        found, _ = join(bodies[:1], bodies[1:2])
        solids = [entity for entity in found if entity[0] == 3]
        if not solids:
            raise RuntimeError("nothing is left of the body")
        bodies = (solids if join is not occ.fragment else solids[:1] + solids[1:]) if len(bodies) == 2 else solids[:1] + bodies[2:]
        if len(bodies) > 1 and join is occ.fragment:
            break
    occ.synchronize()
    # Regions where a body was cut into parts.
    for i, entity in enumerate(gmsh.model.getEntities(3)):
        gmsh.model.addPhysicalGroup(3, [entity[1]], name=f"part{i}")
    surfaces = [tag for _, tag in gmsh.model.getEntities(2)]
    if rng.random() < 0.5:
        gmsh.model.addPhysicalGroup(2, rng.sample(surfaces, rng.randint(1, len(surfaces))), name="some")
    gmsh.option.setNumber("Mesh.MeshSizeMin", rng.uniform(0.6, 1.0))
    gmsh.option.setNumber("Mesh.MeshSizeMax", rng.uniform(1.0, 2.0))
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", rng.choice([0, 0, 0, 4]))
    gmsh.option.setNumber("Mesh.Algorithm3D", rng.choice([1, 1, 10]))
    gmsh.option.setNumber("Mesh.Optimize", rng.choice([0, 1]))
    gmsh.model.mesh.generate(3)
    kind = rng.choice(FORMATS)
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2 if kind == "msh2" else 4.1)
    gmsh.option.setNumber("Mesh.Binary", int(kind == "msh-binary"))
    name = "model." + kind.replace("msh2", "msh").replace("-binary", "")
    gmsh.write(str(folder / name))
    gmsh.finalize()
    return name


def generated(rng):
    """A body that the program makes: the [mesh] of a scenario."""
    n = lambda least, most: rng.randint(least, most)
    size = [round(rng.uniform(0.3, 3.0), 3) for _ in range(3)]
    return rng.choice(
        [
            f"[mesh.box]\nsize = {size}\ncells = [{n(1, 4)}, {n(1, 3)}, {n(1, 3)}]\n",
            f"[mesh.cylinder]\nradius = {size[0]}\nlength = {size[1]}\ncells = [{n(1, 2)}, {n(1, 4)}]\n",
            f"[mesh.tube]\nradii = [{size[0]}, {size[0] + size[1]}]\nlength = {size[2]}\ncells = [1, {n(3, 6)}, {n(1, 2)}]\n",
            f"[mesh.sphere-shell]\nradii = [{size[0]}, {size[0] + size[1]}]\ncells = [{n(1, 2)}, {n(1, 3)}]\n",
        ]
    )


def scenario(number, mesh):
    """A body held at one end and pulled at the other, in random directions, with random choices of all that refinement has."""
    rng = random.Random(f"scenario {number}")
    axis = [rng.gauss(0, 1) for _ in range(3)]
    length = math.hypot(*axis)
    axis = [round(x / length, 6) for x in axis]
    against = [-x for x in axis]
    # Red refinement has no adaptive half to compare with.
    scheme = rng.choice(["sqrt3", "sqrt3", "longest-edge"])
    optimise = rng.choice(['objective = "error"', 'objective = "quality"', 'mode = "paper"'])
    element = rng.choice(["tet4", "tet4", "tet4", "tet10"])
    return (
        f"title = \"model {number}\"\n{mesh}\n[materials.m]\nyoungs_modulus = 1000\npoissons_ratio = {rng.choice([0, 0.3, 0.45])}\n\n"
        f"[supports.hold]\nnormal = {{ direction = {against}, angle = 75 }}\nfix = [\"x\", \"y\", \"z\"]\n\n"
        f"[loads.pull]\nnormal = {{ direction = {axis}, angle = 60 }}\ntraction = {[round(rng.gauss(0, 1), 3) for _ in range(3)]}\n\n"
        f"[analysis]\nelement = \"{element}\"\n\n"
        f"[refine]\nscheme = \"{scheme}\"\nsteps = 3\noptimise = {{ {optimise} }}\nstop = {{ max_cells = 20000 }}\n\n"
        f"[adapt]\ngrow = {rng.choice([0, 1])}\nmarking = {rng.choice(['{ doerfler = 0.5 }', '{ fraction = 0.2 }', '{ maximum = 0.5 }'])}\n"
    )


def limited():
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (COMPUTING, COMPUTING))


def program(arguments, cwd):
    """Runs it under the limits: code, standard error, seconds."""
    start = time.monotonic()
    try:
        done = subprocess.run(arguments, cwd=cwd, capture_output=True, text=True, timeout=SECONDS, preexec_fn=limited)
        return done.returncode, done.stderr, time.monotonic() - start
    except subprocess.TimeoutExpired:
        return None, "", time.monotonic() - start


def digests(folder):
    files = sorted(folder.rglob("*.vtu"))
    return [(str(f.relative_to(folder)), hashlib.sha256(f.read_bytes()).hexdigest()) for f in files]


def faults_of(report):
    """What a report must not say: inverted cells, features lost, volume changed."""
    found, first = [], report["steps"][0]
    for step in report["steps"]:
        if step["quality"]["inverted"]:
            found.append("inverted cells")
        if abs(step["feature_length"] - first["feature_length"]) > 1e-9 * first["feature_length"]:
            found.append("lost features")
        if volume_change([first, step]) > TILTED:
            found.append("changed volume")
    return found


def volume_change(steps):
    return max(abs(step["volume"] / steps[0]["volume"] - 1) for step in steps)


def trial(number, subsolid, keep):
    """One model: a record of what became of it."""
    folder = Path(tempfile.mkdtemp(prefix=f"model-{number}-"))
    record = {"number": number, "faults": [], "cells": 0, "seconds": 0.0, "volume": 0.0}
    try:
        rng = random.Random(f"kind {number}")
        if rng.random() < 0.8:
            line = [sys.executable, __file__, "--make", str(number), str(folder)]
            try:
                done = subprocess.run(line, capture_output=True, text=True, timeout=60)
                name = done.stdout.strip().splitlines()[-1] if done.returncode == 0 and done.stdout.strip() else None
            except subprocess.TimeoutExpired:
                name = None
            if name is None:
                return {**record, "outcome": "not meshed"}
            record["kind"] = "Gmsh, " + name.split(".")[-1]
            mesh = f"[mesh]\nfile = \"{name}\"\n"
        else:
            record["kind"] = "generated"
            mesh = generated(rng)
        (folder / "model.toml").write_text(scenario(number, mesh))
        results = folder / "results"
        base = [subsolid, "compare", "model.toml", "--quiet", "--output", results]
        code, said, seconds = program([*base, "--threads", "1", "--set", "output.vtk=false"], folder)
        record.update(code=code, seconds=seconds)
        if code is None:
            record["faults"].append("time limit")
        elif code == -signal.SIGXCPU or code == -signal.SIGKILL:
            record["faults"].append("time limit")
        elif code < 0 or code == 101 or "panicked" in said:
            record["faults"].append("crash")
        elif code != 0:
            words = " ".join(said.replace("│", " ").split())
            record["reason"] = words[:200]
            if (results / "compare.json").exists():
                record["faults"].append("results of a refused run")
        else:
            reports = json.loads((results / "compare.json").read_text())
            for report in (reports["global"], reports["adaptive"]):
                record["faults"] += faults_of(report)
                record["volume"] = max(record["volume"], volume_change(report["steps"]))
                record["cells"] = max(record["cells"], report["steps"][-1]["cells"])
        if code == 0 and number % 10 == 0:
            bytes_of = []
            for threads in THREADS:
                shutil.rmtree(results, ignore_errors=True)
                program([*base, "--threads", str(threads)], folder)
                bytes_of.append(digests(results))
            record["compared"] = True
            if not bytes_of[0] or any(other != bytes_of[0] for other in bytes_of[1:]):
                record["faults"].append("other bytes on other threads")
        record["faults"] = sorted(set(record["faults"]))
        record["outcome"] = "failed" if record["faults"] else "done" if code == 0 else "refused"
        if record["faults"] and keep:
            shutil.copytree(folder, keep / f"model-{number}", dirs_exist_ok=True)
        return record
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def first_words(reason):
    """The class of a refusal: its message without numbers."""
    text = reason.split("help:")[0]
    text = "".join("N" if c.isdigit() else c for c in text)
    while "NN" in text:
        text = text.replace("NN", "N")
    return text.replace("×", "").strip()[:110]


def page(records, seconds):
    of = lambda outcome: [r for r in records if r["outcome"] == outcome]
    made = [r for r in records if r["outcome"] != "not meshed"]
    faults = collections.Counter(fault for r in records for fault in r["faults"])
    kinds = collections.Counter(r["kind"] for r in made)
    compared = [r for r in made if r.get("compared")]
    refusals = collections.Counter(first_words(r["reason"]) for r in of("refused"))
    wanted = ["crash", "time limit", "inverted cells", "lost features", "changed volume", "other bytes on other threads", "results of a refused run"]
    lines = [
        "Written by `docs/robustness.py`, which makes models of one to three random CAD primitives, joined, cut, intersected or in parts, meshes them by Gmsh with",
        "random sizes into random formats, or takes bodies that the program makes; holds each at one end, pulls it at the other, and lets `subsolid compare` make three",
        "global and three adaptive steps with a random scheme, optimiser, element and marking (up to 20,000 cells), each solved, with at most 6 GB and 300 seconds of computing.",
        "Every tenth is run on 1, 2 and 8 threads. Boundaries are fixed: volumes and feature edges have to stay. Where neighbouring faces are tilted by less than",
        "3e-4 (CAD kernels and files round), optimisation takes them for one plane and slides vertices on it: volumes may change by the square of that.",
        "",
        f"{len(records)} numbers, {len(made)} models ({len(records) - len(made)} could not be meshed by Gmsh), {sum(r['seconds'] for r in made) / 60:.0f} minutes of computing.",
        "",
        "| | models |",
        "|---|---|",
        f"| both refinements done | {len(of('done'))} |",
        f"| refused with a message | {len(of('refused'))} |",
        *[f"| {name} | {faults.get(name, 0)} |" for name in wanted],
        f"| volume kept to {ROUNDING:g} | {sum(r['volume'] <= ROUNDING for r in of('done'))} |",
        f"| volume kept to {TILTED:g}, the largest change being {max((r['volume'] for r in made), default=0):.1e} | {sum(ROUNDING < r['volume'] <= TILTED for r in of('done'))} |",
        f"| compared on {', '.join(map(str, THREADS))} threads | {len(compared)} |",
        "",
        f"Largest mesh: {max((r['cells'] for r in made), default=0):,} cells. Models by origin: "
        + ", ".join(f"{kind} {count}" for kind, count in sorted(kinds.items())) + ".",
        "",
        "Reasons of refusals:",
        "",
        "| message | models |",
        "|---|---|",
        *[f"| {reason} | {count} |" for reason, count in refusals.most_common()],
        "",
    ]
    before, _, after = PAGE.read_text().split("<!-- campaign -->")
    text = "\n".join(lines)
    PAGE.write_text(f"{before}<!-- campaign -->\n{text}<!-- campaign -->{after}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--models", type=int, default=3000)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--subsolid", type=Path, default=ROOT / "target" / "release" / "subsolid")
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--records", type=Path, help="write the records of all models there, and go on from those there")
    parser.add_argument("--make", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.make:
        print(make(int(arguments.make[0]), Path(arguments.make[1])))
        return
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
    start, records = time.monotonic(), []
    if arguments.records and arguments.records.exists():
        records = [json.loads(line) for line in arguments.records.read_text().splitlines()]
    known = {r["number"] for r in records}
    numbers = [n for n in range(arguments.first, arguments.first + arguments.models) if n not in known]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        runs = [pool.submit(trial, n, arguments.subsolid.resolve(), arguments.keep) for n in numbers]
        for run in concurrent.futures.as_completed(runs):
            record = run.result()
            records.append(record)
            if arguments.records:
                with arguments.records.open("a") as file:
                    file.write(json.dumps(record) + "\n")
            if record["faults"]:
                print(record, flush=True)
            if len(records) % 100 == 0:
                print(len(records), collections.Counter(r["outcome"] for r in records), flush=True)
    records.sort(key=lambda r: r["number"])
    page(records, time.monotonic() - start)


main()
