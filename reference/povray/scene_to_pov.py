"""A glTF scene as POV-Ray scene text, for one quantity.

  position   world position of the first hit: each axis a user function of the point, mapped into [0,1]
  normal     shading normal on the eye's side, by the `slope` pattern, which is 1 - angle(n, axis)/pi
  direct     Lambert surfaces under point and directional lights with shadows: albedo/pi * intensity * cos / d^2
  mirror     the same, and perfect mirrors

POV-Ray is left-handed only where it fills in vectors itself. Here every camera vector and matrix is given outright, so
glTF's right-handed coordinates go in as they are. A matrix has row vectors, so its twelve numbers are the columns of
glTF's. mesh2 keeps vertices in object space and turns the ray, so vertices keep glTF's own float values.

The world is scaled to a radius of about 1000, because POV-Ray ignores occluders nearer than 0.001 (in its units) and
mesh hits nearer than 1e-6 in the mesh's own space; that one is blown up likewise, by a power of two, which loses no bit.
mesh2's interior is the side from which vertices run counter-clockwise, glTF's front; faces are given clockwise.
"""

import importlib.util
import math
import os

import numpy as np

import pov



def _load(name, path):
    """A module by its file: a folder on sys.path would also bring in namesakes of the modules here."""
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


# The plain glTF reader of the other witness; it shares nothing with the renderer's.
gltf = _load("assay_gltf", os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "blender", "gltf.py"))

QUANTITIES = ("position", "normal", "direct", "mirror")
RADIUS = 1000.0
FADE = 1e-3  # point lights: 2/(1 + (d/FADE)^2) is 2 FADE^2/d^2 within 1e-9 from d = 32 on
MIRROR_ROUGHNESS = 0.0177828  # below it Blender's specular lobe, and ours, is a perfect mirror
CLEAR = "texture { pigment { rgbt <0,0,0,1> } finish { ambient 0 diffuse 0 } }"


def numbers(values):
    return "<" + ",".join(f"{float(v):.17g}" for v in values) + ">"


def _triangles(scene, primitive, count):
    mode = primitive.get("mode", 4)
    index = (scene.accessor(primitive["indices"])[:, 0].astype(int) if "indices" in primitive else np.arange(count))
    if mode == 4:
        return index[:len(index) // 3 * 3].reshape(-1, 3)
    if mode == 5:  # strip: every second triangle is turned round
        return np.array([(index[i], index[i + 1 + i % 2], index[i + 2 - i % 2]) for i in range(len(index) - 2)]).reshape(-1, 3)
    if mode == 6:
        return np.array([(index[0], index[i], index[i + 1]) for i in range(1, len(index) - 1)]).reshape(-1, 3)
    return np.zeros((0, 3), int)  # points and lines are not surfaces


class Material:
    """What of a glTF material the quantities need."""

    def __init__(self, scene, index):
        data = scene.list("materials")[index] if index is not None else {}
        pbr, extras, extensions = (data.get(k) or {} for k in ("pbrMetallicRoughness", "extras", "extensions"))
        self.where = f"{scene.path}: material '{data.get('name', index)}'"
        self.base = np.array(pbr.get("baseColorFactor", (1, 1, 1, 1)), float)
        self.metallic, self.roughness = pbr.get("metallicFactor", 1.0), pbr.get("roughnessFactor", 1.0)
        self.extras, self.textured = extras, "Texture" in str(data)
        self.specular = extras.get("disney_specular", 0.5)
        self.emission = (np.array(data.get("emissiveFactor", (0, 0, 0)), float)
                         * extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0))
        self.double_sided = data.get("doubleSided", False)
        self.alpha = float(self.base[3])
        self.mode = data.get("alphaMode", "OPAQUE")
        if self.mode == "OPAQUE":
            self.alpha = 1.0
        elif self.mode == "MASK":
            self.alpha = float(self.alpha >= data.get("alphaCutoff", 0.5))
        self.texture = pbr.get("baseColorTexture")
        self.normal_map = "normalTexture" in data
        self.emissive_map = "emissiveTexture" in data and self.emission.any()
        self.other_lobes = any(extras.get(k, 0) for k in ("disney_sheen", "disney_clearcoat"))
        self.metal_map = "metallicRoughnessTexture" in pbr

    @property
    def is_mirror(self):
        return self.metallic == 1 and self.roughness <= MIRROR_ROUGHNESS and not self.metal_map

    def disney(self):
        """The parameters of disney_sdl.py, for a material without textures."""
        values = {key: self.extras[f"disney_{key}"] for key in (
            "specular", "specular_tint", "anisotropic", "anisotropic_rotation", "sheen", "sheen_tint", "clearcoat",
            "clearcoat_roughness") if f"disney_{key}" in self.extras}
        if "disney_clearcoat_gloss" in self.extras:
            values["clearcoat_roughness"] = math.sqrt(0.1 - 0.099 * self.extras["disney_clearcoat_gloss"])
        return {"base": tuple(self.base[:3]), "metallic": self.metallic, "roughness": self.roughness, **values}

    def is_black(self):
        return not self.base[:3].any()


class Mesh:
    """One primitive of one node."""

    def __init__(self, scene, primitive, world):
        attributes = primitive["attributes"]
        self.world = world
        self.positions = scene.accessor(attributes["POSITION"]).astype(np.float64)
        self.normals = scene.accessor(attributes["NORMAL"]).astype(np.float64) if "NORMAL" in attributes else None
        self.texcoords = {k: scene.accessor(attributes[f"TEXCOORD_{k}"]).astype(np.float64)
                          for k in (0, 1) if f"TEXCOORD_{k}" in attributes}
        self.coloured = "COLOR_0" in attributes
        self.triangles = _triangles(scene, primitive, len(self.positions))
        self.material = Material(scene, primitive.get("material"))
        self.world_positions = self.positions @ world[:3, :3].T + world[:3, 3]


class Scene:
    def __init__(self, path, camera=0, units="auto"):
        try:
            self.gltf = gltf.Gltf(path)
            self.meshes = [Mesh(self.gltf, primitive, world) for node, world in self.gltf.nodes() if "mesh" in node
                           for primitive in self.gltf.list("meshes")[node["mesh"]]["primitives"]]
            self.meshes = [m for m in self.meshes if len(m.triangles)]
            self.lights = self.gltf.lights(units)
            cameras = self.gltf.cameras()
        except gltf.GltfError as error:
            raise pov.Failure(str(error)) from None
        except (KeyError, IndexError, TypeError, ValueError) as error:
            raise pov.Failure(f"{path}: wanted a valid glTF scene, found: {type(error).__name__} {error}") from None
        if not self.meshes:
            raise pov.Failure(f"{path}: wanted triangles, found none")
        if camera >= len(cameras):
            raise pov.Failure(f"{path}: wanted camera {camera}, found {len(cameras)} cameras")
        self.path = path
        self.camera, self.camera_world = cameras[camera]
        self.environment = self.gltf.environment()
        points = np.concatenate([m.world_positions[np.unique(m.triangles)] for m in self.meshes])
        self.low, self.high = points.min(0), points.max(0)
        self.size = float(np.linalg.norm(self.high - self.low)) or 1.0
        self.scale = RADIUS / (self.size / 2)

    # --- SDL

    def _camera(self, width, height):
        x, y, z, eye = (self.camera_world[:3, i] for i in range(4))
        aspect = width / height
        if self.camera["type"] == "orthographic":
            kind, tall = "orthographic", 2 * self.camera["orthographic"]["ymag"] * self.scale
        else:
            kind, tall = "perspective", 2 * math.tan(self.camera["perspective"]["yfov"] / 2)
        return (f"camera {{ {kind} location {numbers(eye * self.scale)} direction {numbers(-z)} "
                f"right {numbers(x * tall * aspect)} up {numbers(y * tall)} }}\n")

    def _matrix(self, world, blow_up):
        m = world[:3] * self.scale
        m[:, :3] /= blow_up
        return "matrix " + numbers([m[row, column] for column in range(4) for row in range(3)])

    def _mesh(self, mesh, texture, uv=None):
        def vectors(name, values):
            return f"  {name} {{ {len(values)}, " + ",".join(map(numbers, values)) + " }\n"

        blow_up = 2.0**round(math.log2(RADIUS / (np.abs(mesh.positions).max() or 1)))
        text = "mesh2 {\n" + vectors("vertex_vectors", mesh.positions * blow_up)
        if mesh.normals is not None:
            text += vectors("normal_vectors", mesh.normals)
        if uv is not None:
            text += vectors("uv_vectors", uv)
        text += f"  face_indices {{ {len(mesh.triangles)}, " + ",".join(
            f"<{a},{c},{b}>" for a, b, c in mesh.triangles) + " }\n"
        inside = "" if mesh.material.double_sided else "interior_" + CLEAR + "\n"
        return text + self._matrix(mesh.world, blow_up) + "\n" + texture + inside + "}\n"

    def _check_normals(self, mesh):
        """POV-Ray takes a triangle whose three normals agree for a flat one and forgets them; glTF does not."""
        if mesh.normals is None:
            return
        p, n = mesh.positions[mesh.triangles], mesh.normals[mesh.triangles]
        flat = np.abs(n - n[:, :1]).max((1, 2)) < 1e-9
        face = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
        leaning = np.linalg.norm(np.cross(face, n[:, 0]), axis=1) > 1e-3 * np.linalg.norm(face, axis=1)
        if (flat & leaning).any():
            raise pov.Failure(f"{mesh.material.where}: wanted vertex normals that differ or stand on their triangle, found "
                              f"{(flat & leaning).sum()} triangles with one oblique normal")

    def one_texture(self, texture, width, height):
        """All surfaces with the same world-space texture: position and normal."""
        text = self._camera(width, height)
        for mesh in self.meshes:
            self._refuse_alpha(mesh)
            if "slope" in texture:
                self._check_normals(mesh)
                if mesh.material.normal_map:
                    raise pov.Failure(f"{mesh.material.where}: the quantity normal knows no normal maps")
            text += self._mesh(mesh, texture if mesh.material.alpha > 0 else CLEAR)
        return text

    def position_functions(self):
        """Three functions in (0.01, 0.99) of the point, and what undoes them."""
        extent = np.maximum(self.high - self.low, 1e-6 * self.size)
        functions = [f"0.01 + 0.98*({axis}*{1 / self.scale / e:.17g} - ({l / e:.17g}))"
                     for axis, l, e in zip("xyz", self.low, extent)]
        return functions, lambda pixels: (pixels - 0.01) / 0.98 * extent + self.low

    def lit(self, quantity, width, height, exposure):
        """(SDL, files) of the quantities direct and mirror: radiance times `exposure`."""
        background = self._background(quantity)
        text = f"background {{ rgb {numbers(background * exposure)} }}\n" + self._camera(width, height)
        emissive = [m for m in self.meshes if m.material.emission.any()] or background.any()
        files = []
        for mesh in self.meshes:
            m = mesh.material
            self._refuse_alpha(mesh)
            self._check_material(mesh, quantity, emissive)
            self._check_normals(mesh)
            transmit = 1 - m.alpha
            finish = "ambient 0 diffuse 1/pi emission 0 specular 0 brilliance 1"
            uv = None
            if quantity == "mirror" and m.is_mirror:
                pigment = "rgb 0"
                finish = f"ambient 0 diffuse 0 reflection {{ rgb {numbers(m.base[:3])} }}"
            elif m.texture and not m.is_black():
                uv, pigment = self._texture(mesh, files)
            else:
                pigment = f"rgbt {numbers([*m.base[:3], transmit])}"
            texture = f"texture {{ {pigment if pigment.startswith('uv') else f'pigment {{ {pigment} }}'} finish {{ {finish} }} }}\n"
            if m.emission.any():  # _check_material has seen to it that such a surface does nothing but shine
                texture = (f"texture {{ pigment {{ rgbt {numbers([*(m.emission * exposure), transmit])} }} "
                           "finish { ambient 0 diffuse 0 emission 1 } }\n")
            text += self._mesh(mesh, texture if m.alpha > 0 else CLEAR, uv)
        return text + "".join(self._light(light, exposure) for light in self.lights), files

    def _light(self, light, exposure):
        world, colour = light["matrix"], np.array(light["intensity"]) * exposure
        if light["kind"] == "point":
            colour = colour * self.scale**2 / (2 * FADE**2)
            return (f"light_source {{ {numbers(world[:3, 3] * self.scale)} color rgb {numbers(colour)} "
                    f"fade_distance {FADE} fade_power 2 }}\n")
        if light["kind"] == "directional":  # travels along -z; stands outside the scene
            centre = (self.low + self.high) / 2 * self.scale
            return (f"light_source {{ {numbers(centre + 4 * RADIUS * world[:3, 2])} color rgb {numbers(colour)} "
                    f"parallel point_at {numbers(centre)} }}\n")
        raise pov.Failure(f"{self.path}: POV-Ray's {light['kind']} lights fall off in their own way; "
                          "wanted point or directional lights")

    def _texture(self, mesh, files):
        """Base colour decoded into a 16-bit linear picture: POV-Ray interpolates what glTF means, texel centres alike."""
        m, reference = mesh.material, mesh.material.texture
        entry = self.gltf.list("textures")[reference["index"]]
        sampler = self.gltf.list("samplers")[entry["sampler"]] if "sampler" in entry else {}
        if any(sampler.get(k, 10497) != 10497 for k in ("wrapS", "wrapT")):
            raise pov.Failure(f"{m.where}: wanted a repeating texture, found wrap modes {sampler}")
        transform = reference.get("extensions", {}).get("KHR_texture_transform", {})
        channel = transform.get("texCoord", reference.get("texCoord", 0))
        if channel not in mesh.texcoords:
            raise pov.Failure(f"{m.where}: wanted TEXCOORD_{channel}, found none")
        uv = mesh.texcoords[channel] * transform.get("scale", (1, 1))
        c, s = math.cos(transform.get("rotation", 0)), math.sin(transform.get("rotation", 0))
        uv = np.stack([c * uv[:, 0] + s * uv[:, 1], -s * uv[:, 0] + c * uv[:, 1]], 1) + transform.get("offset", (0, 0))
        name = f"texture{len(files)}.png"
        files.append((name, pov.linear_png(self.gltf.image_bytes(entry["source"]), m.base[:3], m.where)))
        # v runs down in glTF, up in POV-Ray; function() reads the picture at any point, hence uv_mapping outside it.
        interpolate = "" if sampler.get("magFilter", 9729) == 9728 else " interpolate 2"
        uv[:, 1] = 1 - uv[:, 1]
        return uv, f"uv_mapping pigment {{ image_map {{ png \"{name}\" gamma 1.0{interpolate} }} }}"

    def _background(self, quantity):
        if not self.environment:
            return np.zeros(3)
        if quantity == "mirror" and "color" in self.environment:
            return np.array(self.environment["color"], float) * self.environment["strength"]
        raise pov.Failure(f"{self.path}: the quantity {quantity} knows no environment of this kind")

    def _refuse_alpha(self, mesh):
        m = mesh.material
        if m.mode != "OPAQUE" and m.texture:
            raise pov.Failure(f"{m.where}: wanted OPAQUE or an alpha without texture, found {m.mode}")

    def _check_material(self, mesh, quantity, emissive):
        m = mesh.material
        problem = None
        if quantity == "mirror" and m.is_mirror:
            if m.other_lobes or m.specular != 0 and not np.all(m.base[:3] == 1):
                problem = "wanted a mirror of base colour 1 (or specular 0, whose reflectance is constant)"
        elif m.other_lobes or m.specular != 0 or m.metallic != 0 or m.metal_map:
            problem = "wanted Lambert: metallic 0, disney_specular 0, no sheen or clearcoat"
        elif emissive and not m.is_black():
            problem = "wanted base colour 0: POV-Ray's surfaces and background do not light others"
        if m.normal_map or m.emissive_map or mesh.coloured:
            problem = "wanted no normal map, emissive map or vertex colours"
        if mesh.material.texture and m.alpha < 1:
            problem = "wanted an opaque texture"
        if problem:
            raise pov.Failure(f"{m.where}: {problem} for the quantity {quantity}")
