// The bounces of a pixel's path as it stands in this pixel, as far as its reservoir tells them. They are walked again without random
// decisions or visibility, which the shift has tested; at x_k the walk continues from the anchor. [shaders/README: Learning: the splat]
#ifndef RESTIRPG_PATH_WALK_GLSL
#define RESTIRPG_PATH_WALK_GLSL

#include "path_shift.glsl"
#include "scene/primary_hit.glsl"

/// Where a walk along a path has come to: x_u, from where bounce u leaves.
struct PathWalk {
    PartialPath path;
    uint material;
    uint bounce;  ///< u
};

/// At x_1.
PathWalk begin_walk(Hit hit)
{
    Surface s = load_surface(hit, false);
    return PathWalk(begin_path(shade_for_camera(s, frame.c.camera.position)), s.material, 1u);
}

/// The direction in which a path leaves x_{k-1}.
vec3 direction_to_anchor(PathReservoir r, vec3 from)
{
    if (reconnection_index(r) == path_edges(r))
        return edge_to_light(anchored_light(r), from, false).wi;
    return normalize(load_surface(anchored_hit(r), false).position - from);
}

/// The direction in which the path leaves the vertex where the walk stands, as path.wi; false: the reservoir does not tell it.
bool find_direction(PathReservoir r, inout PathWalk walk)
{
    uint u = walk.bounce, k = reconnection_index(r);
    vec3 local;
    BsdfSample drawn;
    if (u == k)
        walk.path.wi = unpack_direction(r.direction);
    else if (u + 1u == k)
        walk.path.wi = direction_to_anchor(r, walk.path.point.position);
    else
        return replay_direction(r, u, walk.path, local, drawn);
    return true;
}

/// Go on to x_{u+1}; false: there is none.
bool walk_edge(PathReservoir r, inout PathWalk walk)
{
    float t;
    if (walk.bounce + 1u == reconnection_index(r))
        walk.path.hit = anchored_hit(r);
    else if (!trace_bounce(walk.path, t))
        return false;
    Surface s = load_surface(walk.path.hit, false);
    walk.path.point = shade_surface(s, -walk.path.wi);
    walk.material = s.material;
    walk.bounce += 1u;
    return true;
}

/// f |cos| of the smooth label.
vec3 smooth_value(ShadingPoint p, vec3 wi)
{
    vec3 local = to_local(p.local_frame, wi);
    return bsdf_eval(p.bsdf, p.wo, local, label_lobes(p.bsdf, LABEL_SMOOTH)) * abs(local.z);
}

/// Is there another bounce, of the first `count` and PATH_TOLD? Then `v` is that vertex, not valid where the bounce is sharp, and the walk
/// goes on behind it. r.ucw > 0. `valued`: v has the bounce's scatter and density, too.
bool walk_bounce(PathReservoir r, uint count, bool valued, inout PathWalk walk, out PathVertex v)
{
    v = no_path_vertex();
    uint u = walk.bounce, last = min(path_edges(r) - 1u, min(count, PATH_TOLD));
    if (u > last || !find_direction(r, walk))
        return false;
    ShadingPoint p = walk.path.point;
    uint label = path_label(r.labels, u);
    if (valued)
        v = record_bounce(p, walk.material, label, walk.path.wi, smooth_value(p, walk.path.wi));
    else if (label == LABEL_SMOOTH)
        v = make_path_vertex(p.position, p.normal, walk.material, walk.path.wi, 1.0, 1.0);
    if (u + 1u == path_edges(r))
        set_final(v, (r.shape & PATH_LIGHT_SAMPLED) != 0u);
    if (u == last || !walk_edge(r, walk))
        walk.bounce = last + 1u;
    return true;
}

#endif
