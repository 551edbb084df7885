// The hybrid shift of ReSTIR PT [shaders/README: The shift and its Jacobian]: a path of one pixel becomes a path of another. Smooth bounces
// before the reconnection copy their direction, sharp ones replay their random numbers, then the path reconnects to x_k and keeps
// everything beyond it.  [Lin et al. 2022, "Generalized Resampled Importance Sampling", hybrid shift]
//
// The measure is solid angle a bounce and counting for deltas and punctual lights. The Jacobian is the ratio of the geometry terms of
// the reconnected edge times the ratio of the replayed sharp densities; no density of a guide ever enters it.
#ifndef RESTIRPG_PATH_SHIFT_GLSL
#define RESTIRPG_PATH_SHIFT_GLSL

#include "path_reservoir.glsl"

/// The path so far: where it stands, how it got there, and what it carries.
struct PartialPath {
    ShadingPoint point;
    vec3 f;
    float sharp_pdf;
    vec3 wi;  ///< of the last replayed bounce
    bool found;  ///< that bounce met a surface; else the path still stands at the vertex before
    Hit hit;
};

PartialPath begin_path(ShadingPoint x1)
{
    return PartialPath(x1, vec3(1.0), 1.0, vec3(0.0), true, Hit(0u, 0u, vec2(0.0)));
}

/// A connection of the path to what it keeps.
struct Connection {
    vec3 f;  ///< of the whole path
    float geometry;  ///< of the new edge
    ShadowRay ray;
};

/// The side of a surface that a ray leaves on.
vec3 side_towards(ShadingPoint p, vec3 wi)
{
    return dot(p.normal, wi) > 0.0 ? p.normal : -p.normal;
}

/// The direction and value of a replayed bounce; false when the label does not exist here or carries nothing.
bool replay_bounce(PathReservoir r, uint bounce, inout PartialPath path)
{
    uint label = path_label(r.labels, bounce);
    ShadingPoint p = path.point;
    uint lobes = label_lobes(p.bsdf, label);
    if (lobes == 0u)
        return false;
    vec3 local;
    vec3 value;
    if (label == LABEL_SMOOTH) {
        if (bounce > PATH_PREFIX)
            return false;
        path.wi = unpack_direction(r.prefix[bounce - 1u]);
        local = to_local(p.local_frame, path.wi);
        value = bsdf_eval(p.bsdf, p.wo, local, lobes) * abs(local.z);
    } else {
        RandomKey key = RandomKey(r.pixel, r.frame, frame.c.seed);
        BsdfSample s = bsdf_sample_lobe(p.bsdf, p.wo, lobes, random2(key, bounce, RANDOM_DIRECTION));
        // Between a delta and a rough lobe no measure is common: neither is the image of the other.
        if (s.pdf <= 0.0 || s.delta != is_delta_bounce(r, bounce))
            return false;
        local = s.wi;
        path.wi = to_world(p.local_frame, local);
        value = s.weight * s.pdf;  // a delta's pdf is 1
        path.sharp_pdf *= s.pdf;
    }
    path.f *= value;
    return value != vec3(0.0) && is_consistent(p, local, path.wi);
}

/// Trace the ray of the last bounce; true: it met a surface, t away.
bool trace_bounce(inout PartialPath path, out float t)
{
    path.found = trace_closest(leave_surface(ray_end(path.point), path.wi), path.wi, RAY_INFINITY, path.hit, t);
    return path.found;
}

/// Follow the path's first bounces from x_1, to the vertex after them. Only the last bounce of a path may leave the scene.
bool replay(PathReservoir r, ShadingPoint x1, uint bounces, out PartialPath path)
{
    path = begin_path(x1);
    for (uint u = 1u; u <= bounces; ++u) {
        if (!replay_bounce(r, u, path))
            return false;
        float t;
        bool last = u + 1u == path_edges(r);
        if (!trace_bounce(path, t))
            return last;
        // A path that could reconnect earlier here would never be shifted back to this one.
        if (!last && is_connectable(path_label(r.labels, u), path_label(r.labels, u + 1u), t))
            return false;
        ShadingPoint next = shade_surface(load_surface(path.hit, false), -path.wi);
        path.f *= transmittance_between(path.point, path.wi, t, next);
        path.point = next;
    }
    return true;
}

/// The end of a path without reconnection: its last, delta bounce has to find an emitter or the environment by itself, as it did.
bool end_replay(inout PathReservoir r, PartialPath path)
{
    if (path.found == (anchored_light(r).instance == INVALID_INDEX))
        return false;
    if (path.found) {
        r.f = path.f * triangle_emission(path.hit.instance, path.hit.triangle, path.hit.barycentrics, path.point.front);
        set_anchor(r, point_on_triangle(path.hit.instance, path.hit.triangle, path.hit.barycentrics));
    } else {
        r.f = path.f * environment_radiance(path.wi) * transmittance_leaving(path.point, path.wi, INFINITE_DISTANCE);
        set_anchor(r, point_in_environment(path.wi));
    }
    return true;
}

/// Connect to the light point.
bool connect_to_light(PathReservoir r, PartialPath path, out Connection c)
{
    ShadingPoint p = path.point;
    LightEdge e = edge_to_light(anchored_light(r), p.position, false);
    c = Connection(vec3(0.0), e.jacobian, shadow_ray_to_light(ray_end(p), e));
    vec3 wi = to_local(p.local_frame, e.wi);
    if (e.radiance == vec3(0.0) || e.jacobian <= 0.0 || !is_consistent(p, wi, e.wi))
        return false;
    uint lobes = label_lobes(p.bsdf, path_label(r.labels, path_edges(r) - 1u));
    c.f = path.f * bsdf_eval(p.bsdf, p.wo, wi, lobes) * abs(wi.z) * e.radiance * edge_transmittance(p, e);
    return c.f != vec3(0.0);
}

/// Where the edge from p to the surface point y starts: where a scattered ray does, so that a path which scattering found and one
/// shifted onto it agree to the last digits.
vec3 connection_origin(ShadingPoint p, vec3 y)
{
    return leave_surface(ray_end(p), y - p.position);
}

/// Connect to the surface vertex x_k.
bool connect_to_surface(PathReservoir r, PartialPath path, out Connection c)
{
    ShadingPoint p = path.point;
    Surface surface = load_surface(anchored_hit(r), false);
    vec3 side = side_towards(p, surface.position - p.position);
    vec3 d = surface.position - connection_origin(p, surface.position);
    float t = length(d);
    vec3 wi = d / max(t, 1e-30);
    ShadingPoint q = shade_surface(surface, -wi);
    c = Connection(vec3(0.0), edge_geometry(q.normal, wi, t), shadow_ray(ray_end(p), ray_end(q)));
    vec3 before = to_local(p.local_frame, wi);
    vec3 leaving = unpack_direction(r.direction);
    vec3 after = to_local(q.local_frame, leaving);
    // No scattered ray comes back through the surface that it left, as an edge to a point of the same plane would.
    if (dot(side, wi) <= 0.0 || !is_connectable(LABEL_SMOOTH, LABEL_SMOOTH, t))
        return false;
    if (!is_consistent(p, before, wi) || !is_consistent(q, after, leaving))
        return false;
    c.f = path.f * bsdf_eval(p.bsdf, p.wo, before, label_lobes(p.bsdf, LABEL_SMOOTH)) * abs(before.z);
    c.f *= bsdf_eval(q.bsdf, q.wo, after, label_lobes(q.bsdf, LABEL_SMOOTH)) * abs(after.z);
    c.f *= transmittance_between(p, wi, t, q) * r.suffix;
    return c.f != vec3(0.0);
}

/// How many bounces of a path its shift replays: all, or those before the one that reconnects.
uint replayed_bounces(PathReservoir r)
{
    uint k = reconnection_index(r);
    return k > 0u ? k - 2u : path_edges(r) - 1u;
}

/// Shift a path to the pixel whose primary hit is x1 (shaded for its own camera). `shifted` is the path there, its ucw and
/// confidence still the source's; `jacobian` is |dT(x)/dx|. False: the path has no image, its target there is 0.
bool shift_path(PathReservoir source, ShadingPoint x1, out PathReservoir shifted, out float jacobian)
{
    shifted = source;
    jacobian = 0.0;
    PartialPath path;
    if (!replay(source, x1, replayed_bounces(source), path))
        return false;
    uint k = reconnection_index(source);
    if (k == 0u) {
        if (!end_replay(shifted, path))
            return false;
    } else {
        Connection c;
        bool connected = k == path_edges(source) ? connect_to_light(source, path, c) : connect_to_surface(source, path, c);
        if (!connected || !is_free(c.ray))
            return false;
        shifted.f = c.f;
        shifted.geometry = c.geometry;
    }
    shifted.sharpPdf = path.sharp_pdf;
    jacobian = source.sharpPdf / path.sharp_pdf * shifted.geometry / source.geometry;
    return luminance(shifted.f) > 0.0 && jacobian > 0.0 && !isinf(jacobian);
}

#endif
