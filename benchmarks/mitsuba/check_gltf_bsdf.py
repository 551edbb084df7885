"""Tests gltf_bsdf.py by itself: chi-square tests of its sampling, and its furnaces against the renderer's closed forms.

Run by the Python that has Mitsuba, without arguments. Exit code 1 when something is wrong.
"""

import contextlib
import io
import sys
import tempfile

import drjit as dr
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

import mitsuba.chi2  # noqa: E402
from gltf_bsdf import GltfBsdf  # noqa: E402

LEVEL = 0.01
DIRECTIONS = (1.0, 0.8, 0.4, -0.6, -0.2)  # cosines of the viewing direction; below 0: from behind
MATERIALS = {
    "lambert": {"metallic": 0.0, "specular": 0.0, "base": (0.8, 0.2, 0.1)},
    "rough plastic": {"metallic": 0.0, "roughness": 0.6},
    "glossy plastic": {"metallic": 0.0, "roughness": 0.3},
    "half metal": {"metallic": 0.5, "roughness": 0.4, "base": (1.0, 0.78, 0.34)},
    "metal": {"roughness": 0.5},
    "frosted glass": {"metallic": 0.0, "roughness": 0.6, "transmission": 1.0, "solid": True},
    "milky glass": {"metallic": 0.0, "roughness": 0.6, "transmission": 0.5, "solid": True, "specular": 0.7},
    "sheet": {"metallic": 0.0, "roughness": 0.5, "transmission": 1.0},
}
FURNACES = [  # what a white material returns at any cosine when nothing is rough
    ("lambert", {"metallic": 0.0, "specular": 0.0}, (1.0, 0.5, -0.5)),
    ("smooth plastic", {"metallic": 0.0, "roughness": 0.0}, (1.0, 0.5, -0.5)),
    ("smooth glass", {"metallic": 0.0, "roughness": 0.0, "transmission": 1.0, "solid": True}, (1.0, 0.5, -0.9, -0.5)),
    ("smooth sheet", {"metallic": 0.0, "roughness": 0.0, "transmission": 1.0}, (1.0, 0.5, -0.5)),
]


def interaction(cosine, count):
    """`count` points of a plane, seen at this cosine."""
    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.n = mi.Normal3f(0, 0, 1)
    si.sh_frame = mi.Frame3f(si.n)
    si.wi = mi.Vector3f(float(np.sqrt(1 - cosine**2)), 0, cosine)
    return si


def chi_square(bsdf, cosine):
    """Mitsuba's p-value of the hypothesis that `sample` draws with density `pdf`."""
    context = mi.BSDFContext()

    def sample(u):
        drawn, weight = bsdf.sample(context, interaction(cosine, dr.width(u)), u.x, mi.Point2f(u.y, u.z), mi.Bool(True))
        return drawn.wo, dr.select(drawn.pdf > 0, 1.0, 0.0)

    def density(w):
        return bsdf.pdf(context, interaction(cosine, dr.width(w)), w, mi.Bool(True))

    test = mi.chi2.ChiSquareTest(
        domain=mi.chi2.SphericalDomain(),
        sample_func=sample,
        pdf_func=density,
        sample_dim=3,
        sample_count=1 << 20,
        res=101,
        ires=16,
    )
    with (
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.chdir(tempfile.gettempdir()),
    ):  # run() writes a file and a log
        test.run(1.0)
    return test.p_value


def albedo(bsdf, cosine, count=1 << 20):
    """Mean weight of the first channel, with its standard error; radiance that crosses is counted by eta squared, as
    energy."""
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, count)
    drawn, weight = bsdf.sample(
        mi.BSDFContext(), interaction(cosine, count), sampler.next_1d(), sampler.next_2d(), mi.Bool(True)
    )
    energy = np.array(weight.x * dr.square(drawn.eta))
    return energy.mean(), energy.std() / np.sqrt(count)


def reciprocity_error(bsdf):
    """Largest relative difference of f between a pair of directions and the same exchanged, both above."""
    count = 1 << 16
    numbers = np.random.default_rng(3)
    a, b = (
        mi.warp.square_to_uniform_hemisphere(mi.Point2f(numbers.random((2, count)).astype(np.float32)))
        for _ in range(2)
    )
    si, exchanged = interaction(1.0, count), interaction(1.0, count)
    si.wi, exchanged.wi = a, b
    forward = np.array(bsdf.eval(mi.BSDFContext(), si, b, mi.Bool(True)) / b.z)
    back = np.array(bsdf.eval(mi.BSDFContext(), exchanged, a, mi.Bool(True)) / a.z)
    return float(np.max(np.abs(forward - back) / np.maximum(forward + back, 1e-3)))


def main():
    """Run everything; 0 when all is right."""
    failures = 0
    tests = [(name, cosine) for name in MATERIALS for cosine in DIRECTIONS]
    for name, cosine in tests:
        p = chi_square(GltfBsdf(**MATERIALS[name]), cosine)
        if p * len(tests) < LEVEL:
            failures += 1
            print(f"chi-square: {name} seen at cosine {cosine}: p = {p:.2g}, {len(tests)} tests")
    wrong = chi_square(Uneven(**MATERIALS["metal"]), 0.8)
    if wrong * len(tests) >= LEVEL:
        failures += 1
        print(f"chi-square: an alpha 5% too large is not found, p = {wrong:.2g}")
    for name, material, cosines in FURNACES:
        for cosine in cosines:
            mean, error = albedo(GltfBsdf(**material), cosine)
            if abs(mean - 1) > 4 * error + 1e-4:
                failures += 1
                print(f"furnace: {name} at cosine {cosine} returns {mean:.5f} +- {error:.5f}")
    mean, error = albedo(GltfBsdf(), 1.0)
    if abs(mean - (1 - np.log(2))) > 4 * error:
        failures += 1
        print(f"furnace: the roughest metal returns {mean:.5f} +- {error:.5f} and not 1 - ln 2")
    for name, material in MATERIALS.items():
        difference = reciprocity_error(GltfBsdf(**material))
        if difference > 1e-3:
            failures += 1
            print(f"reciprocity: {name} differs by {difference:.2g}")
    print(f"{len(tests)} chi-square tests, {failures} failures")
    return min(failures, 1)


class Uneven(GltfBsdf):
    """A mistake: the density is that of a material whose alpha is 5% larger than the one drawn from."""

    def pdf(self, ctx, si, wo, active=True):
        return GltfBsdf(**{**MATERIALS["metal"], "roughness": MATERIALS["metal"]["roughness"] * 1.05**0.5}).pdf(
            ctx, si, wo, active
        )


if __name__ == "__main__":
    sys.exit(main())
