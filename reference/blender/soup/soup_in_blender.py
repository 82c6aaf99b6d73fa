"""Renders blocks of the triangle soup with Cycles, and what its shader saw. Runs inside Blender:

    blender -b --factory-startup -P soup_in_blender.py -- FOLDER

FOLDER/job.npz: `size` and, for every block k, arrays of size * size rows in pixel order (row by row from the top):
kK.vertices (n, 3, 3), kK.NAME for every attribute (n,) or (n, 3), and kK.light, the direction to the sun. Block K goes
to FOLDER/K.exr (multilayer, float): the radiance under a delta sun of irradiance 1, and as shader outputs (AOVs) the
normals, the view direction and every parameter. The line `sun: K x y z` tells the sun's direction as Cycles has it.
"""

import os
import sys

import bpy
import numpy as np
from mathutils import Matrix, Vector

NUMBERS = ("metallic", "roughness", "specular", "specular_tint", "anisotropic", "anisotropic_rotation", "sheen", "sheen_tint",
           "clearcoat", "clearcoat_roughness")
PREFIX = "soup_"  # "normal" alone is taken
SOCKETS = {"base": "Base Color", "tangent": "Tangent", "normal": "Normal", **{n: n.replace("_", " ").title() for n in NUMBERS}}


def make_exact(scene, size):
    """One sample, at the pixel's centre; no bounces, no light picked by chance, nothing approximated."""
    scene.render.engine = "CYCLES"
    for name, value in {
            "device": "CPU", "samples": 1, "use_adaptive_sampling": False, "use_denoising": False, "max_bounces": 0,
            "min_light_bounces": 1024, "min_transparent_bounces": 1024, "sample_clamp_direct": 0, "sample_clamp_indirect": 0,
            "light_sampling_threshold": 0, "blur_glossy": 0, "pixel_filter_type": "BOX", "film_exposure": 1,
            "use_auto_tile": False, "seed": 0}.items():
        setattr(scene.cycles, name, value)
    render = scene.render
    render.resolution_x = render.resolution_y = size
    render.resolution_percentage = 100
    render.use_compositing = render.use_sequencer = False
    render.threads_mode, render.threads = "FIXED", 2
    render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", size
    camera.data.clip_start, camera.data.clip_end = 1, 4096
    camera.location = (0, 0, 1024)
    scene.collection.objects.link(camera)
    scene.camera = camera


def make_material(layer, linked_normal):
    """A Principled BSDF whose every socket is a face attribute, and those values as outputs."""
    material = bpy.data.materials.new("soup")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    bsdf = nodes.new("ShaderNodeBsdfPrincipled")
    bsdf.distribution = "GGX"
    bsdf.subsurface_method = "BURLEY"
    links.new(bsdf.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])

    def attribute(name):
        node = nodes.new("ShaderNodeAttribute")
        node.attribute_type, node.attribute_name = "GEOMETRY", PREFIX + name
        return node.outputs

    def output(name, socket):
        node = nodes.new("ShaderNodeOutputAOV")
        node.name = name
        links.new(socket, node.inputs["Color"])
        if name not in layer.aovs:
            layer.aovs.add().name = name

    for name, socket in SOCKETS.items():
        if name != "normal" or linked_normal:
            value = attribute(name)["Fac" if name in NUMBERS else "Vector"]
            links.new(value, bsdf.inputs[socket])
            if name == "normal":
                links.new(value, bsdf.inputs["Clearcoat Normal"])
            if name not in NUMBERS:
                output(name, value)
    for first in range(0, len(NUMBERS), 3):
        packed = nodes.new("ShaderNodeCombineXYZ")
        for channel, name in enumerate(NUMBERS[first:first + 3]):
            links.new(attribute(name)["Fac"], packed.inputs[channel])
        output(f"numbers{first}", packed.outputs[0])
    geometry = nodes.new("ShaderNodeNewGeometry").outputs
    output("geometric", geometry["True Normal"])
    output("incoming", geometry["Incoming"])
    if not linked_normal:
        output("normal", geometry["Normal"])
    return material


def make_soup(materials, vertices, attributes):
    mesh = bpy.data.meshes.new("soup")
    mesh.from_pydata(vertices.reshape(-1, 3).tolist(), [], np.arange(3 * len(vertices)).reshape(-1, 3).tolist())
    for material in materials:
        mesh.materials.append(material)
    for name, values in attributes.items():
        if name == "linked_normal":
            mesh.polygons.foreach_set("material_index", values.astype(np.int32))
        elif values.ndim == 1:
            mesh.attributes.new(PREFIX + name, "FLOAT", "FACE").data.foreach_set("value", values.astype(np.float32))
        else:
            mesh.attributes.new(PREFIX + name, "FLOAT_VECTOR", "FACE").data.foreach_set("vector", values.astype(np.float32).ravel())
    soup = bpy.data.objects.new("soup", mesh)
    soup.cycles.shadow_terminator_geometry_offset = soup.cycles.shadow_terminator_offset = 0
    return soup


def place_sun(sun, direction):
    """Turns the sun to `direction`, or as little away from it (steps of 3e-7) as makes the float vector's float length
    exactly 1: then Cycles' own normalisation leaves it alone, and its direction is known to the last bit."""
    for step in range(1000):
        turned = Matrix.Rotation(step * 3e-7, 3, "X") @ Matrix.Rotation(step * 2e-7, 3, "Y") @ direction
        sun.matrix_world = turned.to_track_quat("Z", "Y").to_matrix().to_4x4()
        bpy.context.view_layer.update()
        x, y, z = (np.float32(c) for c in sun.matrix_world.col[2][:3])
        if {(x * x + y * y) + z * z, x * x + (y * y + z * z), (x * x + z * z) + y * y} == {np.float32(1)}:
            return x, y, z
    raise RuntimeError("no sun direction of float length 1")


def main():
    folder = sys.argv[sys.argv.index("--") + 1]
    job = np.load(os.path.join(folder, "job.npz"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    make_exact(scene, int(job["size"]))
    materials = [make_material(scene.view_layers[0], linked) for linked in (False, True)]
    data = bpy.data.lights.new("sun", "SUN")
    data.energy, data.angle, data.cycles.cast_shadow = 1, 0, False
    sun = bpy.data.objects.new("sun", data)
    scene.collection.objects.link(sun)
    block = 0
    while f"k{block}.light" in job:
        prefix = f"k{block}."
        fields = {name[len(prefix):]: job[name] for name in job.files if name.startswith(prefix)}
        direction = place_sun(sun, Vector(fields.pop("light").tolist()))
        soup = make_soup(materials, fields.pop("vertices"), fields)
        scene.collection.objects.link(soup)
        print("sun:", block, *(repr(float(x)) for x in direction), flush=True)
        scene.render.filepath = os.path.join(folder, f"{block}.exr")
        bpy.ops.render.render(write_still=True)
        bpy.data.objects.remove(soup)
        block += 1


main()
