"""basic_pl: three shapes, two point lights and a gridded floor, the scene of the 2018 report's figures 4 to 7.

Each shape has unit size and stands at y = 1. The report decoded textures with a plain gamma of 2.2, so its floor has
the albedos (90/255)^2.2 and (128/255)^2.2; here they are the product of a base colour and two sRGB codes.
"""

import math

import image
from glb import Glb, unit
from shapes import Shape, cube_grid, floor

BORDER, FILL = (90 / 255) ** 2.2, (128 / 255) ** 2.2


def flip_cap_sphere(around=128, along=64, flip=0.75):
    """Sphere with poles on +-z whose caps |z| > flip are mirrored inward: a bowl on either side."""
    positions, normals, triangles = [], [], []
    for j in range(along + 1):
        theta = math.pi * j / along
        for i in range(around):
            phi = 2 * math.pi * i / around
            n = (math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta))
            if j in (0, along):
                n = (0, 0, 1 if j == 0 else -1)
            p = n
            if abs(n[2]) > flip:
                p = (n[0], n[1], math.copysign(2 * flip, n[2]) - n[2])
                n = (-n[0], -n[1], n[2])
            positions.append(p)
            normals.append(n)
            if j in (0, along):
                break  # a pole is one vertex
    def at(j, i):
        if j == 0:
            return 0
        return len(positions) - 1 if j == along else 1 + (j - 1) * around + i % around
    for j in range(along):
        for i in range(around):
            a, b, c, d = at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)
            if j < along - 1:
                triangles.append((a, b, c))
            if j > 0:
                triangles.append((a, c, d))
    return Shape(positions, triangles, normals)


def sphere():
    shape = cube_grid(16).mapped(unit)
    shape.normals = list(shape.positions)
    return shape


def rounded_cube():
    def push(p):
        return tuple(0.25 * x + 0.75 * s for x, s in zip(p, unit(p)))
    return cube_grid(16).mapped(push).smooth()


def grid_codes():
    """The two sRGB codes whose linear ratio is nearest to BORDER/FILL, and the factor that makes them right."""
    best = min(((abs(image.decode_srgb(a) / image.decode_srgb(b) - BORDER / FILL), a, b)
                for b in range(160, 256) for a in range(60, b)))
    return best[1], best[2], FILL / image.decode_srgb(best[2])


def scene():
    g = Glb()
    border, fill, factor = grid_codes()
    rows = [[0 if 0 in (x, y) or 63 in (x, y) else 1 for x in range(64)] for y in range(64)]
    texture = g.texture(g.image(image.png(rows, 1, palette=[(border,) * 3, (fill,) * 3])))
    grid = g.material("floor", (factor,) * 3, 1.0, specular=0.0, textures={"baseColorTexture": {"index": texture}})
    g.put(floor(20, texcoords=[(-10, 10), (10, 10), (10, -10), (-10, -10)]), grid, name="floor")
    for name, shape, x, base, rough in (("red", flip_cap_sphere(), -2.5, (0.5, 0.2, 0.2), 0.25),
                                        ("green", sphere(), 0, (0.2, 0.5, 0.2), 0.10),
                                        ("blue", rounded_cube(), 2.5, (0.2, 0.2, 0.5), 0.05)):
        g.put(shape, g.material(name, base, rough, specular=0.5), at=(x, 1, 0), name=name)
    g.light("point", (-2, 10, 8), intensity=400)
    g.light("point", (2, 10, 8), intensity=400)
    g.camera((0, 4.8, 12), (0, 1, 0), 15, aspect=2.35)
    # The figures' highlights are smaller than a pixel. A second camera at the same place fills the view with both of the
    # green sphere's, so that a case can measure the lobe without the noise of finding it.
    g.camera((0, 4.8, 12), (0, 1.541, 0.837), 0.6, aspect=2.35, name="highlight")
    return g
