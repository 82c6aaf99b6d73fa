"""The Disney BRDF and its relatives as POV-Ray user functions of a point on the unit sphere.

Written from Burley, "Physically Based Shading at Disney" (2012), Disney's published shader disney.brdf, and for
`principled` Blender 3.4's documented differences; not from Assay's C++. On a unit sphere about the origin the point
(x, y, z) is the normal; the eye (orthographic) and the light (directional) are constants, so all of a BRDF is a
formula in x, y, z, evaluated by POV-Ray in double precision.

Frame: x right, y up, z to the eye, right-handed. The tangent is the sphere's direction of longitude about y,
T = y cross n / |y cross n|, turned by `anisotropic_rotation` turns counter-clockwise about n; bitangent n cross T.

Values are f * (n.l) per channel: the radiance under a directional light of irradiance 1. Zero where n.l <= 0.
"""

import pov

# name: default. Colours and numbers as in glTF + Assay's extras; alpha is roughness squared.
DEFAULTS = {
    "base": (0.8, 0.8, 0.8), "metallic": 0.0, "roughness": 0.5, "specular": 0.5, "specular_tint": 0.0,
    "anisotropic": 0.0, "anisotropic_rotation": 0.0, "sheen": 0.0, "sheen_tint": 0.5, "clearcoat": 0.0,
    "clearcoat_roughness": 0.1778279, "d_gamma": 2.0, "d_constant": None,
}
LOBES = ("all", "diffuse", "sheen", "specular", "clearcoat")
MODELS = ("disney", "principled", "path", "path_disney")


def _number(value):
    return f"{float(value):.17g}"


def _vector(name, v):
    return "".join(f"#declare {name}{a} = {_number(c)};\n" for a, c in zip("xyz", v))


# S(u) = (1-u)^5, Schlick's weight; FD: unpolarised Fresnel reflectance of a dielectric of relative index e.
_COMMON = """
#declare S5 = function(u) { pow(min(max(1 - u, 0), 1), 5) };
#declare FDG = function(c, e) { sqrt(e*e - 1 + c*c) };
#declare FD = function(c, e) {
  0.5 * pow((FDG(c,e) - c) / (FDG(c,e) + c), 2)
      * (1 + pow((c*(FDG(c,e) + c) - 1) / (c*(FDG(c,e) - c) + 1), 2)) };
#declare NL = function(x,y,z) { x*Lx + y*Ly + z*Lz };
#declare NV = function(x,y,z) { z };
#declare NH = function(x,y,z) { x*Hx + y*Hy + z*Hz };
// Cosines safe to divide by; where they differ from the true ones the result is thrown away.
#declare CL = function(x,y,z) { max(NL(x,y,z), 1e-12) };
#declare CV = function(x,y,z) { max(NV(x,y,z), 1e-12) };
// Coordinates of a vector (a,b,c) along T0 = y cross n and B0 = n cross T0, then turned by the rotation.
#declare LT = function(x,y,z) { max(sqrt(x*x + z*z), 1e-12) };
#declare ET = function(x,y,z,a,b,c) { (z*a - x*c) / LT(x,y,z) };
#declare EB = function(x,y,z,a,b,c) { (b*(z*z + x*x) - y*(x*a + z*c)) / LT(x,y,z) };
#declare WX = function(x,y,z,a,b,c) { cos(Turn)*ET(x,y,z,a,b,c) + sin(Turn)*EB(x,y,z,a,b,c) };
#declare WY = function(x,y,z,a,b,c) { cos(Turn)*EB(x,y,z,a,b,c) - sin(Turn)*ET(x,y,z,a,b,c) };
// Burley's retro-reflective diffuse without base/pi; constant LH because eye and light are.
#declare FD90 = 0.5 + 2*Rough*LH*LH;
#declare DIFFUSE = function(x,y,z) {
  (1 + (FD90 - 1)*S5(NL(x,y,z))) * (1 + (FD90 - 1)*S5(NV(x,y,z))) / pi };
// Smith's G1 of isotropic GGX divided by twice the cosine c; two of them are G/(4 NL NV). a2: alpha squared.
#declare V1 = function(c, a2) { 1 / (c + sqrt(a2 + c*c - a2*c*c)) };
"""

# D G / (4 NL NV) of the specular lobe.
_GTR2_ISOTROPIC = """
#declare SPEC = function(x,y,z) {
  Ax*Ax / (pi * pow(1 + (Ax*Ax - 1)*pow(NH(x,y,z), 2), 2)) * V1(CL(x,y,z), Ax*Ax) * V1(CV(x,y,z), Ax*Ax) };
"""
_GTR2_ANISOTROPIC = """
#declare VA = function(x,y,z,a,b,c,n) {
  1 / (n + sqrt(pow(WX(x,y,z,a,b,c)*Ax, 2) + pow(WY(x,y,z,a,b,c)*Ay, 2) + n*n)) };
#declare SPEC = function(x,y,z) {
  1 / (pi * Ax * Ay * pow(pow(WX(x,y,z,Hx,Hy,Hz)/Ax, 2) + pow(WY(x,y,z,Hx,Hy,Hz)/Ay, 2) + pow(NH(x,y,z), 2), 2))
  * VA(x,y,z,Lx,Ly,Lz,CL(x,y,z)) * VA(x,y,z,0,0,1,CV(x,y,z)) };
"""
# path_disney: D = c / (alpha^2 cos^2 + sin^2)^gamma, masking with alpha_g = (1/2 + roughness/2)^2.
_GTR_GAMMA = """
#declare AG = pow(0.5 + Rough/2, 2);
#declare SPEC = function(x,y,z) {
  Const * pow(1 + (Ax*Ax - 1)*pow(NH(x,y,z), 2), -Gamma) * V1(CL(x,y,z), AG*AG) * V1(CV(x,y,z), AG*AG) };
"""
_CLEARCOAT = """
#declare COAT = function(x,y,z) {
  (Ac*Ac - 1) / (2 * pi * ln(Ac) * (1 + (Ac*Ac - 1)*pow(NH(x,y,z), 2)))
  * V1(CL(x,y,z), 0.0625) * V1(CV(x,y,z), 0.0625) };
"""


def _normalise(v):
    length = sum(c * c for c in v) ** 0.5
    return [c / length for c in v]


def complete(parameters):
    """Defaults filled in, names and ranges checked."""
    unknown = set(parameters) - set(DEFAULTS)
    if unknown:
        raise pov.Failure(f"brdf: unknown parameter '{sorted(unknown)[0]}'; wanted one of {', '.join(DEFAULTS)}")
    return {**DEFAULTS, **parameters}


def declarations(model, parameters, light, lobe="all"):
    """(SDL text, (r, g, b)): the names of three functions of (x,y,z) are usable once the text has been read."""
    if model not in MODELS:
        raise pov.Failure(f"brdf: unknown model '{model}'; wanted one of {', '.join(MODELS)}")
    if lobe not in LOBES:
        raise pov.Failure(f"brdf: unknown lobe '{lobe}'; wanted one of {', '.join(LOBES)}")
    p = complete(parameters)
    light = _normalise(light)
    half = _normalise([light[0], light[1], light[2] + 1])
    principled = model == "principled"
    text = _vector("L", light) + _vector("H", half)
    for name, value in (("LH", sum(a * b for a, b in zip(light, half))), ("Rough", p["roughness"]),
                        ("Metal", p["metallic"]), ("Specular", p["specular"]), ("SpecTint", p["specular_tint"]),
                        ("Sheen", p["sheen"]), ("SheenTint", p["sheen_tint"]), ("Coat", p["clearcoat"]),
                        ("Aniso", p["anisotropic"]), ("CoatRough", p["clearcoat_roughness"])):
        text += f"#declare {name} = {_number(value)};\n"
    text += f"#declare Turn = 2*pi*{_number(p['anisotropic_rotation'])};\n"
    text += _vector("Base", p["base"])

    # Widths. Disney keeps alpha above .001; Blender clamps it to 1.
    text += "#declare Aspect = sqrt(1 - 0.9*Aniso);\n"
    if principled:
        text += "#declare Ax = min(Rough*Rough/Aspect, 1);\n#declare Ay = min(Rough*Rough*Aspect, 1);\n"
    elif model == "disney":
        text += "#declare Ax = max(Rough*Rough/Aspect, 0.001);\n#declare Ay = max(Rough*Rough*Aspect, 0.001);\n"
    else:
        text += "#declare Ax = max(Rough*Rough, 0.001);\n#declare Ay = Ax;\n"
    text += f"#declare Ac = {'CoatRough*CoatRough' if principled else 'max(CoatRough*CoatRough, 0.001)'};\n"
    text += _COMMON

    # Fresnel weights: Schlick's, or the dielectric curve stretched to run from 0 to 1.
    if principled:
        text += "#declare Eta = 2/(1 - sqrt(0.08*Specular)) - 1;\n"
        text += ("#if (Specular > 0) #declare FS = (FD(LH, Eta) - FD(1, Eta)) / (1 - FD(1, Eta)); "
                 "#else #declare FS = 0; #end\n")
        text += "#declare FC = (FD(LH, 1.5) - FD(1, 1.5)) / (1 - FD(1, 1.5));\n"
    else:
        text += "#declare FS = S5(LH);\n#declare FC = S5(LH);\n"

    if model == "path_disney":
        gamma = float(p["d_gamma"])
        text += f"#declare Gamma = {_number(gamma)};\n"
        if p["d_constant"] is not None:
            text += f"#declare Const = {_number(p['d_constant'])};\n"
        elif p["roughness"] == 1:
            text += "#declare Const = 1/pi;\n"
        elif gamma == 1:
            text += "#declare Const = (Ax*Ax - 1) / (2*pi*ln(Ax));\n"
        else:
            text += "#declare Const = (Gamma - 1)*(Ax*Ax - 1) / (pi*(1 - pow(Ax, 2*(1 - Gamma))));\n"
        text += _GTR_GAMMA
    else:
        text += _GTR2_ANISOTROPIC if p["anisotropic"] > 0 and model != "path" else _GTR2_ISOTROPIC
    # The path models have neither sheen, coat nor tint; without specular and metal they are purely diffuse, where
    # Disney's shader keeps Schlick's white edge.
    plain = model in ("path", "path_disney")
    if plain:
        p = dict(p, sheen=0.0, clearcoat=0.0)
        text += "#declare SpecTint = 0;\n"
    has_specular = model == "disney" or p["specular"] > 0 or p["metallic"] > 0
    if model == "path":
        text += "#declare LAMBERT = function(x,y,z) { 1/pi };\n"
    if p["clearcoat"] > 0:
        text += _CLEARCOAT

    # Tints: base over its luminance, by Disney's weights, or for Blender's sheen by Rec.709's.
    text += "#declare Lum = 0.3*Basex + 0.6*Basey + 0.1*Basez;\n"
    text += ("#declare LumSheen = 0.2126729*Basex + 0.7151522*Basey + 0.0721750*Basez;\n" if principled
             else "#declare LumSheen = Lum;\n")
    names = []
    for a in "xyz":
        text += f"#declare Tint{a} = 1; #declare TintSheen{a} = 1;\n"
        text += (f"#if (Lum > 0) #declare Tint{a} = Base{a}/Lum; #declare TintSheen{a} = Base{a}/LumSheen; #end\n"
                 f"#declare F0{a} = 0.08*Specular*(1 + (Tint{a} - 1)*SpecTint)*(1 - Metal) + Base{a}*Metal;\n")
        if principled:
            text += f"#declare F0{a} = min(max(F0{a}, 0), 1);\n"
        terms = []
        if lobe in ("all", "diffuse"):
            terms.append(f"(1 - Metal)*Base{a}*{'LAMBERT' if model == 'path' else 'DIFFUSE'}(x,y,z)")
        if lobe in ("all", "sheen") and p["sheen"] > 0:
            terms.append(f"(1 - Metal)*Sheen*(1 + (TintSheen{a} - 1)*SheenTint)*S5(LH)")
        if lobe in ("all", "specular") and has_specular:
            terms.append(f"(F0{a} + (1 - F0{a})*FS)*SPEC(x,y,z)")
        if lobe in ("all", "clearcoat") and p["clearcoat"] > 0:
            terms.append("Coat/4*(0.04 + 0.96*FC)*COAT(x,y,z)")
        text += (f"#declare BRDF{a} = function(x,y,z) {{ select(min(NL(x,y,z), NV(x,y,z)), 0, 0, "
                 f"NL(x,y,z)*({' + '.join(terms) or '0'})) }};\n")
        names.append(f"BRDF{a}(x,y,z)")
    return text, names
