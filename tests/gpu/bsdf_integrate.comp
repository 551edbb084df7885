// Integrates a BSDF's pdf (x) and the luminance of f |cos| (y) over each bin of bsdf_sample.comp, by the midpoint rule.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "bsdf_case.glsl"

const uint SUBDIVISIONS = 32u;

/// wi at a point d of the binned domain, and |d(wi) / d(d)|; 0 where no direction belongs to it.
float direction_at(Bsdf b, vec3 d, out vec3 wi)
{
    wi = d;
    if (test.domain == DOMAIN_SPHERE)
        return 1.0;
    float alpha = test.roughness * test.roughness;
    vec3 stretched = vec3(alpha * d.xy, d.z);
    float len = length(stretched);
    vec3 h = stretched / len;
    float jacobian = alpha * alpha / (len * len * len);
    float o = dot(test.wo, h);
    if (o <= 0.0)
        return 0.0;
    if (test.domain == DOMAIN_REFLECTION) {
        wi = unfold(b, 2.0 * o * h - test.wo);
        return 4.0 * o * jacobian;
    }
    if (!refract_direction(test.wo, h, b.eta, wi))
        return 0.0;
    float i = dot(wi, h);
    float denominator = o + b.eta * i;
    return jacobian * denominator * denominator / (b.eta * b.eta * -i);
}

void main()
{
    uint bin = gl_GlobalInvocationID.x;
    if (bin >= BINS)
        return;
    Bsdf b = test_bsdf();
    vec3 probabilities = bsdf_lobe_probabilities(b, test.wo);
    vec2 sum = vec2(0.0);
    for (uint k = 0u; k < SUBDIVISIONS * SUBDIVISIONS; ++k) {
        vec2 inside = (vec2(k % SUBDIVISIONS, k / SUBDIVISIONS) + 0.5) / float(SUBDIVISIONS);
        vec2 at = (vec2(bin % BIN_COLUMNS, bin / BIN_COLUMNS) + inside) / vec2(BIN_COLUMNS, BIN_ROWS);
        float phi = 2.0 * PI * (at.x - 0.5);
        bool sphere = test.domain == DOMAIN_SPHERE;
        float z = sphere ? cos(PI * at.y) : at.y;
        float r = sphere ? sin(PI * at.y) : sqrt(max(1.0 - z * z, 0.0));
        vec3 wi;
        float jacobian = direction_at(b, vec3(r * cos(phi), r * sin(phi), z), wi);
        if (jacobian <= 0.0)
            continue;
        bool whole = test.lobe == LOBE_ALL;
        float pdf = whole ? bsdf_pdf(b, probabilities, test.wo, wi, LOBE_ALL) : bsdf_lobe_pdf(b, test.wo, wi, test.lobe);
        jacobian *= sphere ? 2.0 * PI * PI * r : 2.0 * PI;
        sum += jacobian * vec2(pdf, luminance(bsdf_eval(b, test.wo, wi, test.lobe)) * abs(wi.z));
    }
    sum /= float(BINS * SUBDIVISIONS * SUBDIVISIONS);
    if (test.error == ERROR_PDF)
        sum.x *= 1.02;
    Vec2Image(test.results).at[bin] = sum;
}
