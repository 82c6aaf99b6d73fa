"""Damages good scenes for scripts/mutate: file number n is made from n alone, the same one each time."""
import copy
import json
import random
import struct
import zlib
from pathlib import Path

root = Path(__file__).resolve().parent.parent.parent
VALUES = [None, True, False, -1, 0, 1, 2, 3, 7, 255, 5120, 5121, 5123, 5125, 5126, 2**31 - 1, 2**31, 2**32 - 1, 2**63, 2**64, -2**63, .5, -.0,
          1e-45, 1e-30, 1e30, 1e38, 3.5e38, 1e300, "", "x", "SCALAR", "VEC2", "VEC4", "MAT4", "POSITION", "BLEND", "MASK", "KHR_lights_punctual",
          [], {}, [None], [0], [0, 0, 0], [1e30, 1, 1], [0] * 16, [1e-30] * 4, {"a": []}, "deep", "long", "many"]
OUTSIDE = ["../secret.bin", "%2e%2e/secret.bin", "..%2fsecret.bin", "sub/../../secret.bin", "link.bin", "up/secret.bin", "/etc/hostname", "file:///etc/hostname",
           "secret.bin", "\\\\host\\x", "C:\\x", "fifo.bin", ".", "", "x\0.png", "http://localhost/x", "data:,", "data:image/png;base64,AAAA", "~", "$(id)", "/dev/zero"]
KINDS = ["json"] * 7 + ["floats"] * 4 + ["buffer", "buffer", "uri", "image", "image", "map", "file"]
FLOATS = [float("nan"), float("inf"), -float("inf"), 0.0, -0.0, 1e-45, 1e-38, 1e-20, 1e18, 1.9e18, 1e30, 3.4e38, -3.4e38, -1.0]


def read_glb(data):
    length, = struct.unpack_from("<I", data, 12)
    return json.loads(data[20:20 + length]), data[28 + length:]


def glb(text, binary):
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def sources():
    """(name, document, buffer) of every good file."""
    found = []
    for file in sorted((root / "regression/scenes").glob("*.glb")) + [root / "renderer/app/corpus/glb/good"]:
        if file.stat().st_size < 30_000:
            found.append((file.stem, *read_glb(file.read_bytes())))
    return found


def places(value, path=()):
    """Path of every value in a document but the document itself."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, child in inner:
        yield path + (key,)
        yield from places(child, path + (key,))


def at(document, path):
    for step in path:
        document = document[step]
    return document


def damage_json(dice, document):
    path = dice.choice(list(places(document)))
    parent, key = at(document, path[:-1]), path[-1]
    old, way = parent[key], dice.randrange(7)
    if way == 0:
        del parent[key]
    elif isinstance(old, (int, float)) and not isinstance(old, bool) and dice.random() < .8:
        parent[key] = dice.choice([old + 1, old - 1, -old, old * 2, old * 1000, old / 3, old + 2**32, old * 1e-6, 0, .5, 1, 2, 1e-30, 1e30, 1e-45, 3.4e38, 255])
    elif way == 2:
        parent[key] = copy.deepcopy(at(document, dice.choice(list(places(document)))))
    elif way == 3 and isinstance(parent, list):
        parent.insert(key, copy.deepcopy(old))
    elif way >= 4 and isinstance(old, str) and dice.random() < .8:
        parent[key] = "".join(dice.choice([c, c, c, c, c.swapcase(), "", c + c, "\u20ac", "\0"]) for c in old)
    else:
        new = dice.choice(VALUES)
        if new == "deep":
            new = 0
            for _ in range(dice.choice([10, 70, 400])):
                new = [new] if dice.random() < .5 else {"a": new}
        elif new == "long":
            new = "x" * dice.choice([300, 5000, 100_000])
        elif new == "many":
            new = [copy.deepcopy(old)] * dice.choice([17, 1000])
        parent[key] = new


def damage_uri(dice, document):
    holders = [at(document, p[:-1]) for p in places(document) if p[-1] == "uri"] + document.get("images", [])[:1] + document.get("buffers", [])[:1]
    scene = (document.get("scenes") or [{}])[0]
    if not holders or dice.random() < .2:
        scene.setdefault("extras", {})["environment"] = dice.choice(OUTSIDE + ["../secret.exr", "link.exr", "/dev/zero.hdr"])
    else:
        dice.choice(holders)["uri"] = dice.choice(OUTSIDE)


def damage_bytes(dice, data):
    """Flips, cuts, doubles."""
    data, way = bytearray(data), dice.randrange(8)
    if not data:
        return bytes(data)
    if way == 0:
        return bytes(data[:dice.randrange(len(data))])
    if way == 1:
        a, b = sorted(dice.randrange(len(data)) for _ in range(2))
        return bytes(data[:b] + data[a:])
    if way == 2:
        a = dice.randrange(len(data))
        return bytes(data[:a] + data[a + dice.randrange(1, 40):])
    for _ in range(dice.choice([1, 1, 2, 4, 30])):
        data[dice.randrange(len(data))] = dice.choice([0, 255, 127, 128, dice.randrange(256)])
    return bytes(data)


def damage_floats(dice, document, data):
    """Numbers of the accessors that hold floats."""
    data, views = bytearray(data), document["bufferViews"]
    views = [views[a["bufferView"]] for a in document.get("accessors", []) if a.get("componentType") == 5126 and "bufferView" in a]
    for _ in range(dice.choice([1, 1, 3, 20]) if views else 0):
        view = dice.choice(views)
        struct.pack_into("<f", data, view.get("byteOffset", 0) + dice.randrange(view["byteLength"] // 4) * 4, dice.choice(FLOATS))
    return bytes(data)


def damage_image(dice, data):
    """Bytes within the chunks of a PNG, whose checksums are mended; anything else as bytes."""
    if not data.startswith(b"\x89PNG") or dice.random() < .1:
        return damage_bytes(dice, data)
    chunks, place = [], 8
    while place + 12 <= len(data):
        length, = struct.unpack_from(">I", data, place)
        chunks.append((data[place + 4:place + 8], data[place + 8:place + 8 + length]))
        place += 12 + length
    i, way = dice.randrange(len(chunks)), dice.randrange(7)
    name, body = chunks[i]
    if way == 0:
        del chunks[i]
    elif way == 1:
        chunks.insert(dice.randrange(len(chunks)), chunks[i])
    elif way == 2:
        new = dice.choice([(b"gAMA", struct.pack(">I", dice.choice([0, 1, 2**31]))), (b"tRNS", bytes(dice.randrange(9))), (b"PLTE", bytes(dice.choice([3, 4, 768, 900]))), (b"sRGB", b"\7"),
                           (b"iCCP", b"x\0\0" + bytes(20)), (b"cHRM", bytes(32)), (b"tEXt", b"\0" * 99), (b"ABCD", b"x"), (b"sBIT", b"\x63"), (b"IDAT", b"")])
        chunks.insert(dice.randrange(len(chunks)), new)
    elif way == 3 and name == b"IDAT":  # what is compressed, and wrong
        chunks[i] = (name, zlib.compress(damage_bytes(dice, zlib.decompress(body))) if body else b"")
    else:
        chunks[i] = (name, damage_bytes(dice, body))
    return data[:8] + b"".join(struct.pack(">I", len(b)) + n + b + struct.pack(">I", zlib.crc32(n + b)) for n, b in chunks)


def make(number, good, folder):
    """Writes damaged file number `number` into the folder; returns its path and what was done."""
    dice = random.Random(number)
    name, document, binary = good[number % len(good)]
    document, done = copy.deepcopy(document), [name]
    apart = dice.random() < .4  # .gltf, its buffer and its images beside it
    kinds = [dice.choice(KINDS) for _ in range(dice.choice([1, 1, 1, 2, 3]))]
    done += kinds
    files, size = {}, len(binary)
    views = document.get("bufferViews", [])
    for kind in kinds:
        holders = [i for i in document.get("images", []) if isinstance(i, dict) and isinstance(i.get("bufferView"), int)]
        if kind == "image" and holders:
            holder = dice.choice(holders)
            view = views[holder["bufferView"]]
            start = view.get("byteOffset", 0)
            changed = damage_image(dice, binary[start:start + view["byteLength"]])
            binary += bytes(-len(binary) % 4)
            view["byteOffset"], view["byteLength"] = len(binary), len(changed)
            binary += changed
            document["buffers"][0]["byteLength"] = len(binary)
        elif kind == "map":
            source = dice.choice([root / "regression/scenes/sky.hdr", root / "regression/scenes/studio.exr"] + sorted((root / "renderer/app/corpus/image").glob("*.exr")))
            files["map" + source.suffix] = damage_bytes(dice, source.read_bytes())
            extras = document["scenes"][0].setdefault("extras", {})
            extras.pop("environment_color", None)
            extras["environment"] = "map" + source.suffix
        elif kind == "floats" and len(binary) == size:
            binary = damage_floats(dice, document, binary)
        elif kind == "buffer":
            binary = damage_bytes(dice, binary)
    for i, image in enumerate(document.get("images", []) if apart else []):
        if "bufferView" in image:
            view = views[image.pop("bufferView")]
            image["uri"] = f"image{i}.png"
            files[image["uri"]] = binary[view.get("byteOffset", 0):][:view["byteLength"]]
    if apart:
        files["buffer.bin"] = binary
        document["buffers"][0]["uri"] = "buffer.bin"
    for kind in kinds:
        try:
            if kind == "json":
                damage_json(dice, document)
            elif kind == "uri":
                damage_uri(dice, document)
        except (TypeError, KeyError, IndexError, AttributeError, OverflowError):
            pass  # the damage before has left no such place
    text = json.dumps(document).encode()
    data = text if apart else glb(text, binary)
    if "file" in kinds:
        data = damage_bytes(dice, data)
    for file, content in files.items():
        (folder / file).write_bytes(content)
    scene = folder / ("scene.gltf" if apart else "scene.glb")
    scene.write_bytes(data)
    return scene, done
