// Draws light samples: counts directions and lights, sums radiance / pdf, compares pdfs with those that MIS asks for.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "light_case.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CountsRef { LightCounts c; LightSums sums[]; };

LightSample draw(RandomKey key, uint index)
{
    vec4 u = bend(random4(key, index, RANDOM_LIGHT));
    if (test.technique == SAMPLE_LIGHTS)
        return sample_light(test.x, u);
    vec3 wi = sample_environment(u);
    LightSample s = connect_environment(wi);
    s.pdf = pdf_environment(wi);
    return s;
}

/// The pdf of the same sample as scattering would ask for it.
float pdf_for_mis(LightSample s)
{
    if (test.technique == SAMPLE_ENVIRONMENT)
        return pdf_environment(s.wi);
    Light light = LightArray(SCENE.lights).at[s.light];
    if (light.type == LIGHT_ENVIRONMENT)
        return light_pdf_environment(s.wi);
    return light_pdf_triangle(light.instance, light.triangle, s.barycentrics, test.x, s.position);
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
        atomicMax(results.c.worstPdf, floatBitsToUint(abs(pdf_for_mis(s) / s.pdf - 1.0)));
        float value = luminance(s.radiance) / s.pdf;
        sums.radiance += value;
        sums.square += value * value;
    }
    results.sums[gl_GlobalInvocationID.x] = sums;
}
