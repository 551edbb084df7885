#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "lights.glsl"
#include "surface.glsl"
#include "trace.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { PathTracerParameters params; };

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

/// Direct light at p through its rough lobes, from one light sample. `weighted`: against scattering, by the balance heuristic.
vec3 estimate_direct(ShadingPoint p, vec4 u)
{
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
    float weight = light.delta ? 1.0 : balance_heuristic(light.pdf, bsdf_pdf(p.bsdf, p.wo, wi, LOBE_ALL));
    return f * abs(wi.z) * light.radiance * (weight / light.pdf) * transmittance_leaving(p, light.wi, light.distance);
}

/// The density with which next event estimation from x would have found the emitter that scattering hit.
float light_pdf(bool found, Hit hit, vec3 x, vec3 y, vec3 wi)
{
    return found ? light_pdf_triangle(hit.instance, hit.triangle, x, y) : light_pdf_environment(wi);
}

/// Light scattered at the primary hit towards the camera: one path, NEE at every vertex, emission found by scattering.
vec3 trace_path(Hit hit, RandomKey key)
{
    Surface surface = load_surface(hit, false);
    ShadingPoint p = shade_surface(surface, normalize(frame.c.camera.position - surface.position));
    vec3 radiance = vec3(0.0);
    vec3 throughput = vec3(1.0);

    for (uint u = 1u; u <= params.bounces + 1u; ++u) {
        bool direct = u > 1u || params.direct != 0u;
        if (params.nextEventEstimation != 0u && direct)
            radiance += throughput * estimate_direct(p, random4(key, u, RANDOM_LIGHT));

        vec4 numbers = random4(key, u, RANDOM_DIRECTION);
        BsdfSample s = bsdf_sample(p.bsdf, p.wo, numbers.z, numbers.xy);
        vec3 wi = to_world(p.local_frame, s.wi);
        if (s.pdf <= 0.0 || s.weight == vec3(0.0) || !is_consistent(p, s.wi, wi))
            break;
        throughput *= s.weight;

        float t;
        vec3 side = s.wi.z > 0.0 ? p.normal : -p.normal;
        bool found = trace_closest(offset_origin(p.position, side), wi, RAY_INFINITY, hit, t);
        ShadingPoint next;
        vec3 emission;
        if (found) {
            surface = load_surface(hit, false);
            next = shade_surface(surface, -wi);
            throughput *= transmittance_between(p, wi, t, next);
            emission = triangle_emission(hit.instance, hit.triangle, hit.barycentrics, next.front);
        } else {
            throughput *= transmittance_leaving(p, wi, INFINITE_DISTANCE);
            emission = environment_radiance(wi);
        }
        if ((direct || s.delta) && emission != vec3(0.0)) {
            bool weighted = params.nextEventEstimation != 0u && !s.delta;
            float other = weighted ? light_pdf(found, hit, p.position, surface.position, wi) : 0.0;
            radiance += throughput * emission * balance_heuristic(s.pdf, other);
        }
        if (!found)
            break;
        p = next;
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
        radiance = trace_path(hit, random_key(at, frame.c.frame, frame.c.seed));
    if (params.radiance != 0ul)
        Vec3Image(params.radiance).at[pixel] = radiance;
}
