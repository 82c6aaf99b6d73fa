"""Build a small scene in Blender and export it with Blender's own glTF exporter:

    blender -b --factory-startup -P make_asset.py -- OUT.glb

What a user of Blender would do: modifiers, UV maps, several materials, Disney parameters as custom properties
(docs/formats.md), lights in watts, a camera. The stored result is the scene `blender_asset`.
"""

import math
import sys

import bpy
import numpy
from mathutils import Vector

if "bool" not in vars(numpy):
    numpy.bool = bool  # the exporter of Blender 3.4 spells it so; numpy has dropped the name


def material(name, color, roughness, metallic=0.0, image=None, emission=None, **disney):
    """A Principled material; `disney` becomes custom properties, which the exporter writes as extras."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    bsdf = nodes["Principled BSDF"]
    bsdf.inputs["Base Color"].default_value = (*color, 1)
    bsdf.inputs["Roughness"].default_value = roughness
    bsdf.inputs["Metallic"].default_value = metallic
    if emission:
        bsdf.inputs["Emission"].default_value = (*emission, 1)
        bsdf.inputs["Emission Strength"].default_value = 1.0
    if image:
        node = nodes.new("ShaderNodeTexImage")
        node.image = image
        links.new(node.outputs["Color"], bsdf.inputs["Base Color"])
    for key, value in disney.items():
        made["disney_" + key] = value
    return made


def checker(name, size, colors):
    """A packed image of four by four squares, sRGB codes."""
    image = bpy.data.images.new(name, size, size)
    cell = size // 4
    pixels = []
    for y in range(size):
        for x in range(size):
            pixels += [c / 255 for c in colors[(x // cell + y // cell + (x // cell == 0)) % len(colors)]] + [1.0]
    image.pixels = pixels
    image.pack()
    return image


def smooth(thing, auto=None):
    for polygon in thing.data.polygons:
        polygon.use_smooth = True
    if auto is not None:
        thing.data.use_auto_smooth = True
        thing.data.auto_smooth_angle = math.radians(auto)


def aim(thing, target):
    thing.rotation_euler = (Vector(target) - thing.location).to_track_quat("-Z", "Y").to_euler()


def build():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene["environment_color"] = (0.22, 0.25, 0.30)

    bpy.ops.mesh.primitive_plane_add(size=9)
    tiles = checker("tiles", 32, ((150, 146, 138), (96, 92, 96), (176, 168, 150)))
    ground = bpy.context.object
    ground.data.materials.append(material("ground", (1, 1, 1), 0.8, image=tiles, specular=0.2))
    for loop in ground.data.uv_layers[0].data:
        loop.uv = loop.uv * 2.25

    bpy.ops.mesh.primitive_monkey_add(size=1.7, location=(-0.35, 0.1, 0.74), rotation=(-0.5, 0, 0.35))
    head = bpy.context.object
    head.modifiers.new("finer", "SUBSURF").levels = 1
    smooth(head)
    head.data.materials.append(material("copper", (0.75, 0.36, 0.22), 0.5, 1.0, specular=0.5))

    bpy.ops.mesh.primitive_cube_add(size=0.9, location=(1.45, 0.5, 0.46), rotation=(0, 0, 0.5))
    block = bpy.context.object
    bevel = block.modifiers.new("rounded", "BEVEL")
    bevel.width, bevel.segments = 0.14, 3
    smooth(block, auto=40)
    block.data.materials.append(material("velvet", (0.12, 0.05, 0.25), 0.9, sheen=1.0, sheen_tint=0.3, specular=0.1))
    block.data.materials.append(material("lid", (0.7, 0.6, 0.2), 0.35, specular=0.8, specular_tint=0.6))
    top = max(range(len(block.data.polygons)), key=lambda i: block.data.polygons[i].center.z)
    block.data.polygons[top].material_index = 1

    bpy.ops.mesh.primitive_cylinder_add(vertices=20, radius=0.16, depth=0.3, location=(0.9, -0.75, 0.16))
    pin = bpy.context.object
    smooth(pin, auto=40)
    row = pin.modifiers.new("row", "ARRAY")
    row.count, row.use_relative_offset, row.use_constant_offset = 3, False, True
    row.constant_offset_displace = (0.42, 0.12, 0)
    pin.data.materials.append(material("enamel", (0.1, 0.4, 0.35), 0.3))

    bpy.ops.mesh.primitive_cone_add(vertices=4, radius1=0.2, depth=0.5, location=(-1.25, -0.85, 0.26), rotation=(0, 0, 0.4))
    spike = bpy.context.object
    centre = bpy.data.objects.new("centre", None)
    centre.location = (-0.45, 0, 0)
    bpy.context.scene.collection.objects.link(centre)
    mirror = spike.modifiers.new("other side", "MIRROR")
    mirror.use_axis = (True, False, False)
    mirror.mirror_object = centre
    spike.data.materials.append(material("glow", (0.05, 0.05, 0.05), 0.7, emission=(0.5, 0.22, 0.05)))

    for kind, name, energy, color, place in (("POINT", "key", 900, (1, 0.9, 0.8), (-3.0, -3.2, 4.2)),
                                             ("SUN", "sun", 0.8, (0.7, 0.8, 1), (4, -1, 3))):
        lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, kind))
        lamp.data.energy, lamp.data.color, lamp.location = energy, color, place
        aim(lamp, (0, 0, 0))
        scene.collection.objects.link(lamp)

    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = (0.6, -7.2, 3.0)
    camera.data.lens = 70
    aim(camera, (0.3, 0, 0.55))
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = 512


def main():
    out = sys.argv[sys.argv.index("--") + 1]
    if not bpy.app.version_string.startswith("3.4"):
        print(f"make_asset.py: warning: the stored asset was written by Blender 3.4.1, this is {bpy.app.version_string}")
    build()
    result = bpy.ops.export_scene.gltf(filepath=out, export_format="GLB", export_extras=True, export_apply=True,
                                       export_cameras=True, export_lights=True, export_yup=True)
    if result != {"FINISHED"}:
        sys.exit(f"make_asset.py: {out}: wanted the exporter to finish, found {result}")


main()
