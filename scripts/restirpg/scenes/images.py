"""Image files without a library: PNG (8-bit) and Radiance .hdr (RGBE), the same bytes on every run."""

import struct
import zlib

import numpy as np


def encode_png(pixels):
    """Bytes of a PNG file. `pixels`: uint8 (H, W, 3) RGB or (H, W, 4) RGBA, rows from the top."""
    height, width, channels = pixels.shape
    color_type = {3: 2, 4: 6}[channels]
    rows = np.zeros((height, 1 + width * channels), np.uint8)  # a leading 0 a row: PNG filter "none"
    rows[:, 1:] = pixels.reshape(height, -1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, color_type, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header)
            + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)) + chunk(b"IEND", b""))


def encode_hdr(radiance):
    """Bytes of a Radiance .hdr file. `radiance`: float (H, W, 3), linear, 8 <= W < 32768, rows from the top.

    Ward, "Real Pixels", Graphics Gems II (1991): a shared exponent of the brightest channel. Scanlines are in
    the run-length layout, but hold literal runs only, since a sky has no runs.
    """
    height, width, _ = radiance.shape
    brightest = radiance.max(axis=2)
    mantissa, exponent = np.frexp(brightest)
    scale = np.where(brightest > 1e-32, mantissa * 256.0 / np.maximum(brightest, 1e-32), 0.0)
    rgbe = np.empty((height, width, 4), np.uint8)
    rgbe[..., :3] = (radiance * scale[..., None]).astype(np.uint8)
    rgbe[..., 3] = np.where(brightest > 1e-32, exponent + 128, 0)

    body = bytearray()
    for row in rgbe:
        body += bytes((2, 2, width >> 8, width & 255))
        for channel in range(4):
            for start in range(0, width, 128):
                literals = row[start:start + 128, channel].tobytes()
                body += bytes((len(literals),)) + literals
    return f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode() + bytes(body)
