// Sums the weights of a BSDF's draws: its albedo. Radiance that crosses an interface is scaled back to power.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "bsdf_case.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer SumsArray { FurnaceSums at[]; };

void main()
{
    Bsdf b = test_bsdf();
    RandomKey key = random_key(uvec2(gl_GlobalInvocationID.x, 0u), 1u, test.seed);
    FurnaceSums sums = FurnaceSums(vec3(0.0), vec3(0.0));
    for (uint k = 0u; k < DRAWS_A_THREAD; ++k) {
        BsdfSample s = draw(b, key, k);
        vec3 weight = s.pdf > 0.0 ? s.weight : vec3(0.0);
        if (s.wi.z < 0.0 && b.solid)
            weight *= b.eta * b.eta;
        sums.weight += weight;
        sums.square += weight * weight;
    }
    SumsArray(test.results).at[gl_GlobalInvocationID.x] = sums;
}
