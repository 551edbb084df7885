"""Denoise a picture: `python3 -m restirpg.denoise_file IN.exr OUT.exr|OUT.png`.

IN.exr is best rendered with `--output image --output albedo --output normal`; without these two layers edges and
textures are softer. An OUT.exr has the header of IN.exr and `restirpg.denoised` besides. A mistake is one line on
standard error and exit code 2.
"""

import os
import sys


def denoise_file(source, target):
    """Denoise the EXR `source` into `target`, an .exr or .png."""
    import restirpg

    image = restirpg.read_exr(source)
    if os.path.exists(target) and os.path.samefile(source, target):
        raise ValueError(f"{target}: cannot write: it is the file {source}, which was read; choose another name")
    layers = {}
    for name in ("albedo", "normal"):
        try:
            layers[name] = restirpg.read_exr(source, name)
        except restirpg.Error as error:
            print(f"warning: {error}; denoised without it", file=sys.stderr)
    result = restirpg.denoise(image, **layers)
    if str(target).endswith(".png"):
        restirpg.write_png(target, result)
    else:
        attributes = {**restirpg.read_exr_attributes(source), "restirpg.denoised": "true"}
        restirpg.write_exr(target, {"": result}, attributes=attributes)


def main(arguments):
    """The command line. Returns the exit code."""
    if len(arguments) != 2 or arguments[0].startswith("-"):
        print("usage: python3 -m restirpg.denoise_file IN.exr OUT.exr|OUT.png", file=sys.stderr)
        return 2
    import restirpg

    try:
        denoise_file(*arguments)
    except (restirpg.Error, ImportError, ValueError, OSError) as error:
        print(f"restirpg.denoise_file: {error}", file=sys.stderr)
        return 2
    print(f"wrote {arguments[1]}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
