#version 460
#include "prelude.glsl"
#include "edge.glsl"
#include "scene/primary_hit.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

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
    ShadowRay ray = light.distance < INFINITE_DISTANCE
                        ? shadow_ray(ray_end(p), RayEnd(light.position, light.normal, light.clearance))
                        : shadow_ray(ray_end(p), light.wi);
    if (!is_free(ray))
        return vec3(0.0);
    float weight = light.delta ? 1.0 : balance_heuristic(light.pdf, scatter_pdf(v, wi, light.wi));
    return f * abs(wi.z) * light.radiance * (weight / light.pdf) * transmittance_along(p, light.wi, light.distance, light.absorption);
}

/// The density with which next event estimation from x would have found the emitter that scattering hit.
float light_pdf(Arrival a, vec3 x, vec3 wi)
{
    return a.found ? light_pdf_triangle(a.hit.instance, a.hit.triangle, a.hit.barycentrics, x, a.vertex.point.position)
                   : light_pdf_environment(wi);
}

/// Light scattered at the primary hit towards the camera: one path, NEE at every vertex, emission found by scattering.
vec3 trace_path(Hit hit, uvec2 pixel, RandomKey key)
{
    Vertex v = primary_vertex(hit, pixel);
    vec3 radiance = vec3(0.0);
    vec3 throughput = transmittance_to_camera(v.point, frame.c.camera.position);

    for (uint u = 1u; u <= params.bounces + 1u; ++u) {
        bool direct = u > 1u || params.direct != 0u;
        if (params.nextEventEstimation != 0u && direct)
            radiance += throughput * estimate_direct(v, random4(key, u, RANDOM_LIGHT));

        BsdfSample s = scatter(v, key, u);
        vec3 wi = to_world(v.point.local_frame, s.wi);
        if (s.pdf <= 0.0 || s.weight == vec3(0.0) || !is_consistent(v.point, s.wi, wi))
            break;
        throughput *= s.weight;

        Arrival a = follow(v, wi, pixel, u);
        throughput *= a.absorption;
        if ((direct || s.delta) && a.emission != vec3(0.0)) {
            bool weighted = params.nextEventEstimation != 0u && !s.delta;
            float other = weighted ? light_pdf(a, v.point.position, wi) : 0.0;
            radiance += throughput * a.emission * balance_heuristic(s.pdf, other);
        }
        if (!a.found)
            break;
        v = a.vertex;
    }
    return radiance;
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    Hit hit = primary_hit(params.surface, pixel);
    vec3 radiance = vec3(0.0);
    if (hit.instance != INVALID_INDEX)
        [[dont_unroll]] for (uint i = 0u; i < params.trees; ++i)
            radiance += trace_path(hit, at, tree_key(random_key(picture_pixel(at), frame.c.frame, frame.c.seed), i));
    Vec3Image(params.radiance).at[pixel] = radiance / float(params.trees);
}
