"""Every file of regression/scenes and the function that makes its bytes."""

import basic_pl
import closed
import parameters


def files(data):
    """File name -> function without arguments that returns its bytes. `data`: folder of the stored files."""
    made = {"studio.exr": parameters.studio}
    scenes = [basic_pl.scene]
    table = {"basic_pl.glb": basic_pl.scene}
    for module, names in ((closed, "cornell furnace_box furnace_environment furnace_mirror furnace_point spot_flux"),
                          (parameters, "roughness_metallic specular specular_tint sheen clearcoat anisotropy "
                                       "clearcoat_bias")):
        for name in names.split():
            table[name + ".glb"] = getattr(module, name)
    for name, scene in table.items():
        made[name] = lambda scene=scene: scene().bytes()
    return made
