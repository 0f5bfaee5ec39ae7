"""Makes the gallery: a page and a picture of each bundled scenario.

    python docs/gallery.py [--program target/release/subsolid] [SCENARIO...]

Runs the scenarios (the bracket and the tripod as comparisons) into results/gallery/, whose pages open in any browser, and takes the
pictures in docs/gallery/ of them, and docs/report.png. Needs playwright (pip install playwright) and the Chromium of the system; the tripod needs its
mesh (SUBSOLID_DATA), and is left out without it.
"""

import argparse
import subprocess
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parent.parent
# What is set before the picture is taken.
SETTINGS = {
    "bracket": "{}",
    "bent_bracket": "{ edges: true }",
    "bridge": "{ edges: true }",
    "cantilever": "{ field: 'principal_max' }",
    "fichera": "{ field: 'error', edges: true }",
    "le10": "{ field: 'uz' }",
    "shell": "{ edges: true }",
    "tripod": "{ edges: true, field: 'level' }",
    "tube": "{}",
    "twist": "{ edges: true, clip: { axis: 'x', at: 0.5, flip: false } }",
}
COMPARED = {"bracket", "tripod"}
FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]


def run(program, name, folder):
    command = "compare" if name in COMPARED else "run"
    # Relative, as it stands in the page.
    scenario = f"scenarios/{name}.toml"
    done = subprocess.run([program, command, scenario, "--quiet", "--output", folder], cwd=ROOT)
    return done.returncode == 0


def picture(browser, page_file, setting, out):
    page = browser.new_page(viewport={"width": 700, "height": 900})
    page.goto(page_file.as_uri())
    page.evaluate("() => subsolid.ready")
    page.evaluate(f"async () => {{ await subsolid.set({setting}); }}")
    page.locator(".pictures").screenshot(path=out)
    page.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=ROOT / "target/release/subsolid")
    parser.add_argument("scenarios", nargs="*", default=sorted(SETTINGS))
    options = parser.parse_args()
    (ROOT / "docs/gallery").mkdir(exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        for name in options.scenarios:
            folder = ROOT / "results/gallery" / name
            if not run(options.program, name, folder):
                print(f"{name}: left out, it did not run", file=sys.stderr)
                continue
            picture(browser, folder / "report.html", SETTINGS[name], ROOT / "docs/gallery" / f"{name}.png")
            print(folder / "report.html")
            if name == "bracket":
                page = browser.new_page(viewport={"width": 1280, "height": 860})
                page.goto((folder / "report.html").as_uri())
                page.evaluate("() => subsolid.ready")
                page.screenshot(path=ROOT / "docs/report.png")
                page.close()
        browser.close()


main()
