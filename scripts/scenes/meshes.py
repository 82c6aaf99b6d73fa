"""Scenes about geometry: transforms, cameras, culling, smooth normals, and every way glTF has to store a mesh."""

import struct

import image
from glb import ARRAY, BYTE, FAN, FLOAT, SHORT, STRIP, UINT, Glb, rotation
from parameters import STUDIO
from shapes import Shape, ball, box, floor, icosphere, quad


def bracket():
    """An L without symmetry, so that a mirrored or turned one looks different; flat-shaded, closed."""
    outline = [(0, 0), (1.2, 0), (1.2, 0.35), (0.4, 0.5), (0.4, 1.6), (0, 1.6)]
    n = len(outline)
    front = [(x, y, 0.3) for x, y in outline]
    back = [(x, y, -0.3) for x, y in outline]
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    sides = [t for i in range(n) for t in ((i + n, (i + 1) % n + n, (i + 1) % n), (i + n, (i + 1) % n, i))]
    return Shape(front + back, caps + [(c + n, b + n, a + n) for a, b, c in caps] + sides)


def instances():
    """Two meshes, nine times: mirrored, squeezed, sheared by a turn inside a stretch, and as a matrix."""
    g = Glb(environment=STUDIO, strength=0.35)
    sheet = g.material("floor", (0.45, 0.45, 0.45), 0.9, specular=0.1)
    g.put(floor(6), sheet, name="floor")
    red = g.material("red", (0.6, 0.12, 0.08), 0.5)
    blue = g.material("blue", (0.1, 0.2, 0.55), 0.35)
    el, egg = bracket(), ball().smooth()
    g.put(el, red, at=(-3.0, 0, 0.9), name="plain")
    g.put(el, red, at=(0.1, 0, 0.5), scale=(-1, 1, 1), name="mirrored")
    g.put(el, red, at=(1.6, 1.2, -1.0), scale=(0.9, -0.75, 1.4), turn=rotation((0, 1, 0), 35), name="upside down")
    stretch = g.node(translation=[-1.9, 0.02, -1.9], scale=[1.6, 1.1, 0.7], name="stretch")
    g.put(el, red, turn=rotation((0, 0, 1), 25), at=(0.3, 0.1, 0), parent=stretch, name="sheared")
    g.put(egg, blue, turn=rotation((1, 1, 0), 40), at=(1.25, 0.55, 0), scale=(0.3, 0.5, 0.3), parent=stretch, name="egg")
    g.node(mesh=g.mesh((egg, blue)), name="matrix",
           matrix=[0.5, 0, 0.2, 0, 0.15, 0.45, 0, 0, 0, 0, -0.4, 0, 0.55, 0.46, 1.3, 1])
    g.put(egg, blue, at=(2.2, 0.3, 0.9), scale=(0.7, 0.3, 0.45), turn=rotation((0, 1, 0), 30), name="pebble")
    g.put(egg, blue, at=(-1.3, 0.25, 1.6), scale=(-0.25, 0.25, 0.6), name="mirrored pebble")
    g.light("directional", (-2, 4, 3), intensity=1.6, aim=(0, 0, 0))
    g.camera((0.0, 3.6, 8.6), (-0.3, 0.65, 0), 38)
    return g


def orthographic():
    """An isometric view, rolled a little: size does not fall off with distance and no edge converges."""
    g = Glb(color=(0.25, 0.28, 0.35))
    g.put(floor(2.2), g.material("floor", (0.5, 0.5, 0.5), 0.8, specular=0.2), name="floor")
    block = box((-1, 0, -1), (1, 2, 1))
    for i, (x, z, high) in enumerate(((-1.3, -1.3, 0.8), (0, -1.3, 0.55), (1.3, -1.3, 0.3), (-1.3, 0, 0.5), (-1.3, 1.3, 0.25))):
        g.put(block, g.material("block %d" % i, (0.15 + 0.12 * i, 0.35, 0.6 - 0.12 * i), 0.6), at=(x, 0, z),
              scale=(0.4, high, 0.4))
    g.put(ball().smooth(), g.material("ball", (0.7, 0.5, 0.2), 0.4), at=(0.7, 0.75, 0.7), scale=0.75)
    g.light("directional", (-1, 3, 2), intensity=1.8, aim=(0, 0, 0))
    g.camera((6, 5, 6), (0, 0.3, 0), ymag=2.5, up=(0.15, 1, 0))
    return g


def single_sided():
    """A doll's house with a lamp: walls and roof face inward, so the eye looks in through their backs while the lamp's light
    stays inside. A red tray faces up: seen, but it casts no shadow, because rays from below meet its back. A blue one
    faces down: a shadow without a tray. The fence has two sides."""
    g = Glb(color=(0.3, 0.33, 0.4))
    room = box((-1.5, 0, -1.5), (1.5, 2, 1.5))
    room.triangles = [t[::-1] for t in room.triangles]
    g.put(room, g.material("room", (0.6, 0.55, 0.45), 0.8, specular=0.2, double=False), name="room")
    g.put(ball(8).smooth(), g.material("ball", (0.5, 0.1, 0.1), 0.4, double=False), at=(0.5, 0.5, 0.3), scale=0.5)
    inside_out = ball(6)
    inside_out.triangles = [t[::-1] for t in inside_out.triangles]
    g.put(inside_out, g.material("shell", (0.15, 0.45, 0.3), 0.5, double=False), at=(0.8, 0.4, -0.8), scale=0.4)
    g.put(floor(0.35), g.material("tray up", (0.6, 0.1, 0.1), 0.6, double=False), at=(-0.9, 0.6, -0.5), name="tray up")
    g.put(floor(0.35), g.material("tray down", (0.1, 0.1, 0.6), 0.6, double=False), at=(-0.5, 0.5, 0.6),
          turn=rotation((1, 0, 0), 180), name="tray down")
    g.put(quad((-0.45, 0, 0), (0.45, 0, 0), (0.45, 0.6, 0), (-0.45, 0.6, 0)),
          g.material("fence", (0.2, 0.5, 0.2), 0.7, double=True), at=(0.55, 0.01, 1.05), turn=rotation((0, 1, 0), 160))
    g.light("point", (0.1, 1.7, 0.1), color=(1, 0.95, 0.85), intensity=3.0)
    g.camera((2.2, 3.2, 6.0), (0, 0.85, 0), 35)
    return g


def smooth_silhouette():
    """80 triangles pretending to be a sphere: near the edge a reflection would go below the surface, and the shadow of a
    facet falls where the smooth normal still sees the light."""
    g = Glb(environment=STUDIO, strength=0.5)
    coarse = icosphere(1).smooth()
    for x, y, keys in ((-1.1, 1.05, dict(base=(0.9, 0.8, 0.6), rough=0.3, metal=1.0)),
                       (1.1, 1.05, dict(base=(0.15, 0.3, 0.6), rough=0.3)),
                       (-1.1, -1.05, dict(base=(0.6, 0.25, 0.15), rough=0.9, sheen=0.8)),
                       (1.1, -1.05, dict(base=(0.8, 0.8, 0.8), rough=0.0, metal=1.0))):
        g.put(coarse, g.material("ball %g %g" % (x, y), **keys), at=(x, y, 0), turn=rotation((x, y, 1), 33))
    g.light("directional", (4, 3, 1.5), color=(1, 0.9, 0.7), intensity=1.5, aim=(0, 0, 0))
    g.camera((0, 0, 10), (0, 0, 0), 25)
    return g


def gltf_features():
    """A flat wall of 4 x 4 unit squares seen squarely, each stored in another of glTF's ways: under radiance 1 a Lambert
    wall shows its base colours, so the mean of the picture is their mean; through a gap the white world would
    show."""
    g = Glb(color=(1, 1, 1))
    hues = [(0.1 + 0.05 * i, 0.85 - 0.05 * i, (0.2, 0.5, 0.8)[i % 3]) for i in range(16)]
    g.hues = hues
    plain = [(x / 2, y / 2, 0) for y in range(3) for x in range(3)]  # 2 x 2 squares, 9 vertices
    tris = [t for y in range(2) for x in range(2) for a in (3 * y + x,) for t in ((a, a + 1, a + 4), (a, a + 4, a + 3))]
    soup = [plain[i] for t in tris for i in t]
    texture = g.texture(g.image(image.png([[(255, 0, 0), (0, 255, 0)], [(0, 0, 255), (255, 255, 255)]])), nearest=True)

    def put(slot, attributes, textured=False, white=False, **keys):
        material = g.material("square %d" % slot, (1, 1, 1) if white else hues[slot], 1.0, specular=0.0,
                              textures={"baseColorTexture": {"index": texture}} if textured else None)
        mesh = g.add("meshes", {"name": "square %d" % slot,
                                "primitives": [{"attributes": attributes, "material": material, **keys}]})
        g.node(mesh=mesh, translation=[slot % 4 - 2, 1 - slot // 4, 0])

    def positions(points):
        return g.accessor(points, bounds=True)

    shared = {"POSITION": positions(plain)}
    put(0, shared, indices=g.indices(tris, BYTE))
    put(1, shared, indices=g.indices(tris, SHORT))
    put(2, shared, indices=g.indices(tris, UINT))
    put(3, {"POSITION": positions(soup)})
    # One strip over both rows: the second row runs backwards over a degenerate bridge.
    put(4, shared, mode=STRIP, indices=g.indices([3, 0, 4, 1, 5, 2, 2, 2, 8, 8, 5, 7, 4, 6, 3], SHORT))
    put(5, {"POSITION": positions([(0, 1, 0), (0, 0, 0), (0.5, 1, 0), (0.5, 0, 0), (1, 1, 0), (1, 0, 0)])}, mode=STRIP)
    put(6, shared, mode=FAN, indices=g.indices([4, 0, 1, 2, 5, 8, 7, 6, 3, 0], BYTE))
    put(7, {"POSITION": positions([(0, 0, 0), (1, 0, 0), (1, 0.7, 0), (1, 1, 0), (0.4, 1, 0), (0, 1, 0)])}, mode=FAN)

    # Sparse: two wrong corners put right; and all of it sparse over zeros.
    def sparse(base, fixes, component):
        where = g.view(struct.pack("<%d%s" % (len(fixes), {BYTE: "B", SHORT: "H"}[component]), *fixes))
        what = g.view(b"".join(struct.pack("<3f", *p) for p in fixes.values()))
        item = {"componentType": FLOAT, "count": 9, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0],
                "sparse": {"count": len(fixes), "indices": {"bufferView": where, "componentType": component},
                           "values": {"bufferView": what}}}
        if base is not None:
            item["bufferView"] = base
        return g.add("accessors", item)

    bent = [(0.2, 0.3, 0) if i in (2, 6) else p for i, p in enumerate(plain)]
    bent_view = g.view(b"".join(struct.pack("<3f", *p) for p in bent), ARRAY)
    put(8, {"POSITION": sparse(bent_view, {2: plain[2], 6: plain[6]}, BYTE)}, indices=g.indices(tris))
    put(9, {"POSITION": sparse(None, {i: p for i, p in enumerate(plain) if i}, SHORT)}, indices=g.indices(tris))

    # Interleaved position, normal and texture coordinates in one view of stride 32, behind eight other bytes.
    data = b"\xff" * 8 + b"".join(struct.pack("<8f", *p, 0, 0, 1, p[0], 1 - p[1]) for p in plain)
    mixed = g.view(data, ARRAY, 32)
    def part(offset, kind, **bounds):
        return g.add("accessors", {"bufferView": mixed, "byteOffset": offset, "componentType": FLOAT, "count": 9,
                                   "type": kind, **bounds})
    put(10, {"POSITION": part(8, "VEC3", min=[0, 0, 0], max=[1, 1, 0]), "NORMAL": part(20, "VEC3"),
             "TEXCOORD_0": part(32, "VEC2")}, textured=True, white=True, indices=g.indices(tris))
    # Normalised integers: texture coordinates, vertex colours of three and four components.
    corners = [(int(2 * x), int(2 * (1 - y))) for x, y, _ in plain]  # 0, 1, 2
    bytes_uv = g.accessor([(min(255, 128 * u), min(255, 128 * v)) for u, v in corners], "VEC2", BYTE, normalized=True)
    shorts_uv = g.accessor([(min(65535, 32768 * u), min(65535, 32768 * v)) for u, v in corners], "VEC2", SHORT,
                           normalized=True)
    put(11, {**shared, "TEXCOORD_0": bytes_uv}, textured=True, white=True, indices=g.indices(tris))
    put(12, {**shared, "TEXCOORD_0": shorts_uv}, textured=True, white=True, indices=g.indices(tris))
    put(13, {**shared, "COLOR_0": g.accessor([(51, 102, 204)] * 9, "VEC3", BYTE, normalized=True)}, indices=g.indices(tris))
    put(14, {**shared, "COLOR_0": g.accessor([(13107, 26214, 52428, 65535)] * 9, "VEC4", SHORT, normalized=True)},
        indices=g.indices(tris))
    put(15, {**shared, "COLOR_0": g.accessor([(0.2, 0.4, 0.8)] * 9, "VEC3")}, indices=g.indices(tris))
    g.camera((0, 0, 3), (0, 0, 0), ymag=2.0)
    return g
