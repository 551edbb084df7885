"""From a renderer's float images to the bytes that a browser shows."""

import io

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from restirpg.colour import srgb

_STEPS = 4096  # of the transfer function's table over [0, 1]


def _srgb_table():
    return np.rint(255 * srgb(np.arange(_STEPS + 1) / _STEPS)).astype(np.uint8)


_SRGB = _srgb_table()


def _heat_table():
    """Black, violet, red, yellow, white: 256 colours that grow brighter all the way."""
    stops = np.array([[0, 0, 0], [70, 10, 110], [185, 40, 85], [250, 140, 30], [255, 255, 190]])
    return np.stack([np.interp(np.linspace(0, 4, 256), range(5), stops[:, c]) for c in range(3)], -1).astype(np.uint8)


_HEAT = _heat_table()


def radiance(image, exposure):
    """Linear Rec.709 (H, W, 3) or (H, W, 1) as 8-bit sRGB, `exposure` in stops; black where it is not finite."""
    finite = np.isfinite(image)
    if not finite.all():
        image = np.where(finite, image, np.float32(0))
    scaled = image * np.float32(_STEPS * 2.0**exposure)
    np.maximum(scaled, 0, out=scaled)
    np.minimum(scaled, _STEPS, out=scaled)
    encoded = _SRGB.take(scaled.astype(np.intp))
    return encoded if encoded.shape[2] == 3 else np.repeat(encoded[..., :1], 3, axis=2)


def heat(values, limit):
    """Numbers (H, W) from 0 to `limit` in colours from black to white."""
    scaled = np.nan_to_num(values * (255 / limit), nan=255, posinf=255, neginf=0)
    return _HEAT[np.clip(scaled, 0, 255).astype(np.uint8)]


def port(image, name, exposure):
    """A port's values (H, W, C) as colours: directions, vectors and numbers are scaled to what can be seen."""
    if "normal" in name.rpartition(".")[2] and image.shape[2] == 3:
        return np.clip(127.5 + 127.5 * np.nan_to_num(image), 0, 255).astype(np.uint8)
    if image.shape[2] == 3:
        return radiance(image, exposure)
    finite = image[np.isfinite(image)]
    if image.shape[2] == 1:
        low, high = (finite.min(), finite.max()) if finite.size else (0, 1)
        return heat(image[..., 0] - low, max(high - low, 1e-12))
    most = max(np.abs(finite).max() if finite.size else 0, 1e-12)
    shown = np.full((*image.shape[:2], 3), 127, np.uint8)
    shown[..., :2] = np.clip(127.5 + 127.5 * np.nan_to_num(image[..., :2]) / most, 0, 255)
    return shown


def jpeg(pixels, quality=90):
    """8-bit (H, W, 3) as the bytes of a JPEG without chroma subsampling."""
    return _encoded(pixels, "JPEG", quality=quality, subsampling=0)


def png(pixels, texts=None):
    """8-bit (H, W, 3) as the bytes of a PNG that carries texts, {keyword: text}."""
    info = PngInfo()
    for keyword, text in (texts or {}).items():
        info.add_itxt(keyword, text)
    return _encoded(pixels, "PNG", pnginfo=info)


def _encoded(pixels, kind, **options):
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, kind, **options)
    return stream.getvalue()
