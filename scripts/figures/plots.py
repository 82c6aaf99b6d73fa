"""The plots of docs/disney.md, drawn from the curves that bsdf-curves prints."""

from svg import Figure, Panel, polar

# One colour per lobe and per gamma, on every plot.
DIFFUSE, SHEEN, SPECULAR, COAT = "#0072b2", "#aa4499", "#d55e00", "#00805e"
GAMMA = {"0.5": "#5e4fa2", "1": "#3288bd", "1.5": "#2a9d76", "2": "#d18f00", "3": "#d9591c", "10": "#9e0142"}
ROUGHNESS = {"0.1": "#9ecae1", "0.25": "#4292c6", "0.5": "#08519c", "1": "#041f45"}
SHADES = {SPECULAR: ("#fdae6b", "#f07818", "#b54a00", "#6b2b00"), COAT: ("#74c9ae", "#1b9e77", "#00543d"),
          DIFFUSE: ("#7cc0e8", "#2b8cbe", "#08406b"), SHEEN: ("#d9a0cf", "#8e2f80")}
DASH = "6 4"


def parse(text):
    """{"plot/panel/curve": [(x, y), ...]} of bsdf-curves' output."""
    curves = {}
    for block in text.strip().split("\n\n"):
        name, *lines = block.split("\n")
        curves[name] = [tuple(float(x) for x in line.split()) for line in lines]
    return curves


def distribution(curves):
    figure = Figure(920, 400, "The distribution D: GTR of six exponents, normalised; and the settings of the report")
    panel = Panel(figure, (66, 50, 350, 290), [0, 10, 20, 30, 40, 50, 60], [1e-3, .01, .1, 1, 10, 100, 1000],
                  "Normalised GTR, α = 0.1", "angle between half vector and normal, θh", "D, 1/sr", True, "°")
    for gamma, color in GAMMA.items():
        panel.line(curves["distribution/normalised/" + gamma], color)
    figure.legend(330, 74, [("½" if g == "0.5" else g, c, None) for g, c in GAMMA.items()], "γ =")
    panel = Panel(figure, (516, 50, 380, 290), [0, 2, 4, 6, 8, 10], [.01, 1, 100, 1e4, 1e6],
                  "The green sphere of the figures, α = 0.01", "angle between half vector and normal, θh", "D, 1/sr", True, "°")
    entries = []
    for key, label, color, dash in (("2 .005", "γ 2, c 0.005 (figure 7)", GAMMA["2"], DASH),
                                    ("2 auto", "γ 2, normalised", GAMMA["2"], None),
                                    ("1 .3", "γ 1, c 0.3 (figure 6)", GAMMA["1"], "2 3"),
                                    ("1 .03", "γ 1, c 0.03 (its caption)", GAMMA["1"], DASH),
                                    ("1 .005", "γ 1, c 0.005 (figure 5)", GAMMA["1"], "10 3 2 3"),
                                    ("1 auto", "γ 1, normalised", GAMMA["1"], None)):
        panel.line(curves["distribution/report/" + key], color, 2, dash)
        entries.append((label, color, dash))
    figure.legend(690, 68, entries)
    return figure


def fresnel(curves):
    figure = Figure(920, 360, "Fresnel reflectance F: Schlick's curve and the rescaled dielectric curve")
    panel = Panel(figure, (66, 50, 520, 250), [0, 15, 30, 45, 60, 75, 90], [0, .2, .4, .6, .8, 1],
                  "F of a dielectric", "angle between light and half vector, θd", "reflectance", False, "°")
    entries = []
    for specular, color, f0 in (("0.5", SPECULAR, "0.04"), ("1", SHADES[SPECULAR][3], "0.08")):
        for kind, who, dash in (("schlick", "disney, path_disney, path (Schlick)", None), ("dielectric", "principled (Blender)", DASH)):
            panel.line(curves["fresnel/F/%s %s" % (kind, specular)], color, 2, dash)
            entries.append((who, color, dash))
        figure.legend(618, 92 if specular == "0.5" else 192, entries, "specular %s, F₀ = %s" % (specular, f0))
        entries = []
    return figure


def masking(curves):
    figure = Figure(920, 400, "Smith's masking G1 with the two choices of its roughness")
    for i, (kind, title) in enumerate((("shader", "disney, principled, path: αg = r²"), ("text", "path_disney: αg = (½ + r/2)²"))):
        panel = Panel(figure, (66 + 450 * i, 50, 375, 290), [0, 15, 30, 45, 60, 75, 90], [0, .2, .4, .6, .8, 1],
                      title, "angle to the normal, θ", "G₁" if i == 0 else None, False, "°")
        for roughness, color in ROUGHNESS.items():
            panel.line(curves["masking/%s/%s" % (kind, roughness)], color)
        entries = [("r = " + r, c, None) for r, c in ROUGHNESS.items()]
        if kind == "shader":
            panel.line(curves["masking/shader/coat"], COAT, 2, DASH)
            entries.append(("coat, αg = ¼", COAT, DASH))
        figure.legend(84 + 450 * i, 232, entries)
    return figure


def lobes(curves):
    figure = Figure(920, 706, "The four lobes of the Disney BRDF in the plane of incidence")
    shades = SHADES[DIFFUSE]
    entries = [("Lambert", "#888888", DASH)] + [("roughness " + r, c, None) for r, c in zip(("0", "0.5", "1"), shades)]
    names = ("Lambert", "0", "0.5", "1")
    polar(figure, (236, 238), 170, [.2, .4, .6, .8], "Diffuse, white: f, viewer at −60°", 60, [
        (curves["lobes/diffuse/" + name], color, dash) for name, (_, color, dash) in zip(names, entries)])
    figure.legend(80, 286, entries[:2])
    figure.legend(230, 286, entries[2:])
    shades = SHADES[SHEEN]
    polar(figure, (696, 238), 170, [.2, .4, .6], "Sheen on black: f, viewer at −75°", 75, [
        (curves["lobes/sheen/" + name], color, None) for name, color in zip(("0.5", "1"), shades)])
    figure.legend(540, 286, [("sheen 0.5", shades[0], None), ("sheen 1", shades[1], None)])
    ticks = [-90, -60, -30, 0, 30, 60, 90], [1e-4, 1e-3, .01, .1, 1, 10, 100]
    panel = Panel(figure, (66, 372, 370, 270), *ticks, "Specular (GTR2), specular 0.5: viewer at −45°",
                  "direction of the light, θl", "f cos θl, 1/sr", True, "°")
    names = ("0.2", "0.4", "0.7", "1")
    for name, color in zip(names, SHADES[SPECULAR]):
        panel.line(curves["lobes/specular/" + name], color)
    figure.legend(80, 394, [("roughness " + n, c, None) for n, c in zip(names, SHADES[SPECULAR])])
    panel = Panel(figure, (526, 372, 370, 270), *ticks, "Clearcoat (GTR1), clearcoat 1: viewer at −45°",
                  "direction of the light, θl", None, True, "°")
    names = ("0", "0.7", "1")
    for name, color in zip(names, SHADES[COAT]):
        panel.line(curves["lobes/clearcoat/" + name], color)
    figure.legend(540, 394, [("gloss " + n, c, None) for n, c in zip(names, SHADES[COAT])])
    return figure


def albedo(curves):
    figure = Figure(920, 400, "How much of the light a white metal reflects, by angle")
    ticks = [0, 15, 30, 45, 60, 75, 90]
    panel = Panel(figure, (66, 50, 375, 290), ticks, [0, .2, .4, .6, .8, 1, 1.2, 1.4], "disney, white metal", "direction of the light, θl",
                  "reflected share", False, "°")
    shown = {r: ROUGHNESS[r] for r in ("0.1", "0.5", "1")}
    for roughness, color in shown.items():
        panel.line(curves["albedo/disney/" + roughness], color)
    panel.line([(0, 1), (90, 1)], "#888888", 1, DASH)
    figure.legend(84, 76, [("roughness " + r, c, None) for r, c in shown.items()])
    panel = Panel(figure, (516, 50, 375, 290), ticks, [0, .2, .4, .6, .8, 1, 1.2, 1.4],
                  "path_disney, D normalised, roughness 0.25", "direction of the light, θl", None, False, "°")
    shown = {g: GAMMA[g] for g in ("0.5", "1", "2", "10")}
    for gamma, color in shown.items():
        panel.line(curves["albedo/path_disney/" + gamma], color)
    panel.line([(0, 1), (90, 1)], "#888888", 1, DASH)
    figure.legend(534, 240, [("γ = " + ("½" if g == "0.5" else g), c, None) for g, c in shown.items()])
    return figure


def sampling(curves):
    figure = Figure(920, 360, "Density of sampled half vectors and a histogram of samples")
    panel = Panel(figure, (66, 50, 560, 250), [0, 15, 30, 45, 60, 75, 90], [0, .05, .1, .15, .2],
                  "Half vectors of GTR, α = 0.25", "angle to the normal, θh", "share per degree", False, "°")
    shown = ("0.5", "1", "2", "10")
    for gamma in shown:
        panel.bars(curves["sampling/histogram/" + gamma], 1, GAMMA[gamma])
    for gamma in shown:
        panel.line(curves["sampling/density/" + gamma], GAMMA[gamma])
    figure.legend(660, 82, [("γ = " + ("½" if g == "0.5" else g), GAMMA[g], None) for g in shown], "lines: D cos θh 2π sin θh")
    figure.text(660, 190, "bars: 65,536 samples", color="#57606a")
    return figure


PLOTS = {"distribution": distribution, "fresnel": fresnel, "masking": masking, "lobes": lobes, "albedo": albedo,
         "sampling": sampling}


def files(curves):
    return {name + ".svg": plot(curves).bytes() for name, plot in PLOTS.items()}
