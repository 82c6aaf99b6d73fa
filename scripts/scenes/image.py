"""Small image writers whose bytes never change: PNG with stored (uncompressed) blocks, half-float EXR, Radiance HDR."""

import math
import struct
import zlib


def encode_srgb(x):
    """Linear value in [0,1] to an sRGB code in [0,255] (IEC 61966-2-1), rounded."""
    y = 12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055
    return int(math.floor(255 * y + 0.5))


def decode_srgb(code):
    y = code / 255
    return y / 12.92 if y <= 0.04045 else ((y + 0.055) / 1.055) ** 2.4


def png(rows, bits=8, palette=None, srgb=True):
    """`rows`: from the top, each a list of pixels, each an integer or a tuple of 1 to 4 integers (grey, grey+alpha, RGB,
    RGBA), or an index into `palette` (RGB triples), stored with `bits` bits. Deflate's stored blocks keep the file
    the same whichever zlib writes it."""
    pixel = rows[0][0]
    channels = len(pixel) if isinstance(pixel, tuple) else 1
    color_type = 3 if palette else {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    raw = bytearray()
    for row in rows:
        raw.append(0)  # no filter
        values = [v for p in row for v in (p if isinstance(p, tuple) else (p,))]
        if bits == 16:
            raw += struct.pack(">%dH" % len(values), *values)
        elif bits == 8:
            raw += bytes(values)
        else:
            per_byte = 8 // bits
            values += [0] * (-len(values) % per_byte)
            for i in range(0, len(values), per_byte):
                byte = 0
                for v in values[i:i + per_byte]:
                    byte = byte << bits | v
                raw.append(byte)
    stream = b"\x78\x01"
    for start in range(0, len(raw), 65535):
        block = raw[start:start + 65535]
        last = start + 65535 >= len(raw)
        stream += struct.pack("<BHH", last, len(block), len(block) ^ 0xFFFF) + block
    stream += struct.pack(">I", zlib.adler32(raw))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), bits, color_type, 0, 0, 0)
    colors = chunk(b"PLTE", b"".join(bytes(c) for c in palette)) if palette else b""
    space = chunk(b"sRGB", b"\0") if srgb else b""
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + space + colors + chunk(b"IDAT", stream) +
            chunk(b"IEND", b""))


def exr(rows):
    """Uncompressed scan-line OpenEXR, half B G R, from rows (top first) of (r, g, b)."""
    width, height = len(rows[0]), len(rows)

    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(data)) + data

    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    channels = b"".join(c + b"\0" + struct.pack("<iBBBBii", 1, 0, 0, 0, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    header = struct.pack("<II", 20000630, 2) + b"".join((
        attribute(b"channels", b"chlist", channels), attribute(b"compression", b"compression", b"\0"),
        attribute(b"dataWindow", b"box2i", window), attribute(b"displayWindow", b"box2i", window),
        attribute(b"lineOrder", b"lineOrder", b"\0"), attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        attribute(b"screenWindowCenter", b"v2f", struct.pack("<ff", 0, 0)),
        attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)))) + b"\0"
    line = 8 + 6 * width
    first = len(header) + 8 * height
    table = b"".join(struct.pack("<Q", first + line * y) for y in range(height))
    body = b""
    for y, row in enumerate(rows):
        body += struct.pack("<ii", y, 6 * width)
        for channel in (2, 1, 0):
            body += struct.pack("<%de" % width, *(round(p[channel], 4) for p in row))
    return header + table + body


def hdr(rows):
    """Radiance picture, flat RGBE pixels, top row first."""
    data = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (len(rows), len(rows[0]))
    for row in rows:
        for p in row:
            mantissa, exponent = math.frexp(max(p))
            scale = mantissa * 256 / max(p) if max(p) > 1e-32 else 0
            data += bytes(int(c * scale + 1e-6) for c in p) + bytes([exponent + 128 if scale else 0])
    return data


def latlong(width, height, radiance):
    """Rows of radiance(direction) at texel centres, with the layout of docs/formats.md."""
    rows = []
    for j in range(height):
        theta = math.pi * (j + 0.5) / height
        row = []
        for i in range(width):
            phi = 2 * math.pi * ((i + 0.5) / width - 0.5)  # atan2(z, x)
            row.append(radiance((math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi))))
        rows.append(row)
    return rows
