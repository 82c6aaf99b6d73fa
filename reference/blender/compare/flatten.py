"""Whatever a .blend shows -> plain triangle meshes, lamps and one camera (runs inside Blender).

Modifiers, instances, particle instances, curves, text and metaballs become what Blender itself evaluates them to, at
render levels; the materials stay the file's own. Both renderers then see the same triangles.
"""

import math

import bmesh
import bpy
from mathutils import Matrix, Vector

import carry
from notes import Failure

SURFACES = ("MESH", "CURVE", "SURFACE", "FONT", "META")
UNSEEN = {"VOLUME": "a volume", "CURVES": "hair curves", "POINTCLOUD": "a point cloud", "GPENCIL": "grease pencil"}
LIGHT_TRIANGLES = 1024
RAYS = ("visible_camera", "visible_diffuse", "visible_glossy", "visible_transmission", "visible_shadow")


def flatten(scene, notes, camera_name):
    """Replaces the scene's objects. Returns the camera object."""
    source = _camera(scene, camera_name)
    _as_rendered(scene)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    pieces, lamps, meshes = [], [], {}
    for instance in depsgraph.object_instances:
        thing = instance.object
        if not instance.show_self:
            continue
        original = thing.original or thing
        if thing.type in SURFACES:
            key = (thing.data.as_pointer(), tuple(slot.material.name if slot.material else "" for slot in thing.material_slots))
            own = original.evaluated_get(depsgraph).data.as_pointer() == thing.data.as_pointer()
            if not own and original.type != "MESH":
                continue  # the mesh of a curve or text, which comes by itself too
            if key not in meshes:
                meshes[key] = _mesh(thing, depsgraph, own)
            if meshes[key] is not None:
                pieces.append((original.name, meshes[key], instance.matrix_world.copy()))
                _note_object(original, notes)
        elif thing.type == "LIGHT":
            lamps.append((original.name, original.data, instance.matrix_world.copy()))
        elif thing.type in UNSEEN:
            notes.change(f"'{original.name}': {UNSEEN[thing.type]}, left out of both")
    matrix = depsgraph.id_eval_get(source).matrix_world.copy()
    for collection in list(scene.collection.children):
        scene.collection.children.unlink(collection)
    for thing in list(scene.collection.objects):
        scene.collection.objects.unlink(thing)
    for name, mesh, world in pieces:
        _add_piece(scene, name, mesh, world)
    for name, data, world in lamps:
        _add_lamp(scene, notes, name, data, world)
    if not any(thing.type == "MESH" for thing in scene.collection.objects):
        raise Failure("wanted something to see, found no mesh, curve or text that is rendered")
    return _add_camera(scene, notes, source, matrix)


def _camera(scene, name):
    if name is None:
        if scene.camera is None or scene.camera.type != "CAMERA":
            raise Failure("wanted a camera, found none active in the scene (--camera NAME picks one)")
        return scene.camera
    cameras = [thing for thing in scene.objects if thing.type == "CAMERA"]
    found = next((thing for thing in cameras if thing.name == name), None)
    if found is None:
        raise Failure(f"camera: wanted one of {', '.join(thing.name for thing in cameras) or 'none'}, found {name}")
    return found


def _as_rendered(scene):
    """What the depsgraph evaluates is what the viewport shows: make that what a render would."""
    def show(layer):
        layer.hide_viewport = False
        for child in layer.children:
            show(child)

    show(bpy.context.view_layer.layer_collection)
    for collection in bpy.data.collections:
        collection.hide_viewport = collection.hide_render
    scene.render.use_simplify = False
    for thing in scene.objects:
        thing.hide_viewport = thing.hide_render
        if thing.hide_get():
            thing.hide_set(False)
        for modifier in thing.modifiers:
            modifier.show_viewport = modifier.show_render
            if modifier.type in ("SUBSURF", "MULTIRES"):
                modifier.levels = modifier.render_levels
    bpy.context.view_layer.update()


def _note_object(thing, notes):
    hidden = [ray[8:] for ray in RAYS if not getattr(thing, ray)]
    if hidden:
        notes.change(f"'{thing.name}': hidden from {', '.join(hidden)} rays; shown to all in both")
    for flag, name in (("is_holdout", "a holdout"), ("is_shadow_catcher", "a shadow catcher")):
        if getattr(thing, flag):
            notes.change(f"'{thing.name}': {name}; an ordinary surface in both")
    for system in thing.particle_systems:
        if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
            notes.change(f"'{thing.name}': hair '{system.name}', left out of both")


def _mesh(thing, depsgraph, own):
    """The evaluated mesh, or None if it has no faces. Not its own: made by geometry nodes, for which Blender 3.4 crashes in
    new_from_object."""
    if own:
        mesh = bpy.data.meshes.new_from_object(thing, preserve_all_data_layers=True, depsgraph=depsgraph)
    else:
        work, mesh = bmesh.new(), bpy.data.meshes.new(thing.name)
        work.from_mesh(thing.data)
        work.to_mesh(mesh)
        work.free()
    if mesh is None or not mesh.polygons:
        return None
    materials = [slot.material.original if slot.material else None for slot in thing.material_slots] if own else \
        [material.original if material else None for material in thing.data.materials]
    for index, material in enumerate(materials or [None]):  # no materials.clear(): it forgets which face has which
        if index < len(mesh.materials):
            mesh.materials[index] = material
        else:
            mesh.materials.append(material)
    for polygon in mesh.polygons:
        polygon.material_index = min(polygon.material_index, len(mesh.materials) - 1)
    for index in set(range(len(mesh.materials))) - {polygon.material_index for polygon in mesh.polygons}:
        mesh.materials[index] = next((m for m in mesh.materials if m), None)  # a slot that no face uses
    return mesh


def _triangulate(thing):
    """Before either renderer does it in its own way; custom normals stay."""
    mesh = thing.data
    if all(polygon.loop_total == 3 for polygon in mesh.polygons):
        return
    modifier = thing.modifiers.new("triangles", "TRIANGULATE")
    modifier.keep_custom_normals = mesh.has_custom_normals
    depsgraph = bpy.context.evaluated_depsgraph_get()
    triangles = bpy.data.meshes.new_from_object(thing.evaluated_get(depsgraph), preserve_all_data_layers=True,
                                                depsgraph=depsgraph)
    thing.modifiers.clear()
    for user in [other for other in bpy.data.objects if other.data == mesh]:
        user.data = triangles


def _divide_lights(mesh):
    """Cut shining flat triangles into small ones, for the reason given in geometry.subdivide_lights."""
    shining = {i for i, material in enumerate(mesh.materials) if material and carry.emits(material)}
    count = sum(polygon.material_index in shining for polygon in mesh.polygons)
    cuts = min(15, int((LIGHT_TRIANGLES / count) ** .5) - 1) if count else 0
    if cuts < 1 or mesh.has_custom_normals or any(polygon.use_smooth for polygon in mesh.polygons):
        return
    work = bmesh.new()
    work.from_mesh(mesh)
    edges = list({edge for face in work.faces if face.material_index in shining for edge in face.edges})
    bmesh.ops.subdivide_edges(work, edges=edges, cuts=cuts, use_grid_fill=True)
    bmesh.ops.triangulate(work, faces=work.faces[:])
    work.to_mesh(mesh)
    work.free()


def finish_meshes(scene):
    for thing in [thing for thing in scene.collection.objects if thing.type == "MESH"]:
        _triangulate(thing)
    for mesh in {thing.data.name: thing.data for thing in scene.collection.objects if thing.type == "MESH"}.values():
        _divide_lights(mesh)


def _link(scene, name, data, world):
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    thing.matrix_world = world
    thing.cycles.shadow_terminator_offset = thing.cycles.shadow_terminator_geometry_offset = 0
    return thing


def _add_piece(scene, name, mesh, world):
    location, rotation, scale = world.decompose()
    rebuilt = Matrix.LocRotScale(location, rotation, scale)
    error = max(abs(a - b) for one, other in zip(world, rebuilt) for a, b in zip(one, other))
    if error > 1e-5 * max(1e-9, max(abs(s) for s in scale)):  # a shear, which an object cannot hold: into the vertices
        mesh = mesh.copy()
        mesh.transform(world)
        world = Matrix.Identity(4)
    _link(scene, name, mesh, world)


def _add_lamp(scene, notes, name, data, world):
    where = f"lamp '{name}'"
    lamp = data.copy()
    color, strength = _lamp_nodes(lamp, notes, where)
    lamp.use_nodes = False
    lamp.color = [a * b for a, b in zip(lamp.color, color)]
    lamp.energy *= strength
    if lamp.energy <= 0 or max(lamp.color) <= 0:
        if lamp.energy < 0:
            notes.change(f"{where}: takes light away; left out of both")
        return
    if not data.cycles.cast_shadow:
        notes.change(f"{where}: casts shadows in both")
    lamp.cycles.cast_shadow, lamp.cycles.max_bounces = True, 1024
    if lamp.type == "AREA":
        return _add_panel(scene, notes, name, lamp, world)
    if lamp.type == "SUN":
        if lamp.angle > 0:
            notes.change(f"{where}: angle {math.degrees(lamp.angle):.3g}° made 0 in both")
        lamp.angle = 0
    else:
        if lamp.shadow_soft_size > 0:
            notes.change(f"{where}: radius {lamp.shadow_soft_size:.3g} m made 0 in both")
        lamp.shadow_soft_size = 0
        if lamp.type == "SPOT":
            notes.change(f"{where}: its cone falls off as glTF says in both")
            if lamp.spot_size >= math.pi:
                lamp.spot_size = math.radians(179.9)
    location, rotation, _ = world.decompose()
    _link(scene, name, lamp, Matrix.LocRotScale(location, rotation, Vector((1, 1, 1))))


def _lamp_nodes(lamp, notes, where):
    """What a lamp's nodes multiply it with: an Emission node of plain numbers, or nothing."""
    if not lamp.use_nodes or lamp.node_tree is None:
        return (1, 1, 1), 1
    output = lamp.node_tree.get_output_node("CYCLES")
    origin = carry.source(output.inputs["Surface"]) if output else None
    if origin is not None and origin.node.type == "EMISSION" and not any(s.is_linked for s in origin.node.inputs):
        return tuple(origin.node.inputs["Color"].default_value)[:3], origin.node.inputs["Strength"].default_value
    notes.change(f"{where}: its nodes are left out of both")
    return (1, 1, 1), 1


def _add_panel(scene, notes, name, lamp, world):
    """An area lamp as a shining one-sided mesh: the same radiance, and seen by the camera."""
    notes.change(f"lamp '{name}': its area made a shining surface, seen by the camera, in both")
    if lamp.spread < math.pi - 1e-4:
        notes.change(f"lamp '{name}': spread {math.degrees(lamp.spread):.0f}° made 180° in both")
    oblong = lamp.shape in ("RECTANGLE", "ELLIPSE")
    width, height = lamp.size, lamp.size_y if oblong else lamp.size
    round_lamp = lamp.shape in ("DISK", "ELLIPSE")
    mesh, work = bpy.data.meshes.new(name), bmesh.new()
    if round_lamp:
        bmesh.ops.create_circle(work, cap_ends=True, cap_tris=True, segments=64, radius=.5)
        # The circle of the polygon's own area.
        factor = math.sqrt(math.pi / (32 * math.sin(2 * math.pi / 64)))
        width, height = width * factor, height * factor
    else:
        bmesh.ops.create_grid(work, x_segments=1, y_segments=1, size=.5)
    bmesh.ops.scale(work, vec=(width, height, 1), verts=work.verts)
    wanted = Vector((0, 0, -1))  # a lamp shines along its -z
    for face in work.faces:
        face.normal_update()
        if face.normal.dot(wanted) < 0:
            face.normal_flip()
    scale = world.to_scale()
    area = width * height * (math.pi / 4 / factor ** 2 if round_lamp else 1) * abs(scale.x * scale.y)
    radiance = lamp.energy / (4 * area)
    work.to_mesh(mesh)
    work.free()
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shine, clear = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeBsdfTransparent")
    shine.inputs["Color"].default_value, shine.inputs["Strength"].default_value = (*lamp.color, 1), radiance
    mix, output = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeOutputMaterial")
    links.new(nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], mix.inputs[0])
    links.new(shine.outputs[0], mix.inputs[1])
    links.new(clear.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], output.inputs["Surface"])
    material["assay_panel"] = (*(c * radiance for c in lamp.color),)
    mesh.materials.append(material)
    _link(scene, name, mesh, world)


def _add_camera(scene, notes, source, world):
    data = source.data.copy()
    if data.type == "PANO":
        raise Failure(f"camera '{source.name}': wanted a perspective or orthographic one, found a panoramic one")
    if data.dof.use_dof:
        notes.change(f"camera '{source.name}': depth of field off in both")
        data.dof.use_dof = False
    if data.shift_x or data.shift_y:
        notes.change(f"camera '{source.name}': shift made 0 in both")
        data.shift_x = data.shift_y = 0
    data.clip_start, data.clip_end = 1e-4, 1e6
    location, rotation, _ = world.decompose()
    camera = _link(scene, source.name, data, Matrix.LocRotScale(location, rotation, Vector((1, 1, 1))))
    scene.camera = camera
    return camera
