"""Materials and world as Cycles shader nodes, built from what materials.py and gltf.py read (runs inside Blender).

One Principled BSDF (distribution GGX) per material; every number outside a socket's range is linked, because only
unlinked values are clamped. Back faces of single-sided materials are a Transparent BSDF, for every kind of ray.
"""

import math
import os
import tempfile

import bpy

from geometry import COLOR, TANGENT, TANGENT_SIGN
from gltf import GltfError


class Nodes:
    """A node tree, and short words for adding to it. Inputs are numbers, sequences or other nodes' output sockets."""

    def __init__(self, tree):
        self.tree = tree
        tree.nodes.clear()

    def add(self, kind, inputs=(), **properties):
        node = self.tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        for key, value in dict(inputs).items():
            self.set(node.inputs[key], value)
        return node

    def set(self, socket, value):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        elif isinstance(value, (int, float)):
            if 0 <= value <= 1:
                socket.default_value = value
            else:
                node = self.tree.nodes.new("ShaderNodeValue")
                node.outputs[0].default_value = value
                self.tree.links.new(node.outputs[0], socket)
        else:
            value = list(value)
            socket.default_value = value + [1.0] * (len(socket.default_value) - len(value))

    def math(self, operation, *values):
        return self.add("ShaderNodeMath", enumerate(values), operation=operation).outputs[0]

    def vector(self, operation, *values):
        node = self.add("ShaderNodeVectorMath", enumerate(values), operation=operation)
        return node.outputs["Value" if operation == "DOT_PRODUCT" else "Vector"]

    def scaled(self, vector, factor):
        return self.add("ShaderNodeVectorMath", {"Vector": vector, "Scale": factor}, operation="SCALE").outputs[0]

    def xyz(self, vector):
        return self.add("ShaderNodeSeparateXYZ", {0: vector}).outputs

    def combine(self, x, y, z):
        return self.add("ShaderNodeCombineXYZ", {0: x, 1: y, 2: z}).outputs[0]

    def attribute(self, name):
        return self.add("ShaderNodeAttribute", attribute_type="GEOMETRY", attribute_name=name).outputs

    def to_world(self, vector, kind="VECTOR"):
        return self.add("ShaderNodeVectorTransform", {0: vector}, vector_type=kind, convert_from="OBJECT",
                        convert_to="WORLD").outputs[0]

    def mix_shader(self, factor, first, second):
        return self.add("ShaderNodeMixShader", {0: factor, 1: first, 2: second}).outputs[0]


class Shading:
    """Makes the materials of one scene; images are loaded once per colour space."""

    def __init__(self, gltf, emission_only):
        self.gltf = gltf
        self.emission_only = emission_only
        self.images = {}

    def image(self, index, is_color):
        key = (index, is_color)
        if key not in self.images:
            data = self.gltf.image_bytes(index)
            handle, path = tempfile.mkstemp(suffix=".png" if data[:4] == b"\x89PNG" else ".jpg")
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            image = bpy.data.images.load(path)
            image.colorspace_settings.name = "sRGB" if is_color else "Non-Color"
            image.alpha_mode = "CHANNEL_PACKED"  # RGB is filtered as it is, not weighted with alpha
            image.pack()
            os.remove(path)
            self.images[key] = image
        return self.images[key]

    def texture(self, nodes, texture, is_color):
        """Image Texture node. All wrap modes are made from REPEAT: a coordinate kept between the first and the last
        texel centre never reaches a neighbour across the edge, which is what clamping means."""
        image = self.image(texture["image"], is_color)
        name = "UVMap" if texture["texcoord"] == 0 else f"UVMap.{texture['texcoord']:03d}"
        uv = nodes.xyz(nodes.add("ShaderNodeUVMap", uv_map=name).outputs[0])
        uv = (uv[0], nodes.math("SUBTRACT", 1.0, uv[1]))  # the importer has flipped v
        if texture["matrix"] != ((1, 0, 0), (0, 1, 0)):
            uv = [nodes.math("MULTIPLY_ADD", uv[0], a, nodes.math("MULTIPLY_ADD", uv[1], b, c))
                  for a, b, c in texture["matrix"]]
        wrapped = []
        for coordinate, wrap, size in zip(uv, texture["wrap"], image.size):
            if wrap == "mirror":
                coordinate = nodes.math("PINGPONG", coordinate, 1.0)
            if wrap != "repeat":
                coordinate = nodes.math("MINIMUM", nodes.math("MAXIMUM", coordinate, .5 / size), 1 - .5 / size)
            wrapped.append(coordinate)
        vector = nodes.combine(wrapped[0], nodes.math("SUBTRACT", 1.0, wrapped[1]), 0.0)
        return nodes.add("ShaderNodeTexImage", {0: vector}, image=image, extension="REPEAT",
                         interpolation="Closest" if texture["nearest"] else "Linear").outputs

    def material(self, parameters, attributes):
        """`attributes`: the glTF attribute names of the primitive."""
        material = bpy.data.materials.new(parameters["name"])
        material.use_nodes = True
        nodes = Nodes(material.node_tree)
        color, alpha = self._base_color(nodes, parameters, "COLOR_0" in attributes)
        emission = list(parameters["emission"])
        if parameters["emissive_texture"] and any(emission):
            emission = nodes.vector("MULTIPLY", emission,
                                    self.texture(nodes, parameters["emissive_texture"], True)["Color"])
        if self.emission_only:
            bsdf = nodes.add("ShaderNodeEmission", {"Color": emission, "Strength": parameters["emission_strength"]})
            transparent = nodes.add("ShaderNodeBsdfTransparent").outputs[0]
            surface = bsdf.outputs[0] if alpha == 1 else nodes.mix_shader(alpha, transparent, bsdf.outputs[0])
        else:
            surface = self._principled(nodes, parameters, attributes, color, alpha, emission)
        if not parameters["double_sided"]:
            backfacing = nodes.add("ShaderNodeNewGeometry").outputs["Backfacing"]
            transparent = nodes.add("ShaderNodeBsdfTransparent").outputs[0]
            surface = nodes.mix_shader(backfacing, surface, transparent)
        nodes.add("ShaderNodeOutputMaterial", {"Surface": surface})
        return material

    def _base_color(self, nodes, parameters, has_colors):
        color, alpha = list(parameters["base_color"]), parameters["alpha"]
        factors = []
        if parameters["base_color_texture"]:
            texture = self.texture(nodes, parameters["base_color_texture"], True)
            factors.append((texture["Color"], texture["Alpha"]))
        if has_colors:
            attribute = nodes.attribute(COLOR)
            factors.append((attribute["Color"], attribute["Alpha"]))
        for factor, opacity in factors:
            color, alpha = nodes.vector("MULTIPLY", color, factor), nodes.math("MULTIPLY", alpha, opacity)
        if parameters["alpha_mode"] == "OPAQUE":
            alpha = 1.0
        elif parameters["alpha_mode"] == "MASK":  # opaque where alpha >= cutoff
            alpha = nodes.math("SUBTRACT", 1.0, nodes.math("LESS_THAN", alpha, parameters["alpha_cutoff"]))
        return color, alpha

    def _principled(self, nodes, parameters, attributes, color, alpha, emission):
        metallic, roughness = parameters["metallic"], parameters["roughness"]
        if parameters["metallic_roughness_texture"]:
            channels = nodes.xyz(self.texture(nodes, parameters["metallic_roughness_texture"], False)["Color"])
            metallic, roughness = nodes.math("MULTIPLY", metallic, channels[2]), nodes.math("MULTIPLY", roughness, channels[1])
        inputs = {
            "Base Color": color, "Metallic": metallic, "Roughness": roughness, "Alpha": alpha,
            "Specular": parameters["specular"], "Specular Tint": parameters["specular_tint"],
            "Anisotropic": parameters["anisotropic"], "Anisotropic Rotation": parameters["anisotropic_rotation"],
            "Sheen": parameters["sheen"], "Sheen Tint": parameters["sheen_tint"],
            "Clearcoat": parameters["clearcoat"], "Clearcoat Roughness": parameters["clearcoat_roughness"],
            "Emission": emission, "Emission Strength": parameters["emission_strength"],
            "Subsurface": 0.0, "Transmission": 0.0,
        }
        if parameters["normal_texture"]:
            inputs["Normal"] = inputs["Clearcoat Normal"] = self._normal(nodes, parameters, attributes)
        if parameters["anisotropic"]:
            inputs["Tangent"] = self._tangent(nodes, parameters, attributes)
        return nodes.add("ShaderNodeBsdfPrincipled", inputs, distribution="GGX").outputs[0]

    def _tangent(self, nodes, parameters, attributes):
        if "TANGENT" in attributes:
            return nodes.to_world(nodes.attribute(TANGENT)["Vector"])
        if "TEXCOORD_0" not in attributes:
            raise GltfError(f"{self.gltf.path}: {parameters['name']}: wanted TANGENT or TEXCOORD_0 for anisotropy, found none")
        return nodes.add("ShaderNodeTangent", direction_type="UV_MAP", uv_map="UVMap").outputs[0]

    def _normal(self, nodes, parameters, attributes):
        """Tangent space as docs/formats.md has it: t orthogonal to n, b = n x t times the handedness. Without TANGENT
        Blender's own node derives both from the texture coordinates (MikkTSpace)."""
        texture, scale = parameters["normal_texture"], parameters["normal_scale"]
        channels = nodes.xyz(self.texture(nodes, texture, False)["Color"])
        if "TANGENT" not in attributes:
            # The node's Strength is another thing than glTF's scale, which stretches x and y.
            x, y = (nodes.math("MULTIPLY_ADD", channel, scale, .5 - .5 * scale) for channel in channels[:2])
            uv_map = "UVMap" if texture["texcoord"] == 0 else f"UVMap.{texture['texcoord']:03d}"
            return nodes.add("ShaderNodeNormalMap", {"Color": nodes.combine(x, y, channels[2])}, space="TANGENT",
                             uv_map=uv_map).outputs[0]
        x, y, z = (nodes.math("MULTIPLY_ADD", channel, 2.0 * k, -k) for channel, k in zip(channels, (scale, scale, 1.0)))
        geometry = nodes.add("ShaderNodeNewGeometry").outputs
        normal = geometry["Normal"]  # on back faces already turned to the viewer, so x must turn too
        x = nodes.math("MULTIPLY", x, nodes.math("MULTIPLY_ADD", geometry["Backfacing"], -2.0, 1.0))
        tangent = nodes.to_world(nodes.attribute(TANGENT)["Vector"])
        tangent = nodes.vector("SUBTRACT", tangent, nodes.scaled(normal, nodes.vector("DOT_PRODUCT", normal, tangent)))
        tangent = nodes.vector("NORMALIZE", tangent)
        bitangent = nodes.scaled(nodes.vector("CROSS_PRODUCT", normal, tangent), nodes.attribute(TANGENT_SIGN)["Fac"])
        total = nodes.vector("ADD", nodes.scaled(tangent, x), nodes.scaled(bitangent, y))
        return nodes.vector("NORMALIZE", nodes.vector("ADD", total, nodes.scaled(normal, z)))


def build_world(gltf, hide_environment):
    """Environment as the world's shader: direction (x, y, z) of glTF is Blender's (x, -z, y), so that Blender's own
    latitude-longitude look-up is the one of docs/formats.md."""
    environment = gltf.environment()
    world = bpy.context.scene.world = bpy.data.worlds.new("world")
    world.use_nodes = True
    nodes = Nodes(world.node_tree)
    color, strength = [0.0, 0.0, 0.0], 0.0
    if environment and "file" in environment:
        color, strength = _environment_map(nodes, environment), environment["strength"]
    elif environment:
        color, strength = environment["color"], environment["strength"]
    background = nodes.add("ShaderNodeBackground", {"Color": color, "Strength": strength})
    nodes.add("ShaderNodeOutputWorld", {"Surface": background.outputs[0]})
    world.cycles_visibility.camera = not hide_environment


def _environment_map(nodes, environment):
    try:
        image = bpy.data.images.load(environment["file"])
    except RuntimeError:
        raise GltfError(f"{environment['file']}: wanted an .exr or .hdr environment, found none that opens") from None
    image.colorspace_settings.name = "Non-Color"  # texels are linear Rec.709 already
    direction = nodes.add("ShaderNodeTexCoord").outputs["Generated"]
    direction = nodes.add("ShaderNodeVectorRotate", {"Vector": direction, "Angle": -environment["rotation"]},
                          rotation_type="Z_AXIS").outputs[0]
    # Blender repeats the map in v as well: half a texel around each pole would mix with the other pole. A direction kept
    # from climbing past the middle of the first and last row does not reach there, which is what clamping means.
    x, y, z = nodes.xyz(direction)
    across = nodes.add("ShaderNodeVectorMath", {0: nodes.combine(x, y, 0.0)}, operation="LENGTH").outputs["Value"]
    limit = nodes.math("MULTIPLY", across, 1 / math.tan(.5 * math.pi / image.size[1]))
    z = nodes.math("MAXIMUM", nodes.math("MINIMUM", z, limit), nodes.math("MULTIPLY", limit, -1.0))
    direction = nodes.combine(x, y, z)
    return nodes.add("ShaderNodeTexEnvironment", {0: direction}, image=image, interpolation="Linear",
                     projection="EQUIRECTANGULAR").outputs[0]
