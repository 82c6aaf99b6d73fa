"""The scenes of exposures.py, as small as the question allows. Runs inside Blender:

    blender -b --factory-startup -P scenes_in_blender.py -- FOLDER NAME...

Every picture is written to FOLDER/NAME.KEY.exr, float, linear. Only Blender's own settings are used; approximations that
can be switched off are.
"""

import math
import os
import sys

import bpy
from mathutils import Matrix, Vector

SIZE = 32


class Scene:
    """An empty scene with an orthographic camera that sees `width` metres around `target` from `direction`."""

    def __init__(self, direction, target=(0, 0, 0), width=.01):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = bpy.context.scene
        camera = bpy.data.cameras.new("camera")
        camera.type, camera.ortho_scale, camera.clip_start = "ORTHO", width, 1e-4
        self.scene.camera = self.add(camera)
        self.scene.camera.matrix_world = Matrix.Translation(Vector(target) + 10 * Vector(direction)) @ turned_to(direction)

    def add(self, data):
        thing = bpy.data.objects.new(data.name, data)
        self.scene.collection.objects.link(thing)
        return thing

    def quad(self, material, corners, cuts=1):
        """A flat quadrilateral of cuts x cuts x 2 triangles."""
        a, b, c, d = map(Vector, corners)
        n = cuts + 1
        points = [(a.lerp(b, i / cuts)).lerp(d.lerp(c, i / cuts), j / cuts) for j in range(n) for i in range(n)]
        faces = []
        for j in range(cuts):
            for i in range(cuts):
                k = j * n + i
                faces += [(k, k + 1, k + n + 1), (k, k + n + 1, k + n)]
        mesh = bpy.data.meshes.new("quad")
        mesh.from_pydata([tuple(p) for p in points], [], faces)
        mesh.materials.append(material)
        thing = self.add(mesh)
        thing.cycles.shadow_terminator_geometry_offset = 0
        return thing

    def plane(self, material, half=1.):
        return self.quad(material, [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)])

    def lamp(self, kind, energy, place=(0, 0, 0), direction=(0, 0, 1), **settings):
        data = bpy.data.lights.new(kind, kind)
        data.energy = energy
        for name, value in settings.items():
            setattr(data, name, value)
        thing = self.add(data)
        thing.matrix_world = Matrix.Translation(place) @ turned_to(direction)
        return thing

    def world(self, strength=1., image=None, sampling="AUTOMATIC"):
        world = self.scene.world = bpy.data.worlds.new("world")
        world.use_nodes = True
        background = world.node_tree.nodes["Background"]
        background.inputs["Color"].default_value = (1, 1, 1, 1)
        background.inputs["Strength"].default_value = strength
        if image:
            node = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
            node.image = image
            world.node_tree.links.new(node.outputs[0], background.inputs["Color"])
        world.cycles.sampling_method = sampling

    def render(self, key, spp=1, seed=1, size=SIZE, offset=0):
        render, cycles = self.scene.render, self.scene.cycles
        render.engine = "CYCLES"
        for name, value in {
                "device": "CPU", "samples": spp, "seed": seed, "sample_offset": offset, "use_adaptive_sampling": False,
                "use_denoising": False, "max_bounces": 0, "min_light_bounces": 1024, "sample_clamp_direct": 0,
                "sample_clamp_indirect": 0, "light_sampling_threshold": 0, "blur_glossy": 0, "pixel_filter_type": "BOX",
                "film_exposure": 1, "use_auto_tile": False}.items():
            setattr(cycles, name, value)
        render.resolution_x = render.resolution_y = size
        render.resolution_percentage = 100
        render.threads_mode, render.threads = "FIXED", 2
        render.image_settings.file_format = "OPEN_EXR"
        render.image_settings.color_depth = "32"
        render.filepath = os.path.join(FOLDER, f"{NAME}.{key}.exr")
        bpy.ops.render.render(write_still=True)


def turned_to(direction):
    return Vector(direction).to_track_quat("Z", "Y").to_matrix().to_4x4()


def at(degrees, azimuth=0.):
    t, p = math.radians(degrees), math.radians(azimuth)
    return (math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t))


def principled(vectors=(), **sockets):
    """A Principled BSDF (GGX); black and without lobes but for the sockets given, spelt as in Blender with _ for blanks.
    `vectors`: those to be linked (Normal, Tangent)."""
    material = bpy.data.materials.new("principled")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    bsdf = nodes["Principled BSDF"]
    bsdf.distribution = "GGX"
    for name, value in {"Base_Color": (0, 0, 0, 1), "Specular": 0, "Metallic": 0, **sockets}.items():
        bsdf.inputs[name.replace("_", " ")].default_value = value
    for name, vector in dict(vectors).items():
        node = nodes.new("ShaderNodeCombineXYZ")
        for i in range(3):
            node.inputs[i].default_value = vector[i]
        material.node_tree.links.new(node.outputs[0], bsdf.inputs[name])
    return material


def shader(kind, **inputs):
    material = bpy.data.materials.new(kind)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    node = nodes.new(kind)
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    material.node_tree.links.new(node.outputs[0], nodes["Material Output"].inputs["Surface"])
    return material


WHITE = (1, 1, 1, 1)


def clearcoat():
    """A lone coat in a white furnace, and under an area lamp with and without BSDF samples that find it."""
    for roughness, angle in ((.3, 30), (.3, 75), (1, 75)):
        scene = Scene(at(angle))
        scene.plane(principled(Clearcoat=1, Clearcoat_Roughness=roughness), 10)
        scene.world()
        scene.render(f"furnace {roughness} {angle}", 1024)
    for mis in (True, False):
        scene = Scene(at(30))
        scene.plane(principled(Clearcoat=1, Clearcoat_Roughness=.2))
        x, y, z = at(30, 180)
        lamp = scene.lamp("AREA", 40, (2 * x, 2 * y, 2 * z), (x, y, z), shape="DISK", size=2)
        lamp.data.cycles.use_multiple_importance_sampling = mis
        scene.render(f"lamp {'with' if mis else 'without'}", 1024)


def normal_incidence():
    """An anisotropic metal seen exactly along its normal, and a thousandth of a degree beside it."""
    for key, angle in (("along", 0), ("beside", .001)):
        for anisotropic in (0, .8):
            scene = Scene(at(angle))
            scene.plane(principled({"Tangent": (1, 0, 0)}, Base_Color=WHITE, Metallic=1, Roughness=.5, Anisotropic=anisotropic))
            scene.lamp("SUN", 1, direction=at(30, 40), angle=0)
            scene.render(f"{key} {anisotropic}", size=4)


def lamps():
    """Radiance of an area lamp of 1 W and 2 m^2; irradiance below point and spot lamps, straight down and 40 degrees off."""
    scene = Scene((0, 0, -1))
    lamp = scene.lamp("AREA", 1, shape="RECTANGLE", size=2, size_y=1)
    lamp.visible_camera = True
    scene.render("area", size=4)
    for kind, settings in (("POINT", {}), ("SPOT", {"spot_size": math.radians(120), "spot_blend": 0})):
        for key, angle in (("0", 0), ("40", 40)):
            x = math.tan(math.radians(angle))
            scene = Scene((0, 0, 1), (x, 0, 0), 1e-4)
            scene.plane(shader("ShaderNodeBsdfDiffuse", Color=WHITE))
            scene.lamp(kind, 4 * math.pi, (0, 0, 1), shadow_soft_size=0, **settings)
            scene.render(f"{kind.lower()} {key}", size=4)


def emitters():
    """A white wall that sees a square emitter at a grazing angle, `height` above its plane: two triangles, or 512."""
    for height in (.001, .003, .01, .03, .1):
        for key, cuts in (("large", 1), ("small", 16)):
            scene = Scene((-1, 0, 0), (1.5, 0, height), height / 4)
            low, high, half = .75 * height, 1.25 * height, height / 4
            scene.quad(shader("ShaderNodeBsdfDiffuse", Color=WHITE),
                       [(1.5, -half, low), (1.5, -half, high), (1.5, half, high), (1.5, half, low)])
            glow = shader("ShaderNodeEmission", Color=WHITE, Strength=1)
            scene.quad(glow, [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], cuts)
            scene.render(f"{key} {height}", 1024)


def first_sample():
    """A white half plane whose edge leaves a quarter of every pixel of one column black; one and four samples, many seeds."""
    scene = Scene((0, 0, 1), (0, 0, 0), 1.)
    glow = shader("ShaderNodeEmission", Color=WHITE, Strength=1)
    scene.quad(glow, [(.25 / 8, -1, 0), (2, -1, 0), (2, 1, 0), (.25 / 8, 1, 0)])
    for spp in (1, 4):
        for offset in (0, spp):
            for seed in range(1, 33):
                scene.render(f"{spp} {offset} {seed}", spp, seed, 8, offset)


def poles():
    """An environment whose top row is white and all others black, seen straight up and down, and a texel beside."""
    import numpy as np
    width, height = 32, 16
    image = bpy.data.images.new("poles", width, height, float_buffer=True, is_data=True)
    texels = np.zeros((height, width, 4), np.float32)
    texels[..., 3] = 1
    texels[-1, :, :3] = 1  # Blender's last row is the top
    image.pixels.foreach_set(texels.ravel())
    keep = saved(image, "poles")
    for key, elevation in (("up", 90), ("quarter", 90 - 180 / height / 4), ("centre", 90 - 180 / height / 2), ("down", -90)):
        scene = Scene(tuple(-c for c in at(90 - elevation)))
        scene.world(image=bpy.data.images.load(keep))
        scene.render(key, size=4)


def normal_map():
    """A rough metal with a tilted shading normal in a white furnace, found by BSDF samples, and by light samples too."""
    white = white_map()
    for tilt in (0, 20, 35):
        vectors = {"Normal": at(tilt, 180)} if tilt else {}
        for key, image in (("bsdf", None), ("both", white)):
            scene = Scene(at(10))
            scene.plane(principled(vectors, Base_Color=WHITE, Metallic=1, Roughness=.6), 10)
            scene.world(image=image and bpy.data.images.load(image), sampling="MANUAL" if image else "NONE")
            scene.render(f"{key} {tilt}", 1024)


def white_map():
    """The path of an environment that is 1 everywhere: Cycles samples maps, but not a plain colour."""
    image = bpy.data.images.new("white", 64, 32, float_buffer=True, is_data=True)
    image.pixels.foreach_set([1.] * (64 * 32 * 4))
    return saved(image, "white")


def saved(image, name):
    image.update()
    image.pack()
    image.filepath_raw, image.file_format = os.path.join(FOLDER, f"map.{name}.exr"), "OPEN_EXR"
    image.save()
    return image.filepath_raw


arguments = sys.argv[sys.argv.index("--") + 1:]
FOLDER = arguments[0]
for NAME in arguments[1:]:
    globals()[NAME]()
