"""Scenes about what a surface looks up: textures and their settings, vertex colours, alpha, material extensions."""

import math

import image
from glb import Glb, rotation
from parameters import SPACING, STUDIO, arrange
from shapes import ball, box, floor, plate, quad

REPEAT, MIRROR, CLAMP = 10497, 33648, 33071


def grid(size, function):
    """Rows of function(x, y) over the texels, top first."""
    return [[function(x, y) for x in range(size)] for y in range(size)]


def bricks(x, y):
    """32 x 32: 0 mortar, 1 to 3 brick of one of three kinds."""
    row = y // 8
    shifted = (x + 8 * (row % 2)) % 32
    if y % 8 == 0 or shifted % 16 == 0:
        return 0
    return 1 + (row * 2 + shifted // 16) % 3


def dents(x, y):
    """Tangent-space normal of a bed of sine bumps, green up, as 16-bit codes."""
    phase_x, phase_y = 2 * math.pi * (x + 0.5) / 16, 2 * math.pi * (y + 0.5) / 16
    dx, dy = 0.9 * math.cos(phase_x) * math.sin(phase_y), 0.9 * math.sin(phase_x) * math.cos(phase_y)
    length = math.sqrt(1 + dx * dx + dy * dy)
    return tuple(int(round(255 * (0.5 + 0.5 * c / length))) for c in (-dx, dy, 1))


def textures():
    """Base colour, metallic and roughness, normal and emission from textures, on a bent plate, a floor and a sign. Almost
    all light comes from delta lights: where rays sampled from a normal-mapped BRDF find light, Blender 3.4.1 is wrong (see
    the scene normal_map_bias)."""
    g = Glb(color=(0.03, 0.033, 0.04))
    brick_colors = [(120, 118, 112), (188, 84, 62), (168, 66, 48), (204, 148, 52)]
    base = g.texture(g.image(image.png(grid(32, bricks), 2, palette=brick_colors)))
    # Green: roughness, blue: metallic. Mortar rough, bricks ever smoother towards the right, the third kind metal.
    shine = g.texture(g.image(image.png(grid(32, lambda x, y: (255, 230, 0) if bricks(x, y) == 0 else
                                             (255, 190 - 4 * x, 255 if bricks(x, y) == 3 else 0)), srgb=False)))
    bumps = g.texture(g.image(image.png(grid(16, dents), srgb=False)))
    sign = g.texture(g.image(image.png([[(255, 190, 90) if c == "#" else (10, 14, 40) for c in row] for row in
                                        ("........", "..##....", ".#..#...", ".#..#.#.", ".####.#.", ".#..#...", ".#..#.#.",
                                         "........")])), wrap=(CLAMP, CLAMP), nearest=True)
    g.put(plate(1.5, 1.0, 50, repeat=(2, 1)), g.material("bricks", (1, 1, 1), 1.0, 1.0, textures={
        "baseColorTexture": {"index": base}, "metallicRoughnessTexture": {"index": shine}}), at=(-0.2, 1.05, -0.6))
    tiles = floor(3, texcoords=[(-1.5, 1.5), (1.5, 1.5), (1.5, -1.5), (-1.5, -1.5)])
    tiles.normals, tiles.tangents = [(0, 1, 0)] * 4, [(1, 0, 0, 1)] * 4
    g.put(tiles, g.material("dents", (0.35, 0.4, 0.5), 0.35, textures={
        "normalTexture": {"index": bumps, "scale": 0.8}}), name="floor")
    g.put(quad((-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0), True),
          g.material("sign", (0.05, 0.05, 0.05), 0.6, emit=(1, 1, 1), strength=1.5,
                     textures={"emissiveTexture": {"index": sign}}), at=(1.35, 0.62, 0.5), turn=rotation((0, 1, 0), -20))
    ball_shape = plate(0.55, 0.55, 75, steps=14)
    g.put(ball_shape, g.material("knurled", (0.9, 0.85, 0.75), 0.4, 1.0, textures={"normalTexture": {"index": bumps}}),
          at=(-1.35, 0.6, 0.75), turn=rotation((0, 1, 0), 15))
    g.light("directional", (4, 3.2, 2.5), color=(1, 0.95, 0.85), intensity=1.5, aim=(0, 0, 0))
    g.light("directional", (-3, 1.2, -3.2), color=(0.6, 0.75, 1), intensity=0.8, aim=(0, 0, 0))
    g.light("point", (-0.6, 2.6, 2.6), color=(1, 0.8, 0.6), intensity=7)
    g.camera((0.3, 2.2, 6.8), (0, 0.75, 0), 33)
    return g


def normal_map_bias():
    """Rough dented metal under the same radiance from everywhere. Blender 3.4.1 keeps sampled directions below the mapped
    normal's horizon, for which its evaluation is zero: the picture depends on how the light was found."""
    g = Glb(color=(1, 1, 1))
    bumps = g.texture(g.image(image.png(grid(16, dents), srgb=False)))
    sheet = floor(3, texcoords=[(-1.5, 1.5), (1.5, 1.5), (1.5, -1.5), (-1.5, -1.5)])
    sheet.normals, sheet.tangents = [(0, 1, 0)] * 4, [(1, 0, 0, 1)] * 4
    g.put(sheet, g.material("dents", (0.6, 0.55, 0.5), 0.9, 1.0, textures={"normalTexture": {"index": bumps}}))
    g.camera((0.3, 3.0, 5.2), (0, 0, 0), 12)
    return g


# One panel each: wrap modes in u and v, nearest?, offset, scale, rotation (radians), texture coordinates (0 runs from -0.7
# to 1.6 over the panel; set 1 is the unit square turned by a quarter), picture.
PANELS = [
    (REPEAT, REPEAT, False, None, None, None, 0, "rgb"), (MIRROR, MIRROR, False, None, None, None, 0, "rgb"),
    (CLAMP, CLAMP, False, None, None, None, 0, "rgb"), (REPEAT, CLAMP, False, None, None, None, 0, "rgb"),
    (REPEAT, REPEAT, True, None, None, None, 0, "rgb"), (MIRROR, MIRROR, True, None, None, None, 0, "rgb"),
    (CLAMP, CLAMP, True, None, None, None, 0, "rgb"), (MIRROR, REPEAT, True, None, None, None, 0, "rgb"),
    (REPEAT, REPEAT, True, (0.25, 0.125), None, None, 1, "rgb"), (REPEAT, REPEAT, True, None, (1.5, 0.5), None, 1, "rgb"),
    (CLAMP, CLAMP, True, None, None, 0.5, 1, "rgb"), (MIRROR, CLAMP, False, (-0.3, 0.4), (1.2, 2.0), -0.7, 1, "rgb"),
    (REPEAT, REPEAT, False, None, None, None, 1, "grey16"), (REPEAT, REPEAT, False, None, None, None, 1, "palette"),
    (CLAMP, CLAMP, False, None, None, None, 1, "grey"), (CLAMP, CLAMP, False, None, None, None, 1, "rgb16"),
]


def pictures():
    """Name -> rows of texels. 8 x 8 without symmetry, in five PNG flavours."""
    def rgb(x, y):
        return (40 + 25 * x, 230 - 22 * y, 60 + 150 * ((x + y) % 3 == 0)) if x < 5 or y > 4 else (30, 40, 200)
    colors = [(230, 60, 40), (250, 240, 200), (40, 90, 160), (20, 20, 30)]
    return {"rgb": grid(8, rgb), "palette": grid(8, lambda x, y: colors[(x // 2 + 3 * (y // 3)) % 4]),
            "grey": grid(8, lambda x, y: 20 + 28 * x if y < 5 else 235 - 20 * y),
            "grey16": grid(8, lambda x, y: 3000 + 777 * (x * 8 + y)),
            "rgb16": grid(8, lambda x, y: (60000 - 7001 * x, 5000 + 6003 * y, 30000))}, colors


def texture_settings():
    """A wall of 4 x 4 unit panels seen squarely under radiance 1: a Lambert wall shows its texture."""
    g = Glb(color=(1, 1, 1))
    g.uses("KHR_texture_transform")
    rows, colors = pictures()
    files = {"rgb": image.png(rows["rgb"]), "grey": image.png(rows["grey"]), "grey16": image.png(rows["grey16"], 16),
             "rgb16": image.png(rows["rgb16"], 16),
             "palette": image.png([[colors.index(c) for c in row] for row in rows["palette"]], 2, palette=colors)}
    images = {name: g.image(data) for name, data in files.items()}
    low, high = -0.7, 1.6
    sets = ([(low, high), (high, high), (high, low), (low, low)], [(0, 0), (0, 1), (1, 1), (1, 0)])
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    attributes = {"POSITION": g.accessor(corners, bounds=True), "TEXCOORD_0": g.accessor(sets[0], "VEC2"),
                  "TEXCOORD_1": g.accessor(sets[1], "VEC2")}
    indices = g.indices([(0, 1, 2), (0, 2, 3)])
    for slot, (u, v, nearest, offset, scale, turn, coordinates, name) in enumerate(PANELS):
        info = {"index": g.texture(images[name], (u, v), nearest)}
        if coordinates:
            info["texCoord"] = coordinates
        transform = {key: value for key, value in (("offset", offset), ("rotation", turn), ("scale", scale))
                     if value is not None}
        if transform:
            info["extensions"] = {"KHR_texture_transform": transform}
        material = g.material("panel %d" % slot, (1, 1, 1), 1.0, specular=0.0, textures={"baseColorTexture": info})
        mesh = g.add("meshes", {"name": "panel %d" % slot, "primitives": [
            {"attributes": attributes, "indices": indices, "material": material}]})
        g.node(mesh=mesh, translation=[slot % 4 - 2, 1 - slot // 4, 0])
    g.camera((0, 0, 3), (0, 0, 0), ymag=2.0)
    return g


def jpeg(data):
    """A wall covered by a JPEG photograph's worth of colours, seen squarely under radiance 1."""
    g = Glb(color=(1, 1, 1))
    picture = g.texture(g.image((data / "wood.jpg").read_bytes(), "image/jpeg"), wrap=(CLAMP, CLAMP))
    g.put(quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), True),
          g.material("wood", (1, 1, 1), 1.0, specular=0.0, textures={"baseColorTexture": {"index": picture}}))
    g.camera((0, 0, 3), (0, 0, 0), ymag=1.0)
    return g


def vertex_colors():
    """Colours at vertices, linear and interpolated linearly, multiplied with base colour and texture."""
    g = Glb(color=(0.5, 0.55, 0.6))
    sheet = plate(1.0, 1.0, 40, steps=6, rows=3)
    sheet.tangents = ()
    rainbow = [(0.5 + 0.5 * math.cos(0.9 * i), 0.5 + 0.5 * math.cos(0.9 * i + 2.1), 0.5 + 0.5 * math.cos(0.9 * i + 4.2))
               for i in range(len(sheet.positions))]
    sheet.colors = rainbow
    g.put(sheet, g.material("painted", (0.9, 0.9, 0.9), 0.5), at=(-1.1, 0.2, 0))
    checks = g.texture(g.image(image.png(grid(4, lambda x, y: (x + y) % 2), 1, palette=[(90, 90, 90), (250, 250, 250)])),
                       nearest=True)
    tinted = quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), True)
    tinted.colors = [(1, 0, 0, 1), (0, 1, 0, 1), (0, 0, 1, 1), (1, 1, 0, 1)]
    g.put(tinted, g.material("checked", (1, 1, 1), 0.7, textures={"baseColorTexture": {"index": checks}}), at=(1.15, 0.2, -0.1),
          turn=rotation((0, 1, 0), -15))
    g.put(floor(4, -0.9), g.material("floor", (0.4, 0.4, 0.4), 0.8, specular=0.2))
    g.light("directional", (-2, 3, 4), intensity=1.5, aim=(0, 0, 0))
    g.camera((0, 0.9, 7), (0, 0.05, 0), 36)
    return g


def alpha():
    """A cut-out disc, a fading curtain, a half-transparent glowing pane, and their shadows."""
    g = Glb(color=(0.12, 0.14, 0.18))
    def disc(x, y):
        r = math.hypot(x - 7.5, y - 7.5)
        return (220, 120 + 6 * x, 50, int(max(0, min(255, 255 - 60 * (r - 3) * (r > 3)))) if not 9 <= x + y <= 11 else 20)
    masked = g.texture(g.image(image.png(grid(16, disc))), wrap=(CLAMP, CLAMP))
    faded = g.texture(g.image(image.png(grid(8, lambda x, y: (60, 190, 130, 36 * x)))), wrap=(CLAMP, CLAMP))
    card = quad((-0.7, 0, 0), (0.7, 0, 0), (0.7, 1.4, 0), (-0.7, 1.4, 0), True)
    g.put(floor(4), g.material("floor", (0.6, 0.6, 0.6), 0.8, specular=0.2), name="floor")
    g.put(card, g.material("disc", (1, 1, 1), 0.6, textures={"baseColorTexture": {"index": masked}}, mode="MASK", cutoff=0.6),
          at=(-1.05, 0.02, 0.4), turn=rotation((0, 1, 0), 20), name="disc")
    g.put(card, g.material("curtain", (1, 0.9, 0.9), 0.6, textures={"baseColorTexture": {"index": faded}}, mode="BLEND",
                           alpha=0.9), at=(0.75, 0.02, 0.55), turn=rotation((0, 1, 0), -15), name="curtain")
    g.put(card, g.material("pane", (0.2, 0.3, 0.7), 0.5, emit=(0.5, 0.2, 0.1), mode="BLEND", alpha=0.4),
          at=(0.15, 0.02, -0.8), name="pane")
    g.put(box(), g.material("box", (0.6, 0.5, 0.15), 0.6), at=(0.9, 0.3, -1.6), scale=0.3)
    g.light("point", (-1.6, 3.4, -2.6), intensity=26)
    g.light("directional", (2, 3, 4), color=(0.6, 0.7, 1), intensity=0.8, aim=(0, 0, 0))
    g.camera((0.2, 2.3, 5.6), (0, 0.5, -0.2), 32)
    return g


def khr_specular():
    """KHR_materials_ior, _specular and _emissive_strength: they map exactly."""
    g = Glb(environment=STUDIO)
    def material(name, emit=None, **extensions):
        return g.material(name, (0.2, 0.05, 0.04), 0.25, emit=emit,
                          extensions={"KHR_materials_" + key: value for key, value in extensions.items()})
    row = [material("ior 1.2", ior={"ior": 1.2}), material("ior 1.5", ior={"ior": 1.5}),
           material("ior 1.7", ior={"ior": 1.7}), material("specular .3", specular={"specularFactor": 0.3}),
           material("both", ior={"ior": 1.7}, specular={"specularFactor": 0.5}),
           material("glow", emit=(0.3, 0.2, 0.05), emissive_strength={"emissiveStrength": 2.5})]
    return arrange(g, ball().smooth(), [row])


def khr_layers():
    """KHR_materials_clearcoat, _sheen and _anisotropy: Disney's lobes are not Khronos', so they are read by their meaning."""
    g = Glb(environment=STUDIO)
    def material(name, base, rough, metal=0.0, **extensions):
        return g.material(name, base, rough, metal, extensions={"KHR_materials_" + k: v for k, v in extensions.items()})
    red, cloth, gold = (0.3, 0.02, 0.03), (0.1, 0.05, 0.2), (0.95, 0.8, 0.55)
    rows = [[material("coat", red, 0.6, clearcoat={"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.1}),
             material("thin coat", red, 0.6, clearcoat={"clearcoatFactor": 0.4, "clearcoatRoughnessFactor": 0.4}),
             material("sheen", cloth, 0.9, sheen={"sheenColorFactor": [0.8, 0.7, 0.9], "sheenRoughnessFactor": 0.5})],
            [material("brushed", gold, 0.45, 1.0, anisotropy={"anisotropyStrength": 0.9}),
             material("turned", gold, 0.45, 1.0, anisotropy={"anisotropyStrength": 0.9, "anisotropyRotation": 0.8}),
             material("dull", gold, 0.45, 1.0)]]
    balls, sheet = ball().smooth(), plate(1.0, 1.0, 60)
    for j, (shape, row) in enumerate(zip((balls, sheet), rows)):
        for i, item in enumerate(row):
            g.put(shape, item, at=(SPACING * (i - 1), SPACING * (0.5 - j), 0))
    g.camera((0, 5, 16), (0, 0, 0), 16.5, aspect=1.5)
    return g
