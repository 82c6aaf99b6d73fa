"""Triangle meshes. Counter-clockwise seen from outside; smooth shapes carry the angle-weighted vertex normals that
Blender computes for itself: Blender stores normals that differ from its own by more than 1e-4 in 16 bits, and keeps
its own, in floats, where they do not. So scenes meant for Blender need no detour through it."""

import math

from glb import cross, dot, minus, unit


class Shape:
    """positions, triangles, and per vertex, where not empty, normals, texcoords, tangents, colors."""

    def __init__(self, positions, triangles, normals=(), texcoords=(), tangents=(), colors=()):
        self.positions = [tuple(p) for p in positions]
        self.triangles = [tuple(t) for t in triangles]
        self.normals, self.texcoords, self.tangents, self.colors = normals, texcoords, tangents, colors

    def smooth(self):
        self.normals = vertex_normals(self.positions, self.triangles)
        return self

    def mapped(self, function):
        """A flat-shaded copy with each position sent through `function`."""
        return Shape([function(p) for p in self.positions], self.triangles, (), self.texcoords, (), self.colors)


def vertex_normals(positions, triangles):
    """Face normals weighted by the corner's angle."""
    sums = [[0.0, 0.0, 0.0] for _ in positions]
    for t in triangles:
        p = [positions[i] for i in t]
        face = unit(cross(minus(p[1], p[0]), minus(p[2], p[0])))
        for k in range(3):
            a, b = unit(minus(p[(k + 1) % 3], p[k])), unit(minus(p[(k + 2) % 3], p[k]))
            angle = math.acos(max(-1.0, min(1.0, dot(a, b))))
            for axis in range(3):
                sums[t[k]][axis] += angle * face[axis]
    return [unit(s) for s in sums]


def join(*shapes):
    """One shape out of several flat-shaded ones without texture coordinates."""
    positions, triangles = [], []
    for shape in shapes:
        start = len(positions)
        positions += shape.positions
        triangles += [tuple(start + i for i in t) for t in shape.triangles]
    return Shape(positions, triangles)


def quad(a, b, c, d, texcoords=()):
    """Corners counter-clockwise seen from the front. texcoords: True for (0,0) at a, (1,0) at b, (1,1) at c in glTF's
    sense (v down), or four pairs."""
    if texcoords is True:
        texcoords = [(0, 1), (1, 1), (1, 0), (0, 0)]
    return Shape((a, b, c, d), ((0, 1, 2), (0, 2, 3)), (), texcoords)


def floor(half, y=0.0, texcoords=()):
    return quad((-half, y, half), (half, y, half), (half, y, -half), (-half, y, -half), texcoords)


def box(low=(-1, -1, -1), high=(1, 1, 1), sides="xXyYzZ"):
    """Axis-aligned box out of the named sides (capital: the high one), flat-shaded, outward."""
    (x, y, z), (X, Y, Z) = low, high
    corners = [(i, j, k) for k in (z, Z) for j in (y, Y) for i in (x, X)]
    faces = {"x": (0, 4, 6, 2), "X": (5, 1, 3, 7), "y": (0, 1, 5, 4), "Y": (6, 7, 3, 2), "z": (1, 0, 2, 3),
             "Z": (4, 5, 7, 6)}
    triangles = []
    for side in sides:
        a, b, c, d = faces[side]
        triangles += [(a, b, c), (a, c, d)]
    used = sorted({i for t in triangles for i in t})
    return Shape([corners[i] for i in used], [tuple(used.index(i) for i in t) for t in triangles])


def cube_grid(steps):
    """The surface of the cube [-1,1]^3 as six grids of steps x steps quads with shared edges; flat-shaded."""
    index, positions, triangles = {}, [], []

    def vertex(p):
        if p not in index:
            index[p] = len(positions)
            positions.append(tuple(2 * x / steps - 1 for x in p))
        return index[p]

    for axis in range(3):
        for side in (0, steps):
            for i in range(steps):
                for j in range(steps):
                    corners = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = [0, 0, 0]
                        p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = side, a, b
                        corners.append(vertex(tuple(p)))
                    if side == 0:
                        corners.reverse()
                    triangles += [(corners[0], corners[1], corners[2]), (corners[0], corners[2], corners[3])]
    return Shape(positions, triangles)


def ball(steps=10):
    """Unit sphere from a cube grid with equal angles, flat-shaded; .smooth() makes it round."""
    def push(p):
        return unit(tuple(math.tan(math.pi / 4 * x) for x in p))
    return cube_grid(steps).mapped(push)


def icosphere(levels):
    """Unit sphere of 20 * 4^levels triangles, flat-shaded."""
    g = (1 + math.sqrt(5)) / 2
    positions = [unit(p) for p in ((-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g),
                                   (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1))]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
                 (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
                 (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(levels):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(positions)
                positions.append(unit(tuple(x + y for x, y in zip(positions[a], positions[b]))))
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    return Shape(positions, triangles)


def plate(half_width, half_height, bend_degrees, steps=10, rows=2, repeat=(1, 1)):
    """A sheet in the xy plane facing +z, bent backwards about a vertical axis by +-bend_degrees at its ends. u runs
    along the bend, v down. Its tangents are what MikkTSpace makes of these coordinates: in the plane of the bend and
    perpendicular to the vertex normal."""
    radius = half_width / math.sin(math.radians(bend_degrees))
    positions, texcoords, triangles = [], [], []
    for j in range(rows + 1):
        for i in range(steps + 1):
            angle = math.radians(bend_degrees) * (2 * i / steps - 1)
            positions.append((radius * math.sin(angle), half_height * (2 * j / rows - 1),
                              radius * (math.cos(angle) - 1)))
            texcoords.append((repeat[0] * i / steps, repeat[1] * (1 - j / rows)))
    for j in range(rows):
        for i in range(steps):
            a = j * (steps + 1) + i
            triangles += [(a, a + 1, a + steps + 2), (a, a + steps + 2, a + steps + 1)]
    shape = Shape(positions, triangles, (), texcoords).smooth()
    shape.tangents = [unit((n[2], 0, -n[0])) + (1.0,) for n in shape.normals]
    return shape
