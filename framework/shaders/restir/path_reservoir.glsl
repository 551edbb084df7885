// Reading and writing PathReservoir.
#ifndef RESTIRPG_PATH_RESERVOIR_GLSL
#define RESTIRPG_PATH_RESERVOIR_GLSL

#include "bsdf/labels.glsl"
#include "light_reservoir.glsl"
#include "path_reservoir_types.h"
#include "path_vertex.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PathReservoirArray { PathReservoir at[]; };

/// Interior vertices closer than this part of the scene's radius do not reconnect: the geometry term would explode (near field).
const float NEAR_FIELD = 0.01;

uint path_edges(PathReservoir r)
{
    return r.shape & 0x7fu;
}

/// Index k of the reconnection vertex; 0: none.
uint reconnection_index(PathReservoir r)
{
    return (r.shape >> 8u) & 0xffu;
}

/// Was the bounce drawn from a delta lobe? Its label alone does not say: a sharp lobe is a delta on one surface and rough on another.
bool is_delta_bounce(PathReservoir r, uint bounce)
{
    return (r.shape >> (15u + bounce) & 1u) != 0u;
}

void set_delta_bounce(inout PathReservoir r, uint bounce)
{
    r.shape |= 1u << (15u + bounce);
}

/// Set D and k of a path whose last edge scattering has found.
void set_path_shape(inout PathReservoir r, uint edges, uint k)
{
    r.shape = (r.shape & 0xffff0000u) | (k << 8u) | edges;
}

uint path_label(uint labels, uint bounce)
{
    return (labels >> (2u * bounce - 2u)) & 3u;
}

uint set_path_label(uint labels, uint bounce, uint label)
{
    uint shift = 2u * bounce - 2u;
    return (labels & ~(3u << shift)) | (label << shift);
}

/// Where the direction of a smooth bounce stands in `prefix`, if it is below PATH_PREFIX: how many smooth bounces come before it.
uint prefix_slot(uint labels, uint bounce)
{
    uint sharp = (labels | labels >> 1u) & 0x55555555u & ((1u << (2u * bounce - 2u)) - 1u);
    return bounce - 1u - uint(bitCount(sharp));
}

/// May the edge between two surface vertices reconnect? By the labels of its two ends and its length [shaders/README: What may reconnect].
bool is_connectable(uint label_before, uint label_after, float edge_length)
{
    return label_before == LABEL_SMOOTH && label_after == LABEL_SMOOTH && edge_length >= NEAR_FIELD * SCENE.radius;
}

/// The bounce at p in direction wi, as guides are trained on it; `value`: its f |cos|.
PathVertex record_bounce(ShadingPoint p, uint material, uint label, vec3 wi, vec3 value)
{
    if (label != LABEL_SMOOTH)
        return no_path_vertex();
    float density = label_pdf(p.bsdf, p.lobe_probabilities, p.wo, to_local(p.local_frame, wi), label);
    return make_path_vertex(p.position, p.normal, material, wi, luminance(value), density);
}

/// |cos| / d^2 of an edge of direction wi and length d that arrives at a surface of normal n.
float edge_geometry(vec3 n, vec3 wi, float d)
{
    return abs(dot(n, wi)) / (d * d);
}

LightPoint anchored_light(PathReservoir r)
{
    return LightPoint(r.anchor.x, r.anchor.y, r.place);
}

void set_anchor(inout PathReservoir r, LightPoint point)
{
    r.anchor = uvec2(point.instance, point.index);
    r.place = point.place;
}

Hit anchored_hit(PathReservoir r)
{
    return Hit(r.anchor.x, r.anchor.y, r.place);
}

PathReservoir empty_path_reservoir(float confidence)
{
    return PathReservoir(vec3(0.0), 0.0, confidence, 0u, 0u, 0u, 0u, uvec4(0u), uvec2(0u), vec2(0.0), 0u, 1.0, vec3(1.0));
}

#endif
