"""Scenes whose answer is known: furnaces, flux through a spot, and the Cornell box as the classic beside them."""

import math

from glb import Glb, rotation
from shapes import ball, box, join, quad


def cornell():
    """Two metres wide, y from 0 to 2, open towards the camera. The light fills a hole in the ceiling, so that its back
    lights nothing, and no two surfaces coincide."""
    g = Glb()
    white = g.material("white", (0.73, 0.73, 0.73), 0.5, specular=0.0)
    red = g.material("red", (0.63, 0.065, 0.05), 0.5, specular=0.0)
    green = g.material("green", (0.14, 0.45, 0.091), 0.5, specular=0.0)
    lamp = g.material("lamp", (0, 0, 0), 1.0, emit=(1, 0.8, 0.5), strength=12.0, specular=0.0)
    room = box((-1, 0, -1), (1, 2, 1), "yz")
    h = 0.35
    ring = [quad((x0, 2, z0), (x1, 2, z0), (x1, 2, z1), (x0, 2, z1)) for x0, x1, z0, z1 in
            ((-1, 1, -1, -h), (-1, 1, h, 1), (-1, -h, -h, h), (h, 1, -h, h))]
    g.put(join(room, *ring), white, name="room")
    g.put(box((-1, 0, -1), (1, 2, 1), "x"), red, name="left")
    g.put(box((-1, 0, -1), (1, 2, 1), "X"), green, name="right")
    g.put(quad((-h, 2, -h), (h, 2, -h), (h, 2, h), (-h, 2, h)), lamp, name="lamp")
    block = box((-1, 0, -1), (1, 2, 1), "xXYzZ")
    g.put(block, white, at=(-0.34, 0, -0.3), scale=(0.3, 0.6, 0.3), turn=rotation((0, 1, 0), 17), name="tall")
    g.put(block, white, at=(0.36, 0, 0.33), scale=(0.3, 0.3, 0.3), turn=rotation((0, 1, 0), -16), name="short")
    g.camera((0, 1, 4.45), (0, 1, 0), 33)
    return g


def furnace_box():
    """Closed box, each wall of albedo a and emission 1 - a: every radiance is 1 - a^(N+1) after N scattering events."""
    g = Glb()
    wall = g.material("wall", (0.5, 0.25, 0.75), 1.0, emit=(0.5, 0.75, 0.25), specular=0.0)
    g.put(box((-1, -1, -1), (1, 1, 1)), wall, name="box")
    g.camera((0.3, 0.2, 0.5), (-1, -1, -1), 80)
    return g


def furnace_environment():
    """A faceted Lambert sphere filling the view under radiance 1 from everywhere: its radiance is its albedo."""
    g = Glb(color=(1, 1, 1))
    g.put(ball(6), g.material("lambert", (0.2, 0.5, 0.8), 1.0, specular=0.0), name="ball")
    g.camera((0.4, 0.5, 1.6), (0, 0, 0), 20)
    return g


def furnace_mirror():
    """Perfect mirrors under radiance 1 from everywhere cannot be seen."""
    g = Glb(color=(1, 1, 1))
    mirror = g.material("mirror", (1, 1, 1), 0.0, 1.0)
    facets = ball(5)
    for at, size in (((-1.1, 0, 0), 1), ((1.0, 0.2, -0.3), 0.9), ((0.1, -0.9, 1.2), 0.5)):
        g.put(facets, mirror, at=at, scale=size)
    g.camera((0, 0.5, 7), (0, 0, 0), 28)
    return g


def furnace_point():
    """Inside a Lambert sphere of albedo 1/2 with a point light of pi W/sr at its centre: radiance 1/2 from the light and,
    in equilibrium, 1 in all. The sphere is scaled so that the mean inverse square distance of its facets is 1."""
    g = Glb()
    shape = ball(20)
    total = area = 0.0
    for t in shape.triangles:
        center = [sum(shape.positions[i][k] for i in t) / 3 for k in range(3)]
        total += 1 / sum(x * x for x in center)
        area += 1
    g.put(shape.smooth(), g.material("lambert", (0.5, 0.5, 0.5), 1.0, specular=0.0),
          scale=math.sqrt(total / area), name="sphere")
    g.light("point", (0, 0, 0), intensity=math.pi)
    g.camera((0.3, 0.2, 0.4), (-1, -0.6, -1), 60)
    return g


def spot_flux():
    """A white plane seen squarely from above, and a tilted spot whose whole cone lands on it. The mean radiance is
    albedo/pi * flux / area with flux = 2 pi I ((1 - cos inner) + (cos inner - cos outer)/3): glTF's falloff is a ramp in
    the cosine, squared."""
    g = Glb()
    g.put(quad((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)),
          g.material("plane", (0.8, 0.8, 0.8), 1.0, specular=0.0), name="plane")
    g.light("spot", (-0.9, 0.6, 2.5), color=(1, 0.6, 0.3), intensity=30, aim=(0.2, -0.2, 0), cone=(10, 24))
    g.camera((0, 0, 5), (0, 0, 0), ymag=2.0)
    return g
