#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "guide.glsl"
#include "labels.glsl"
#include "lights.glsl"
#include "trace.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { PathTracerParameters params; };

/// Where a path scatters, and what guides it there.
struct Vertex {
    ShadingPoint point;
    bool guided;
    Guide guide;
};

Vertex make_vertex(Surface surface, vec3 wo, uvec2 pixel, uint bounce)
{
    Vertex v;
    v.point = shade_surface(surface, wo);
    v.guided = false;
#if GUIDED
    bool guidable = params.guide != 0ul && label_lobes(v.point.bsdf, LABEL_SMOOTH) != 0u;
    v.guided = guidable &&
               guide_lookup(params.guide, GuideQuery(surface.position, v.point.normal, wo, surface.material, pixel, bounce), v.guide);
#endif
    return v;
}

/// Density of scatter over all rough lobes, 1/sr: within the smooth label one-sample MIS of BSDF and guide, sharp lobes never guided.
float scatter_pdf(Vertex v, vec3 wi_local, vec3 wi)
{
    float unguided = bsdf_pdf(v.point.bsdf, v.point.wo, wi_local, LOBE_ALL);
    if (!v.guided)
        return unguided;
    float smooth_pdf = bsdf_pdf(v.point.bsdf, v.point.wo, wi_local, label_lobes(v.point.bsdf, LABEL_SMOOTH));
    float guided_pdf = label_probability(v.point.bsdf, v.point.wo, LABEL_SMOOTH) * guide_pdf(v.guide, wi);
    return unguided + (1.0 - params.alpha) * (guided_pdf - smooth_pdf);
}

/// A scattered direction (BsdfSample::wi in the local frame) by the BSDF or, in the smooth label, by the guide.
BsdfSample scatter(Vertex v, RandomKey key, uint bounce)
{
    Bsdf bsdf = v.point.bsdf;
    vec4 numbers = random4(key, bounce, RANDOM_DIRECTION);
    if (!v.guided)
        return bsdf_sample(bsdf, v.point.wo, numbers.z, numbers.xy);
    uint lobe = bsdf_select_lobe(bsdf, v.point.wo, LOBE_ALL, numbers.z);
    BsdfSample s;
    if (label_of_lobe(bsdf, lobe) == LABEL_SMOOTH && random1(key, bounce, RANDOM_TECHNIQUE) >= params.alpha) {
        s = no_bsdf_sample(lobe);
        s.wi = to_local(v.point.local_frame, guide_sample(v.guide, vec3(numbers.xy, random1(key, bounce, RANDOM_GUIDE_LOBE))));
    } else {
        s = bsdf_sample_lobe(bsdf, v.point.wo, lobe, numbers.xy);
        if (s.pdf <= 0.0)
            return s;
        if (s.delta) {
            s.pdf = bsdf_lobe_probability(bsdf, v.point.wo, lobe);
            s.weight /= s.pdf;
            return s;
        }
    }
    s.pdf = scatter_pdf(v, s.wi, to_world(v.point.local_frame, s.wi));
    s.weight = s.pdf > 0.0 ? bsdf_eval(bsdf, v.point.wo, s.wi, LOBE_ALL) * (abs(s.wi.z) / s.pdf) : vec3(0.0);
    return s;
}

/// Beer-Lambert along a segment that leaves p in direction wi (world).
vec3 transmittance_leaving(ShadingPoint p, vec3 wi, float distance)
{
    bool inwards = (dot(p.normal, wi) > 0.0) != p.front;
    return inwards && p.absorption != vec3(0.0) ? exp(-p.absorption * distance) : vec3(1.0);
}

/// Beer-Lambert along a segment between two surfaces: inside the solid that it leaves into, else inside the one it arrives from.
vec3 transmittance_between(ShadingPoint from, vec3 wi, float distance, ShadingPoint to)
{
    bool inwards = (dot(from.normal, wi) > 0.0) != from.front;
    if (inwards && from.absorption != vec3(0.0))
        return exp(-from.absorption * distance);
    return !to.front && to.absorption != vec3(0.0) ? exp(-to.absorption * distance) : vec3(1.0);
}

/// Direct light through the rough lobes, from one light sample weighted against scatter by the balance heuristic.
vec3 estimate_direct(Vertex v, vec4 u)
{
    ShadingPoint p = v.point;
    if (bsdf_rough_lobes(p.bsdf, LOBE_ALL) == 0u)
        return vec3(0.0);
    LightSample light = sample_light(p.position, u);
    if (light.pdf <= 0.0 || light.radiance == vec3(0.0))
        return vec3(0.0);
    vec3 wi = to_local(p.local_frame, light.wi);
    vec3 f = bsdf_eval(p.bsdf, p.wo, wi, LOBE_ALL);
    if (f == vec3(0.0) || !is_consistent(p, wi, light.wi))
        return vec3(0.0);
    vec3 side = wi.z > 0.0 ? p.normal : -p.normal;
    bool lit = light.distance < INFINITE_DISTANCE
                   ? visible(p.position, side, light.position, dot(light.normal, light.wi) < 0.0 ? light.normal : -light.normal)
                   : !trace_any(offset_origin(p.position, side), light.wi, RAY_INFINITY);
    if (!lit)
        return vec3(0.0);
    float weight = light.delta ? 1.0 : balance_heuristic(light.pdf, scatter_pdf(v, wi, light.wi));
    return f * abs(wi.z) * light.radiance * (weight / light.pdf) * transmittance_leaving(p, light.wi, light.distance);
}

/// The density with which next event estimation from x would have found the emitter that scattering hit.
float light_pdf(bool found, Hit hit, vec3 x, vec3 y, vec3 wi)
{
    return found ? light_pdf_triangle(hit.instance, hit.triangle, x, y) : light_pdf_environment(wi);
}

/// Light scattered at the primary hit towards the camera: one path, NEE at every vertex, emission found by scattering.
vec3 trace_path(Hit hit, uvec2 pixel, RandomKey key)
{
    Surface surface = load_surface(hit, false);
    Vertex v = make_vertex(surface, normalize(frame.c.camera.position - surface.position), pixel, 1u);
    vec3 radiance = vec3(0.0);
    vec3 throughput = vec3(1.0);

    for (uint u = 1u; u <= params.bounces + 1u; ++u) {
        bool direct = u > 1u || params.direct != 0u;
        if (params.nextEventEstimation != 0u && direct)
            radiance += throughput * estimate_direct(v, random4(key, u, RANDOM_LIGHT));

        BsdfSample s = scatter(v, key, u);
        vec3 wi = to_world(v.point.local_frame, s.wi);
        if (s.pdf <= 0.0 || s.weight == vec3(0.0) || !is_consistent(v.point, s.wi, wi))
            break;
        throughput *= s.weight;

        float t;
        vec3 x = v.point.position;
        vec3 side = s.wi.z > 0.0 ? v.point.normal : -v.point.normal;
        bool found = trace_closest(offset_origin(x, side), wi, RAY_INFINITY, hit, t);
        vec3 emission;
        if (found) {
            surface = load_surface(hit, false);
            ShadingPoint from = v.point;
            v = make_vertex(surface, -wi, pixel, u + 1u);
            throughput *= transmittance_between(from, wi, t, v.point);
            emission = triangle_emission(hit.instance, hit.triangle, hit.barycentrics, v.point.front);
        } else {
            throughput *= transmittance_leaving(v.point, wi, INFINITE_DISTANCE);
            emission = environment_radiance(wi);
        }
        if ((direct || s.delta) && emission != vec3(0.0)) {
            bool weighted = params.nextEventEstimation != 0u && !s.delta;
            float other = weighted ? light_pdf(found, hit, x, surface.position, wi) : 0.0;
            radiance += throughput * emission * balance_heuristic(s.pdf, other);
        }
        if (!found)
            break;
    }
    return radiance;
}

void main()
{
    frame = FrameRef(params.frame);
    uvec2 at = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(at, frame.c.size)))
        return;
    uint pixel = at.y * frame.c.size.x + at.x;
    Hit hit = HitArray(params.surface).at[pixel];
    vec3 radiance = vec3(0.0);
    if (hit.instance != INVALID_INDEX)
        radiance = trace_path(hit, at, random_key(at, frame.c.frame, frame.c.seed));
    if (params.radiance != 0ul)
        Vec3Image(params.radiance).at[pixel] = radiance;
}
