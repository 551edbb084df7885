// Integrates a lobe's density over each bin of screen_lobe_sample.comp by the midpoint rule.
#version 460
#include "prelude.glsl"
#include "screen_lobe_case.glsl"

const uint SUBDIVISIONS = 64u;

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Results { float at[]; };

/// Density times solid angle per unit of `at`, which is in the unit square of bins.
float integrand(Guide g, vec2 at)
{
    if (test.zoom > 0.0) {
        vec2 p = (2.0 * at - 1.0) * test.zoom;
        float z = sqrt(max(1.0 - dot(p, p), 0.0));
        return z > 0.0 ? guide_pdf(g, to_world(make_frame(g.centre), vec3(p, z))) * 4.0 * test.zoom * test.zoom / z : 0.0;
    }
    float phi = 2.0 * PI * (at.x - 0.5);
    float r = sin(PI * at.y);
    return guide_pdf(g, vec3(r * cos(phi), r * sin(phi), cos(PI * at.y))) * 2.0 * PI * PI * r;
}

void main()
{
    uint bin = gl_GlobalInvocationID.x;
    Guide g;
    if (bin >= BINS || !find_lobe(1u, g))
        return;
    float sum = 0.0;
    for (uint k = 0u; k < SUBDIVISIONS * SUBDIVISIONS; ++k) {
        vec2 inside = (vec2(k % SUBDIVISIONS, k / SUBDIVISIONS) + 0.5) / float(SUBDIVISIONS);
        sum += integrand(g, (vec2(bin % BIN_COLUMNS, bin / BIN_COLUMNS) + inside) / vec2(BIN_COLUMNS, BIN_ROWS));
    }
    Results(test.results).at[bin] = sum / float(BINS * SUBDIVISIONS * SUBDIVISIONS) * (test.error == ERROR_PDF ? 1.02 : 1.0);
}
