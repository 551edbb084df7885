// Counts draws of a BSDF in bins; the last counter holds the draws that carry nothing.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "bsdf_case.glsl"

uint bin_of(Bsdf b, vec3 wi)
{
    vec3 d = wi;
    if (test.domain == DOMAIN_REFLECTION)
        d = normalize(test.wo + unfold(b, wi));
    if (test.domain == DOMAIN_REFRACTION)
        d = refraction_half_vector(test.wo, wi, b.eta);
    if (test.domain != DOMAIN_SPHERE)
        d = normalize(vec3(d.xy / (test.roughness * test.roughness), d.z));
    // Rows of equal angle on the sphere, for lobes about the pole are narrow; of equal solid angle on the stretched
    // hemisphere.
    float height = test.domain == DOMAIN_SPHERE ? atan(length(d.xy), d.z) * INV_PI : d.z;
    uint column = min(uint((0.5 + 0.5 * INV_PI * atan(d.y, d.x)) * BIN_COLUMNS), BIN_COLUMNS - 1u);
    return min(uint(max(height, 0.0) * BIN_ROWS), BIN_ROWS - 1u) * BIN_COLUMNS + column;
}

void main()
{
    Bsdf b = test_bsdf();
    RandomKey key = random_key(uvec2(gl_GlobalInvocationID.x, 0u), 0u, test.seed);
    Counters counters = Counters(test.results);
    for (uint k = 0u; k < DRAWS_A_THREAD; ++k) {
        BsdfSample s = draw(b, key, k);
        bool lost = s.pdf <= 0.0 || s.delta;
        atomicAdd(counters.at[lost ? BINS : bin_of(b, s.wi)], 1u);
    }
}
