// Draws from one material's BSDF, each with its weight and pdf, and sums the weights so that nothing is optimized away.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "bsdf/labels.glsl"
#include "math/random.glsl"
#include "scene/scene.glsl"
#include "Shared.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { BsdfSamplingParameters params; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer SumArray { vec3 at[]; };

void main()
{
    uint thread = gl_GlobalInvocationID.x;
    if (thread >= params.threads)
        return;
    Bsdf b = make_bsdf(BsdfParameters(vec3(0.8, 0.6, 0.4), params.metallic, params.roughness, 1.0, vec3(1.0),
                                      params.transmission, params.ior, params.coatAverage, params.solid != 0u, true));
    RandomKey key = random_key(uvec2(thread & 0xffffu, thread >> 16u), 0u, 1u);
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < params.samples; ++i) {
        vec4 u = random4(key, i, RANDOM_DIRECTION);
        vec4 v = random4(key, i, RANDOM_LIGHT);
        float z = 0.05 + 0.95 * v.x;  // wo anywhere over the hemisphere but at its very edge
        float r = sqrt(1.0 - z * z);
        BsdfSample s = bsdf_sample(b, bsdf_lobe_probabilities(b, vec3(r, 0.0, z)), vec3(r, 0.0, z), u.z, u.xy);
        if (s.pdf > 0.0)
            sum += s.weight;
    }
    SumArray(params.sums).at[thread] = sum;
}
