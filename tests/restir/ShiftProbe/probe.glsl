// What the kernels of ShiftProbe share: the pair of domains, and the kind of a path.
#ifndef RESTIRPG_SHIFT_PROBE_GLSL
#define RESTIRPG_SHIFT_PROBE_GLSL

#include "Shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ShiftProbeParameters params; };

#include "../../../passes/ReSTIRReuse/merge.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Vec4Array { vec4 at[]; };

/// Pixels around it that a pixel is paired with.
const float PAIR_RADIUS = 3.0;
/// "Bounce" of the random numbers that pair pixels: of no round of reuse.
const uint PAIRING_ROUND = 0xfffeu;

/// A pixel near this one whose surface is there, in this frame or the one before.
bool find_pair(uvec2 at, uint i, out uint pixel)
{
    if (!find_neighbour_pixel(at, PAIR_RADIUS, random2(reuse_key(at), PAIRING_ROUND, i), pixel))
        return false;
    return primary_hit(params.way == WAY_PREVIOUS ? params.previousSurface : params.surface, pixel).instance != INVALID_INDEX;
}

/// The domain of a pixel that the paths are shifted to.
ShadingPoint load_pair(uint pixel)
{
    bool previous = params.way == WAY_PREVIOUS;
    return domain_today(primary_hit(previous ? params.previousSurface : params.surface, pixel), previous);
}

/// This pixel's domain and path, and the domain to shift it to; false: nothing to shift.
bool load_case(uvec2 at, out PathReservoir path, out ShadingPoint here, out ShadingPoint there)
{
    uint pixel = pixel_index(at);
    Hit hit = primary_hit(params.surface, pixel);
    path = PathReservoirArray(params.reservoirs).at[pixel];
    uint other = pixel;
    if (hit.instance == INVALID_INDEX || path.ucw <= 0.0 || (params.way != WAY_STAY && !find_pair(at, 0u, other)))
        return false;
    here = domain_today(hit, false);
    there = load_pair(other);
    return true;
}

uint kind_of_end(PathReservoir r)
{
    uint k = reconnection_index(r);
    if (k < path_edges(r))
        return k == 0u ? END_DELTA : END_SURFACE;
    if (r.anchor.x != INVALID_INDEX)
        return END_EMITTER;
    return r.anchor.y == SCENE.environmentLight ? END_ENVIRONMENT : END_PUNCTUAL;
}

/// Where the edge that reconnects leads, seen from x_{k-1}.
vec3 connection_direction(PathReservoir r, ShadingPoint p)
{
    if (reconnection_index(r) == path_edges(r))
        return edge_to_light(anchored_light(r), p.position, false).wi;
    vec3 y = load_surface(anchored_hit(r), false).position;
    return normalize(y - connection_origin(p, y));
}

/// What the replayed bounce at p is, as PREFIX_*.
uint kind_of_bounce(PathReservoir r, uint bounce)
{
    bool delta = is_delta_bounce(r, bounce);
    uint label = path_label(r.labels, bounce);
    if (label == LABEL_SMOOTH)
        return PREFIX_COPIED;
    if (label == LABEL_SHARP_REFLECT)
        return delta ? PREFIX_DELTA_REFLECTION : PREFIX_SHARP_REFLECTION;
    return delta ? PREFIX_DELTA_TRANSMISSION : PREFIX_SHARP_TRANSMISSION;
}

/// Relative to the near field's limit, a distance that is too close to it to judge.
const float NEAR_FIELD_DOUBT = 1e-4;

/// Do two surface vertices reconnect, by the definition [shaders/README: What may reconnect] and not by the shift's own test? `doubtful`: say this.
bool reconnects(PathReservoir r, uint bounce, vec3 x, vec3 y, bool doubtful)
{
    float reach = distance(x, y) / (NEAR_FIELD * SCENE.radius);
    if (abs(reach - 1.0) < NEAR_FIELD_DOUBT)
        return doubtful;
    return path_label(r.labels, bounce) == LABEL_SMOOTH && path_label(r.labels, bounce + 1u) == LABEL_SMOOTH && reach > 1.0;
}

/// The kind of the path that the domain x1 holds, and whether it is classified as this domain classifies its own paths: k is the first
/// vertex that can reconnect, and deltas are deltas. If not, two domains would disagree on who could have made the path.
uint inspect(PathReservoir r, ShadingPoint x1, out bool canonical)
{
    uint kind = kind_of_end(r);
    uint k = reconnection_index(r);
    uint replayed = replayed_bounces(r);
    vec3 before = x1.position;
    PartialPath path;
    canonical = true;
    for (uint u = 1u; u <= (k > 0u ? k - 1u : replayed); ++u) {  // at x_u
        if (!replay(r, x1, u - 1u, path))
            return kind;
        ShadingPoint p = path.point;
        canonical = canonical && (u == 1u || !reconnects(r, u - 1u, before, p.position, false));
        before = p.position;
        if (u > replayed)
            break;
        kind |= kind_of_bounce(r, u);
        uint label = path_label(r.labels, u);
        canonical = canonical && (label == LABEL_SMOOTH || bsdf_is_delta(p.bsdf, label_lobes(p.bsdf, label)) == is_delta_bounce(r, u));
    }
    if (k == 0u)
        return kind;
    if (kind_of_end(r) == END_SURFACE)
        canonical = canonical && reconnects(r, k - 1u, before, load_surface(anchored_hit(r), false).position, true);
    if (path_label(r.labels, k - 1u) != LABEL_SMOOTH)
        kind |= CONNECTION_SHARP;
    return dot(path.point.normal, connection_direction(r, path.point)) < 0.0 ? kind | CONNECTION_TRANSMITS : kind;
}

#endif
