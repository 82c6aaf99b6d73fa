"""Every file of regression/scenes and the function that makes its bytes."""

import basic_pl
import card
import closed
import lights
import meshes
import parameters
import surfaces

SCENES = (
    (card, "brdf_card"),
    (closed, "cornell furnace_box furnace_environment furnace_mirror furnace_point spot_flux"),
    (parameters, "roughness_metallic specular specular_tint sheen clearcoat anisotropy clearcoat_bias"),
    (lights, "sun_sky area_gloss many_lights punctual direct_shadows mirror"),
    (meshes, "instances orthographic single_sided smooth_silhouette gltf_features"),
    (surfaces, "textures normal_map_bias texture_settings vertex_colors alpha khr_specular khr_layers"),
)


def files(data):
    """File name -> function without arguments that returns its bytes. `data`: the folder of the stored files."""
    found = {parameters.STUDIO: parameters.studio, lights.SKY: lights.sky,
             "basic_pl.glb": lambda: basic_pl.scene().bytes(), "jpeg.glb": lambda: surfaces.jpeg(data).bytes()}
    for module, names in SCENES:
        for name in names.split():
            found[name + ".glb"] = lambda make=getattr(module, name): make().bytes()
    for path in sorted(data.glob("*.glb")):
        found[path.name] = path.read_bytes
    return found
