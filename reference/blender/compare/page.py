"""The page: both pictures, where they differ, the numbers, and what was not carried over. One file, no network."""

import base64
import html
import os
import tempfile

import numpy as np
import OpenImageIO as oiio

import judge
import suite


def png(pixels):
    """(h, w, 3) in [0, 1], display-encoded -> a data: URI."""
    values = np.ascontiguousarray(np.clip(pixels * 255 + .5, 0, 255).astype(np.uint8))
    handle, path = tempfile.mkstemp(suffix=".png")
    os.close(handle)
    output = oiio.ImageOutput.create(path)
    output.open(path, oiio.ImageSpec(values.shape[1], values.shape[0], 3, oiio.UINT8))
    output.write_image(values)
    output.close()
    with open(path, "rb") as file:
        data = file.read()
    os.remove(path)
    return "data:image/png;base64," + base64.b64encode(data).decode()


def srgb(linear):
    x = np.clip(linear, 0, 1)
    return np.where(x <= .0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - .055)


def exposure(mean):
    """A factor that brings the brightest hundredth of the picture to white."""
    top = float(np.percentile(mean.max(axis=2), 99))
    return 1 / top if top > 0 else 1.0


def heat(values):
    """0 black, red, yellow, 1 white."""
    v = np.clip(values, 0, 1)[..., None] * 3
    return np.clip(np.concatenate([v, v - 1, v - 2], axis=2), 0, 1)


def signed(values):
    """-1 blue, 0 white, 1 red."""
    v = np.clip(values, -1, 1)
    return np.stack([np.where(v < 0, 1 + v, 1), 1 - np.abs(v), np.where(v > 0, 1 - v, 1)], axis=2)


def tile_map(result, shape):
    values = np.zeros(shape)
    for tile in result["tiles"]:
        values[tile["y"]:tile["y"] + judge.TILE, tile["x"]:tile["x"] + judge.TILE] = tile["relative"] / result["tile_margin"]
    return values


STYLE = """
:root{color-scheme:light dark;--line:#8884;--soft:#8882}
body{font:15px/1.5 system-ui,sans-serif;max-width:1180px;margin:2rem auto;padding:0 1rem}
h1{font-size:1.5rem;margin:0 0 .2rem}h2{font-size:1.1rem;margin:2rem 0 .5rem}
.verdict{display:inline-block;padding:.1rem .7rem;border-radius:.3rem;color:#fff;background:#b3261e;margin-right:.5rem}
.verdict.agrees{background:#1b7f3b}.verdict.undecided{background:#8a6d00}p.why{margin:.3rem 0}
.stage{position:relative;background:#777;line-height:0;overflow:hidden;cursor:ew-resize;touch-action:none}
.stage img{width:100%;image-rendering:pixelated}.stage .over{position:absolute;inset:0;clip-path:inset(0 50% 0 0)}
.stage .bar{position:absolute;top:0;bottom:0;left:50%;width:2px;background:#fff;box-shadow:0 0 4px #000}
.stage b{position:absolute;top:.5rem;font:600 12px/1 system-ui;color:#fff;text-shadow:0 0 4px #000,0 0 2px #000}
.grid{display:grid;grid-template-columns:repeat(auto-fit,minmax(260px,1fr));gap:1rem;margin-top:1rem}
figure{margin:0}figure img{width:100%;image-rendering:pixelated;border:1px solid var(--line)}
figcaption{font-size:13px;opacity:.8}
table{border-collapse:collapse}td,th{padding:.15rem .8rem .15rem 0;text-align:left;border-bottom:1px solid var(--line);
font-variant-numeric:tabular-nums}td.n{text-align:right}code{background:var(--soft);padding:.1rem .3rem;border-radius:.2rem}
ul{padding-left:1.2rem}
"""
SCRIPT = """
const s=document.querySelector('.stage'),o=s.querySelector('.over'),b=s.querySelector('.bar');
const at=x=>{x=Math.min(100,Math.max(0,x));o.style.clipPath=`inset(0 ${100-x}% 0 0)`;b.style.left=x+'%'};
s.addEventListener('pointermove',e=>{const r=s.getBoundingClientRect();at(100*(e.clientX-r.left)/r.width)});
document.addEventListener('keydown',e=>{if(e.key=='1')at(100);if(e.key=='2')at(0)});
"""
LISTS = (
    ("lost", "Not carried over", "In Blender's picture only: what differs there says nothing about either renderer.",
     "Everything Blender shows was carried over."),
    ("changed", "Made alike", "Changed in both pictures, because glTF has no word for it.", ""),
    ("known", "Known of Blender 3.4.1", "Where Blender itself is known to be off.", ""),
)


def percent(x):
    return "–" if x is None else f"{100 * x:+.3f} %"


def write(path, title, result, notes, reference, test, facts, command):
    """`facts`: (name, value) pairs about how the pictures were made."""
    mean, ours = judge.read(reference)[0], judge.read(test)[0]
    flip = suite.read_exr(os.path.join(os.path.dirname(path), "flip.exr"))[0][..., 0]
    factor = exposure(mean)
    blender, assay = png(srgb(mean * factor)), png(srgb(ours * factor))
    floor = max(judge.TILE_FLOOR * result["image_mean"], 1e-30)
    relative = (ours - mean).mean(axis=2) / np.maximum(mean.mean(axis=2), floor)
    figures = (
        (blender, "Blender (Cycles)"), (assay, "Assay"),
        (png(signed(relative / .2)), "Assay − Blender, per pixel: red brighter, blue darker; full colour at 20 %"),
        (png(signed(tile_map(result, mean.shape[:2]))),
         f"the same per tile of {judge.TILE} × {judge.TILE}; full colour at the tile's margin, {100 * result['tile_margin']:.3g} %"),
        (png(heat(flip)), "FLIP: black equal, white as different as can be"),
    )
    agrees = result["verdict"] == "AGREES"
    style = {"AGREES": " agrees", "UNDECIDED": " undecided"}.get(result["verdict"], "")
    out = [f"<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width'>"
           f"<title>{html.escape(title)}: {result['verdict']}</title><style>{STYLE}</style>",
           f"<h1><span class='verdict{style}'>{result['verdict']}</span>{html.escape(title)}</h1>"]
    for why in result["reasons"]:
        out.append(f"<p class=why>{html.escape(why)}</p>")
    for why in result["too_noisy"]:
        out.append(f"<p class=why>Too noisy to tell: {html.escape(why)}</p>")
    if agrees:
        out.append(f"<p class=why>The means of red, green, blue and luminance agree within {100 * result['margin']:.3g} %, errors "
                   "included; FLIP is that of the noise; no tile is off.</p>")
    out.append(f"<div class=stage><img src='{assay}' alt='Assay'><img class=over src='{blender}' alt='Blender'><div class=bar></div>"
               "<b style='left:.5rem'>Blender</b><b style='right:.5rem'>Assay</b></div>"
               "<p class=why><small>Move over the picture; keys 1 and 2 show one alone.</small></p><div class=grid>")
    out += [f"<figure><img src='{uri}' alt=''><figcaption>{html.escape(text)}</figcaption></figure>" for uri, text in figures]
    out.append("</div><h2>Numbers</h2><table><tr><th>bias, Assay − Blender<th>relative<th>99 % interval")
    for name, d in result["bias"].items():
        out.append(f"<tr><td>{name}<td class=n>{percent(d['relative'])}<td class=n>[{percent(d['low'])}, {percent(d['high'])}]")
    out.append("</table><table style='margin-top:1rem'>")
    worst = sorted(result["tiles"], key=lambda t: -abs(t["relative"]))[:5]
    rows = [("FLIP, mean", f"{result['flip']['mean']:.4g}" if result["flip"]["mean"] is not None else "–"),
            ("FLIP of noise alone; limit", f"{result['flip']['noise_alone']:.4g}; {result['flip']['limit']:.4g}"),
            ("RMSE", f"{result['rmse']:.4g}"), ("relative MSE", f"{result['relative_mse']:.4g}"), *facts]
    out += [f"<tr><td>{html.escape(name)}<td>{html.escape(str(value))}" for name, value in rows]
    out.append("</table><h2>The five tiles furthest apart</h2><table><tr><th>x, y<th>bias<th>RMSE<th>noise of both<th>")
    out += [f"<tr><td>{t['x']}, {t['y']}<td class=n>{percent(t['relative'])}<td class=n>{t['rmse']:.3g}<td class=n>{t['noise']:.3g}"
            f"<td>{'beyond its margin' if t['shown'] else ''}" for t in worst]
    out.append("</table>")
    for key, heading, text, nothing in LISTS:
        if notes[key]:
            out.append(f"<h2>{heading}</h2><p class=why>{text}</p><ul>" +
                       "".join(f"<li>{html.escape(item)}" for item in notes[key]) + "</ul>")
        elif nothing:
            out.append(f"<h2>{heading}</h2><p class=why>{nothing}</p>")
    out.append("<h2>Again</h2>" + "".join(f"<p class=why><code>{html.escape(line)}</code></p>" for line in command))
    out.append(f"<script>{SCRIPT}</script></html>")
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(out) + "\n")
