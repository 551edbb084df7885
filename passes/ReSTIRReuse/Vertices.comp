// The bounces of each pixel's chosen path as it stands in this pixel. Those from the reconnection vertex on are those of the path that was
// shifted here; those before it are walked again, without random decisions or visibility: the shift has tested it.
#version 460
#include "prelude.glsl"
#include "merge.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ReuseVerticesParameters params; };

/// The direction in which the path leaves x_{k-1}.
vec3 direction_to_anchor(PathReservoir r, vec3 from)
{
    if (reconnection_index(r) == path_edges(r))
        return edge_to_light(anchored_light(r), from, false).wi;
    return normalize(load_surface(anchored_hit(r), false).position - from);
}

/// Bounce u of the pixel whose bounces begin at `first`, if it is kept; what is known of its last edge stays as it was.
void write_bounce(uint first, uint u, uint label, uint material, ShadingPoint p, vec3 wi, vec3 value)
{
    if (u > params.stride)
        return;
    uint slot = first + u - 1u;
    PathVertexArray vertices = PathVertexArray(params.vertices);
    uint flags = vertices.at[slot].surface & (VERTEX_FINAL | VERTEX_LIGHT_SAMPLED);
    PathVertex v = record_bounce(p, material, label, wi, value);
    if (is_valid(v))
        v.surface |= flags;
    vertices.at[slot] = v;
}

void write_prefix(PathReservoir r, Hit hit, uint first)
{
    uint k = reconnection_index(r);
    PartialPath path = begin_path(domain_today(hit, false));
    uint material = load_surface(hit, false).material;
    for (uint u = 1u; u <= min(replayed_bounces(r), params.stride); ++u) {
        path.f = vec3(1.0);
        if (!replay_bounce(r, u, path))
            return;
        write_bounce(first, u, path_label(r.labels, u), material, path.point, path.wi, path.f);
        float t;
        if (u + 1u == path_edges(r) || !trace_bounce(path, t))
            return;
        Surface surface = load_surface(path.hit, false);
        path.point = shade_surface(surface, -path.wi);
        material = surface.material;
    }
    if (k == 0u || k - 1u > params.stride)  // replayed to its end, or connected behind the bounces that are kept
        return;
    ShadingPoint p = path.point;
    uint label = path_label(r.labels, k - 1u);
    vec3 wi = direction_to_anchor(r, p.position);
    vec3 local = to_local(p.local_frame, wi);
    write_bounce(first, k - 1u, label, material, p, wi, bsdf_eval(p.bsdf, p.wo, local, label_lobes(p.bsdf, label)) * abs(local.z));
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    PathReservoir r = PathReservoirArray(params.source).at[pixel];
    uint origin = origin_of(params.origins, pixel);
    PathVertexArray from = PathVertexArray((origin & OF_HISTORY) != 0u ? params.history : params.candidates);
    uint first = pixel * params.stride;
    // Where the history's positions cannot be read any more, the bounces that are walked again are all that is known.
    bool known = r.ucw > 0.0 && ((origin & OF_HISTORY) == 0u || frame.c.rescaled == 0u);
    for (uint i = 0u; i < params.stride; ++i) {
        PathVertex v = no_path_vertex();
        if (known)
            v = from.at[(origin & ~OF_HISTORY) * params.stride + i];
        PathVertexArray(params.vertices).at[first + i] = v;
    }
    if (r.ucw > 0.0 && origin != pixel)
        write_prefix(r, primary_hit(params.surface, pixel), first);
}
