// What the BSDF test kernels have in common.
#include "bsdf/labels.glsl"
#include "math/random.glsl"
#include "scene/scene.glsl"
#include "bsdf_case.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Parameters { BsdfCase test; };

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Counters { uint at[]; };

BsdfParameters test_parameters()
{
    return BsdfParameters(test.baseColor, test.metallic, test.roughness, test.specular, test.specularColor,
                          test.transmission, test.ior, test.coatAverage, test.solid != 0u, test.entering != 0u
#if RESTIRPG_ENERGY_COMPENSATION
                          ,
                          test.energyTable
#endif
    );
}

Bsdf test_bsdf()
{
    return make_bsdf(test_parameters());
}

/// ERROR_BEND: a density of 0.95 at 0 that rises to 1.05 at 1.
vec2 bend(vec2 u)
{
    return test.error == ERROR_BEND ? u + 0.05 * u * (u - 1.0) : u;
}

/// The test's draw: one lobe, or the whole BSDF.
BsdfSample draw(Bsdf b, RandomKey key, uint index)
{
    vec4 u = random4(key, index, RANDOM_DIRECTION);
    u.xy = bend(u.xy);
    if (test.error == ERROR_ALPHA)
        b.alpha *= 1.05;
    if (test.error == ERROR_LOBE)
        u.z *= 0.9;
    if (test.lobe == LOBE_ALL)
        return bsdf_sample(b, bsdf_lobe_probabilities(b, test.wo), test.wo, u.z, u.xy);
    BsdfSample s = bsdf_sample_lobe(b, test.wo, test.lobe, u.xy);
    if (!s.delta && s.pdf > 0.0)
        s.weight = bsdf_eval(b, test.wo, s.wi, test.lobe) * (abs(s.wi.z) / s.pdf);
    return s;
}

/// Mirrors the far side up for a thin sheet's transmission, which is a reflection continued.
vec3 unfold(Bsdf b, vec3 wi)
{
    return test.lobe == LOBE_TRANSMIT && !b.solid ? vec3(wi.xy, -wi.z) : wi;
}
