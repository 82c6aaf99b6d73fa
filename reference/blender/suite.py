"""The judge's side of the contract (docs/formats.md) in plain Python: case files, hashes, witness renders as EXR."""

import hashlib
import json
import math
import os

import numpy as np
import OpenImageIO as oiio

import gltf

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
# Shaders against which a picture of the Principled BSDF means anything, close or not.
SHADERS = ("principled", "disney", "path", "path_disney")
# Renderer options that Blender follows (clamp never: it would bias both), and those that do not change the picture or
# only our own model.
FOLLOWED = ("hide-environment", "punctual-units")
HARMLESS = ("d-gamma", "d-constant", "sampler", "isa", "fastest-isa")


class CaseError(Exception):
    """One line for the user."""


class Case:
    def __init__(self, name, suite):
        self.name = name
        self.file = os.path.join(suite, "cases", name + ".json")
        try:
            with open(self.file) as file:
                self.json = json.load(file)
        except OSError as error:
            raise CaseError(f"{self.file}: wanted a case file, found: {error.strerror}") from None
        except ValueError as error:
            raise CaseError(f"{self.file}: wanted JSON, found: {error}") from None
        if not isinstance(self.json, dict):
            raise CaseError(f"{self.file}: wanted an object, found {type(self.json).__name__}")
        for key, kind in (("scene", str), ("shader", str), ("size", list), ("depth", int)):
            if not isinstance(self.json.get(key), kind):
                raise CaseError(f"{self.file}: {key}: wanted {kind.__name__}, found {self.json.get(key)!r}")
        self.scene = os.path.join(suite, "scenes", self.json["scene"])
        witnesses = [w for w in self.json.get("witnesses", []) if w.get("kind") == "blender"]
        self.witness = witnesses[0] if witnesses else None

    def hashes(self):
        """(scene hash, picture hash)."""
        try:
            scene = gltf.scene_hash(self.scene)
        except gltf.GltfError as error:
            raise CaseError(str(error)) from None
        return scene, picture_hash(self.json, scene)

    def job(self):
        """What render_in_blender.py is told, without seeds and output. Refuses what Blender cannot follow."""
        witness = self.witness or {}
        shader = witness.get("shader", self.json["shader"])
        if shader not in SHADERS:
            raise CaseError(f"{self.file}: shader: wanted one of {', '.join(SHADERS)} for Blender, found {shader}")
        options = self.json.get("options", {})
        for option, value in options.items():
            if option not in FOLLOWED + HARMLESS and (option, value) != ("filter", "box"):
                raise CaseError(f"{self.file}: options: Blender cannot follow {option}: {json.dumps(value)}")
        return {
            "name": self.name, "scene": self.scene, "width": self.json["size"][0], "height": self.json["size"][1],
            "camera": self.json.get("camera", 0), "depth": witness.get("depth", self.json["depth"]),
            "spp": witness.get("spp", 1024), "hide_environment": bool(options.get("hide-environment", False)),
            "punctual_units": options.get("punctual-units", "auto"),
        }

    def seeds(self):
        return (self.witness or {}).get("seeds", 8)


def case_names(suite):
    """The names of all cases that call Blender as a witness."""
    folder = os.path.join(suite, "cases")
    try:
        names = sorted(name[:-5] for name in os.listdir(folder) if name.endswith(".json") and name != "schema.json")
    except OSError as error:
        raise CaseError(f"{folder}: wanted case files, found: {error.strerror}") from None
    return [name for name in names if Case(name, suite).witness]


def canonical_json(value):
    return json.dumps(value, sort_keys=True, separators=(",", ":"))


def picture_hash(case, scene_hash):
    picture = {"camera": case.get("camera", 0), "depth": case["depth"], "options": case.get("options", {}),
               "scene_hash": scene_hash, "shader": case["shader"], "size": case["size"]}
    return hashlib.sha256(canonical_json(picture).encode()).hexdigest()


def script_hash(folder=HERE):
    digest = hashlib.sha256()
    for name in sorted(os.listdir(folder)):
        if name.endswith(".py"):
            with open(os.path.join(folder, name), "rb") as file:
                digest.update(file.read())
    return digest.hexdigest()


def merge(images):
    """Mean and variance of the mean of independent renders (float64)."""
    stack = np.stack([np.asarray(image, np.float64) for image in images])
    return stack.mean(axis=0), stack.var(axis=0, ddof=1) / len(stack)


def read_exr(path):
    """Pixels of all channels (float32) and the spec."""
    image = oiio.ImageInput.open(path)
    if image is None:
        raise CaseError(f"{path}: wanted an EXR, found: {oiio.geterror()}")
    spec = image.spec()
    pixels = image.read_image(0, 0, 0, spec.nchannels, oiio.FLOAT)
    image.close()
    if pixels is None:
        raise CaseError(f"{path}: wanted pixels, found: {oiio.geterror()}")
    return pixels, spec


def read_witness(path):
    """(mean, variance of the mean, header) of a stored witness render."""
    pixels, spec = read_exr(path)
    if spec.nchannels < 6:
        raise CaseError(f"{path}: wanted R, G, B and their variances, found {spec.nchannels} channels")
    header = {attribute.name: attribute.value for attribute in spec.extra_attribs if attribute.name.startswith("assay:")}
    channels = [spec.channelnames.index(c) for c in ("R", "G", "B", "variance.R", "variance.G", "variance.B")]
    pixels = pixels[..., channels].astype(np.float64)
    return pixels[..., :3], pixels[..., 3:] * header.get("assay:variance_scale", 1.0), header


def write_witness(path, mean, variance, header):
    """float R G B and half variance.*, the latter divided by a power of two that keeps it in half's range."""
    scale = 2.0 ** math.ceil(math.log2(variance.max() / 32768)) if variance.max() > 0 else 1.0
    height, width, _ = mean.shape
    spec = oiio.ImageSpec(width, height, 6, oiio.FLOAT)
    spec.channelnames = ("R", "G", "B", "variance.R", "variance.G", "variance.B")
    spec.channelformats = (oiio.TypeDesc("float"),) * 3 + (oiio.TypeDesc("half"),) * 3
    spec.attribute("compression", "zip")
    for name, value in dict(header, **{"assay:variance_scale": float(scale)}).items():
        spec.attribute(name, value)
    temporary = path + ".tmp.exr"
    output = oiio.ImageOutput.create(temporary)
    pixels = np.concatenate([mean, variance / scale], axis=2).astype(np.float32)
    if output is None or not output.open(temporary, spec) or not output.write_image(pixels) or not output.close():
        raise CaseError(f"{path}: cannot be written: {output.geterror() if output else oiio.geterror()}")
    os.replace(temporary, path)
