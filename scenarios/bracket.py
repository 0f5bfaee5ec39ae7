#!/usr/bin/env python3
"""Models the mounting bracket of `bracket.toml` and meshes it into `bracket.msh` (Gmsh 4.1, ASCII).

    pip install gmsh==4.15.2
    python scenarios/bracket.py [OUT.msh]

Needed only to change the part: the mesh is kept beside this script. Lengths in millimetres; z points up.

                 z
              .--|--.            an upright flange 14 thick with a bore of 30 for a bearing at height 50, the bore cut
             /  ( )  \           at its mid-height so that the lower half can carry the shaft;
            |    |    |          a base plate 12 thick with two bolt holes of 13 and chamfered outer corners;
            |    |rib |          a fillet of 10 in the inner corner and a rib of 10 on the middle plane.
         ---'----+----'------ x, y

Same script, same Gmsh, same bytes: one thread, fixed seeds.
"""

import math
import sys
from pathlib import Path

import gmsh

LENGTH, WIDTH, PLATE = 70.0, 60.0, 12.0  # base plate: x from 0 to LENGTH, y from -WIDTH/2 to WIDTH/2
FLANGE = 14.0  # thickness of the flange, x from 0
BORE_HEIGHT, BORE = 50.0, 30.0  # centre height and diameter of the bearing's bore
BOLT_X, BOLT_Y, BOLT = 50.0, 17.0, 13.0  # positions (y: plus and minus) and diameter of the bolt holes
CHAMFER = 10.0  # outer corners of the base plate, seen from above
FILLET = 10.0  # radius in the inner corner
RIB_WIDTH, RIB_LENGTH, RIB_HEIGHT = 10.0, 18.0, 18.0  # RIB_HEIGHT = RIB_LENGTH: a slope of 45 degrees
SIZE = 9.0  # largest edge in the bulk, mm; the holes ask for less around them
# Chords a full circle gets. Twelve keep the turn from chord to chord (30 degrees) below the default feature angle of
# 40 degrees, so that a hole's wall is smooth and its rim a feature.
CHORDS = 12
ARC = 6.0  # longest chord on the rims of bore and crown, so that both look round


def box(lo, hi):
    """Tag of an axis-parallel box."""
    return gmsh.model.occ.addBox(*lo, *(h - l for h, l in zip(hi, lo)))


def prism(corners, direction):
    """Tag of the solid that a polygon sweeps."""
    occ = gmsh.model.occ
    points = [occ.addPoint(*c) for c in corners]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1])]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    return next(tag for dim, tag in occ.extrude([(2, face)], *direction) if dim == 3)


def fillet():
    """Tag of the concave wedge between plate and flange."""
    occ = gmsh.model.occ
    lo = (FLANGE, -WIDTH / 2, PLATE)
    corner = box(lo, (FLANGE + FILLET, WIDTH / 2, PLATE + FILLET))
    tool = occ.addCylinder(FLANGE + FILLET, -WIDTH / 2, PLATE + FILLET, 0, WIDTH, 0, FILLET)
    return occ.cut([(3, corner)], [(3, tool)])[0][0][1]


def half_bore(bottom, top):
    """Tag of the part of the bore's cylinder between two heights."""
    occ = gmsh.model.occ
    cylinder = occ.addCylinder(-1, 0, BORE_HEIGHT, FLANGE + 2, 0, 0, BORE / 2)
    slab = box((-1, -BORE, bottom), (FLANGE + 1, BORE, top))
    return occ.intersect([(3, cylinder)], [(3, slab)])[0][0][1]


def model():
    """Builds the solid; returns its tag."""
    occ = gmsh.model.occ
    half = WIDTH / 2
    plate = prism(
        [
            (0, -half, 0),
            (LENGTH - CHAMFER, -half, 0),
            (LENGTH, -half + CHAMFER, 0),
            (LENGTH, half - CHAMFER, 0),
            (LENGTH - CHAMFER, half, 0),
            (0, half, 0),
        ],
        (0, 0, PLATE),
    )
    flange = box((0, -half, 0), (FLANGE, half, BORE_HEIGHT))
    crown = occ.addCylinder(0, 0, BORE_HEIGHT, FLANGE, 0, 0, half)
    rib = prism(
        [
            (FLANGE, -RIB_WIDTH / 2, PLATE),
            (FLANGE + RIB_LENGTH, -RIB_WIDTH / 2, PLATE),
            (FLANGE, -RIB_WIDTH / 2, PLATE + RIB_HEIGHT),
        ],
        (0, RIB_WIDTH, 0),
    )
    solids = [(3, t) for t in (flange, crown, fillet(), rib)]
    fused, _ = occ.fuse([(3, plate)], solids)
    # The bore is cut by two half cylinders, which leave its wall in two surfaces.
    halves = [half_bore(BORE_HEIGHT - BORE, BORE_HEIGHT), half_bore(BORE_HEIGHT, BORE_HEIGHT + BORE)]
    bolts = [occ.addCylinder(BOLT_X, y, -1, 0, 0, PLATE + 2, BOLT / 2) for y in (-BOLT_Y, BOLT_Y)]
    solid, _ = occ.cut(fused, [(3, t) for t in (*halves, *bolts)])
    occ.removeAllDuplicates()
    occ.synchronize()
    (only,) = gmsh.model.getEntities(3)
    return only[1]


def on_cylinder(surface, axis, centre, radius):
    """Whether a surface is part of the cylinder about `axis` (0, 1, 2) through `centre`."""
    if gmsh.model.getType(2, surface) != "Cylinder":
        return False
    lo, hi = gmsh.model.getParametrizationBounds(2, surface)
    point = gmsh.model.getValue(2, surface, [(a + b) / 2 for a, b in zip(lo, hi)])
    across = [p - c for i, (p, c) in enumerate(zip(point, centre)) if i != axis]
    return abs(math.hypot(*across) - radius) < 1e-6


def mean_z(surface):
    """Height of a surface's centre of mass."""
    return gmsh.model.occ.getCenterOfMass(2, surface)[2]


def name_groups(solid):
    """Physical groups: what the scenario calls by name. Other boundary faces belong to none."""
    surfaces = [tag for _, tag in gmsh.model.getEntities(2)]
    bore = [s for s in surfaces if on_cylinder(s, 0, (0, 0, BORE_HEIGHT), BORE / 2)]
    bolts = [s for s in surfaces for y in (-BOLT_Y, BOLT_Y) if on_cylinder(s, 2, (BOLT_X, y, 0), BOLT / 2)]
    groups = {
        "base": [s for s in surfaces if abs(mean_z(s)) < 1e-6],
        "bolt-holes": bolts,
        "bearing": [s for s in bore if mean_z(s) < BORE_HEIGHT],
        "bearing-cap": [s for s in bore if mean_z(s) > BORE_HEIGHT],
    }
    for name, tags in groups.items():
        assert tags, f"no surface for {name}"
        gmsh.model.addPhysicalGroup(2, tags, name=name)
    gmsh.model.addPhysicalGroup(3, [solid], name="bracket")


def mesh():
    """Meshes the solid with four-node tetrahedra."""
    options = {
        "General.NumThreads": 1,
        "Mesh.RandomSeed": 1,
        "Mesh.MeshSizeMax": SIZE,
        "Mesh.MeshSizeFromCurvature": CHORDS,
        "Mesh.MeshSizeExtendFromBoundary": 1,
        "Mesh.Algorithm": 6,  # frontal Delaunay
        "Mesh.Algorithm3D": 1,  # Delaunay
        "Mesh.ElementOrder": 1,
        "Mesh.Optimize": 1,
        "Mesh.OptimizeThreshold": 0.5,
        "Mesh.OptimizeNetgen": 1,
    }
    for name, value in options.items():
        gmsh.option.setNumber(name, value)
    for _, curve in gmsh.model.getEntities(1):
        length = gmsh.model.occ.getMass(1, curve)
        if gmsh.model.getType(1, curve) == "Circle" and length > BORE:
            gmsh.model.mesh.setTransfiniteCurve(curve, math.ceil(length / ARC) + 1)
    gmsh.model.mesh.generate(3)
    for _ in range(2):
        gmsh.model.mesh.optimize("")
        gmsh.model.mesh.optimize("Netgen")
    gmsh.model.mesh.renumberNodes()
    gmsh.model.mesh.renumberElements()


def round_coordinates(digits=6):
    """Rounds to a nanometre: what lies in a plane of the drawing then has that plane's coordinate exactly (OpenCASCADE
    leaves noise such as 1e-17 or 11.999999999999998), so planes are flat to the last bit and the file is short."""
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    for tag, i in zip(tags, range(0, len(xyz), 3)):
        point = [round(float(x), digits) + 0.0 for x in xyz[i : i + 3]]  # + 0.0 turns -0.0 into 0.0
        gmsh.model.mesh.setNode(tag, point, [])


def report(path):
    """Prints what was made."""
    tets = gmsh.model.mesh.getElementsByType(4)[0]
    nodes = gmsh.model.mesh.getNodes()[0]
    angles = gmsh.model.mesh.getElementQualities(tets, "minSICN")
    volumes = gmsh.model.mesh.getElementQualities(tets, "volume")
    print(f"{path}: {len(tets)} tetrahedra, {len(nodes)} nodes, volume {sum(volumes):.3f} mm^3")
    print(f"worst signed inverse condition number {min(angles):.3f}")
    for dim, tag in gmsh.model.getPhysicalGroups():
        entities = gmsh.model.getEntitiesForPhysicalGroup(dim, tag)
        count = sum(len(gmsh.model.mesh.getElements(dim, e)[1][0]) for e in entities)
        print(f"  {gmsh.model.getPhysicalName(dim, tag)}: {count} {'triangles' if dim == 2 else 'tetrahedra'}")


def main():
    """Models, meshes, writes."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_suffix(".msh")
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("bracket")
    name_groups(model())
    mesh()
    round_coordinates()
    report(path)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 0)
    gmsh.option.setNumber("Mesh.SaveAll", 0)
    gmsh.write(str(path))
    gmsh.finalize()


if __name__ == "__main__":
    main()
