// The hybrid shift of ReSTIR PT [shaders/README: The shift and its Jacobian]: a path of one pixel becomes a path of another. Smooth bounces
// before the reconnection copy their direction, sharp ones replay their random numbers, then the path reconnects to x_k and keeps
// everything beyond it.  [Lin et al. 2022, "Generalized Resampled Importance Sampling", hybrid shift]
//
// The measure is solid angle a bounce, of replayed sharp bounces their random numbers, and counting for deltas and punctual lights. The
// Jacobian is the ratio of the geometry terms of the reconnected edge; no density of a guide ever enters it.
#ifndef RESTIRPG_PATH_SHIFT_GLSL
#define RESTIRPG_PATH_SHIFT_GLSL

#include "path_reservoir.glsl"

/// The path so far: where it stands, how it got there, and what it carries.
struct PartialPath {
    ShadingPoint point;
    vec3 f;
    vec3 wi;  ///< of the last replayed bounce
    bool found;  ///< that bounce met a surface; else the path still stands at the vertex before
    Hit hit;
};

PartialPath begin_path(ShadingPoint x1)
{
    return PartialPath(x1, x1.to_camera, vec3(0.0), true, Hit(0u, 0u, vec2(0.0)));
}

/// The edge x_{k-1} -> x_k that reconnects a path, and its factors of f.
struct Connection {
    vec3 wi;  ///< unit direction from x_{k-1} to x_k
    vec3 end;  ///< at x_k: the light's radiance, or the surface's f |cos| for the kept outgoing direction
    vec3 throughput;  ///< transmittance of the edge; to a surface, times the path's suffix
    float geometry;  ///< of the edge; the Jacobian is the ratio of the two paths' values
    ShadowRay ray;
};

/// The side of a surface that a ray leaves on.
vec3 side_towards(ShadingPoint p, vec3 wi)
{
    return dot(p.normal, wi) > 0.0 ? p.normal : -p.normal;
}

/// The direction of a replayed bounce that leaves p, as path.wi and `local`; false when the label does not exist here. `drawn`: of a sharp
/// bounce, its sample.
bool replay_direction(PathReservoir r, uint bounce, inout PartialPath path, out vec3 local, out BsdfSample drawn)
{
    uint label = path_label(r.labels, bounce);
    ShadingPoint p = path.point;
    uint lobes = label_lobes(p.bsdf, label);
    drawn = no_bsdf_sample(lobes);
    if (lobes == 0u)
        return false;
    if (label == LABEL_SMOOTH) {
        uint slot = prefix_slot(r.labels, bounce);
        if (slot >= PATH_PREFIX)
            return false;
        path.wi = unpack_direction(r.prefix[slot]);
        local = to_local(p.local_frame, path.wi);
        return true;
    }
    RandomKey key = RandomKey(r.pixel, r.frame, frame.c.seed);
    drawn = bsdf_sample_lobe(p.bsdf, p.wo, lobes, random2(key, bounce, RANDOM_DIRECTION));
    local = drawn.wi;
    path.wi = to_world(p.local_frame, local);
    // Between a delta and a rough lobe no measure is common: neither is the image of the other.
    return drawn.pdf > 0.0 && drawn.delta == is_delta_bounce(r, bounce);
}

/// The direction and value, as it is in f, of a replayed bounce; false when the label does not exist here or carries nothing.
bool replay_bounce(PathReservoir r, uint bounce, inout PartialPath path)
{
    vec3 local;
    BsdfSample drawn;
    if (!replay_direction(r, bounce, path, local, drawn))
        return false;
    uint label = path_label(r.labels, bounce);
    ShadingPoint p = path.point;
    vec3 value = bsdf_eval(p.bsdf, p.wo, local, label_lobes(p.bsdf, label)) * abs(local.z);
    if (drawn.delta)
        value = drawn.weight;
    else if (label != LABEL_SMOOTH)
        value /= drawn.pdf;  // its measure is its random numbers
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
    if (bounces == 0u)  // CPU devices skip a branch that no lane takes, but run the body of a loop at least once
        return true;
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

/// Connect p to the light point.
bool connect_to_light(PathReservoir r, ShadingPoint p, out Connection c)
{
    LightEdge e = edge_to_light(anchored_light(r), p.position, false);
    c = Connection(e.wi, e.radiance, edge_transmittance(p, e), e.jacobian, shadow_ray_to_light(ray_end(p), e));
    return e.radiance != vec3(0.0) && e.jacobian > 0.0;
}

/// Where the edge from p to the surface point y starts: where a scattered ray does, so that a path which scattering found and one
/// shifted onto it agree to the last digits.
vec3 connection_origin(ShadingPoint p, vec3 y)
{
    return leave_surface(ray_end(p), y - p.position);
}

/// Connect p to the surface vertex x_k.
bool connect_to_surface(PathReservoir r, ShadingPoint p, out Connection c)
{
    Surface surface = load_surface(anchored_hit(r), false);
    vec3 side = side_towards(p, surface.position - p.position);
    vec3 d = surface.position - connection_origin(p, surface.position);
    float t = length(d);
    vec3 wi = d / max(t, 1e-30);
    ShadingPoint q = shade_surface(surface, -wi);
    vec3 leaving = unpack_direction(r.direction);
    vec3 after = to_local(q.local_frame, leaving);
    vec3 end = bsdf_eval(q.bsdf, q.wo, after, label_lobes(q.bsdf, LABEL_SMOOTH)) * abs(after.z);
    c = Connection(wi, end, transmittance_between(p, wi, t, q) * r.suffix, edge_geometry(q.normal, wi, t), shadow_ray(ray_end(p), ray_end(q)));
    // No scattered ray comes back through the surface that it left, as an edge to a point of the same plane would.
    return dot(side, wi) > 0.0 && is_connectable(LABEL_SMOOTH, LABEL_SMOOTH, t) && is_consistent(q, after, leaving);
}

/// Reconnect the path, which stands at x_{k-1}, to x_k: a light or a surface.
bool reconnect(inout PathReservoir r, PartialPath path, uint k)
{
    ShadingPoint p = path.point;
    Connection c;
    bool connected = k == path_edges(r) ? connect_to_light(r, p, c) : connect_to_surface(r, p, c);
    vec3 local = to_local(p.local_frame, c.wi);
    vec3 value = bsdf_eval(p.bsdf, p.wo, local, label_lobes(p.bsdf, path_label(r.labels, k - 1u))) * abs(local.z);
    r.f = path.f * value * c.end * c.throughput;
    r.geometry = c.geometry;
    return connected && is_consistent(p, local, c.wi) && r.f != vec3(0.0) && is_free(c.ray);
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
    bool ended = k > 0u ? reconnect(shifted, path, k) : end_replay(shifted, path);
    if (!ended)
        return false;
    jacobian = shifted.geometry / source.geometry;
    return luminance(shifted.f) > 0.0 && jacobian > 0.0 && !isinf(jacobian);
}

#endif
