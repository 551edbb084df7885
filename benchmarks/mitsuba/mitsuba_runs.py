"""Render independent runs of one scene with Mitsuba 3. Run by Mitsuba's own Python, as compare_with_mitsuba.py does.

    mitsuba_runs.py CONVERTER RUNS OUT.npy SCENE [converter options ...]

The converter (gltf_to_mitsuba.py) has no way to render one scene twice, so its `mi.render` is replaced: it renders RUNS
seeds instead of one and keeps them all, float32 (RUNS, H, W, 3), in OUT.npy. Loading and compiling happen once.
"""

import runpy
import sys

import mitsuba
import numpy as np


def main():
    """Take the converter's place on the command line and collect what it renders."""
    converter, runs, out, scene, *options = sys.argv[1:]
    variant = options[options.index("--variant") + 1] if "--variant" in options else "llvm_ad_rgb"
    mitsuba.set_variant(variant)
    render, images = mitsuba.render, []

    def render_runs(prepared, spp, seed):
        images.extend(np.array(render(prepared, spp=spp, seed=seed + k))[:, :, :3] for k in range(int(runs)))
        return images[0]

    mitsuba.render = render_runs
    sys.argv = [converter, scene, "-", *options]
    runpy.run_path(converter, run_name="__main__")
    np.save(out, np.array(images, np.float32))


if __name__ == "__main__":
    main()
