"""A Blender material -> one that glTF and the disney_* extras of docs/formats.md can say (runs inside Blender).

`Materials.export(material)` gives a copy for the exporter: a Principled BSDF whose sockets are numbers or image
textures, what glTF lacks as custom properties. Whatever the copy cannot hold is named in the notes, and its socket
keeps the number Blender shows while it is unlinked. The original stays as it is for Cycles, but for what both pictures
must share: distribution GGX, textures filtered linearly with plain RGB.
"""

import bpy

# Sockets that are numbers, here and in docs/formats.md.
EXTRAS = {"Specular": "specular", "Specular Tint": "specular_tint", "Anisotropic": "anisotropic",
          "Anisotropic Rotation": "anisotropic_rotation", "Sheen": "sheen", "Sheen Tint": "sheen_tint",
          "Clearcoat": "clearcoat", "Clearcoat Roughness": "clearcoat_roughness"}
COLOR = ("sRGB",)
DATA = ("Non-Color", "Raw", "Linear")


def source(socket):
    """The output socket a link comes from, past reroutes; None if there is no link."""
    while socket.is_linked:
        origin = socket.links[0].from_socket
        if origin.node.type != "REROUTE":
            return origin
        socket = origin.node.inputs[0]
    return None


def clean(value):
    """A float as the artist typed it: the shortest decimal that is the same float."""
    return float(f"{value:.7g}")


def describe(node):
    group = f" '{node.node_tree.name}'" if node.type == "GROUP" and node.node_tree else ""
    return f"{node.bl_label}{group}"


def nodes_of(tree, seen=None):
    """All nodes, those in groups too."""
    seen = set() if seen is None else seen
    for node in tree.nodes:
        yield node
        if node.type == "GROUP" and node.node_tree and node.node_tree.name not in seen:
            seen.add(node.node_tree.name)
            yield from nodes_of(node.node_tree, seen)


class Materials:
    def __init__(self, notes):
        self.notes = notes
        self.made = {}
        self.names = {}  # of the exported copy -> of the material
        self.tangents = {}  # name of the exported copy -> "uv" or "radial", where it matters
        self.default = None

    def export(self, material):
        if material.name not in self.made:
            self.place = f"material '{material.name}'"
            self._make_alike(material)
            copy = self._export(material)
            copy.use_backface_culling = False  # Cycles shows both sides
            self.names[copy.name] = material.name
            self.made[material.name] = copy
        return self.made[material.name]

    def none(self):
        """For faces without a material: Cycles paints them grey."""
        if self.default is None:
            self.notes.change("faces without a material: given a grey Principled BSDF in both")
            self.default = self._stand_in("no material", (.8, .8, .8))
        return self.default

    # --- what both pictures share

    def _make_alike(self, material):
        if not material.use_nodes or material.node_tree is None:
            self.notes.change(f"{self.place}: has no nodes; given a Principled BSDF of its viewport colour in both")
            color = tuple(material.diffuse_color)
            material.use_nodes = True
            material.node_tree.nodes.clear()
            bsdf = material.node_tree.nodes.new("ShaderNodeBsdfPrincipled")
            bsdf.inputs["Base Color"].default_value = (*color[:3], 1)
            output = material.node_tree.nodes.new("ShaderNodeOutputMaterial")
            material.node_tree.links.new(bsdf.outputs[0], output.inputs["Surface"])
        for node in nodes_of(material.node_tree):
            if node.type == "BSDF_PRINCIPLED" and node.distribution != "GGX":
                self.notes.change(f"{self.place}: Multiscatter GGX made GGX in both (it has no closed form)")
                node.distribution = "GGX"
            if node.type == "TEX_IMAGE" and node.image is not None:
                if node.interpolation not in ("Linear", "Closest"):
                    self.notes.change(f"{self.place}: texture '{node.image.name}' filtered linearly in both, "
                                      f"was {node.interpolation}")
                    node.interpolation = "Linear"
                if node.image.alpha_mode == "STRAIGHT":
                    node.image.alpha_mode = "CHANNEL_PACKED"  # glTF filters RGB as it is, not weighted with alpha

    # --- the copy for the exporter

    def _stand_in(self, name, color, emission=(0, 0, 0), strength=1.0, specular=.5):
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        bsdf = made.node_tree.nodes["Principled BSDF"]
        bsdf.inputs["Base Color"].default_value = (*color, 1)
        bsdf.inputs["Emission"].default_value = (*emission, 1)
        bsdf.inputs["Emission Strength"].default_value = strength
        bsdf.inputs["Specular"].default_value = specular
        made["disney_specular"] = specular
        return made

    def _export(self, material):
        if "assay_panel" in material:  # patch.py writes the rest of it
            made = self._stand_in(material.name, (0, 0, 0), specular=0.0)
            made["assay_panel"] = list(material["assay_panel"])
            return made
        output = material.node_tree.get_output_node("CYCLES")
        if output is None or source(output.inputs["Surface"]) is None:
            return self._stand_in(material.name, (0, 0, 0), specular=0.0)  # Cycles: nothing is reflected
        for socket in ("Volume", "Displacement"):
            if source(output.inputs[socket]) is not None:
                self.notes.lose(f"{self.place}: {socket.lower()}")
        shader = source(output.inputs["Surface"]).node
        if shader.type == "BSDF_PRINCIPLED":
            copy = material.copy()
            self._principled(copy, source(copy.node_tree.get_output_node("CYCLES").inputs["Surface"]).node)
            return copy
        if shader.type == "EMISSION" and not any(socket.is_linked for socket in shader.inputs):
            return self._stand_in(material.name, (0, 0, 0), tuple(shader.inputs["Color"].default_value)[:3],
                                  shader.inputs["Strength"].default_value, specular=0.0)
        color = next((s for s in shader.inputs if s.name == "Color" and not s.is_linked), None)
        color = tuple(min(max(c, 0), 1) for c in color.default_value[:3]) if color else (.8, .8, .8)
        self.notes.lose(f"{self.place}: its surface is {describe(shader)}, no Principled BSDF; Assay is given a plain one "
                        f"of colour {', '.join(f'{c:.2g}' for c in color)}")
        return self._stand_in(material.name, color)

    def _principled(self, material, bsdf):
        tree, inputs = material.node_tree, bsdf.inputs
        self._fold_constants(tree, inputs)
        image = self._texture("Base Color", inputs["Base Color"], "Color", COLOR)
        self._unless(tree, inputs["Base Color"], image)
        self._unless(tree, inputs["Emission"], self._texture("Emission", inputs["Emission"], "Color", COLOR))
        for name, channel in (("Roughness", "Green"), ("Metallic", "Blue")):
            self._unless(tree, inputs[name], self._channel(name, inputs[name], channel))
        self._alpha(material, tree, inputs["Alpha"], image)
        self._normal(tree, inputs)
        for name in ("Subsurface", "Transmission"):
            if inputs[name].is_linked or inputs[name].default_value > 0:
                self.notes.lose(f"{self.place}: {name.lower()}")
                self._unlink(tree, inputs[name])
                inputs[name].default_value = 0
        for name in (*EXTRAS, "Emission Strength"):
            self._unless(tree, inputs[name], inputs[name].is_linked and self._refuse(name, source(inputs[name]).node))
        color = inputs["Base Color"].default_value
        if max(color[:3]) > 1 and not inputs["Base Color"].is_linked:
            self.notes.lose(f"{self.place}: Base Color above 1: glTF stops there")
        self._tangent(material, inputs)
        self._write_extras(material, inputs)
        self._say_known(inputs)

    def _write_extras(self, material, inputs):
        wanted = {"disney_" + key: clean(inputs[name].default_value) for name, key in EXTRAS.items()}
        for key in [key for key in material.keys() if key.startswith("disney_")]:
            if key not in wanted or abs(wanted[key] - float(material[key])) > 1e-6:
                self.notes.change(f"{self.place}: custom property {key} = {material[key]:.4g} ignored: its node says otherwise, "
                                  "and that is what Blender renders")
            del material[key]
        for key, value in wanted.items():
            material[key] = value

    def _say_known(self, inputs):
        if inputs["Clearcoat"].default_value > 0:
            self.notes.know(f"{self.place}: clearcoat; Blender 3.4.1 gets it wrong wherever a bounced ray finds the light (an "
                            "environment, a shining surface, other objects), by a quarter and more; right under lamps alone")
        if inputs["Normal"].is_linked and inputs["Metallic"].default_value > 0:
            self.notes.know(f"{self.place}: normal-mapped metal; Blender 3.4.1 is some per cent off where it is rough")
        roughness = inputs["Roughness"]
        if not roughness.is_linked and .0178 < roughness.default_value < .15:
            self.notes.know(f"{self.place}: roughness {clean(roughness.default_value):g}; Cycles' own rounding shows in highlights of "
                            "lamps below .15 (2 % at .05)")

    # --- sockets

    def _refuse(self, name, node, why=""):
        self.notes.lose(f"{self.place}: {name} is linked to {describe(node)}{why}; Assay is given the socket's own value")
        return False

    def _unlink(self, tree, socket):
        for link in list(socket.links):
            tree.links.remove(link)

    def _unless(self, tree, socket, kept):
        if socket.is_linked and not kept:
            self._unlink(tree, socket)

    def _fold_constants(self, tree, inputs):
        """A Value or RGB node is a number. Linked numbers pass unclamped in Cycles; here they are 0 to 1."""
        for socket in inputs:
            origin = source(socket)
            if origin is None or origin.node.type not in ("VALUE", "RGB"):
                continue
            value = origin.default_value
            numbers = list(value)[:3] if origin.node.type == "RGB" else [value]
            if socket.type == "VALUE" and len(numbers) > 1:
                numbers = [.2126729 * numbers[0] + .7151522 * numbers[1] + .0721750 * numbers[2]]
            self._unlink(tree, socket)
            if socket.type == "RGBA":
                socket.default_value = (*(numbers * 3)[:3], 1)
            elif socket.type == "VALUE":
                if not 0 <= numbers[0] <= 1 and socket.name != "Emission Strength":
                    self.notes.lose(f"{self.place}: {socket.name} {numbers[0]:.4g} from a node: clamped to 0..1 for Assay")
                socket.default_value = numbers[0]

    def _texture(self, name, socket, output, spaces):
        """The Image Texture node plugged straight into `socket` that glTF can say, or None (and the notes say why)."""
        origin = source(socket)
        if origin is None:
            return None
        node = origin.node
        if node.type != "TEX_IMAGE":
            return self._refuse(name, node) or None
        image = node.image
        if image is None or not image.has_data and image.size[0] == 0:
            return self._refuse(name, node, f" without a readable image{f' ({image.name})' if image else ''}, "
                                            "which Blender draws pink") or None
        where = f" '{image.name}'"
        problem = None
        if origin.name != output:
            problem = f"its output {origin.name}"
        elif image.source not in ("FILE", "GENERATED"):
            problem = f"image source {image.source}"
        elif image.colorspace_settings.name not in spaces:
            problem = f"colour space {image.colorspace_settings.name}"
        elif node.projection != "FLAT" or node.extension == "CLIP":
            problem = f"projection {node.projection}, extension {node.extension}"
        elif not self._plain_coordinates(node):
            problem = "coordinates that are no UV map"
        if problem:
            return self._refuse(name, node, f"{where} with {problem}") or None
        if image.is_float:
            self.notes.lose(f"{self.place}: {name}: image{where} is float; glTF keeps 8 bits")
        return node

    def _plain_coordinates(self, node):
        origin = source(node.inputs["Vector"])
        if origin is not None and origin.node.type == "MAPPING":
            mapping = origin.node
            fixed = not any(mapping.inputs[k].is_linked for k in ("Location", "Rotation", "Scale") if k in mapping.inputs)
            flat = not any(mapping.inputs["Rotation"].default_value[:2])
            if mapping.vector_type != "POINT" or not fixed or not flat or source(mapping.inputs["Vector"]) is None:
                return False
            origin = source(mapping.inputs["Vector"])
        return origin is None or origin.node.type == "UVMAP" and not origin.node.from_instancer or \
            origin.node.type == "TEX_COORD" and origin.name == "UV"

    def _channel(self, name, socket, channel):
        """metallicRoughnessTexture: roughness is its green, metallic its blue."""
        origin = source(socket)
        if origin is None:
            return None
        if origin.node.type == "TEX_IMAGE":
            return self._texture(name, socket, "Color", DATA) if self._is_grey(origin.node.image) else \
                self._refuse(name, origin.node, ", whose colours would become their mean")
        if origin.node.type not in ("SEPARATE_COLOR", "SEPRGB") or origin.name not in (channel, channel[0]) or \
                getattr(origin.node, "mode", "RGB") != "RGB" or source(origin.node.inputs[0]) is None:
            return self._refuse(name, origin.node)
        return self._texture(name, origin.node.inputs[0], "Color", DATA)

    def _is_grey(self, image):
        """A texture whose channels are equal is its own luminance, which Blender takes for a number."""
        if image is None or image.channels < 3 or not image.has_data and image.size[0] == 0:
            return image is not None and image.channels == 1
        import numpy as np
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        pixels = pixels.reshape(-1, image.channels)
        return bool((pixels[:, 0] == pixels[:, 1]).all() and (pixels[:, 1] == pixels[:, 2]).all())

    def _alpha(self, material, tree, socket, base_image):
        """Cycles always blends; glTF says so in alphaMode."""
        origin = source(socket)
        if origin is not None:
            same = base_image is not None and origin.node == base_image and origin.name == "Alpha"
            if not same:
                self._refuse("Alpha", origin.node, ", which is not the alpha of the Base Color's image")
                self._unlink(tree, socket)
        blends = socket.is_linked or socket.default_value < 1
        if blends and not socket.is_linked and base_image is not None and base_image.image.depth in (32, 64, 128):
            self.notes.lose(f"{self.place}: Alpha is a number, but glTF multiplies it with the alpha of the Base Color's image")
        material.blend_method = "BLEND" if blends else "OPAQUE"

    def _normal(self, tree, inputs):
        origin, coat = source(inputs["Normal"]), source(inputs["Clearcoat Normal"])
        if (inputs["Clearcoat"].is_linked or inputs["Clearcoat"].default_value > 0) and coat != origin:
            self.notes.lose(f"{self.place}: Clearcoat Normal is not the Normal")
        self._unlink(tree, inputs["Clearcoat Normal"])
        if origin is None:
            return
        node = origin.node
        if node.type != "NORMAL_MAP" or node.space != "TANGENT" or node.inputs["Strength"].is_linked:
            self._refuse("Normal", node)
            return self._unlink(tree, inputs["Normal"])
        if not self._texture("Normal", node.inputs["Color"], "Color", DATA):
            return self._unlink(tree, inputs["Normal"])
        if abs(node.inputs["Strength"].default_value - 1) > 1e-6:
            self.notes.lose(f"{self.place}: Normal Map strength {clean(node.inputs['Strength'].default_value):g}: glTF's scale, "
                            "which Assay is given, bends by another formula")

    def _tangent(self, material, inputs):
        if inputs["Anisotropic"].default_value == 0:
            return
        origin = source(inputs["Tangent"])
        if origin is None or origin.node.type == "TANGENT" and (origin.node.direction_type, origin.node.axis) == ("RADIAL", "Z"):
            self.tangents[material.name] = "radial"
        elif origin.node.type == "TANGENT" and origin.node.direction_type == "UV_MAP":
            self.tangents[material.name] = "uv"
        else:
            self.notes.lose(f"{self.place}: Tangent is linked to {describe(origin.node)}; Assay takes it from the UV map")


def emits(material):
    """Whether a material shines, for all one can tell without rendering it."""
    for node in nodes_of(material.node_tree) if material.node_tree else ():
        if node.type == "EMISSION" and (node.inputs["Strength"].is_linked or node.inputs["Strength"].default_value > 0):
            return True
        if node.type == "BSDF_PRINCIPLED":
            color, strength = node.inputs["Emission"], node.inputs["Emission Strength"]
            if (color.is_linked or max(color.default_value[:3]) > 0) and (strength.is_linked or strength.default_value > 0):
                return True
    return False

