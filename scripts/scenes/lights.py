"""Scenes about light: a sky with a sun, area lights, many lights, punctual lights, and two that POV-Ray can repeat."""

import math
import random

import image
from glb import Glb, cross, dot, rotation, unit
from shapes import ball, box, floor, icosphere, join, quad

SKY = "sky.hdr"
HIGH, AROUND = math.radians(35), math.radians(-160)
SUN = (math.cos(HIGH) * math.cos(AROUND), math.sin(HIGH), math.cos(HIGH) * math.sin(AROUND))


def sky():
    """Latitude-longitude map, 128 x 64: blue above, brown below, a sun of about 3 degrees."""
    def radiance(d):
        if d[1] < 0:
            color = [0.22, 0.17, 0.12]
        else:
            color = [0.75 - 0.55 * d[1] ** 0.5, 0.85 - 0.45 * d[1] ** 0.5, 1.0 - 0.15 * d[1] ** 0.5]
        angle = math.degrees(math.acos(max(-1.0, min(1.0, dot(d, SUN)))))
        sun = max(0.0, min(1.0, 4.0 - angle))
        glow = 1.5 * math.exp(-angle / 12)
        return [c + 150 * sun * s + glow * s for c, s in zip(color, (1.0, 0.85, 0.65))]
    return image.hdr(image.latlong(128, 64, radiance))


def sun_sky():
    g = Glb(environment=SKY, strength=0.8, rotation=70.0)
    round_ball = ball().smooth()
    g.put(floor(6), g.material("floor", (0.5, 0.48, 0.45), 0.8, specular=0.3), name="floor")
    g.put(round_ball, g.material("metal", (0.9, 0.75, 0.5), 0.5, 1.0), at=(-1.15, 0.9, 0.0), scale=0.9)
    g.put(round_ball, g.material("plastic", (0.05, 0.15, 0.5), 0.4), at=(0.75, 0.6, 0.9), scale=0.6)
    g.put(box(), g.material("brick", (0.6, 0.2, 0.1), 0.7), at=(1.2, 0.75, -1.2), scale=0.75,
          turn=rotation((0, 1, 0), 30))
    g.camera((0.8, 2.4, 7.6), (0, 0.7, 0), 31)
    return g


def area_gloss():
    """Glossy plastic under two rectangular lights, one of them in the picture."""
    g = Glb()
    round_ball = ball().smooth()
    g.put(floor(5), g.material("floor", (0.4, 0.4, 0.42), 0.4), name="floor")
    g.put(quad((-5, 0, -2.5), (5, 0, -2.5), (5, 5, -2.5), (-5, 5, -2.5)),
          g.material("wall", (0.35, 0.3, 0.28), 0.9, specular=0.2), name="wall")
    for i, (rough, base) in enumerate(((0.15, (0.5, 0.05, 0.04)), (0.3, (0.05, 0.35, 0.1)), (0.5, (0.06, 0.1, 0.5)))):
        g.put(round_ball, g.material("plastic %g" % rough, base, rough), at=(1.5 * (i - 1), 0.7, 0.2), scale=0.7)
    warm = g.material("warm", (0, 0, 0), 1.0, emit=(1, 0.85, 0.6), strength=14.0, specular=0.0)
    cool = g.material("cool", (0, 0, 0), 1.0, emit=(0.5, 0.7, 1), strength=5.0, specular=0.0)
    lamp = quad((-1, -0.6, 0), (1, -0.6, 0), (1, 0.6, 0), (-1, 0.6, 0))
    g.put(lamp, warm, at=(-1.0, 3.4, 1.4), turn=rotation((1, 0, 0), 75), name="warm")
    g.put(lamp, cool, at=(1.5, 2.15, -1.9), scale=0.6, turn=rotation((0, 1, 0), -25), name="cool")
    g.camera((0, 2.0, 7.4), (0, 1.15, 0), 35)
    return g


def many_lights():
    """64 small square lights of 64 sizes, directions and four colours above a few diffuse things."""
    g = Glb()
    noise = random.Random(7)
    colors = ((1, 0.35, 0.2), (1, 0.8, 0.5), (0.3, 0.7, 1), (0.6, 1, 0.4))
    groups = [[] for _ in colors]
    for i in range(64):
        x, z = (i % 8 - 3.5) * 0.8, (i // 8 - 4.5) * 0.8
        y = 2.4 + 0.35 * noise.random() + 0.04 * (x * x + z * z)
        n = unit((0.8 * (noise.random() - 0.5), -1, 0.8 * (noise.random() - 0.5)))
        a = unit(cross((0, 0, 1), n))
        b = cross(n, a)
        h = 0.05 + 0.06 * noise.random()
        corner = [[c + h * (s * u + t * v) for c, u, v in zip((x, y, z), a, b)] for s, t in
                  ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        groups[(i + i // 8) % 4].append(quad(*corner))
    for k, (color, quads) in enumerate(zip(colors, groups)):
        g.put(join(*quads), g.material("lamp %d" % k, (0, 0, 0), 1.0, emit=color, strength=24.0, specular=0.0))
    g.put(floor(5), g.material("floor", (0.5, 0.5, 0.5), 0.6, specular=0.2), name="floor")
    g.put(ball().smooth(), g.material("ball", (0.7, 0.7, 0.7), 0.5, specular=0.3), at=(-0.9, 0.7, 0.2), scale=0.7)
    g.put(box(), g.material("box", (0.7, 0.6, 0.5), 0.6, specular=0.2), at=(0.9, 0.5, -0.2), scale=0.5,
          turn=rotation((0, 1, 0), 35))
    g.camera((0, 2.0, 7.6), (0, 1.35, 0), 36)
    return g


def punctual():
    """One point, one spot and one directional light in three colours."""
    g = Glb()
    g.put(floor(4), g.material("floor", (0.6, 0.6, 0.6), 0.7, specular=0.2), name="floor")
    g.put(ball().smooth(), g.material("ball", (0.7, 0.7, 0.7), 0.4), at=(-0.7, 0.7, 0), scale=0.7)
    g.put(box(), g.material("box", (0.6, 0.6, 0.6), 0.6), at=(0.9, 0.45, 0.3), scale=0.45, turn=rotation((0, 1, 0), 25))
    g.light("directional", (-3, 2.5, 2), color=(1, 0.75, 0.5), intensity=1.2, aim=(0, 0, 0))
    g.light("point", (1.6, 1.6, -1.2), color=(0.4, 0.6, 1), intensity=5)
    g.light("spot", (0.5, 4.0, 2.2), color=(0.5, 1, 0.5), intensity=30, aim=(0.3, 0, 0.5), cone=(8, 20))
    g.camera((0.3, 2.4, 5.2), (0.15, 0.5, 0), 37)
    return g


def direct_shadows():
    """Lambert only: flat and smooth bodies, two point lights of different colours, hard shadows over edges."""
    g = Glb()
    def lambert(name, base):
        return g.material(name, base, 1.0, specular=0.0)
    g.put(floor(4), lambert("floor", (0.6, 0.6, 0.6)), name="floor")
    g.put(box(), lambert("box", (0.6, 0.3, 0.15)), at=(0.9, 0.5, -0.4), scale=(0.5, 0.5, 0.5), turn=rotation((0, 1, 0), 28))
    g.put(box(), lambert("slab", (0.2, 0.5, 0.25)), at=(-0.3, 0.25, 1.1), scale=(0.8, 0.25, 0.2), turn=rotation((0, 1, 0), -20))
    g.put(ball(16).smooth(), lambert("ball", (0.25, 0.3, 0.6)), at=(-0.9, 0.75, -0.3), scale=0.75)
    g.light("point", (-2.5, 4, 3), color=(1, 0.8, 0.6), intensity=24)
    g.light("point", (3, 3, 1.5), color=(0.4, 0.6, 1), intensity=14)
    g.camera((0.2, 2.6, 5.5), (0, 0.45, 0.1), 36)
    return g


def mirror():
    """Flat mirrors in a closed room of plain emitters: a faceted gem, a mirror on the wall, and their reflections of each
    other. No scattering, so each pixel is the emission at the end of one polygonal path."""
    g = Glb()
    glass = g.material("mirror", (1, 1, 1), 0.0, 1.0)
    hues = ((0.8, 0.25, 0.15), (0.15, 0.5, 0.75), (0.75, 0.65, 0.2), (0.25, 0.6, 0.25), (0.55, 0.3, 0.65),
            (0.85, 0.85, 0.8), (0.12, 0.12, 0.15))
    glow = [g.material("glow %d" % i, (0, 0, 0), 1.0, emit=c, specular=0.0) for i, c in enumerate(hues)]
    half, cells = 2.0, 4
    tiles = [[] for _ in glow]
    for axis in range(3):
        for side in (-half, half):
            for i in range(cells):
                for j in range(cells):
                    corner = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = [0.0] * 3
                        p[axis] = side
                        p[(axis + 1) % 3] = half * (2 * a / cells - 1)
                        p[(axis + 2) % 3] = half * (2 * b / cells - 1)
                        corner.append(p)
                    wall = 2 * axis + (side > 0)
                    tiles[wall if (i + j) % 2 else 6 if wall % 2 else 5].append(quad(*corner))
    for material, quads in zip(glow, tiles):
        g.put(join(*quads), material)
    g.put(icosphere(1), glass, at=(-0.35, -0.5, -0.2), scale=0.8, turn=rotation((1, 2, 3), 40), name="gem")
    g.put(quad((-0.7, -0.9, 0), (0.7, -0.9, 0), (0.7, 0.9, 0), (-0.7, 0.9, 0)), glass, at=(0.95, 0.1, -1.2),
          turn=rotation((0, 1, 0), -35), name="looking glass")
    g.camera((0.2, 0.35, 1.9), (0, -0.15, -0.6), 62)
    return g
