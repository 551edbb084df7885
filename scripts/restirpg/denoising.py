"""Denoising by Open Image Denoise, through its Python package pyoidn, which is optional."""

import importlib.util


def have_denoiser():
    """Whether pyoidn is installed."""
    return importlib.util.find_spec("pyoidn") is not None


def denoise(image, albedo=None, normal=None, quality="high"):
    """The image without its noise: float32 (H, W, 3), by Open Image Denoise.

    image: linear radiance (H, W, 3). albedo, normal: what the pixels see, of the same shape, as a Renderer made with
    outputs=["albedo", "normal"] gives them; they keep edges and textures sharp. quality: "fast", "balanced" or "high".
    NaN, infinite and negative values count as 0. Raises ImportError where pyoidn is not installed, ValueError for
    arrays of other shapes.
    """
    import numpy as np

    try:
        import pyoidn
    except ImportError:
        raise ImportError(
            "denoising needs the Python package pyoidn, which is not installed: pip install pyoidn"
        ) from None
    named = {"image": image, "albedo": albedo, "normal": normal}
    arrays = {name: np.asarray(array, np.float32) for name, array in named.items() if array is not None}
    for name, array in arrays.items():
        if array.ndim != 3 or array.shape[2] != 3 or array.shape != arrays["image"].shape:
            raise ValueError(f"'{name}' has the shape {array.shape}; all have one shape (height, width, 3)")
        arrays[name] = np.nan_to_num(array, nan=0, posinf=0, neginf=0)
    return pyoidn.denoise(
        np.maximum(arrays["image"], 0), arrays.get("albedo"), arrays.get("normal"), hdr=True, quality=quality
    )
