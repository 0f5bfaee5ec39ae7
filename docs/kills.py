#!/usr/bin/env python3
"""Kills runs at random moments, and fills the disk under them; resumes them; writes the part of docs/robustness.md about it.

    python3 docs/kills.py [--kills 50] [--scenario scenarios/bracket.toml] [--subsolid target/release/subsolid]

Needs the program built; the full disk needs a Linux system where this may mount a tmpfs (root).
"""

import argparse
import hashlib
import random
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "robustness.md"


def digests(folder):
    """The solution: names and hashes of the files that do not tell times."""
    files = sorted([*folder.glob("*.vtu"), *folder.glob("*.pvd"), *folder.glob("*.csv")])
    return {f.name: hashlib.sha256(f.read_bytes()).hexdigest() for f in files}


def line(program, scenario, folder, *more):
    return [program, "run", scenario, "--quiet", "--output", folder, *more]


def whole(program, folder):
    """What of a folder's files is not whole."""
    found = []
    for file in folder.glob("*.vtu"):
        code = subprocess.run([program, "inspect", file, "--quiet"], capture_output=True).returncode
        if code != 0:
            found.append(f"{file.name} is damaged")
    collection = folder / "results.pvd"
    if collection.exists():
        for name in collection.read_text().split('file="')[1:]:
            if not (folder / name.split('"')[0]).exists():
                found.append("results.pvd lists a file that is not there")
    return found


def finish(program, scenario, folder, unbroken):
    """Goes on with a run that was ended: what is wrong with its results, and whether there was a checkpoint."""
    resumed = (folder / "checkpoint.bin").exists()
    done = subprocess.run(line(program, scenario, folder, *(["--resume"] if resumed else [])), capture_output=True, text=True)
    if done.returncode != 0:
        return [f"ends with {done.returncode}: {done.stderr[:200]}"], resumed
    faults = [f"left behind: {f.name}" for f in folder.iterdir() if f.name.startswith(".") or f.name == "checkpoint.bin"]
    return faults + ([] if digests(folder) == unbroken else ["other bytes"]), resumed


def killed(program, scenario, seconds, unbroken, count):
    rng, faults, resumed = random.Random(1), [], 0
    for i in range(count):
        folder = Path(tempfile.mkdtemp()) / "results"
        child = subprocess.Popen(line(program, scenario, folder), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(rng.uniform(0, seconds))
        child.kill()
        child.wait()
        if folder.exists():
            faults += whole(program, folder)
        wrong, had_one = finish(program, scenario, folder, unbroken)
        faults += wrong
        resumed += had_one
        print(f"kill {i + 1}: resumed {had_one}, faults {faults}", flush=True)
        shutil.rmtree(folder.parent)
    return faults, resumed


def filled(program, scenario, unbroken, sizes):
    """Runs on file systems that are too small, then made large enough: faults, and how the first runs ended."""
    faults, codes, resumed = [], [], 0
    for kilobytes in sizes:
        disk = Path(tempfile.mkdtemp())
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", disk], check=True)
        try:
            folder = disk / "results"
            codes.append(subprocess.run(line(program, scenario, folder), capture_output=True).returncode)
            if folder.exists():
                faults += whole(program, folder)
            subprocess.run(["mount", "-o", "remount,size=1g", disk], check=True)
            wrong, had_one = finish(program, scenario, folder, unbroken)
            faults += wrong
            resumed += had_one
            print(f"{kilobytes} kB: code {codes[-1]}, resumed {had_one}, faults {faults}", flush=True)
        finally:
            subprocess.run(["umount", disk], check=True)
            disk.rmdir()
    return faults, codes, resumed


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--scenario", type=Path, default=ROOT / "scenarios" / "bracket.toml")
    parser.add_argument("--subsolid", type=Path, default=ROOT / "target" / "release" / "subsolid")
    arguments = parser.parse_args()
    program, scenario = arguments.subsolid.resolve(), arguments.scenario.resolve()
    with tempfile.TemporaryDirectory() as folder:
        start = time.monotonic()
        subprocess.run(line(program, scenario, folder), check=True)
        seconds, unbroken = time.monotonic() - start, digests(Path(folder))
        total = sum(f.stat().st_size for f in Path(folder).iterdir())
    kill_faults, resumed = killed(program, scenario, seconds, unbroken, arguments.kills)
    sizes = [int(total / 1024 * share) for share in (0.02, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95)]
    disk_faults, codes, went_on = filled(program, scenario, unbroken, sizes)
    name = scenario.relative_to(ROOT)
    text = (
        f"Written by `docs/kills.py`. `{name}` was killed (kill -9) at {arguments.kills} random moments: {resumed} of these runs had a checkpoint and were\n"
        f"resumed, the others begun again. Files that were not whole, results with other bytes than those of an unbroken run: {len(kill_faults)}.\n"
        f"On {len(sizes)} file systems with room for 2 to 95 % of the results the run ended with the exit codes {', '.join(map(str, sorted(set(codes))))}; with room made, "
        f"{went_on} were resumed. Files\nthat were not whole, other bytes: {len(disk_faults)}.\n"
    )
    for fault in kill_faults + disk_faults:
        text += f"- {fault}\n"
    before, _, after = PAGE.read_text().split("<!-- kills -->")
    PAGE.write_text(f"{before}<!-- kills -->\n{text}<!-- kills -->{after}")


main()
