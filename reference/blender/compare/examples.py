"""Small .blend files for the tests and for docs/compare-blend.md. Runs inside Blender:

    blender -b --factory-startup -P examples.py -- DIR [NAME...]

Each scene is a few objects on a floor, a camera and a light, and shows one thing.
"""

import math
import os
import sys

import bpy
from mathutils import Vector

STUDIO = os.path.join(bpy.utils.system_resource("DATAFILES"), "studiolights", "world")


def material(name="m", **sockets):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    bsdf = made.node_tree.nodes["Principled BSDF"]
    for key, value in sockets.items():
        socket = bsdf.inputs[key.replace("_", " ")]
        socket.default_value = (*value, 1) if isinstance(value, tuple) else value
    return made, made.node_tree, bsdf


def look_at(thing, target):
    thing.rotation_euler = (Vector(target) - thing.location).to_track_quat("-Z", "Y").to_euler()


def ball(look, x=0.0, smooth=True):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=.8, location=(x, 0, .8))
    thing = bpy.context.object
    for polygon in thing.data.polygons:
        polygon.use_smooth = smooth
    thing.data.materials.append(look)
    return thing


def floor(look=None):
    bpy.ops.mesh.primitive_plane_add(size=12)
    bpy.context.object.data.materials.append(look or material("floor", Base_Color=(.5, .5, .5), Roughness=.9, Specular=.2)[0])


def lamp(kind="POINT", energy=400.0, place=(-2.5, -3, 4), **properties):
    data = bpy.data.lights.new(kind.lower(), kind)
    data.energy = energy
    for key, value in {"shadow_soft_size": 0, **properties}.items():
        if hasattr(data, key):
            setattr(data, key, value)
    thing = bpy.data.objects.new(kind.lower(), data)
    thing.location = place
    bpy.context.scene.collection.objects.link(thing)
    look_at(thing, (0, 0, .5))
    return thing


def world(color=(.2, .22, .25)):
    made = bpy.data.worlds.new("world")
    made.use_nodes = True
    made.node_tree.nodes["Background"].inputs["Color"].default_value = (*color, 1)
    bpy.context.scene.world = made
    return made.node_tree


def start():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = (.4, -6, 2.4)
    look_at(camera, (0, 0, .7))
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 240, 160


def pair(first, second):
    """Two materials side by side on a floor, under a lamp and a grey sky."""
    floor()
    ball(first, -.9)
    ball(second, .9)
    lamp()
    world()


def diffuse():
    pair(material("rough", Base_Color=(.8, .3, .2), Roughness=1.0, Specular=0.0)[0],
         material("smooth", Base_Color=(.2, .4, .8), Roughness=.2, Specular=0.0)[0])


def specular():
    pair(material("plastic", Base_Color=(.1, .4, .1), Roughness=.3, Specular=.8, Specular_Tint=.7)[0],
         material("gold", Base_Color=(.9, .6, .2), Roughness=.4, Metallic=1.0)[0])


def sheen():
    pair(material("velvet", Base_Color=(.3, .05, .1), Roughness=.9, Sheen=1.0, Sheen_Tint=.8, Specular=.1)[0],
         material("cloth", Base_Color=(.1, .1, .3), Roughness=.9, Sheen=.6, Sheen_Tint=0.0)[0])


def clearcoat_lamp():
    """The light of a lamp alone on a convex body, where Blender's clearcoat is right."""
    ball(material("paint", Base_Color=(.4, .02, .02), Roughness=.6, Clearcoat=1.0, Clearcoat_Roughness=.3)[0])
    lamp(place=(-1, -5, 3))


def clearcoat_sky():
    ball(material("paint", Base_Color=(.02, .02, .02), Roughness=.8, Specular=0.0, Clearcoat=1.0, Clearcoat_Roughness=.5)[0])
    world((.8, .8, .8))
    bpy.context.scene.world.cycles_visibility.camera = False  # nothing but the ball counts


def anisotropic():
    pair(material("turned", Base_Color=(.9, .8, .7), Roughness=.4, Metallic=1.0, Anisotropic=.8)[0],
         material("across", Base_Color=(.9, .8, .7), Roughness=.4, Metallic=1.0, Anisotropic=.8, Anisotropic_Rotation=.25)[0])


def brushed():
    """Anisotropy along a UV map."""
    look, tree, bsdf = material("brushed", Base_Color=(.8, .8, .85), Roughness=.4, Metallic=1.0, Anisotropic=.7)
    node = tree.nodes.new("ShaderNodeTangent")
    node.direction_type = "UV_MAP"
    tree.links.new(node.outputs[0], bsdf.inputs["Tangent"])
    floor(look)
    ball(look)
    lamp()
    world()


def glow():
    floor()
    shine, tree, bsdf = material("shine")
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value, emission.inputs["Strength"].default_value = (1, .6, .2, 1), 6
    tree.links.new(emission.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    ball(shine, -.9, smooth=False)
    ball(material("warm", Base_Color=(.5, .5, .5), Emission=(.1, .3, .1), Emission_Strength=1.0)[0], .9)


def checker(tree, bsdf, color_space="sRGB"):
    image = bpy.data.images.new("checker", 16, 16)
    image.colorspace_settings.name = color_space
    image.pixels = [v for y in range(16) for x in range(16)
                    for v in ((.8, .7, .5, 1) if (x // 4 + y // 4) % 2 else (.2, .25, .4, 1))]
    image.pack()
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    return node


def textured():
    look, tree, bsdf = material("tiles", Roughness=.5)
    node = checker(tree, bsdf)
    tree.links.new(node.outputs["Color"], bsdf.inputs["Base Color"])
    pair(look, look)


def alpha():
    pair(material("thin", Base_Color=(.8, .2, .2), Alpha=.4)[0], material("solid", Base_Color=(.2, .6, .2))[0])


def lamps():
    floor()
    ball(material("grey", Base_Color=(.6, .6, .6), Roughness=.6)[0])
    lamp("SPOT", 600, (-2, -3, 4), spot_size=.6, spot_blend=.4, shadow_soft_size=.1)
    lamp("SUN", .8, (3, -1, 4), angle=.05)
    lamp("AREA", 60, (2.5, -2, 2.5), size=1.0, shape="DISK")


def studio(picture, turn=0.0):
    """One of the studio lights that come with Blender, turned about z."""
    nodes = world()
    texture, mapping, coordinates = (nodes.nodes.new("ShaderNode" + kind) for kind in ("TexEnvironment", "Mapping", "TexCoord"))
    texture.image = bpy.data.images.load(os.path.join(STUDIO, picture + ".exr"))
    mapping.inputs["Rotation"].default_value = (0, 0, turn)
    nodes.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    nodes.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    nodes.links.new(texture.outputs["Color"], nodes.nodes["Background"].inputs["Color"])
    floor()
    ball(material("metal", Base_Color=(.9, .9, .9), Roughness=.3, Metallic=1.0)[0], -.9)
    ball(material("white", Base_Color=(.8, .8, .8), Roughness=.5)[0], .9)


def sky_picture():
    studio("sunset", 1.0)


def sky_nodes():
    """A world that only Blender can compute."""
    nodes = world()
    gradient = nodes.nodes.new("ShaderNodeTexGradient")
    nodes.links.new(nodes.nodes.new("ShaderNodeTexCoord").outputs["Generated"], gradient.inputs["Vector"])
    nodes.links.new(gradient.outputs["Color"], nodes.nodes["Background"].inputs["Color"])
    floor()
    ball(material("white", Base_Color=(.8, .8, .8), Roughness=.5)[0])


def scatter(look):
    """Geometry nodes: a small ball on each corner of a square."""
    bpy.ops.mesh.primitive_plane_add(size=.7, location=(1.5, -1.4, .1))
    thing = bpy.context.object
    tree = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    tree.inputs.new("NodeSocketGeometry", "Geometry")
    tree.outputs.new("NodeSocketGeometry", "Geometry")
    kinds = ("NodeGroupInput", "GeometryNodeInstanceOnPoints", "GeometryNodeMeshIcoSphere", "GeometryNodeSetMaterial", "NodeGroupOutput")
    begin, instance, shape, paint, end = (tree.nodes.new(kind) for kind in kinds)
    shape.inputs["Radius"].default_value = .1
    paint.inputs["Material"].default_value = look
    tree.links.new(begin.outputs[0], instance.inputs["Points"])
    tree.links.new(shape.outputs["Mesh"], paint.inputs["Geometry"])
    tree.links.new(paint.outputs[0], instance.inputs["Instance"])
    tree.links.new(instance.outputs[0], end.inputs[0])
    thing.modifiers.new("scatter", "NODES").node_group = tree


def geometry():
    """Modifiers, instances of a collection, geometry nodes, text, two materials, a parent that shears, a mirrored copy."""
    floor()
    look = material("clay", Base_Color=(.7, .4, .3), Roughness=.6)[0]
    thing = ball(look, -1.4)
    thing.data.materials.append(material("moss", Base_Color=(.2, .5, .1), Roughness=.8)[0])
    for polygon in thing.data.polygons:
        polygon.material_index = polygon.center.z > 0
    group = bpy.data.collections.new("group")
    bpy.ops.mesh.primitive_monkey_add(size=.9, location=(0, 0, .7))
    head = bpy.context.object
    head.data.materials.append(look)
    for owner in list(head.users_collection):
        owner.objects.unlink(head)
    group.objects.link(head)
    for x, mirrored in ((.2, 1), (1.5, -1)):
        instance = bpy.data.objects.new("instance", None)
        instance.instance_type, instance.instance_collection = "COLLECTION", group
        instance.location, instance.scale = (x, 0, 0), (mirrored, 1, 1)
        bpy.context.scene.collection.objects.link(instance)
    parent = bpy.data.objects.new("parent", None)
    parent.scale = (1.6, 1, .6)
    bpy.context.scene.collection.objects.link(parent)
    bpy.ops.mesh.primitive_cube_add(size=.5, location=(-.5, -1.6, .6), rotation=(.3, .5, .7))
    bpy.context.object.parent = parent
    rounded = bpy.context.object.modifiers.new("rounded", "SUBSURF")  # round in renders only
    rounded.levels, rounded.render_levels = 0, 2
    bpy.context.object.data.materials.append(look)
    bpy.ops.object.text_add(location=(-.2, -1.8, .05), rotation=(1.3, 0, 0))
    bpy.context.object.data.body, bpy.context.object.data.extrude = "assay", .05
    bpy.context.object.scale = (.6, .6, .6)
    bpy.context.object.data.materials.append(look)
    scatter(look)
    lamp()
    world()


def not_carried():
    """Glass, procedural colour and a bump map: Blender's alone."""
    look, tree, bsdf = material("marble", Roughness=.4)
    noise, bump = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeBump")
    tree.links.new(noise.outputs["Color"], bsdf.inputs["Base Color"])
    tree.links.new(noise.outputs["Fac"], bump.inputs["Height"])
    tree.links.new(bump.outputs[0], bsdf.inputs["Normal"])
    pair(look, material("glass", Base_Color=(.9, .9, .9), Roughness=.1, Transmission=1.0)[0])


def empty():
    lamp()


def no_camera():
    pair(material()[0], material()[0])
    bpy.data.objects.remove(bpy.context.scene.camera)


def dark():
    """Nothing shines."""
    ball(material()[0])


SCENES = (diffuse, specular, sheen, anisotropic, brushed, clearcoat_lamp, clearcoat_sky, glow, textured, alpha, lamps, sky_picture,
          sky_nodes, geometry, not_carried, empty, no_camera, dark)
STUDIOS = ("city", "courtyard", "forest", "interior", "night", "studio", "sunrise", "sunset")


def main():
    folder, *wanted = sys.argv[sys.argv.index("--") + 1:]
    os.makedirs(folder, exist_ok=True)
    makers = {scene.__name__: scene for scene in SCENES}
    makers.update({"studio_" + name: lambda name=name: studio(name) for name in STUDIOS})
    for name in wanted or makers:
        start()
        makers[name]()
        bpy.context.preferences.filepaths.save_version = 0
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(os.path.abspath(folder), name + ".blend"))


main()
