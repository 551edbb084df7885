// The pixel's own candidates: points sampled on lights and points that scattering finds, resampled to one by the light
// they would send without occlusion; then one shadow ray.  [Bitterli et al. 2020, algorithm 3; the mixture's density:
// Veach's balance heuristic over light and BSDF samples]
#version 460
#include "prelude.glsl"
#include "push.glsl"
#include "merge.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

/// A candidate of the light that scattering through the rough lobes finds; false when it finds none.
bool scatter_to_light(ShadingPoint p, vec4 u, out LightPoint point)
{
    uint lobe = bsdf_select_lobe(p.lobe_probabilities, bsdf_rough_lobes(p.bsdf, LOBE_ALL), u.z);
    BsdfSample s = bsdf_sample_lobe(p.bsdf, p.wo, lobe, u.xy);
    vec3 wi = to_world(p.local_frame, s.wi);
    if (s.pdf <= 0.0 || !is_consistent(p, s.wi, wi))
        return false;
    Hit hit;
    float t;
    if (trace_closest(leave_surface(ray_end(p), wi), wi, RAY_INFINITY, hit, t)) {
        point = point_on_triangle(hit.instance, hit.triangle, hit.barycentrics);
        return true;
    }
    point = point_in_environment(wi);
    return SCENE.environmentLight != INVALID_INDEX;
}

/// Density of scatter_to_light over directions, 1/sr. `rough`: probability of the rough lobes under bsdf_pdf.
float scatter_pdf(ShadingPoint p, LightEdge e, float rough)
{
    if (e.delta)
        return 0.0;
    return bsdf_pdf(p.bsdf, p.lobe_probabilities, p.wo, to_local(p.local_frame, e.wi), LOBE_ALL) / rough;
}

LightReservoir resample_candidates(ShadingPoint p, RandomKey key)
{
    LightReservoir r;
    r.point = LightPoint(INVALID_INDEX, INVALID_INDEX, vec2(0.0));
    r.ucw = 0.0;
    r.confidence = 1.0;
    r.target = 0.0;
    uint lobes = bsdf_rough_lobes(p.bsdf, LOBE_ALL);
    if (lobes == 0u)
        return r;
    float rough = sum_over_lobes(p.lobe_probabilities, lobes);

    float sum = 0.0;
    for (uint i = 0u; i < params.candidates + params.bsdfCandidates; ++i) {
        LightPoint y;
        bool found = i < params.candidates ? sample_light_point(random4(key, i, RANDOM_LIGHT), y)
                                           : scatter_to_light(p, random4(key, i, RANDOM_DIRECTION), y);
        if (!found)
            continue;
        LightEdge e = edge_to_light(y, p.position, false);
        float target = luminance(direct_contribution(p, e));
        if (target <= 0.0)
            continue;
        // The balance heuristic over both techniques, each as often as it is drawn: a technique that fails counts all
        // the same.
        float pdf = float(params.candidates) * e.light_pdf +
                    float(params.bsdfCandidates) * scatter_pdf(p, e, rough) * e.jacobian;
        float weight = target / pdf;
        if (resample(sum, weight, random1(key, i, RANDOM_RESAMPLING))) {
            r.point = y;
            r.target = target;
        }
    }
    r.ucw = sum > 0.0 ? sum / r.target : 0.0;
    return r;
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    Hit hit = primary_hit(params.surface, pixel);
    LightReservoir r = LightReservoir(LightPoint(0u, 0u, vec2(0.0)), 0.0, 0.0, 0.0);
    if (hit.instance != INVALID_INDEX) {
        Domain domain = load_domain(hit, false);
        r = resample_candidates(domain.point, direct_key(at));
        // An occluded winner is an estimate of 0 from a whole candidate set: its confidence stays.
        if (r.ucw > 0.0 && !is_free(shadow_ray_to_light(domain.today, r.point)))
            r.ucw = 0.0;
    }
    LightReservoirArray(params.reservoirs).at[pixel] = r;
}
