"""Witness files as docs/formats.md states them: float R G B, optional variance, provenance in the header; hashes."""

import glob
import hashlib
import json
import os

import numpy as np
import OpenImageIO as oiio

import pov

HERE = os.path.dirname(os.path.abspath(__file__))


def script_hash():
    """Of all scripts in this folder, in the order of their names."""
    digest = hashlib.sha256()
    for path in sorted(glob.glob(os.path.join(HERE, "*.py"))):
        with open(path, "rb") as file:
            digest.update(file.read())
    return digest.hexdigest()


def picture_hash(case, scene_hash):
    """What decides a picture, apart from its samples (docs/formats.md, Hashes)."""
    decides = {"camera": case.get("camera", 0), "depth": case["depth"], "options": case.get("options", {}),
               "scene_hash": scene_hash, "shader": case["shader"], "size": case["size"]}
    return hashlib.sha256(json.dumps(decides, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
                          .encode("utf-8")).hexdigest()


def write(path, pixels, header, variance=None, coverage=None):
    """(h, w, 3) -> float R G B; with `variance` half variance.R .G .B, with `coverage` float A. Written aside, then moved: never half a file."""
    height, width = pixels.shape[:2]
    planes = np.asarray(pixels, dtype=np.float32)
    names, formats = ["R", "G", "B"], [oiio.FLOAT] * 3
    if coverage is not None:
        planes = np.concatenate([planes, np.asarray(coverage, dtype=np.float32)[..., None]], axis=2)
        names.append("A")
        formats.append(oiio.FLOAT)
    if variance is not None:
        # Half holds nothing above 65504: a header scale keeps larger variances (formats.md).
        scale, top = 1.0, float(np.max(variance, initial=0))
        while top / scale > 60000:
            scale *= 2
        while 0 < top / scale < 1e-2 and scale > 2.0**-60:
            scale /= 2
        header = {**header, "assay:variance_scale": scale}
        planes = np.concatenate([planes, np.asarray(variance / scale, dtype=np.float32)], axis=2)
        names += ["variance.R", "variance.G", "variance.B"]
        formats += [oiio.HALF] * 3
    spec = oiio.ImageSpec(width, height, len(names), oiio.FLOAT)
    spec.channelnames = tuple(names)
    spec.channelformats = tuple(oiio.TypeDesc(f) for f in formats)
    spec["compression"] = "zip"
    spec["DateTime"] = "1970:01:01 00:00:00"  # or OpenImageIO writes today, and equal pictures differ
    for key, value in header.items():
        spec[key] = value
    temporary = f"{path}.{os.getpid()}.exr"
    out = oiio.ImageOutput.create(temporary)
    if not out or not out.open(temporary, spec) or not out.write_image(np.ascontiguousarray(planes)):
        raise pov.Failure(f"{path}: cannot be written: {oiio.geterror() or (out and out.geterror())}")
    out.close()
    os.replace(temporary, path)


def read(path):
    """(pixels (h, w, channels) float32, channel names, header attributes)."""
    source = oiio.ImageInput.open(path)
    if not source:
        raise pov.Failure(f"{path}: cannot be read: {oiio.geterror()}")
    spec = source.spec()
    pixels = np.array(source.read_image("float")).reshape(spec.height, spec.width, spec.nchannels)
    header = {a.name: a.value for a in spec.extra_attribs}
    source.close()
    return pixels, list(spec.channelnames), header
