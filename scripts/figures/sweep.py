"""The parameter sweep of docs/disney.md: one row of spheres per parameter, which goes from 0 to 1 from left to right.

Every row has an orthographic camera of the parameter's name; all rows stand far apart on one grey floor under one studio.
"""

import math

import image
from glb import Glb, unit
from shapes import Shape, floor

STEPS, SPACING, APART = 11, 2.2, 60.0
ENVIRONMENT = "sweep_studio.exr"

GOLD, COPPER, STEEL = (0.94, 0.66, 0.22), (0.92, 0.5, 0.32), (0.62, 0.6, 0.57)
# Row -> (the parameter that goes from 0 to 1, what stays fixed), as keywords of Glb.material.
ROWS = {
    "metallic": ("metal", dict(base=GOLD, rough=0.25)),
    "roughness": ("rough", dict(base=(0.1, 0.2, 0.5))),
    "roughness_metal": ("rough", dict(base=COPPER, metal=1.0)),
    "specular": ("specular", dict(base=(0.03, 0.12, 0.06), rough=0.2)),
    "specular_tint": ("specular_tint", dict(base=(0.1, 0.015, 0.01), rough=0.25, specular=1.0)),
    "anisotropic": ("anisotropic", dict(base=STEEL, rough=0.35, metal=1.0)),
    "sheen": ("sheen", dict(base=(0.03, 0.005, 0.012), rough=0.9, specular=0.0, sheen_tint=0.0)),
    "sheen_tint": ("sheen_tint", dict(base=(0.03, 0.005, 0.012), rough=0.9, specular=0.0, sheen=1.0)),
    "clearcoat": ("clearcoat", dict(base=(0.12, 0.006, 0.008), rough=0.7, specular=0.2, clearcoat_gloss=1.0)),
    "clearcoat_gloss": ("clearcoat_gloss", dict(base=(0.12, 0.006, 0.008), rough=0.7, specular=0.2, clearcoat=1.0)),
}


def studio():
    """A dim room with two windows in front, a strip light behind, all with edges, so that blur can be seen."""
    def frame(azimuth, elevation):
        a, e = math.radians(azimuth), math.radians(elevation)
        forward = (math.cos(e) * math.sin(a), math.sin(e), math.cos(e) * math.cos(a))  # azimuth 0 is the camera's side
        right = (math.cos(a), 0.0, -math.sin(a))
        up = (forward[1] * right[2] - forward[2] * right[1], forward[2] * right[0] - forward[0] * right[2],
              forward[0] * right[1] - forward[1] * right[0])
        return forward, right, up

    # (frame, half width, half height, bars, radiance)
    boxes = [(frame(-42, 40), 0.36, 0.36, True, (12.0, 11.6, 11.0)), (frame(68, 22), 0.13, 0.62, False, (4.0, 4.8, 6.0)),
             (frame(172, 30), 1.1, 0.16, False, (10.0, 9.4, 8.6))]

    def radiance(d):
        up = 0.5 + 0.5 * d[1]
        color = (0.05 + 0.17 * up, 0.05 + 0.18 * up, 0.06 + 0.20 * up)
        for (forward, right, above), wide, high, bars, power in boxes:
            z = sum(a * b for a, b in zip(forward, d))
            if z <= 0:
                continue
            x, y = (sum(a * b for a, b in zip(axis, d)) / z for axis in (right, above))
            if abs(x) < wide and abs(y) < high and not (bars and min(abs(x), abs(y)) < 0.02):
                color = power
        return color
    return image.exr(image.latlong(512, 256, radiance))


def globe(around=96, along=48):
    """Unit sphere with poles on +-y and tangents along the parallels."""
    positions, tangents, triangles = [], [], []
    for j in range(along + 1):
        for i in range(around + 1):
            theta, phi = math.pi * j / along, 2 * math.pi * i / around
            positions.append((math.sin(theta) * math.sin(phi), math.cos(theta), math.sin(theta) * math.cos(phi)))
            tangents.append((math.cos(phi), 0.0, -math.sin(phi), 1.0))
    for j in range(along):
        for i in range(around):
            a = j * (around + 1) + i
            b = a + around + 1
            if j < along - 1:
                triangles.append((a, b, b + 1))
            if j > 0:
                triangles.append((a, b + 1, a + 1))
    return Shape(positions, triangles, [unit(p) for p in positions], (), tangents)


def scene():
    g = Glb(environment=ENVIRONMENT)
    half = APART * len(ROWS)
    g.put(floor(half), g.material("floor", (0.18, 0.18, 0.18), 1.0, specular=0.0), name="floor")
    ball = globe()
    for row, (name, (key, fixed)) in enumerate(ROWS.items()):
        z = APART * (row - (len(ROWS) - 1) / 2)
        for i in range(STEPS):
            value = i / (STEPS - 1)
            material = g.material("%s %g" % (name, value), **{**fixed, key: value})
            g.put(ball, material, at=(SPACING * (i - (STEPS - 1) / 2), 1, z), name="%s %g" % (name, value))
        g.camera((0, 1 + 20 * math.sin(math.radians(14)), z + 20 * math.cos(math.radians(14))), (0, 1, z), ymag=1.265,
                 aspect=STEPS * SPACING / 2 / 1.265, name=name)
    return g


def files():
    """File name -> bytes."""
    return {"sweep.glb": scene().bytes(), ENVIRONMENT: studio()}
