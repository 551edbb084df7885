// Points of lights as ReSTIR DI resamples them. Each lives in its light's own measure (see LightPoint): a point that is
// handed to another pixel, or moves with its light, keeps that measure, so no shift has a Jacobian.
#ifndef RESTIRPG_LIGHT_RESERVOIR_GLSL
#define RESTIRPG_LIGHT_RESERVOIR_GLSL

#include "light_reservoir_types.h"
#include "scene/lights.glsl"
#include "trace/trace.glsl"
#include "bsdf/transmittance.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer LightReservoirArray { LightReservoir at[]; };

/// Density of a uniform point over the unit triangle of barycentrics, whose area is 1/2.
const float BARYCENTRIC_PDF = 2.0;

/// A light point as seen from a surface point x.
struct LightEdge {
    vec3 wi;  ///< unit, from x to the light
    float distance;  ///< m; INFINITE_DISTANCE: directional light or environment
    vec3 position;  ///< of the light point; not set where distance is infinite
    vec3 normal;  ///< geometric, on x's side
    float clearance;  ///< as in RayEnd
    vec3 radiance;  ///< W/sr/m^2; of a punctual light: irradiance on a surface facing it, W/m^2
    float jacobian;  ///< d(solid angle at x) / d(the point's own measure); 0: the edge carries nothing
    float light_pdf;  ///< density of sample_light_point in the point's own measure
    bool delta;  ///< punctual: scattering can never find it
    vec3 absorption;  ///< sigma_a on x's side of the light's surface, 1/m
};

LightPoint point_on_triangle(uint instance, uint triangle, vec2 barycentrics)
{
    return LightPoint(instance, triangle, barycentrics);
}

LightPoint point_in_environment(vec3 wi)
{
    return LightPoint(INVALID_INDEX, SCENE.environmentLight, encode_octahedral(wi));
}

/// A light chosen by power and a point of it; false when the scene has no light. u: xy select, zw place.
bool sample_light_point(vec4 u, out LightPoint point)
{
    uint index = select_light(u.xy);
    if (index == INVALID_INDEX)
        return false;
    Light light = LightArray(SCENE.lights).at[index];
    if (light.type == LIGHT_TRIANGLE)
        point = point_on_triangle(light.instance, light.triangle, sample_emission(light, u));
    else if (light.type == LIGHT_ENVIRONMENT)
        point = point_in_environment(sample_environment(hashed_numbers(u)));  // a texel, and a place in it
    else
        point = LightPoint(INVALID_INDEX, index, vec2(0.0));
    return true;
}

LightEdge edge_to_triangle(LightPoint point, vec3 x, bool previous)
{
    Instance placed = load_instance(point.instance);
    MeshTriangle triangle = load_triangle(placed, point.index);
    WorldTriangle t = place_triangle(placed, load_corners(triangle.vertices), load_pose(point.instance, placed, previous));
    LightEdge e;
    e.position = point_on(t, point.place);
    vec3 d = e.position - x;
    float distance2 = dot(d, d);
    e.distance = sqrt(distance2);
    e.wi = d / max(e.distance, 1e-30);
    float facing = dot(t.cross_product, e.wi);
    e.normal = normalize(facing < 0.0 ? t.cross_product : -t.cross_product);
    e.clearance = find_clearance(t, placed, e.position, e.normal);
    Emission emission = emit_from_triangle(triangle, point.place, facing < 0.0);
    e.radiance = emission.radiance;
    e.absorption = emission.absorption;
    // d(omega) = |cos| dA / d^2 and dA = |cross_product| d(barycentrics).
    e.jacobian = distance2 > 0.0 ? abs(facing) / distance2 : 0.0;
    e.light_pdf = triangle_light_density(point.instance, point.index, point.place) * BARYCENTRIC_PDF;
    e.delta = false;
    return e;
}

/// The light point seen from x. With `previous`, triangles stand where they stood in the frame before; x is the
/// caller's.
LightEdge edge_to_light(LightPoint point, vec3 x, bool previous)
{
    if (point.instance != INVALID_INDEX)
        return edge_to_triangle(point, x, previous);
    Light light = LightArray(SCENE.lights).at[point.index];
    LightSample s = light.type == LIGHT_ENVIRONMENT ? connect_environment(decode_octahedral(point.place))
                                                    : connect_punctual_light(point.index, light, x);
    // A texel of the environment that sampling never takes can still be found by scattering; a light at x itself
    // cannot.
    float jacobian = s.delta && s.pdf <= 0.0 ? 0.0 : 1.0;
    return LightEdge(s.wi, s.distance, s.position, s.normal, s.clearance, s.radiance, jacobian, s.pdf, s.delta, s.absorption);
}

/// What is left of the light on its way along the edge to p.
vec3 edge_transmittance(ShadingPoint p, LightEdge e)
{
    return transmittance_along(p, e.wi, e.distance, e.absorption);
}

/// Light that the edge sends to the camera by way of p's rough lobes, per unit of the point's measure; visibility not
/// tested.
vec3 direct_contribution(ShadingPoint p, LightEdge e)
{
    vec3 wi = to_local(p.local_frame, e.wi);
    if (e.radiance == vec3(0.0) || e.jacobian <= 0.0 || !is_consistent(p, wi, e.wi))
        return vec3(0.0);
    vec3 f = bsdf_eval(p.bsdf, p.wo, wi, LOBE_ALL);
    return f * abs(wi.z) * e.radiance * e.jacobian * edge_transmittance(p, e) * p.to_camera;
}

/// From the surface point x to the light point at the end of its edge.
ShadowRay shadow_ray_to_light(RayEnd x, LightEdge e)
{
    if (e.distance >= INFINITE_DISTANCE)
        return shadow_ray(x, e.wi);
    return shadow_ray(x, RayEnd(e.position, e.normal, e.clearance));
}

/// The same from the light point alone, as it stands today.
ShadowRay shadow_ray_to_light(RayEnd x, LightPoint y)
{
    if (y.instance != INVALID_INDEX) {
        Instance placed = load_instance(y.instance);
        WorldTriangle t = place_triangle(placed, y.index, placed.objectToWorld);
        vec3 position = point_on(t, y.place);
        vec3 normal = normalize(t.cross_product);
        return shadow_ray(x, RayEnd(position, normal, find_clearance(t, placed, position, normal)));
    }
    Light light = LightArray(SCENE.lights).at[y.index];
    if (light.type == LIGHT_ENVIRONMENT)
        return shadow_ray(x, decode_octahedral(y.place));
    if (light.type == LIGHT_DIRECTIONAL)
        return shadow_ray(x, -light.direction);
    vec3 d = light.position - x.position;
    return shadow_ray(x, RayEnd(light.position, d / length(d), 0.0));
}

/// Does nothing stand between?
bool is_lit(RayEnd x, LightEdge e)
{
    return is_free(shadow_ray_to_light(x, e));
}

#endif
