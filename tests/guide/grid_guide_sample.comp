// Counts draws in bins of equal solid angle; the last counter holds those outside of the cap, or without a direction.
#version 460
#include "grid_guide_draw.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Counters { uint at[]; };

uint bin_of(vec3 w)
{
    vec3 d = w * bin_frame();
    float t = d.z > 0.0 ? dot(d.xy, d.xy) / (1.0 + d.z) : 1.0 - d.z;
    vec2 at = vec2(0.5 + 0.5 * INV_PI * atan(d.y, d.x), t / params.height);
    if (w == vec3(0.0) || at.y > 1.0 + 1e-6)
        return BINS;
    uvec2 bin = min(uvec2(at * vec2(BIN_COLUMNS, BIN_ROWS)), uvec2(BIN_COLUMNS, BIN_ROWS) - 1u);
    return bin.y * BIN_COLUMNS + bin.x;
}

vec3 draw(Vertex v, RandomKey key, uint k)
{
    vec4 u = random4(key, k, RANDOM_DIRECTION);
    if (params.technique == TECHNIQUE_VMF)
        return sample_vmf(params.mu, params.kappa, u.xy);
    if (params.technique == TECHNIQUE_GUIDE)
        return guide_sample(v.guide, u.xyz);
    BsdfSample s = scatter(v, key, k);
    return s.pdf > 0.0 ? s.wi : vec3(0.0);
}

void main()
{
    Vertex v = test_vertex();
    RandomKey key = random_key(uvec2(gl_GlobalInvocationID.x, 0u), 0u, params.seed);
    for (uint k = 0u; k < DRAWS_A_THREAD; ++k)
        atomicAdd(Counters(params.results).at[bin_of(draw(v, key, k))], 1u);
}
