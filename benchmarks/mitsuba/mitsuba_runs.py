"""Render independent runs of one scene with Mitsuba 3. Run by Mitsuba's own Python, as compare_with_mitsuba.py does.

    mitsuba_runs.py CONVERTER RUNS OUT.npy MATERIALS SCENE [converter options ...]

The converter (gltf_to_mitsuba.py) has no way to render one scene twice, so its `mi.render` is replaced: it renders RUNS
seeds instead of one and keeps them all, float32 (RUNS, H, W, 3), in OUT.npy. Loading and compiling happen once.
MATERIALS: "gltf" takes the file's own by gltf_bsdf.py, "literal" the same with the diffuse lobe of glTF's sample
implementation, "converter" what the converter makes of them (`principled`).
"""

import runpy
import sys

import mitsuba
import numpy as np


def main():
    """Take the converter's place on the command line and collect what it renders."""
    converter, runs, out, materials, scene, *options = sys.argv[1:]
    variant = options[options.index("--variant") + 1] if "--variant" in options else "llvm_ad_rgb"
    mitsuba.set_variant(variant)
    render, load_dict, images = mitsuba.render, mitsuba.load_dict, []

    def render_runs(prepared, spp, seed):
        images.extend(np.array(render(prepared, spp=spp, seed=seed + k))[:, :, :3] for k in range(int(runs)))
        return images[0]

    def load_scene(description, *arguments, **keywords):
        if description.get("type") == "scene" and materials != "converter":
            from gltf_materials import put_materials  # needs the variant

            put_materials(description, scene, materials == "literal")
        return load_dict(description, *arguments, **keywords)

    mitsuba.render, mitsuba.load_dict = render_runs, load_scene
    sys.argv = [converter, scene, "-", *options]
    runpy.run_path(converter, run_name="__main__")
    np.save(out, np.array(images, np.float32))


if __name__ == "__main__":
    main()
