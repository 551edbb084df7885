// Draws materials and directions at their limits and looks for values that no picture survives.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "math/random.glsl"
#include "bsdf/labels.glsl"
#include "extremes_case.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Parameters { ExtremesCase test; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FoundRef { ExtremesFound f; };

/// 0, 1, or something between, each a third of the time.
float at_limits(float u)
{
    return u < 0.33 ? 0.0 : u < 0.67 ? 1.0 : 3.0 * (u - 0.67);
}

BsdfParameters extreme_parameters(RandomKey key)
{
    vec4 a = random4(key, 0u, 0u);
    vec4 b = random4(key, 0u, 1u);
    vec4 c = random4(key, 0u, 2u);
    const float IORS[8] = float[8](0.0, 1.0, 1.0005, 1.0015, 1.1, 1.5, 2.4, 10.0);
    const float ROUGHNESSES[8] = float[8](0.0, 0.0299, 0.03, 0.05, 0.2, 0.4, 0.7, 1.0);
    BsdfParameters p;
    p.baseColor = vec3(at_limits(a.x), at_limits(a.y), at_limits(a.z));
    p.metallic = at_limits(a.w);
    p.roughness = ROUGHNESSES[uint(b.x * 8.0)];
    p.specular = at_limits(b.y);
    p.specularColor = vec3(at_limits(b.z), 20.0 * at_limits(b.w), 1.0);
    p.transmission = at_limits(c.x);
    p.ior = IORS[uint(c.y * 8.0)];
    p.coatAverage = 0.06 * c.z;
    p.solid = c.w < 0.5;
    p.entering = fract(4.0 * c.w) < 0.5;
    return p;
}

vec3 extreme_direction(vec4 u)
{
    const float COSINES[8] = float[8](0.0, 1e-12, 1e-7, 1e-4, 0.01, 0.5, 0.9999, 1.0);
    float z = u.z < 0.7 ? COSINES[uint(u.x * 8.0)] : u.x;
    float r = sqrt(1.0 - z * z);
    return vec3(r * cos(2.0 * PI * u.y), r * sin(2.0 * PI * u.y), u.w < 0.5 ? z : -z);
}

bool is_broken(vec3 v)
{
    return any(isnan(v)) || any(isinf(v)) || any(lessThan(v, vec3(0.0)));
}

void main()
{
    RandomKey key = random_key(uvec2(gl_GlobalInvocationID.x & 0xffffu, gl_GlobalInvocationID.x >> 16), 0u, 3u);
    FoundRef found = FoundRef(test.results);
    Bsdf b = make_bsdf(extreme_parameters(key));
    vec3 wo = extreme_direction(random4(key, 0u, 3u));
    wo.z = abs(wo.z);
    vec3 wi = extreme_direction(random4(key, 0u, 4u));
    if (random1(key, 0u, 5u) < 0.2)
        wi = vec3(-wo.xy, wo.z);

    if (is_broken(bsdf_eval(b, wo, wi, LOBE_ALL)))
        atomicAdd(found.f.brokenValues, 1u);
    vec3 probabilities = bsdf_lobe_probabilities(b, wo);
    vec2 pdfs = vec2(bsdf_pdf(b, probabilities, wo, wi, LOBE_ALL), label_pdf(b, probabilities, wo, wi, LABEL_SMOOTH));
    if (is_broken(vec3(pdfs, 0.0)) || is_broken(probabilities))
        atomicAdd(found.f.brokenPdfs, 1u);
    vec4 u = random4(key, 0u, 6u);
    u = mix(u, vec4(16777215.0 / 16777216.0), lessThan(random4(key, 0u, 7u), vec4(0.1)));
    u = mix(u, vec4(0.0), lessThan(random4(key, 0u, 8u), vec4(0.1)));
    BsdfSample s = bsdf_sample(b, probabilities, wo, u.x, u.yz);
    if (is_broken(s.weight) || is_broken(vec3(s.pdf)) || (s.pdf > 0.0 && !(abs(length(s.wi) - 1.0) < 1e-4)))
        atomicAdd(found.f.brokenSamples, 1u);
    // Power, not radiance: what an interface does to radiance is no fault of the sampler.
    float power = luminance(s.weight) * (s.lobe == LOBE_TRANSMIT && b.solid ? b.eta * b.eta : 1.0);
    if (s.pdf > 0.0)
        atomicMax(found.f.largestWeight, floatBitsToUint(power));
}
