"""Drawing: tone-mapped pictures, the crops in which methods differ most, and rows of both."""

import numpy as np

from restirpg.colour import luminance, srgb
from restirpg.harness import plots  # noqa: F401  (chooses matplotlib's backend and style)

from matplotlib.figure import Figure  # isort: skip
from matplotlib.patches import Rectangle  # isort: skip

CROP = 4  # a crop's side is the picture's height over this
CROP_COLOURS = ("#e8590c", "#1c7ed6")


def displayable(image, exposure):
    """Linear Rec. 709 radiance times `exposure` as sRGB in [0, 1]."""
    return srgb(np.clip(np.nan_to_num(np.asarray(image, float) * exposure), 0, 1))


def exposure_of(reference):
    """What brings the reference's 90th percentile of luminance to a half."""
    return 0.5 / max(float(np.percentile(luminance(reference), 90)), 1e-6)


def crops_of(errors, count=2):
    """Corners (x, y) and side of the square crops in which error maps (methods, H, W) differ most.

    Of a crop's mean errors the standard deviation over methods decides; crops do not overlap.
    """
    errors = np.asarray(errors, float)
    height, width = errors.shape[1:]
    side = max(2, min(height // CROP, width // 2))
    means = np.lib.stride_tricks.sliding_window_view(errors, (side, side), (1, 2)).mean((-2, -1))
    spread = means.std(0)
    corners = []
    for _ in range(count):
        y, x = np.unravel_index(np.argmax(spread), spread.shape)
        corners.append((int(x), int(y)))
        spread[max(0, y - side + 1) : y + side, max(0, x - side + 1) : x + side] = -1
    return corners, side


class Picture:
    """A column of a row: its title, what is shown, and the line under it."""

    def __init__(self, title, image, line):
        self.title, self.image, self.line = title, image, line


def _show(axes, pixels):
    axes.imshow(pixels, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(False)


def _frame(axes, colour):
    for spine in axes.spines.values():
        spine.set(visible=True, color=colour, linewidth=2)


def rows(scenes):
    """One row a scene, as figures 5, 6 and 8 of the paper: whole pictures, two crops under each, errors.

    scenes: [(name, exposure, (corners, side), [Picture])].
    """
    columns = max(len(pictures) for _, _, _, pictures in scenes)
    height, width = scenes[0][3][0].image.shape[:2]
    inches = 15.0 / columns
    tall = inches * (height / width + 0.5) + 0.45
    figure = Figure(figsize=(15.4, tall * len(scenes) + 0.3))
    figure.set_layout_engine("none")
    parts = figure.subfigures(len(scenes), 1, squeeze=False)[:, 0]
    for part, (name, exposure, (corners, side), pictures) in zip(parts, scenes):
        grid = part.add_gridspec(
            2, 2 * columns, height_ratios=(height / width, 0.5), left=0.03, right=0.995, top=0.9, bottom=0.09,
            wspace=0.04, hspace=0.03,
        )  # fmt: skip
        for at, picture in enumerate(pictures):
            pixels = displayable(picture.image, exposure)
            axes = part.add_subplot(grid[0, 2 * at : 2 * at + 2])
            _show(axes, pixels)
            axes.set_title(picture.title, fontsize=10, pad=3)
            if at == 0:
                axes.set_ylabel(name)
            for number, ((x, y), colour) in enumerate(zip(corners, CROP_COLOURS)):
                axes.add_patch(Rectangle((x - 0.5, y - 0.5), side, side, fill=False, edgecolor=colour, linewidth=1.5))
                crop = part.add_subplot(grid[1, 2 * at + number])
                _show(crop, pixels[y : y + side, x : x + side])
                _frame(crop, colour)
            part.text(
                0.03 + 0.965 * (at + 0.5) / columns,
                0.02,
                picture.line,
                ha="center",
                va="bottom",
                fontsize=9.5,
            )
    return figure


def teaser(name, exposure, crops, whole, pictures, measured="MAPE of the whole picture"):
    """One large picture and, beside it, its crops by every method, as figure 1 of the paper. `measured` says what the
    lines under the crops are."""
    corners, side = crops
    height, width = whole.image.shape[:2]
    figure = Figure(figsize=(15.4, 4.6))
    figure.set_layout_engine("none")
    share = 3.7 * width / height / 15.4
    axes = figure.add_axes((0.005, 0.1, share, 0.8))
    _show(axes, displayable(whole.image, exposure))
    axes.set_title(f"{name}: {whole.title}", fontsize=13)
    figure.text(0.005 + share, 0.03, f"{measured}:", ha="right", fontsize=12)
    step = (0.99 - share - 0.01) / len(pictures)
    for at, picture in enumerate(pictures):
        left = share + 0.015 + at * step
        for number, ((x, y), colour) in enumerate(zip(corners, CROP_COLOURS)):
            if at == 0:
                axes.add_patch(Rectangle((x - 0.5, y - 0.5), side, side, fill=False, edgecolor=colour, linewidth=2))
            crop = figure.add_axes((left, 0.51 - 0.41 * number, step - 0.006, 0.39))
            _show(crop, displayable(picture.image, exposure)[y : y + side, x : x + side])
            _frame(crop, colour)
            if number == 0:
                crop.set_title(picture.title, fontsize=10.5)
        figure.text(left + step / 2, 0.03, picture.line, ha="center", fontsize=12)
    return figure
