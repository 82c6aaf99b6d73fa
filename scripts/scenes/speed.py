"""The scenes of `assay speed`: fixed before anything was measured, made here and nowhere else. Surfaces are double-sided and
dense meshes flat-shaded, so that both renderers get the same triangles and neither works around the other's model."""

import math
import pathlib
import random
import struct
import zlib

import numpy as np

import closed
import image
from glb import ARRAY, ELEMENTS, FLOAT, UINT, Glb, cross, rotation, unit
from shapes import Shape, ball, box, floor, plate, quad

SKY = "speed_sky.exr"
STUDIO = "speed_studio.exr"
BUNDLED = pathlib.Path("/usr/share/blender/datafiles/studiolights/world/forest.exr")  # CC0


def arrays(g, positions, triangles, material):
    """A node with a mesh from numpy arrays, far faster than Glb.put."""
    p = (np.round(np.asarray(positions, np.float64), 7) + 0.0).astype("<f4")
    t = np.ascontiguousarray(triangles, "<u4")
    position = g.add("accessors", {"bufferView": g.view(p.tobytes(), ARRAY), "componentType": FLOAT, "count": len(p),
                                   "type": "VEC3", "min": p.min(axis=0).tolist(), "max": p.max(axis=0).tolist()})
    index = g.add("accessors", {"bufferView": g.view(t.tobytes(), ELEMENTS), "componentType": UINT, "count": t.size,
                                "type": "SCALAR"})
    mesh = g.add("meshes", {"primitives": [{"attributes": {"POSITION": position}, "indices": index, "material": material}]})
    g.node(mesh=mesh)


def noise(x, z, octaves, seed):
    """Sum of value noise in [0, 1], by +, * and integer hashes alone: the same bits everywhere."""
    total, weight = np.zeros_like(x), 0.5
    for octave in range(octaves):
        i, j = np.floor(x), np.floor(z)
        u, v = x - i, z - j
        u, v = u * u * (3 - 2 * u), v * v * (3 - 2 * v)

        def corner(di, dj):
            h = ((i + di).astype(np.int64) * 374761393 + (j + dj).astype(np.int64) * 668265263 +
                 (seed + octave) * 2147483647) & 0xFFFFFFFF
            h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
            h = ((h ^ (h >> 16)) * 2246822519) & 0xFFFFFFFF
            return (h >> 8) / float(1 << 24)

        low = corner(0, 0) * (1 - u) + corner(1, 0) * u
        high = corner(0, 1) * (1 - u) + corner(1, 1) * u
        total += weight * (low * (1 - v) + high * v)
        x, z, weight = 2 * x + 17.3, 2 * z + 9.1, weight / 2
    return total


def heights(x, z):
    return 1.6 * noise(0.35 * x + 100, 0.35 * z + 100, 7, 1) - 0.8


def landscape(g, steps, half, material):
    """2 * steps^2 triangles."""
    axis = np.linspace(-half, half, steps + 1)
    x, z = (a.ravel() for a in np.meshgrid(axis, axis))
    k = np.arange(steps)
    a = (k[:, None] * (steps + 1) + k[None, :]).ravel()
    b, c, d = a + 1, a + steps + 2, a + steps + 1
    triangles = np.concatenate([np.stack([a, d, c], 1), np.stack([a, c, b], 1)])
    arrays(g, np.stack([x, heights(x, z), z], 1), triangles, material)


def boulder(g, steps, at, size, seed, material):
    """A rough stone of 12 * steps^2 triangles: a cube grid pushed onto a sphere and out by noise."""
    axis = np.linspace(-1, 1, steps + 1)
    s, t = (a.ravel() for a in np.meshgrid(axis, axis))
    k = np.arange(steps)
    a = (k[:, None] * (steps + 1) + k[None, :]).ravel()
    face = np.concatenate([np.stack([a, a + 1, a + steps + 2], 1), np.stack([a, a + steps + 2, a + steps + 1], 1)])
    positions, triangles, one = [], [], np.ones_like(s)
    for axis_index in range(3):
        for sign in (1.0, -1.0):
            p = np.roll(np.stack([sign * one, s, t], 1), axis_index, axis=1)
            triangles.append((face if sign > 0 else face[:, ::-1]) + len(positions) * len(s))
            positions.append(p / np.sqrt((p * p).sum(axis=1))[:, None])
    p = np.concatenate(positions)
    bump = noise(2.1 * p[:, 0] + 1.3 * p[:, 1] + 50, 2.1 * p[:, 2] - 1.3 * p[:, 1] + 50, 6, seed)
    arrays(g, np.asarray(at) + size * (0.7 + 0.6 * bump)[:, None] * p, np.concatenate(triangles), material)


# --- the scenes


def spheres():
    """Twelve balls of plastic and metal on a plane, one small bright quad: the plainest soft shadow."""
    g = Glb()
    shape = ball(16).smooth()
    g.put(floor(7), g.material("floor", (0.5, 0.5, 0.52), 0.6, specular=0.3), name="floor")
    for i in range(12):
        hue = [0.5 + 0.4 * math.cos(2 * math.pi * (i / 12 + k / 3)) for k in range(3)]
        metal = 1.0 if i % 3 == 2 else 0.0
        g.put(shape, g.material("ball %d" % i, hue, (0.35, 0.45, 0.6)[i % 3], metal, specular=0.5, sheen=0.2 * (i % 2)),
              at=(1.3 * (i % 4 - 1.5), 0.55, 1.3 * (i // 4 - 1.2)), scale=0.55)
    lamp = g.material("lamp", (0, 0, 0), 1.0, emit=(1, 0.9, 0.75), strength=160.0, specular=0.0)
    g.put(quad((-0.2, 0, -0.2), (0.2, 0, -0.2), (0.2, 0, 0.2), (-0.2, 0, 0.2)), lamp, at=(1.5, 4.5, 2.0), name="lamp")
    g.camera((0, 3.6, 7.5), (0, 0.4, 0), 40)
    return g


def terrain(environment, rotation_degrees, strength):
    """384,000 triangles under the sky: a landscape and ten boulders."""
    g = Glb(environment=environment, rotation=rotation_degrees, strength=strength)
    landscape(g, 330, 8, g.material("earth", (0.32, 0.26, 0.17), 0.8, specular=0.3, sheen=0.3))
    place = random.Random(3)
    for i in range(10):
        x, z, size = 9 * (place.random() - 0.5), 7 * (place.random() - 0.6), 0.35 + 0.5 * place.random()
        y = float(heights(np.array([x]), np.array([z]))[0]) + 0.4 * size
        material = g.material("stone %d" % i, [c * (0.5 + 0.5 * place.random()) for c in (0.6, 0.55, 0.5)], 0.35 + 0.05 * i,
                              1.0 if i % 4 == 3 else 0.0, specular=0.5)
        boulder(g, 37, (x, y, z), size, i, material)
    g.camera((0, 2.6, 8.2), (0, 0.1, 0), 40)
    return g


def sky():
    """1024 x 512: a blue gradient, brown below, and a sun of one degree that gives about half of the light."""
    j, i = np.meshgrid(np.arange(512), np.arange(1024), indexing="ij")
    theta, phi = np.pi * (j + 0.5) / 512, 2 * np.pi * ((i + 0.5) / 1024 - 0.5)
    d = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], axis=2)
    up = np.clip(d[..., 1:2], 0, 1) ** 0.5
    color = np.where(d[..., 1:2] < 0, [0.20, 0.16, 0.12], np.array([0.75, 0.85, 1.0]) - up * [0.55, 0.45, 0.15])
    toward = np.array(unit((-0.6, 0.62, 0.5)))
    angle = np.degrees(np.arccos(np.clip((d * toward).sum(axis=2), -1, 1)))[..., None]
    color = color + 6500 * np.clip(1.0 - angle, 0, 1) * [1.0, 0.85, 0.65] + 0.8 * np.exp(-angle / 10) * [1.0, 0.9, 0.75]
    return latlong_exr(color)


def lights(count):
    """A room of 16 by 16 metres under `count` small quads, none overlapping another, in four colours and strengths; their
    power in sum is always the same."""
    g = Glb()
    place = random.Random(7)
    side = math.ceil(math.sqrt(count))
    cell = 14.0 / side
    groups, area = [[] for _ in range(4)], [0.0] * 4
    for i in range(count):
        x, z = (i % side + 0.5) * cell - 7.0, (i // side + 0.5) * cell - 7.0
        if count == 1:
            x, z = 0.6, 2.0
        y = 3.0 + 0.5 * place.random()
        n = unit((0.8 * (place.random() - 0.5), -1, 0.8 * (place.random() - 0.5)))
        a = unit(cross((0, 0, 1), n))
        b = cross(n, a)
        h = min(0.22 * cell, 0.15) * (0.5 + 0.5 * place.random())
        groups[(i + i // side) % 4].append([[c + h * (s * u + t * v) for c, u, v in zip((x, y, z), a, b)]
                                            for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        area[(i + i // side) % 4] += 4 * h * h
    weights = (1.0, 2.0, 3.0, 4.0)
    total = sum(a * w for a, w in zip(area, weights))
    for quads, weight, color in zip(groups, weights, ((1, 0.5, 0.3), (1, 0.85, 0.6), (0.5, 0.75, 1), (0.7, 1, 0.6))):
        if quads:
            corner = 4 * np.arange(len(quads))[:, None]
            arrays(g, np.array(quads).reshape(-1, 3), np.concatenate([corner + [0, 1, 2], corner + [0, 2, 3]]),
                   g.material("lamp %g" % weight, (0, 0, 0), 1.0, emit=color, strength=60 * weight / total, specular=0.0))
    g.put(floor(8), g.material("floor", (0.5, 0.48, 0.45), 0.5, specular=0.4), name="floor")
    g.put(quad((-8, 0, -8), (8, 0, -8), (8, 5, -8), (-8, 5, -8)), g.material("wall", (0.6, 0.6, 0.6), 0.7, specular=0.2))
    shape, block = ball(12).smooth(), box()
    for i in range(16):
        x, z = 3.2 * (i % 4 - 1.5) + 0.9 * (place.random() - 0.5), 3.2 * (i // 4 - 1.7) + 0.9 * (place.random() - 0.5)
        material = g.material("thing %d" % i, [0.2 + 0.6 * place.random() for _ in range(3)], 0.3 + 0.5 * place.random(),
                              1.0 if i % 5 == 4 else 0.0, specular=0.5, sheen=0.3 * (i % 2))
        if i % 2:
            g.put(shape, material, at=(x, 0.8, z), scale=0.8)
        else:
            g.put(block, material, at=(x, 0.7, z), scale=0.7, turn=rotation((0, 1, 0), 90 * place.random()))
    g.camera((0, 3.0, 10.0), (0, 0, 0), 30)  # sees no light: its edge would be all the error
    return g


def lobes():
    """Every lobe of the Disney BRDF in every material: balls and brushed plates under three area lights."""
    g = Glb()
    round_ball, sheet = ball(14).smooth(), plate(0.62, 0.62, 55)
    round_ball.tangents = [(*(unit((n[2], 0, -n[0])) if abs(n[1]) < 0.9999 else (1.0, 0.0, 0.0)), 1.0)
                           for n in round_ball.normals]
    g.put(floor(6), g.material("floor", (0.4, 0.4, 0.42), 0.5, specular=0.4, sheen=0.2), name="floor")
    for i in range(8):
        t = i / 7
        material = g.material("all %d" % i, (0.85 - 0.6 * t, 0.25 + 0.3 * t, 0.15 + 0.6 * t), 0.25 + 0.05 * i,
                              0.5 * (i % 3) / 2, specular=0.6, specular_tint=t, anisotropic=0.2 + 0.08 * i,
                              anisotropic_rotation=0.1 * i, sheen=0.8, sheen_tint=1 - t, clearcoat=0.25 + 0.1 * t,
                              clearcoat_gloss=0.2 + 0.08 * i)
        at = (1.55 * (i % 4 - 1.5), 0.7 + 1.5 * (i // 4), -1.2 * (i // 4))
        g.put(sheet if i % 2 else round_ball, material, at=at, scale=1.0 if i % 2 else 0.65)
    for color, strength, at, size in (((1, 0.9, 0.8), 12, (-2.5, 4.5, 2.5), 0.7), ((0.6, 0.8, 1), 8, (3.0, 3.8, 2.0), 0.6),
                                      ((1, 1, 1), 6, (0, 5.5, -1), 1.0)):
        lamp = g.material("lamp %d" % strength, (0, 0, 0), 1.0, emit=color, strength=float(strength), specular=0.0)
        g.put(quad((-size, 0, -size), (size, 0, -size), (size, 0, size), (-size, 0, size)), lamp, at=at)
    g.camera((0, 2.3, 9.4), (0, 1.35, 0), 36)
    return g


def png(pixels, srgb):
    """8-bit RGB from a numpy array, stored blocks: the same bytes whichever zlib writes them."""
    rows = np.concatenate([np.zeros((len(pixels), 1), np.uint8), pixels.reshape(len(pixels), -1)], axis=1).tobytes()
    stream = b"\x78\x01"
    for start in range(0, len(rows), 65535):
        block = rows[start:start + 65535]
        stream += struct.pack("<BHH", start + 65535 >= len(rows), len(block), len(block) ^ 0xFFFF) + block
    stream += struct.pack(">I", zlib.adler32(rows))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", pixels.shape[1], len(pixels), 8, 2, 0, 0, 0)) +
            (chunk(b"sRGB", b"\0") if srgb else b"") + chunk(b"IDAT", stream) + chunk(b"IEND", b""))


def textured():
    """Colour, roughness and metal from 512 x 512 textures on everything, under a sky and a lamp."""
    g = Glb(color=(0.35, 0.4, 0.5))
    size = 512
    y, x = np.meshgrid(np.arange(size), np.arange(size), indexing="ij")
    row = y // 64
    brick = (((x + 64 * (row % 2)) % 128 > 8) & (y % 64 > 8))[..., None]
    grain = noise(x / 24.0, y / 24.0, 5, 5)[..., None]
    tone = noise(x // 128 + 0.5, row + 0.5, 1, 9)[..., None]
    color = np.where(brick, (0.45 + 0.5 * tone) * [190, 95, 70] + 60 * (grain - 0.5), 120 + 60 * (grain - 0.5))
    shine = np.where(brick, 60 + 150 * grain, 230)
    mask = np.where(brick & (tone > 0.55), 255.0, 0.0)
    packed = np.concatenate([255 + 0 * shine, shine, mask], axis=2)

    def texture(values, srgb):
        return {"index": g.texture(g.image(png(np.clip(np.floor(values + 0.5), 0, 255).astype(np.uint8), srgb)))}

    base, surface = texture(color, True), texture(packed, False)
    material = g.material("bricks", (1, 1, 1), 1.0, 1.0, textures={"baseColorTexture": base, "metallicRoughnessTexture": surface})
    wood = g.material("worn", (0.8, 0.9, 1), 0.9, 0.3, textures={"baseColorTexture": base, "metallicRoughnessTexture": surface})
    g.put(floor(5, texcoords=[(-3, 3), (3, 3), (3, -3), (-3, -3)]), material, name="floor")
    sheet = plate(1.1, 1.1, 70, steps=24, rows=12, repeat=(2, 1.5))
    sheet.tangents = ()
    for i in range(3):
        g.put(sheet, (material, wood)[i % 2], at=(2.3 * (i - 1), 1.1, -0.6 * (i % 2)), turn=rotation((0, 1, 0), 25 * (1 - i)))
    lamp = g.material("lamp", (0, 0, 0), 1.0, emit=(1, 0.85, 0.65), strength=45.0, specular=0.0)
    g.put(quad((-0.4, 0, -0.4), (0.4, 0, -0.4), (0.4, 0, 0.4), (-0.4, 0, 0.4)), lamp, at=(-1.5, 4.2, 2.5))
    g.camera((0.3, 2.3, 7.2), (0, 0.9, 0), 35)
    return g


def torus(around, across, radius, tube):
    """A smooth ring about the z axis."""
    positions, triangles = [], []
    for i in range(around):
        for j in range(across):
            u, v = 2 * math.pi * i / around, 2 * math.pi * j / across
            r = radius + tube * math.cos(v)
            positions.append((r * math.cos(u), r * math.sin(u), tube * math.sin(v)))
            a, b = i * across + j, i * across + (j + 1) % across
            c, d = (i + 1) % around * across + (j + 1) % across, (i + 1) % around * across + j
            triangles += [(a, d, c), (a, c, b)]
    return Shape(positions, triangles).smooth()


def glossy():
    """A chain of interlinked metal rings over a polished floor between two walls: light arrives over many glossy bounces."""
    g = Glb(color=(0.05, 0.06, 0.08))
    ring = torus(72, 24, 0.62, 0.16)
    metals = ((0.95, 0.78, 0.4), (0.92, 0.92, 0.95), (0.9, 0.55, 0.4))
    for i in range(9):
        g.put(ring, g.material("metal %d" % i, metals[i % 3], 0.2 + 0.03 * (i % 5), 1.0), at=(0.72 * (i - 4), 1.2, 0.25 * (i % 2)),
              turn=rotation((1, 0, 0) if i % 2 else (0.2, 1, 0), 80 if i % 2 else 15))
    polish = g.material("polish", (0.25, 0.2, 0.18), 0.2, specular=0.9)
    g.put(floor(5), polish, name="floor")
    g.put(quad((-5, 0, -2), (5, 0, -2), (5, 4, -2), (-5, 4, -2)), g.material("wall", (0.6, 0.25, 0.2), 0.3, 0.4), name="wall")
    lamp = g.material("lamp", (0, 0, 0), 1.0, emit=(1, 0.95, 0.85), strength=6.0, specular=0.0)
    g.put(quad((-2, 0, -0.8), (2, 0, -0.8), (2, 0, 0.8), (-2, 0, 0.8)), lamp, at=(0, 4.0, 1.0))
    g.camera((0, 2.0, 6.4), (0, 1.0, 0), 40)
    return g


def mesh_of(triangles):
    """The landscape with about this many triangles, one quad light and a grey sky: only the mesh grows."""
    g = Glb(color=(0.4, 0.45, 0.5))
    landscape(g, round(math.sqrt(triangles / 2)), 8, g.material("earth", (0.4, 0.33, 0.25), 0.7, specular=0.4))
    lamp = g.material("lamp", (0, 0, 0), 1.0, emit=(1, 0.9, 0.75), strength=40.0, specular=0.0)
    g.put(quad((-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)), lamp, at=(3, 6, 1))
    g.camera((0, 3.0, 8.2), (0, 0, 0), 40)
    return g


def studio():
    """Blender's own forest.exr, where the package blender-data has put it, else None. Its compression left negative texels,
    which are no radiance: they become 0."""
    if not BUNDLED.is_file():
        return None
    import OpenImageIO as oiio
    pixels = oiio.ImageBuf(str(BUNDLED)).get_pixels(oiio.FLOAT)[..., :3]
    return latlong_exr(np.maximum(pixels, 0))


def latlong_exr(pixels):
    return image.exr([[tuple(float(c) for c in p) for p in row] for row in pixels])


SCENES = {
    "spheres": spheres, "cornell": closed.cornell, "terrain_sun": lambda: terrain(SKY, 0.0, 0.6),
    "terrain_studio": lambda: terrain(STUDIO, 40.0, 1.0), "lights_64": lambda: lights(64), "lights_4096": lambda: lights(4096),
    "lobes": lobes, "textured": textured, "glossy": glossy,
    **{"triangles_1e%d" % k: lambda k=k: mesh_of(10 ** k) for k in range(3, 8)},
    **{"lights_1e%d" % k: lambda k=k: lights(10 ** k) for k in range(0, 6)},
}
ENVIRONMENTS = {SKY: sky, STUDIO: studio}
