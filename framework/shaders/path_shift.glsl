// The hybrid shift of ReSTIR PT, variant U (ALGORITHMS 5.5, 6.5): a path of one pixel becomes a path of another. Smooth bounces
// before the reconnection copy their direction, sharp ones replay their random numbers, then the path reconnects to x_k and keeps
// everything beyond it.  [Lin et al. 2022, "Generalized Resampled Importance Sampling", hybrid shift]
//
// The measure is solid angle a bounce and counting for deltas and punctual lights. The Jacobian is the ratio of the geometry terms of
// the reconnected edge times the ratio of the replayed sharp densities; no density of a guide ever enters it.
#ifndef RESTIRPG_PATH_SHIFT_GLSL
#define RESTIRPG_PATH_SHIFT_GLSL

#include "path_reservoir.glsl"

/// The path so far: where it stands, and what it carries.
struct PartialPath {
    ShadingPoint point;
    vec3 f;
    float sharp_pdf;
};

/// The side of a surface that a ray leaves on.
vec3 side_towards(ShadingPoint p, vec3 wi)
{
    return dot(p.normal, wi) > 0.0 ? p.normal : -p.normal;
}

/// The direction and value of a replayed bounce; false when the label does not exist here or carries nothing.
bool replay_bounce(PathReservoir r, uint bounce, inout PartialPath path, out vec3 wi)
{
    uint label = path_label(r.labels, bounce);
    ShadingPoint p = path.point;
    uint lobes = label_lobes(p.bsdf, label);
    wi = vec3(0.0);
    if (lobes == 0u)
        return false;
    vec3 local;
    vec3 value;
    if (label == LABEL_SMOOTH) {
        if (bounce > PATH_PREFIX)
            return false;
        wi = unpack_direction(r.prefix[bounce - 1u]);
        local = to_local(p.local_frame, wi);
        value = bsdf_eval(p.bsdf, p.wo, local, lobes) * abs(local.z);
    } else {
        RandomKey key = RandomKey(r.pixel, r.frame, frame.c.seed);
        BsdfSample s = bsdf_sample_lobe(p.bsdf, p.wo, lobes, random2(key, bounce, RANDOM_DIRECTION));
        if (s.pdf <= 0.0)
            return false;
        local = s.wi;
        wi = to_world(p.local_frame, local);
        value = s.weight * s.pdf;  // a delta's pdf is 1
        path.sharp_pdf *= s.pdf;
    }
    path.f *= value;
    return value != vec3(0.0) && is_consistent(p, local, wi);
}

/// The end of a path without reconnection: the last, delta bounce has to find an emitter or the environment by itself, as it did.
bool end_replay(inout PathReservoir r, PartialPath path, vec3 wi, bool found, Hit hit, float t, out vec3 f)
{
    f = vec3(0.0);
    bool environment = anchored_light(r).instance == INVALID_INDEX;
    if (found == environment)
        return false;
    if (environment) {
        f = path.f * environment_radiance(wi) * transmittance_leaving(path.point, wi, INFINITE_DISTANCE);
        set_anchor(r, point_in_environment(wi));
        return true;
    }
    ShadingPoint emitter = shade_surface(load_surface(hit, false), -wi);
    f = path.f * triangle_emission(hit.instance, hit.triangle, hit.barycentrics, emitter.front) *
        transmittance_between(path.point, wi, t, emitter);
    set_anchor(r, point_on_triangle(hit.instance, hit.triangle, hit.barycentrics));
    return true;
}

/// Connect to the light point; `geometry` receives the new edge's.
bool connect_to_light(PathReservoir r, PartialPath path, out vec3 f, out float geometry)
{
    ShadingPoint p = path.point;
    LightEdge e = edge_to_light(anchored_light(r), p.position, false);
    geometry = e.jacobian;
    f = vec3(0.0);
    vec3 wi = to_local(p.local_frame, e.wi);
    if (e.radiance == vec3(0.0) || e.jacobian <= 0.0 || !is_consistent(p, wi, e.wi))
        return false;
    uint lobes = label_lobes(p.bsdf, path_label(r.labels, path_edges(r) - 1u));
    f = path.f * bsdf_eval(p.bsdf, p.wo, wi, lobes) * abs(wi.z) * e.radiance * transmittance_leaving(p, e.wi, e.distance);
    return f != vec3(0.0) && is_lit(p.position, p.normal, e);
}

/// Connect to the surface vertex x_k.
bool connect_to_surface(PathReservoir r, PartialPath path, out vec3 f, out float geometry)
{
    ShadingPoint p = path.point;
    Surface surface = load_surface(anchored_hit(r), false);
    vec3 d = surface.position - p.position;
    float t = length(d);
    vec3 wi = d / max(t, 1e-30);
    ShadingPoint q = shade_surface(surface, -wi);
    geometry = edge_geometry(q.normal, wi, t);
    f = vec3(0.0);
    vec3 before = to_local(p.local_frame, wi);
    vec3 leaving = unpack_direction(r.direction);
    vec3 after = to_local(q.local_frame, leaving);
    if (!is_connectable(LABEL_SMOOTH, LABEL_SMOOTH, t) || !is_consistent(p, before, wi) || !is_consistent(q, after, leaving))
        return false;
    f = path.f * bsdf_eval(p.bsdf, p.wo, before, label_lobes(p.bsdf, LABEL_SMOOTH)) * abs(before.z);
    f *= bsdf_eval(q.bsdf, q.wo, after, label_lobes(q.bsdf, LABEL_SMOOTH)) * abs(after.z);
    f *= transmittance_between(p, wi, t, q) * r.suffix;
    return f != vec3(0.0) && geometry > 0.0 && visible(p.position, side_towards(p, wi), surface.position, q.normal);
}

/// Shift a path to the pixel whose primary hit is x1 (shaded for its own camera). `shifted` is the path there, its ucw and
/// confidence still the source's; `jacobian` is |dT(x)/dx|. False: the path has no image, its target there is 0.
bool shift_path(PathReservoir source, ShadingPoint x1, out PathReservoir shifted, out float jacobian)
{
    shifted = source;
    jacobian = 0.0;
    uint edges = path_edges(source);
    uint k = reconnection_index(source);
    uint replayed = k > 0u ? k - 2u : edges - 1u;
    PartialPath path = PartialPath(x1, vec3(1.0), 1.0);

    for (uint u = 1u; u <= replayed; ++u) {
        vec3 wi;
        if (!replay_bounce(source, u, path, wi))
            return false;
        Hit hit;
        float t;
        bool found = trace_closest(offset_origin(path.point.position, side_towards(path.point, wi)), wi, RAY_INFINITY, hit, t);
        if (u == edges - 1u) {
            jacobian = source.sharpPdf / path.sharp_pdf;
            shifted.sharpPdf = path.sharp_pdf;
            return end_replay(shifted, path, wi, found, hit, t, shifted.f) && luminance(shifted.f) > 0.0;
        }
        if (!found)
            return false;
        ShadingPoint next = shade_surface(load_surface(hit, false), -wi);
        // A path that could reconnect earlier there would never be shifted back to this one.
        if (is_connectable(path_label(source.labels, u), path_label(source.labels, u + 1u), t))
            return false;
        path.f *= transmittance_between(path.point, wi, t, next);
        path.point = next;
    }
    bool connected = k == edges ? connect_to_light(source, path, shifted.f, shifted.geometry)
                                : connect_to_surface(source, path, shifted.f, shifted.geometry);
    jacobian = source.sharpPdf / path.sharp_pdf * shifted.geometry / source.geometry;
    shifted.sharpPdf = path.sharp_pdf;
    return connected && luminance(shifted.f) > 0.0 && jacobian > 0.0 && !isinf(jacobian);
}

#endif
