// The largest relative difference between f(wo, wi) / n_o^2 and f(wi, wo) / n_i^2, over directions that the BSDF draws.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "bsdf_case.glsl"

/// The BSDF as seen by light that goes the other way: from the far side when wi lies there.
vec3 eval_exchanged(BsdfParameters p, vec3 wo, vec3 wi)
{
    if (wi.z < 0.0) {
        p.entering = !p.entering;
        wo.z = -wo.z;
        wi.z = -wi.z;
    }
    if (test.error == ERROR_SWAP)
        p.roughness *= 1.01;
    return bsdf_eval(make_bsdf(p), wi, wo, LOBE_ALL);
}

void main()
{
    RandomKey key = random_key(uvec2(gl_GlobalInvocationID.x, 0u), 2u, test.seed);
    vec4 u = random4(key, 0u, RANDOM_PIXEL);
    float z = max(u.x, 1e-3);
    vec3 wo = vec3(sqrt(1.0 - z * z), 0.0, z);
    BsdfParameters p = test_parameters();
    Bsdf b = make_bsdf(p);
    u = random4(key, 0u, RANDOM_DIRECTION);
    BsdfSample s = bsdf_sample(b, bsdf_lobe_probabilities(b, wo), wo, u.z, u.xy);
    if (s.pdf <= 0.0 || s.delta || abs(s.wi.z) < 1e-3)
        return;
    vec3 forward = bsdf_eval(b, wo, s.wi, LOBE_ALL);
    float squared_index = s.wi.z < 0.0 ? b.eta * b.eta : 1.0;  // (n_i / n_o)^2
    if (!b.solid)
        squared_index = 1.0;
    vec3 backward = eval_exchanged(p, wo, s.wi) / squared_index;
    // Values below 0.01/sr do not matter to a picture, and 1 - F has few digits left next to total internal reflection.
    vec3 difference = abs(forward - backward) / max(max(forward, backward), 1e-2);
    float worst = max(difference.x, max(difference.y, difference.z));
    Counters counters = Counters(test.results);
    atomicMax(counters.at[0], floatBitsToUint(worst));
    atomicAdd(counters.at[1], 1u);
}
