"""A Blender world -> scene extras of docs/formats.md (runs inside Blender).

A plain colour and a latitude-longitude picture, turned about z or not, are carried over as they are. Any other world is
photographed by Cycles with a panoramic camera, and that picture lights both.
"""

import math
import os
import shutil

import bpy
import numpy as np

import carry

LINEAR = ("Linear", "Non-Color", "Raw")
BAKED = (1024, 512)


def carry_over(scene, notes, folder, exact):
    """The extras, and whether the camera sees the world. `exact` sets a scene's Cycles up."""
    world = scene.world
    if world is None:
        return {}, True
    rays = world.cycles_visibility
    for ray in ("diffuse", "glossy", "shadow"):
        if hasattr(rays, ray) and not getattr(rays, ray):
            notes.change(f"world: made visible to {ray} rays in both")
            setattr(rays, ray, True)
    extras = _extras(scene, world, notes, folder, exact)
    for key in ("environment", "environment_color"):
        if key in scene.keys() and key not in extras:
            notes.change(f"scene: custom property {key} ignored: the world says otherwise, and that is what Blender renders")
    return extras, rays.camera


def _extras(scene, world, notes, folder, exact):
    if not world.use_nodes or world.node_tree is None:
        return _color(world.color, 1)
    output = world.node_tree.get_output_node("CYCLES")
    origin = carry.source(output.inputs["Surface"]) if output else None
    if output is not None and output.inputs["Volume"].is_linked:
        notes.lose("world: volume")
    if origin is None:
        return {}
    background = origin.node
    if background.type == "BACKGROUND" and not background.inputs["Strength"].is_linked:
        strength = background.inputs["Strength"].default_value
        texture = carry.source(background.inputs["Color"])
        if texture is None:
            return _color(background.inputs["Color"].default_value, strength)
        extras = _picture(scene, texture.node, strength, notes, folder, exact)
        if extras:
            return extras
    return _bake(world, notes, folder, exact)


def _color(color, strength):
    radiance = [carry.clean(c * strength) for c in list(color)[:3]]
    return {"environment_color": radiance} if max(radiance) > 0 else {}


def _picture(scene, node, strength, notes, folder, exact):
    """An Environment Texture of linear floats that is at most turned about z; else None."""
    if node.type != "TEX_ENVIRONMENT" or node.image is None or node.projection != "EQUIRECTANGULAR":
        return None
    turn, origin = 0.0, carry.source(node.inputs["Vector"])
    if origin is not None and origin.node.type == "MAPPING":
        mapping = origin.node
        angles = mapping.inputs["Rotation"].default_value
        moved = any(mapping.inputs["Location"].default_value) if "Location" in mapping.inputs else False
        scaled = any(abs(s - 1) > 1e-6 for s in mapping.inputs["Scale"].default_value)
        linked = any(s.is_linked for s in mapping.inputs if s.name != "Vector")
        if angles[0] or angles[1] or moved or scaled or linked or mapping.vector_type not in ("POINT", "TEXTURE", "VECTOR"):
            return None
        turn = angles[2] if mapping.vector_type == "TEXTURE" else -angles[2]
        origin = carry.source(mapping.inputs["Vector"])
        if origin is None:
            return None
    if origin is not None and (origin.node.type, origin.name) != ("TEX_COORD", "Generated"):
        return None
    image = node.image
    suffix = {"OPEN_EXR": ".exr", "HDR": ".hdr"}.get(image.file_format)
    if suffix is None or image.source != "FILE" or image.colorspace_settings.name not in LINEAR or not image.size[0]:
        return None
    node.interpolation = "Linear"
    name = "environment" + suffix
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    bad = ~(np.isfinite(pixels) & (pixels >= 0))
    if bad.any():
        notes.change(f"world: {int(bad.sum())} values of '{image.name}' that are no radiance (negative, infinite) made 0 in both")
        name = "environment.exr"
        node.image = _write(scene, image, np.where(bad, 0, pixels), os.path.join(folder, name), exact)
    elif image.packed_file:
        with open(os.path.join(folder, name), "wb") as file:
            file.write(image.packed_file.data)
    else:
        shutil.copyfile(bpy.path.abspath(image.filepath, library=image.library), os.path.join(folder, name))
    return {"environment": name, "environment_strength": carry.clean(strength),
            "environment_rotation": carry.clean(math.degrees(turn))}


def _write(scene, image, pixels, path, exact):
    """A float picture as a file, and as the image that Blender reads back from it."""
    mended = bpy.data.images.new("environment", *image.size, float_buffer=True)
    mended.colorspace_settings.name = "Non-Color"
    mended.pixels.foreach_set(pixels)
    exact(scene, {"spp": 1, "depth": 1, "width": 16, "height": 16})  # for the file format: 32 bits
    mended.save_render(path, scene=scene)
    result = bpy.data.images.load(path)
    result.colorspace_settings.name = "Non-Color"
    result.pack()
    return result


def _bake(world, notes, folder, exact):
    notes.change(f"world: its nodes painted into a picture of {BAKED[0]} x {BAKED[1]}, which lights both")
    seen, world.cycles_visibility.camera = world.cycles_visibility.camera, True
    stage = bpy.data.scenes.new("world")
    stage.world = world
    camera = bpy.data.objects.new("panorama", bpy.data.cameras.new("panorama"))
    camera.data.type, camera.data.cycles.panorama_type = "PANO", "EQUIRECTANGULAR"
    camera.rotation_euler = (math.pi / 2, 0, -math.pi / 2)  # the middle of the picture is +x
    stage.collection.objects.link(camera)
    stage.camera = camera
    exact(stage, {"spp": 16, "depth": 1, "width": BAKED[0], "height": BAKED[1]})
    path = os.path.join(folder, "environment.exr")
    stage.render.filepath = path
    bpy.ops.render.render(scene=stage.name, write_still=True)
    bpy.data.scenes.remove(stage)
    bpy.data.objects.remove(camera)
    world.cycles_visibility.camera = seen
    # Blender shows the picture too.
    world.node_tree.nodes.clear()
    nodes, links = world.node_tree.nodes, world.node_tree.links
    texture, background = nodes.new("ShaderNodeTexEnvironment"), nodes.new("ShaderNodeBackground")
    texture.image = bpy.data.images.load(path)
    texture.image.pack()
    links.new(texture.outputs["Color"], background.inputs["Color"])
    links.new(background.outputs[0], nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    return {"environment": "environment.exr"}
