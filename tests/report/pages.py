"""Opens the pages of results in Chromium, from disk, and tries what is on them.

    python tests/report/pages.py FOLDER...

Of each report.html: no error and no request to a network; the canvas shows a body; the sliders, the cut, picking, keys and linked
cameras do what they say; what picking shows is what the .vtu files hold, to the rounding that the page states; it fits a phone.
With --approve, the pictures in approved/ are written anew; else they are compared with these. Needs vtk, numpy and playwright
(which drives the Chromium that is installed; it brings none).
"""

import base64
import math
import sys
import tempfile
from pathlib import Path

import numpy as np
from playwright.sync_api import sync_playwright
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

APPROVED = Path(__file__).parent / "approved"
# Pictures that are compared: the name of the folder of results, and what is set before.
PICTURES = {
    "bracket": ("threads-1", "{ field: 'von_mises' }"),
    "bracket-cut": ("threads-1", "{ field: 'error', edges: true, clip: { axis: 'y', at: 0.5, flip: false } }"),
    "bridge": ("bridge", "{ field: 'displacement', edges: true }"),
    "twist-cut": ("twist", "{ field: 'principal_max', edges: true, clip: { axis: 'x', at: 0.5, flip: false } }"),
}
# Largest mean difference of a channel (of 255), and largest share of pixels that differ clearly.
MEAN, CLEAR, SHARE = 3.0, 48, 0.02

BROWSER = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox", "--force-color-profile=srgb"]


def image(page, view=0):
    """The pixels of a canvas, and its PNG file."""
    text = page.evaluate(f"() => {{ const v = subsolid.views[{view}]; v.render(); return v.canvas.toDataURL(); }}")
    png = base64.b64decode(text.split(",")[1])
    return pixels(png), png


def pixels(png):
    with tempfile.NamedTemporaryFile(suffix=".png") as file:
        file.write(png)
        file.flush()
        reader = vtkPNGReader()
        reader.SetFileName(file.name)
        reader.Update()
    data = reader.GetOutput()
    width, height, _ = data.GetDimensions()
    return vtk_to_numpy(data.GetPointData().GetScalars()).reshape(height, width, -1)[..., :3].astype(int)


def difference(a, b):
    """The mean difference of two pictures, and the share of pixels that differ clearly."""
    off = np.abs(a - b)
    return off.mean(), (off.max(axis=2) > CLEAR).mean()


def open_page(browser, file, width=1100, height=900, scheme="light"):
    page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
    faults = []
    page.on("console", lambda m: m.type in ("error", "warning") and "GPU stall" not in m.text and faults.append(m.text))
    page.on("pageerror", lambda e: faults.append(str(e)))
    page.on("request", lambda r: r.url.split(":")[0] not in ("file", "data", "blob") and faults.append(f"asks for {r.url}"))
    page.goto(file.resolve().as_uri())
    page.evaluate("() => subsolid.ready")
    return page, faults


class Step:
    """What a .vtu file holds, by point and by cell."""

    def __init__(self, file):
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(file))
        reader.Update()
        grid = reader.GetOutput()
        self.grid = grid
        self.points = vtk_to_numpy(grid.GetPoints().GetData())
        self.displacement = vtk_to_numpy(grid.GetPointData().GetArray("displacement"))
        self.stress = vtk_to_numpy(grid.GetPointData().GetArray("stress"))
        cell = lambda name: vtk_to_numpy(grid.GetCellData().GetArray(name))
        self.error, self.quality, self.level = (cell(n) for n in ("error_indicator", "quality", "refinement_level"))

    def stresses(self, point):
        """Von Mises' stress, the largest and the smallest principal stress."""
        xx, yy, zz, xy, yz, xz = self.stress[point]
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        deviator = tensor - np.trace(tensor) / 3 * np.eye(3)
        principal = np.linalg.eigvalsh(tensor)
        return np.array([math.sqrt(1.5 * (deviator**2).sum()), principal[-1], principal[0]])

    def middles(self):
        """The mean of the corners of tetrahedra, and of all points of hexahedra."""
        cells = self.grid.GetCells()
        points = vtk_to_numpy(cells.GetConnectivityArray()).reshape(self.grid.GetNumberOfCells(), -1)
        return self.points[points[:, :4] if points.shape[1] in (4, 10) else points].mean(axis=1)


def near(got, want, rounding, what):
    """Equal to the rounding of the page's codes, and of its limits as doubles."""
    worst = np.max(np.abs(np.asarray(got) - want))
    scale = np.max(np.abs(want))
    assert worst <= rounding * (1 + 1e-6) + 1e-12 * scale, f"{what}: {got}, the file has {want}, rounding {rounding}"


def check_values(page, view, step):
    """Picks all over a picture and compares with the file. Gives the number of points that were hit."""
    roundings = {n: page.evaluate(f"n => subsolid.views[{view}].model.rounding(n)", n)
                 for n in ("points", "displacement", "stress", "face_error", "face_quality", "cell_error", "cell_quality")}
    hits = 0
    for x in np.linspace(-0.7, 0.7, 8):
        for y in np.linspace(-0.7, 0.7, 8):
            got = page.evaluate(f"([x, y]) => {{ const v = subsolid.views[{view}]; v.pick(x, y); return v.picked; }}", [float(x), float(y)])
            if got is None:
                continue
            hits += 1
            point, cell, kind = got["point"], got["cell"], "face" if "face" in got["where"] else "cell"
            near(got["position"], step.points[point], roundings["points"], f"place of point {point}")
            near(got["displacement"], step.displacement[point], roundings["displacement"], f"displacement of point {point}")
            near(got["stress"], step.stresses(point), roundings["stress"], f"stress of point {point}")
            near(got["error"], step.error[cell], roundings[f"{kind}_error"], f"error of cell {cell}")
            near(got["quality"], step.quality[cell], roundings[f"{kind}_quality"], f"angle of cell {cell}")
            assert got["level"] == step.level[cell], f"level of cell {cell}"
    assert hits > 4, f"picking met the body {hits} times"
    return hits


def check_body(page, view):
    """The canvas shows something, in many colours, on its ground."""
    picture, _ = image(page, view)
    ground = picture[0, 0]
    covered = (np.abs(picture - ground).max(axis=2) > 8).mean()
    colours = len(np.unique((picture // 4).reshape(-1, 3), axis=0))
    assert 0.02 < covered < 0.9, f"the body covers {covered:.0%} of the canvas"
    assert colours > 40, f"the canvas has {colours} colours"


def slide(page, selector, value):
    page.eval_on_selector(selector, "(e, v) => { e.value = v; e.dispatchEvent(new Event('input')); e.dispatchEvent(new Event('change')); }", value)
    settle(page)


def settle(page):
    page.evaluate("() => new Promise((done) => setTimeout(() => requestAnimationFrame(() => done()), 60))")


def check_controls(page, view, step):
    slide(page, "#deformation", 0)
    still, _ = image(page, view)
    assert page.evaluate("() => subsolid.state.amount") == 0
    slide(page, "#deformation", 1)
    amount = page.evaluate("() => subsolid.state.amount")
    moved = np.abs(step.displacement).max() > 0
    far, _ = image(page, view)
    if moved:
        assert amount > 0 and difference(still, far)[0] > 0.2, "the deformation slider does not move the body"
        place = page.evaluate(f"() => {{ const v = subsolid.views[{view}], m = v.model; return [m.arrays.ids[0], v.place(0), v.origin]; }}")
        want = step.points[place[0]] + amount * step.displacement[place[0]] - place[2]
        assert np.abs(np.array(place[1]) - want).max() < 1e-3 * np.ptp(step.points, axis=0).max(), "points are drawn elsewhere"
    slide(page, "#deformation", 0)

    for field, name in [("quality", "quality"), ("displacement", "displacement")]:
        page.select_option("#field", field)
        settle(page)
        lo, hi = page.evaluate(f"() => subsolid.views[{view}].range('{field}', false)")
        known = np.linalg.norm(step.displacement, axis=1) if name == "displacement" else step.quality
        assert hi <= known.max() * (1 + 1e-4) + 1e-12 and lo >= known.min() - 1e-4 * abs(known.max()), f"colours of {field}"

    page.select_option("#clip-axis", "x")
    settle(page)
    check_cut(page, view, step)
    hits = check_values(page, view, step)
    page.select_option("#clip-axis", "off")
    page.select_option("#field", "von_mises")
    page.evaluate(f"() => subsolid.views[{view}].unpick()")
    settle(page)
    return hits


def check_cut(page, view, step):
    """The cells that stay are those of the file whose middles lie on that side."""
    got = page.evaluate(f"""() => {{ const v = subsolid.views[{view}], m = v.model, s = v.section;
        return {{ kept: s.kept, faces: s.faces.length, all: m.faceCount, inner: s.inner.length, drawn: m.info.cells_drawn,
                  merged: m.info.merged, offset: m.lo[0] + 0.5 * (m.hi[0] - m.lo[0]), cells: m.info.cells }}; }}""")
    assert 0 < got["faces"] < got["all"], "the cut takes nothing away, or all"
    if got["drawn"] == 0:
        return
    assert got["inner"] > 0, "the cut shows no cells"
    if got["merged"] is None and got["drawn"] < 6000:
        want = (step.middles()[:, 0] <= got["offset"]).sum()
        # Cells with their middles in the plane go either way by rounding.
        on = (np.abs(step.middles()[:, 0] - got["offset"]) < 1e-4 * np.ptp(step.points[:, 0])).sum()
        assert abs(got["kept"] - want) <= on, f"{got['kept']} cells stay, {want} of the file lie there"


def check_steps(page, view):
    count = page.evaluate(f"() => subsolid.views[{view}].run.steps.length")
    sliders = page.locator("input.step")
    if count < 2:
        return
    caption = lambda: page.evaluate(f"() => subsolid.views[{view}].caption.textContent")
    before = caption()
    sliders.nth(view).evaluate("e => { e.value = 0; e.dispatchEvent(new Event('input')); }")
    page.wait_for_function(f"() => subsolid.views[{view}].caption.textContent.startsWith('Step 0 ')")
    assert caption() != before
    check_body(page, view)
    sliders.nth(view).evaluate(f"e => {{ e.value = {count - 1}; e.dispatchEvent(new Event('input')); }}")
    page.wait_for_function(f"() => subsolid.views[{view}].caption.textContent.startsWith('Step {count - 1} ')")


def check_cameras(page):
    where = lambda: page.evaluate("() => subsolid.views.map((v) => [...v.camera.position.toArray(), v.camera.zoom])")
    canvas = page.locator("canvas").first
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    before = where()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2 + 60, box["y"] + box["height"] / 2 + 20, steps=4)
    page.mouse.up()
    settle(page)
    turned = where()
    assert not np.allclose(before[0], turned[0]), "dragging does not turn the body"
    for other in turned[1:]:
        assert np.allclose(turned[0], other), f"cameras are not linked: {turned}"
    canvas.focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("+")
    settle(page)
    keyed = where()
    assert not np.allclose(turned[0][:3], keyed[0][:3]) and keyed[0][3] > turned[0][3], "keys do not turn and zoom"
    for other in keyed[1:]:
        assert np.allclose(keyed[0], other), "keys do not turn both pictures"
    page.evaluate("() => subsolid.views[0].home()")


def check_page(browser, folder):
    page, faults = open_page(browser, folder / "report.html")
    milliseconds = page.evaluate("() => performance.now()")
    names = page.evaluate("() => subsolid.views.map((v) => [v.run.name, v.step])")
    hits = 0
    for view, (name, step) in enumerate(names):
        check_body(page, view)
        file = Step(folder / name / f"step_{step:03d}.vtu")
        hits += check_values(page, view, file)
        hits += check_controls(page, view, file)
        check_steps(page, view)
    check_cameras(page)
    assert page.locator("figure svg[aria-label]").count() == page.locator("figure svg").count(), "a plot has no text"
    assert page.locator("figure").count() == page.locator("figure details table").count(), "a plot has no table"
    page.close()
    phone, more = open_page(browser, folder / "report.html", 390, 844, "dark")
    width = phone.evaluate("() => document.documentElement.scrollWidth")
    assert width <= 390, f"on a phone the page is {width} wide"
    check_body(phone, 0)
    faults += more
    phone.close()
    assert not faults, faults
    print(f"{folder.name}: {len(names)} picture(s), {hits} points picked, first picture after {milliseconds:.0f} ms")


def check_picture(browser, name, folder, setting, approve):
    page, faults = open_page(browser, folder / "report.html", 400, 800)
    page.evaluate(f"async () => {{ await subsolid.set({setting}); }}")
    picture, png = image(page)
    page.close()
    file = APPROVED / f"{name}.png"
    if approve:
        file.write_bytes(png)
        return
    wanted = pixels(file.read_bytes())
    assert picture.shape == wanted.shape, f"{name}: {picture.shape}, approved {wanted.shape}"
    mean, clear = difference(picture, wanted)
    if mean > MEAN or clear > SHARE:
        other = folder / f"{name}-now.png"
        other.write_bytes(png)
        raise AssertionError(f"{name}: differs by {mean:.2f} on average, {clear:.1%} of it clearly; see {other} beside {file}")
    print(f"{name}: as approved (mean difference {mean:.2f}, {clear:.2%} of the pixels clearly)")


def main(arguments):
    approve = "--approve" in arguments
    folders = [Path(a) for a in arguments if a != "--approve"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=BROWSER)
        for folder in folders:
            if not approve:
                check_page(browser, folder)
            for name, (of, setting) in PICTURES.items():
                if folder.name == of:
                    check_picture(browser, name, folder, setting, approve)
        browser.close()


def chromium():
    for name in ("chromium", "chromium-browser", "google-chrome"):
        for place in ("/usr/bin", "/usr/local/bin", "/snap/bin"):
            if (Path(place) / name).exists():
                return str(Path(place) / name)
    sys.exit("Chromium is not here (apt install chromium)")


main(sys.argv[1:])
