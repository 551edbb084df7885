// Integrates the density over each bin of grid_guide_sample.comp by the midpoint rule.
#version 460
#include "grid_guide_draw.glsl"

const uint SUBDIVISIONS = 32u;

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Results { float at[]; };

float density(Vertex v, vec3 w)
{
    if (params.technique == TECHNIQUE_VMF)
        return vmf_pdf(w, params.mu, params.kappa);
    return params.technique == TECHNIQUE_GUIDE ? guide_pdf(v.guide, w) : scatter_pdf(v, w, w);
}

void main()
{
    uint bin = gl_GlobalInvocationID.x;
    if (bin >= BINS)
        return;
    Vertex v = test_vertex();
    float sum = 0.0;
    for (uint k = 0u; k < SUBDIVISIONS * SUBDIVISIONS; ++k) {
        vec2 inside = (vec2(k % SUBDIVISIONS, k / SUBDIVISIONS) + 0.5) / float(SUBDIVISIONS);
        vec2 at = (vec2(bin % BIN_COLUMNS, bin / BIN_COLUMNS) + inside) / vec2(BIN_COLUMNS, BIN_ROWS);
        float phi = 2.0 * PI * (at.x - 0.5);
        float t = params.height * at.y;
        float r = sqrt(t * (2.0 - t));
        sum += density(v, bin_frame() * vec3(r * cos(phi), r * sin(phi), 1.0 - t));
    }
    Results(params.results).at[bin] = sum * 2.0 * PI * params.height / float(BINS * SUBDIVISIONS * SUBDIVISIONS);
}
