"""Do two pictures agree? `assay compare` answers for the whole, and this looks at every tile (plain Python).

AGREES needs all three:
  mean   the 99 % intervals of the relative bias of red, green, blue and luminance lie inside the margin
  FLIP   at most 1.25 times what the noise of both pictures alone shows, plus .005
  tiles  no tile of 8 x 8 pixels is shown (false alarm 1e-4 over all) to be off by more than ten margins
DIFFERS if one of them is shown not to hold; UNDECIDED if only noise is in the way.
"""

import json
import math
import os
import statistics
import subprocess

import numpy as np

import suite
from notes import Failure

TILE = 8
TILE_MARGINS = 10  # a tile's margin, in margins of the image
TILE_FLOOR = .1  # a darker tile is held to this share of the image's mean
FALSE_ALARM = 1e-4


def read(path):
    """(mean, variance of the mean, replicates as images, their number)."""
    pixels, spec = suite.read_exr(path)
    names, pixels = list(spec.channelnames), pixels.astype(np.float64)

    def layer(prefix):
        return np.ascontiguousarray(pixels[..., [names.index(prefix + c) for c in "RGB"]])

    header = {a.name: a.value for a in spec.extra_attribs if a.name.startswith("assay:")}
    count = int(header.get("assay:replicates", 0))
    parts = [layer(f"replicate{r}.") for r in range(count)] if "replicate0.R" in names else []
    return layer(""), layer("variance.") * header.get("assay:variance_scale", 1.0), parts, count


def run_compare(assay, reference, test, flip_map=None):
    command = [assay, "compare", "--json", reference, test] + (["--flip-map", flip_map] if flip_map else [])
    ran = subprocess.run(command, capture_output=True, text=True)
    if ran.returncode not in (0, 1):
        raise Failure((ran.stderr.strip() or ran.stdout.strip() or f"assay compare: exit code {ran.returncode}").splitlines()[-1])
    return json.loads(ran.stdout)


def noise_alone(reference, ours, parts):
    """The reference with as much noise as both pictures have: that of our replicates, one half against the other."""
    mean, variance = reference
    half = len(parts) // 2
    noise = (sum(parts[:half]) - sum(parts[half:2 * half])) / (2 * half)
    have, wanted = ours[1].sum(axis=2), (ours[1] + variance).sum(axis=2)
    scale = np.sqrt(np.where(have > 0, wanted / np.where(have > 0, have, 1), 0))
    return mean + noise * scale[..., None]


def tiles(mean, variance, count, our_mean, our_variance, our_count, margin):
    """Per tile: place, relative difference of the worst channel, RMSE, and whether it is shown to be beyond its margin."""
    height, width, _ = mean.shape
    image_mean = mean.mean()
    places = [(x, y) for y in range(0, height, TILE) for x in range(0, width, TILE)]
    critical = statistics.NormalDist().inv_cdf(1 - FALSE_ALARM / (len(places) * 3) / 2)
    found = []
    for x, y in places:
        cut = np.s_[y:y + TILE, x:x + TILE]
        a, b, va, vb = (p[cut].reshape(-1, 3) for p in (mean, our_mean, variance, our_variance))
        n = len(a)
        scale = max(a.mean(), TILE_FLOOR * image_mean, 1e-30)
        difference, total = (b - a).mean(axis=0), (va + vb).sum(axis=0) / n ** 2
        spread = ((va ** 2).sum(axis=0) / (count - 1) + (vb ** 2).sum(axis=0) / (our_count - 1)) / n ** 4
        freedom = np.maximum(np.where(spread > 0, total ** 2 / np.where(spread > 0, spread, 1), 1e9), 1)
        beyond = np.maximum(np.abs(difference) - TILE_MARGINS * margin * scale, 0)
        t2 = beyond ** 2 / (total + (1e-5 * scale) ** 2)
        # Wallace's normal deviate of Student's t.
        z = (8 * freedom + 1) / (8 * freedom + 3) * np.sqrt(freedom * np.log1p(t2 / freedom))
        worst = int(np.abs(difference).argmax())
        noise = math.sqrt(float((va + vb).mean()))
        found.append({"x": x, "y": y, "relative": float(difference[worst] / scale), "rmse": float(np.sqrt(((b - a) ** 2).mean())),
                      "noise": noise, "shown": bool((z > critical).any())})
    return found


def judge(assay, reference, test, margin, folder):
    """`reference` and `test` are .exr files with variances. Everything the page and --json say about them."""
    mean, variance, _, count = read(reference)
    our_mean, our_variance, parts, our_count = read(test)
    if not np.isfinite(mean).all() or not np.isfinite(our_mean).all():
        raise Failure(f"{reference if not np.isfinite(mean).all() else test}: wanted finite pixels, found some that are not")
    answer = run_compare(assay, reference, test, os.path.join(folder, "flip.exr"))
    reasons, unclear, bias = [], [], (answer["bias"] or {}).get("image", {})
    for name, d in bias.items():
        low, high = (d[k] if d[k] is not None else 0.0 for k in ("low", "high"))
        if -margin <= low and high <= margin:
            continue
        text = f"{name} {100 * (d['relative'] or 0):+.3g} % [{100 * low:+.3g}, {100 * high:+.3g}], margin {100 * margin:.3g} %"
        (reasons if low > margin or high < -margin else unclear).append(text)
    if not bias:
        unclear.append((answer["bias"] or {}).get("failure", "no statistics"))

    floor = 0.0
    if len(parts) >= 2:
        path = os.path.join(folder, "noise.exr")
        suite.write_witness(path, noise_alone((mean, variance), (our_mean, our_variance), parts), variance, {})
        floor = run_compare(assay, reference, path)["flip"]["mean"] or 0.0
        os.remove(path)
    limit = 1.25 * floor + .005
    flip = answer["flip"]["mean"]
    if flip is None or flip > limit:
        if not (flip is None and not mean.any() and not our_mean.any()):
            reasons.append(f"FLIP {flip if flip is None else format(flip, '.3g')} above its limit {limit:.3g}")
    found = tiles(mean, variance, count, our_mean, our_variance, our_count, margin)
    beyond = [t for t in found if t["shown"]]
    if beyond:
        reasons.append(f"{len(beyond)} of {len(found)} tiles beyond {100 * TILE_MARGINS * margin:.3g} %")
    return {
        "verdict": "DIFFERS" if reasons else "UNDECIDED" if unclear else "AGREES", "shown": bool(reasons), "reasons": reasons,
        "too_noisy": unclear, "margin": margin, "bias": bias,
        "flip": {"mean": flip, "noise_alone": floor, "limit": limit}, "rmse": answer["rmse"], "relative_mse": answer["relative_mse"],
        "image_mean": float(mean.mean()), "tile": TILE, "tile_margin": TILE_MARGINS * margin, "tiles": found,
    }
