"""Albedo of Mitsuba's `principled` in a furnace: a sphere under constant radiance 1, one bounce.

Run by the Python that has Mitsuba. Prints the albedo a row of roughness and base colour: over the whole sphere, seen
along the normal (cosine above 0.98) and at grazing angles (cosine below 0.3). More than the base colour leaves light
over; more than 1 makes light.
"""

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
SIZE = 64
SAMPLES = 256


def albedos(base, roughness):
    """Means over the sphere, where it is seen along the normal, and where it is seen at grazing angles."""
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 3},
            "environment": {"type": "constant", "radiance": 1.0},
            "sensor": {
                "type": "orthographic",
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]),
                "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}},
            },
            "sphere": {
                "type": "sphere",
                "bsdf": {
                    "type": "principled",
                    "base_color": {"type": "rgb", "value": base},
                    "roughness": roughness,
                    "metallic": 0.0,
                    "eta": 1.5,
                },
            },
        }
    )
    image = np.array(mi.render(scene, spp=SAMPLES))[..., 0]
    centers = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
    radius = np.hypot(*np.meshgrid(centers, centers))
    cosine = np.sqrt(np.maximum(1 - radius**2, 0))
    inside = radius < 0.98
    return image[inside].mean(), image[cosine > 0.98].mean(), image[inside & (cosine < 0.3)].mean()


if __name__ == "__main__":
    print("| roughness | base colour | mean | along the normal | grazing |\n| --- | --- | --- | --- | --- |")
    for roughness in (0.2, 0.5, 1.0):
        for base in (0.5, 0.8, 1.0):
            print(
                f"| {roughness} | {base} | " + " | ".join(f"{value:.3f}" for value in albedos(base, roughness)) + " |"
            )
