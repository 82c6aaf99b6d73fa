"""A card: one quad per pixel of a 32 x 32 image, all in one plane facing an orthographic camera, each with the normal
and tangent that a unit sphere filling the image has at the pixel's centre. Under one directional light every pixel is one
value of the BRDF, without noise, shadows or a silhouette, so that a formula evaluated elsewhere can be compared with it.

Only normals within 44 degrees of the eye: a renderer may bend a steeper one, whose mirror direction lies below the card.
"""

import math

from glb import Glb, unit
from shapes import Shape

SIZE = 32


def brdf_card():
    positions, normals, tangents, triangles = [], [], [], []
    for j in range(SIZE):
        for i in range(SIZE):
            x, y = (2 * i + 1) / SIZE - 1, 1 - (2 * j + 1) / SIZE
            if x * x + y * y > math.sin(math.radians(44)) ** 2:
                continue
            z = math.sqrt(1 - x * x - y * y)
            first, h = len(positions), 1 / SIZE
            positions += [(x - h, y - h, 0), (x + h, y - h, 0), (x + h, y + h, 0), (x - h, y + h, 0)]
            normals += [(x, y, z)] * 4
            tangents += [(*unit((z, 0, -x)), 1)] * 4
            triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    g = Glb()
    shape = Shape(positions, triangles, normals)
    shape.tangents = tangents
    everything = g.material("everything", (0.8, 0.4, 0.1), 0.4, 0.3, specular=0.8, specular_tint=0.6, anisotropic=0.8,
                            anisotropic_rotation=0.1, sheen=1.0, sheen_tint=0.7, clearcoat=1.0, clearcoat_roughness=0.2)
    g.put(shape, everything, name="card")
    g.light("directional", (5, 4, 8), aim=(0, 0, 0))
    g.camera((0, 0, 4), (0, 0, 0), ymag=1)
    return g
