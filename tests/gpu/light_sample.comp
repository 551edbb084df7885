// Draws light samples: counts directions and lights, sums radiance / pdf, compares the pdfs of points on triangles with
// those that MIS asks for.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "light_case.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CountsRef { LightCounts c; LightSums sums[]; };

LightSample draw(RandomKey key, uint index)
{
    vec4 u = bend(random4(key, index, RANDOM_LIGHT));
    if (test.technique == SAMPLE_LIGHTS) {
        LightSample s = sample_light(test.x, u);
        s.pdf *= test.error == ERROR_PDF ? 1.02 : 1.0;
        return s;
    }
    vec3 wi = sample_environment(u);
    LightSample s = connect_environment(wi);
    s.pdf = pdf_environment(wi);
    return s;
}

/// Relative difference between the sample's pdf and the one that scattering would ask for. That of the environment is one
/// function for both, which the counts of directions test.
float pdf_error(LightSample s)
{
    if (test.technique == SAMPLE_ENVIRONMENT)
        return 0.0;
    Light light = LightArray(SCENE.lights).at[s.light];
    if (light.type == LIGHT_ENVIRONMENT)
        return 0.0;
    float asked = light_pdf_triangle(light.instance, light.triangle, s.barycentrics, test.x, s.position);
    return abs(asked / s.pdf - 1.0);
}

void main()
{
    frame = FrameRef(test.frame);
    RandomKey key = random_key(uvec2(gl_GlobalInvocationID.x, 0u), 0u, test.seed);
    CountsRef results = CountsRef(test.results);
    LightSums sums = LightSums(0.0, 0.0);
    for (uint k = 0u; k < DRAWS_A_THREAD; ++k) {
        LightSample s = draw(key, k);
        if (s.pdf <= 0.0) {
            atomicAdd(results.c.empty, 1u);
            continue;
        }
        atomicAdd(results.c.lights[s.light], 1u);
        if (s.delta) {
            atomicAdd(results.c.deltas, 1u);
            continue;
        }
        uint column = min(uint((0.5 + 0.5 * INV_PI * atan(s.wi.y, s.wi.x)) * BIN_COLUMNS), BIN_COLUMNS - 1u);
        uint row = min(uint(atan(length(s.wi.xy), s.wi.z) * INV_PI * BIN_ROWS), BIN_ROWS - 1u);
        atomicAdd(results.c.bins[row * BIN_COLUMNS + column], 1u);
        atomicMax(results.c.worstPdf, floatBitsToUint(pdf_error(s)));
        float value = luminance(s.radiance) / s.pdf;
        sums.radiance += value;
        sums.square += value * value;
    }
    results.sums[gl_GlobalInvocationID.x] = sums;
}
