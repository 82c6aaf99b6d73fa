"""One row of spheres or plates per Disney parameter, lit by a studio of soft boxes or, for clearcoat, by delta lights."""

import math

import image
from glb import Glb, dot, unit
from shapes import ball, plate

STUDIO = "studio.exr"


def studio():
    """Latitude-longitude map: a gradient and three soft boxes, no point brighter than 9, so that it is quiet to sample."""
    boxes = [(unit((-0.55, 0.6, 0.75)), 0.42, (9.0, 8.6, 8.0)), (unit((0.95, 0.25, 0.1)), 0.35, (2.0, 3.0, 5.0)),
             (unit((-0.85, 0.25, -0.55)), 0.45, (5.0, 3.4, 2.0))]

    def radiance(d):
        up = 0.5 + 0.5 * d[1]
        color = [0.06 + 0.30 * up, 0.06 + 0.32 * up, 0.07 + 0.36 * up]
        for axis, width, power in boxes:
            angle = math.acos(max(-1.0, min(1.0, dot(axis, d)))) / width
            soft = max(0.0, 1 - angle * angle) ** 1.5
            color = [c + soft * p for c, p in zip(color, power)]
        return color
    return image.exr(image.latlong(64, 32, radiance))


SPACING = 2.25


def arrange(g, shape, rows, tilt=0.0):
    """`rows` of material indices, top first, in the plane z = 0, seen from afar."""
    for j, row in enumerate(rows):
        for i, material in enumerate(row):
            g.put(shape, material, at=(SPACING * (i - (len(row) - 1) / 2), SPACING * ((len(rows) - 1) / 2 - j), 0))
    high = SPACING * len(rows) + 0.15
    distance = 22.0
    g.camera((0, distance * math.sin(math.radians(tilt)), distance * math.cos(math.radians(tilt))), (0, 0, 0),
             2 * math.degrees(math.atan(high / 2 / distance)), aspect=SPACING * len(rows[0]) / high)
    return g


def spheres(name, rows, rim=None):
    """rows: lists of keyword dictionaries for Glb.material. rim: irradiance of a light from behind and above."""
    g = Glb(environment=STUDIO)
    if rim:
        g.light("directional", (0.5, 3, -3), intensity=rim, aim=(0, 0, 0))
    return arrange(g, ball().smooth(), [[g.material("%s %d %d" % (name, j, i), **keys) for i, keys in enumerate(row)]
                                        for j, row in enumerate(rows)])


STEPS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)


def roughness_metallic():
    return spheres("roughness metallic", [[dict(base=(0.9, 0.55, 0.25), rough=r, metal=m)
                                           for r in (0.0, 0.1, 0.25, 0.5, 0.75, 1.0)] for m in (0.0, 0.5, 1.0)])


def specular():
    return spheres("specular", [[dict(base=(0.05, 0.08, 0.2), rough=0.25, specular=s) for s in STEPS]])


def specular_tint():
    return spheres("tint", [[dict(base=(0.1, 0.35, 0.05), rough=0.3, specular=1.0, specular_tint=t) for t in STEPS]])


def sheen():
    return spheres("sheen", [[dict(base=(0.04, 0.005, 0.01), rough=0.9, specular=0.0, sheen=s, sheen_tint=t)
                              for s in STEPS] for t in (0.0, 1.0)], rim=2.0)


def clearcoat():
    """Delta lights and a black world: the only light under which Blender 3.4.1's clearcoat is right."""
    g = Glb()
    rows = [[g.material("coat %g gloss %g" % (c, gloss), (0.2, 0.015, 0.02), 0.6, specular=0.3, clearcoat=c,
                        clearcoat_gloss=gloss) for gloss in (0.0, 0.3, 0.55, 0.75, 0.9)] for c in (0.3, 1.0)]
    g.light("directional", (-3, 5, 6), intensity=3.0, aim=(0, 0, 0))
    g.light("point", (7, -1, 7), color=(0.5, 0.7, 1.0), intensity=160)
    return arrange(g, ball(14).smooth(), rows)


def anisotropy():
    """Brushed plates bent about the vertical: anisotropy in the upper row, its rotation in the lower."""
    g = Glb(environment=STUDIO, strength=0.4)
    keys = dict(base=(0.95, 0.8, 0.55), rough=0.4, metal=1.0)
    rows = [[g.material("anisotropic %g" % a, anisotropic=a, **keys) for a in STEPS],
            [g.material("rotation %g" % r, anisotropic=0.9, anisotropic_rotation=r, **keys)
             for r in (0.0, 0.125, 0.25, 0.375, 0.5, 0.875)]]
    g.light("directional", (-0.5, -0.3, 6), intensity=1.2, aim=(0, 0, 0))
    return arrange(g, plate(1.0, 1.0, 60), rows, tilt=12)


def clearcoat_bias():
    """The same coat under a constant environment, where Blender 3.4.1 reports the wrong pdf for it."""
    g = Glb(color=(1, 1, 1))
    row = [g.material("coat %g" % r, (0.0, 0.0, 0.0), 1.0, specular=0.0, clearcoat=1.0, clearcoat_roughness=r)
           for r in (0.2, 0.3, 0.4)]
    return arrange(g, ball().smooth(), [row])
