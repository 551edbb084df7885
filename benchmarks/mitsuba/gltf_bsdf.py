"""The renderer's glTF material as a BSDF of Mitsuba 3, written from its formulas (head of
framework/shaders/bsdf/bsdf_model.glsl).

Import it after mitsuba.set_variant. Only the value of f is the renderer's: Fresnel, GGX and refraction are Mitsuba's
own functions, masking is written with Smith's Lambda, and directions are drawn from a mixture of this file's own. What
the renderer decides outside its BSDF is here too: which hemisphere counts where shading and geometric normal differ,
and alpha masks (Mitsuba's `volpath` lets a masked ray pass without counting a bounce; `path` counts one).
"""

from types import SimpleNamespace

import drjit as dr
import mitsuba as mi
import numpy as np

DELTA_ROUGHNESS = 0.03
INDEX_MATCHED = 1e-3
SMALLEST_SHARE = 0.1  # of the draws, for every lobe that is there


def fresnel_average(ior):
    """Cosine-weighted mean over the hemisphere of (F - F0) / (1 - F0), from outside."""
    if ior == 0:
        return 1 / 21
    if ior == 1:
        return 0.0
    nodes, weights = np.polynomial.legendre.leggauss(256)
    cosine = (nodes + 1) / 2
    refracted = np.sqrt(1 - (1 - cosine**2) / ior**2)
    s = (cosine - ior * refracted) / (cosine + ior * refracted)
    p = (ior * cosine - refracted) / (ior * cosine + refracted)
    normal = ((ior - 1) / (ior + 1)) ** 2
    return float(np.sum(weights * cosine * ((s**2 + p**2) / 2 - normal) / (1 - normal)))


def smith_lambda(w, alpha):
    """Lambda(w) of GGX, Heitz 2014 eq. 72."""
    tangent2 = (dr.square(w.x) + dr.square(w.y)) / dr.square(w.z)
    return (dr.sqrt(1 + dr.square(alpha) * tangent2) - 1) / 2


def facet_cosine(cosine, alpha):
    """Where a smooth coat reflects what the rough one does: the model's fit, coat_cosine."""
    at_grazing = 0.511 * alpha / (0.228 + alpha)
    at_normal = 1 - 0.293 * alpha / (0.816 + alpha)
    bend = 1.222 * dr.square(alpha)
    square = dr.square(at_grazing) * (1 - dr.square(cosine)) + bend * (cosine - dr.square(cosine))
    return dr.sqrt(square + dr.square(at_normal * cosine))


class GltfBsdf(mi.BSDF):
    """One glTF material. Values are numbers, colours (three numbers) or textures of Mitsuba, already multiplied by
    their factors."""

    def __init__(
        self,
        base=(1, 1, 1),
        metallic=1.0,
        roughness=1.0,
        specular=1.0,
        specular_color=(1, 1, 1),
        transmission=0.0,
        ior=1.5,
        solid=False,
        alpha=1.0,
        alpha_cutoff=None,
        normal=None,
        normal_scale=1.0,
        literal=False,
    ):
        """literal: the diffuse lobe of glTF's sample implementation, base / pi (1 - F(v.h)), which the renderer
        deviates from."""
        super().__init__(mi.Properties())
        self.literal = literal
        self.values = {
            "base": base,
            "metallic": metallic,
            "roughness": roughness,
            "specular": specular,
            "specular_color": specular_color,
            "transmission": transmission,
            "alpha": alpha,
        }
        self.ior = 1.0 if abs(ior - 1) < INDEX_MATCHED else ior
        self.solid, self.alpha_cutoff, self.normal, self.normal_scale = solid, alpha_cutoff, normal, normal_scale
        self.f0 = ((self.ior - 1) / (self.ior + 1)) ** 2
        self.average = fresnel_average(self.ior)
        self.set_components()

    def set_components(self):
        """Tell Mitsuba what kinds of lobes there can be."""
        sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        kinds = [mi.BSDFFlags.DiffuseReflection]
        rough = self.values["roughness"]
        if not isinstance(rough, float) or rough >= DELTA_ROUGHNESS:
            kinds += [mi.BSDFFlags.GlossyReflection, mi.BSDFFlags.GlossyTransmission]
        if not isinstance(rough, float) or rough < DELTA_ROUGHNESS:
            kinds.append(mi.BSDFFlags.DeltaReflection)
        if self.values["transmission"] != 0.0:
            kinds.append(mi.BSDFFlags.DeltaTransmission)
        if self.alpha_cutoff is not None:
            kinds.append(mi.BSDFFlags.Null)
        self.m_components = [kind | sides for kind in kinds]
        self.m_flags = self.m_components[0]
        for flags in self.m_components[1:]:
            self.m_flags |= flags

    def value(self, name, si, active, kind):
        """One of `values` at a point, as a float or a colour."""
        value = self.values[name]
        if isinstance(value, mi.Texture):
            return mi.Color3f(value.eval(si, active)) if kind is mi.Color3f else value.eval_1(si, active)
        return kind(value)

    # ---- The material and the frame at a point ----

    def place(self, si, active):
        """Everything that depends on the point and on the viewing direction v, which is si.wi in a frame of this BSDF's
        own."""
        view = si.to_world(si.wi)
        n = dr.select(dr.dot(si.sh_frame.n, si.n) > 0, mi.Normal3f(si.sh_frame.n), mi.Normal3f(si.n))
        n = self.mapped_normal(n, si, active)
        front = dr.dot(si.n, view) >= 0
        geometric = dr.select(front, si.n, -si.n)
        n = dr.select(front, n, -n)
        frame = mi.Frame3f(dr.select(dr.dot(n, view) > 1e-4, n, geometric))
        p = SimpleNamespace(frame=frame, v=frame.to_local(view), geometric=geometric)
        self.fill(p, front, si, active)
        return p

    def mapped_normal(self, n, si, active):
        """The normal map's, in the tangent frame of the texture coordinates (files' own tangents are not known
        here)."""
        if self.normal is None:
            return n
        tangent = si.dp_du - n * dr.dot(n, si.dp_du)
        tangent = dr.normalize(tangent)
        bitangent = dr.normalize(dr.cross(n, tangent)) * dr.sign(dr.dot(dr.cross(n, tangent), si.dp_dv))
        m = mi.Vector3f(self.normal.eval_3(si, active)) * 2 - 1
        mapped = dr.normalize(self.normal_scale * (m.x * tangent + m.y * bitangent) + m.z * n)
        return dr.select(dr.all(dr.isfinite(mapped)), mi.Normal3f(mapped), n)

    def fill(self, p, front, si, active):
        """Evaluate the material into `p`."""
        color, number = mi.Color3f, mi.Float
        base = self.value("base", si, active, color)
        p.metallic = self.value("metallic", si, active, number)
        roughness = self.value("roughness", si, active, number)
        specular = self.value("specular", si, active, number)
        transmission = self.value("transmission", si, active, number)
        p.delta = roughness < DELTA_ROUGHNESS
        p.alpha = dr.select(p.delta, 0, dr.square(roughness))
        p.ggx = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, dr.maximum(p.alpha, 1e-4), True)
        p.base = base
        p.solid = mi.Bool(self.solid and self.ior > 0)
        inside = p.solid & ~front
        p.eta = dr.select(inside, 1 / max(self.ior, 1e-6), self.ior)
        p.coat0 = specular * dr.minimum(self.f0 * self.value("specular_color", si, active, color), 1)
        p.coat90 = specular if self.ior != 1 else mi.Float(0)
        p.pane = dr.select(p.solid, 0, transmission)
        position = self.average / (1 + 2.6 * p.alpha + 12.4 * dr.square(p.alpha))
        average = dr.lerp(dr.max(p.coat0), p.coat90, position)
        dielectric = base * (1 - p.metallic)
        p.diffuse = dr.select(inside, color(0), dielectric * (1 - transmission))
        if not self.literal:
            p.diffuse /= dr.maximum(1 - average, 1e-4)
        p.transmittance = dielectric * transmission
        p.straight = p.solid & (p.eta == 1)
        p.masked = (
            self.value("alpha", si, active, number) < self.alpha_cutoff
            if self.alpha_cutoff is not None
            else mi.Bool(False)
        )

    # ---- Fresnel terms ----

    def coat(self, p, cosine):
        """Reflectance of one interface of the dielectric."""
        if self.ior == 0:
            position = (1 - cosine) ** 5
        else:
            position = (mi.fresnel(cosine, p.eta)[0] - self.f0) / max(1 - self.f0, 1e-6)
        return dr.clip(dr.lerp(p.coat0, mi.Color3f(p.coat90), position), 0, 1)

    def coat_share(self, p, cosine):
        """What the interface takes of the light towards what lies below it (KHR_materials_specular)."""
        return dr.max(self.coat(p, cosine))

    def reflectance(self, p, cosine):
        """F of the reflecting lobe."""
        coat = self.coat(p, cosine)
        dielectric = dr.lerp(coat, 2 * coat / (1 + coat), p.pane)
        schlick = p.base + (1 - p.base) * dr.clip(1 - cosine, 0, 1) ** 5
        return dr.lerp(dielectric, schlick, p.metallic)

    def transmittance(self, p, cosine):
        """What the transmitting lobe has instead of F."""
        coat = self.coat_share(p, cosine)
        sheet = p.transmittance * (1 - 2 * coat / (1 + coat))
        if self.ior == 0 or not self.solid:
            return sheet
        total = mi.fresnel(cosine, p.eta)[0] >= 1
        return dr.select(p.solid, dr.select(total, 0, p.transmittance * (1 - coat)), sheet)

    # ---- Value and density in the local frame, without delta lobes ----

    def shares(self, p):
        """How often each of the lobes (diffuse, reflect, transmit) is drawn."""
        facet = facet_cosine(p.v.z, p.alpha)
        weights = [
            mi.luminance(p.diffuse * (1 - self.coat_share(p, facet))),
            mi.luminance(self.reflectance(p, facet)),
            mi.luminance(self.transmittance(p, facet)),
        ]
        there = [dr.any(p.diffuse > 0), (p.metallic > 0) | (p.coat90 > 0), dr.any(p.transmittance > 0)]
        total = dr.maximum(weights[0] + weights[1] + weights[2], 1e-6)
        weights = [
            dr.select(flag, dr.maximum(weight, SMALLEST_SHARE * total), 0) for weight, flag in zip(weights, there)
        ]
        total = dr.maximum(weights[0] + weights[1] + weights[2], 1e-20)
        return [weight / total for weight in weights]

    def local_value_and_pdf(self, p, light):
        """f |cos| of all lobes that are not deltas, and the density with which `sample` draws them."""
        v = p.v
        mirrored = mi.Vector3f(
            light.x, light.y, dr.abs(light.z)
        )  # a sheet's transmission is a reflection seen from behind
        above, usable = light.z > 0, (v.z > 0) & (light.z != 0)
        masking = 1 / (1 + smith_lambda(v, p.alpha) + smith_lambda(mirrored, p.alpha))
        diffuse, reflect, transmit = self.shares(p)
        h = dr.normalize(v + mirrored)
        o = dr.dot(v, h)
        shape = p.ggx.eval(h) * masking / (4 * v.z)  # times |cos| of the light
        half_pdf = p.ggx.pdf(v, h) / (4 * o)
        passed = 1 - self.coat_share(p, facet_cosine(v.z, p.alpha))
        passed *= 1 - self.coat_share(p, facet_cosine(mirrored.z, p.alpha))
        value = p.diffuse * dr.inv_pi * mirrored.z * (1 - self.coat_share(p, o) if self.literal else passed)
        value += dr.select(p.delta, 0, self.reflectance(p, o) * shape)
        pdf = diffuse * mirrored.z * dr.inv_pi + dr.select(p.delta, 0, reflect * half_pdf)
        sheet = self.transmittance(p, o) * shape
        solid, solid_pdf = self.refraction(p, light, masking)
        across = dr.select(p.delta | p.straight, 0, dr.select(p.solid, solid, sheet))
        across_pdf = transmit * dr.select(p.delta | p.straight, 0, dr.select(p.solid, solid_pdf, half_pdf))
        value, pdf = dr.select(above, value, across), dr.select(above, pdf, across_pdf)
        return dr.select(usable, value, 0), dr.select(usable, pdf, 0)

    def refraction(self, p, light, masking):
        """Walter et al. 2007, eqs. 16, 17 and 21, for radiance; f |cos|."""
        h = dr.normalize(p.v + p.eta * light)
        h = dr.mulsign(h, h.z)
        o, i = dr.dot(p.v, h), dr.dot(light, h)
        jacobian = dr.square(p.eta) * dr.abs(i) / dr.square(o + p.eta * i)
        value = self.transmittance(p, o) * (p.ggx.eval(h) * masking * o / p.v.z * jacobian / dr.square(p.eta))
        possible = (o > 0) & (i < 0)
        return dr.select(possible, value, 0), dr.select(possible, p.ggx.pdf(p.v, h) * jacobian, 0)

    def consistent(self, p, light, world):
        """Is the direction on the same side of the shading and of the geometric normal?"""
        return (light.z > 0) == (dr.dot(p.geometric, world) > 0)

    # ---- Mitsuba's interface ----

    def eval_pdf(self, ctx, si, wo, active=True):
        """f |cos| and density of a direction."""
        p = self.place(si, active)
        world = si.to_world(wo)
        light = p.frame.to_local(world)
        value, pdf = self.local_value_and_pdf(p, light)
        kept = active & ~p.masked & self.consistent(p, light, world)
        return dr.select(kept, value, 0), dr.select(active & ~p.masked, pdf, 0)

    def eval(self, ctx, si, wo, active=True):
        """f |cos|."""
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        """Density."""
        return self.eval_pdf(ctx, si, wo, active)[1]

    def eval_null_transmission(self, si, active=True):
        """1 where the mask cuts the surface away."""
        if self.alpha_cutoff is None:
            return mi.Color3f(0)
        return dr.select(
            active & (self.value("alpha", si, active, mi.Float) < self.alpha_cutoff), mi.Color3f(1), mi.Color3f(0)
        )

    def draw(self, p, which, u):
        """A direction of the lobe that `which` in [0, 1) chooses, in the local frame; and that lobe's flags and delta
        weight."""
        diffuse, reflect, transmit = self.shares(p)
        is_diffuse = which < diffuse
        is_reflect = ~is_diffuse & (which < diffuse + reflect)
        h = dr.select(p.delta, mi.Normal3f(0, 0, 1), p.ggx.sample(p.v, u)[0])
        o = dr.dot(p.v, h)
        mirror = mi.reflect(p.v, h)
        reflected, cosine, _, eta_ti = mi.fresnel(o, p.eta)
        refracted = dr.select(p.straight, -p.v, mi.refract(p.v, h, cosine, eta_ti))
        through = dr.select(p.solid, refracted, mi.Vector3f(mirror.x, mirror.y, -mirror.z))
        light = dr.select(is_diffuse, mi.warp.square_to_cosine_hemisphere(u), dr.select(is_reflect, mirror, through))
        delta = ~is_diffuse & (p.delta | (~is_reflect & p.straight))
        scale = dr.select(p.solid, dr.square(eta_ti), 1)
        weight = dr.select(is_reflect, self.reflectance(p, p.v.z), self.transmittance(p, p.v.z) * scale)
        share = dr.select(is_diffuse, diffuse, dr.select(is_reflect, reflect, transmit))
        crosses = ~(is_diffuse | is_reflect)
        right = ((light.z < 0) == crosses) & ~(crosses & p.solid & (reflected >= 1))
        return SimpleNamespace(light=light, delta=delta, weight=weight, share=share, right=right, crosses=crosses)

    def sample(self, ctx, si, sample1, sample2, active=True):
        """A direction of the whole material; its value over its density."""
        p = self.place(si, active)
        s = self.draw(p, sample1, sample2)
        world = p.frame.to_world(s.light)
        value, pdf = self.local_value_and_pdf(p, s.light)
        bs = mi.BSDFSample3f()
        bs.wo = si.to_local(world)
        bs.pdf = dr.select(s.delta, s.share, pdf)
        bs.eta = dr.select(s.crosses & p.solid, p.eta, 1)
        flags = dr.select(s.delta, mi.UInt32(+mi.BSDFFlags.DeltaReflection), mi.UInt32(+mi.BSDFFlags.GlossyReflection))
        bs.sampled_type = dr.select(
            s.crosses, dr.select(s.delta, +mi.BSDFFlags.DeltaTransmission, +mi.BSDFFlags.GlossyTransmission), flags
        )
        bs.sampled_component = 0
        weight = dr.select(s.delta, s.weight / s.share, value / pdf)
        good = active & s.right & (bs.pdf > 0) & (p.v.z > 0)
        bs.pdf = dr.select(good, bs.pdf, 0)
        weight = dr.select(good & self.consistent(p, s.light, world), weight, 0)
        bs.wo = dr.select(p.masked, -si.wi, bs.wo)
        bs.pdf = dr.select(p.masked, 1, bs.pdf)
        bs.eta = dr.select(p.masked, 1, bs.eta)
        bs.sampled_type = dr.select(p.masked, +mi.BSDFFlags.Null, bs.sampled_type)
        return bs, dr.select(p.masked & active, mi.Color3f(1), weight)

    def traverse(self, callback):
        """Nothing to differentiate."""

    def to_string(self):
        """A name for Mitsuba's log."""
        return "GltfBsdf[]"
