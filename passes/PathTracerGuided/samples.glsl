// All bounces of a path tree with the light that came back along each: what guides are trained on that learn from raw samples.
// Compiled away where nobody reads them (SAMPLES).
#ifndef RESTIRPG_PATH_TRACER_SAMPLES_GLSL
#define RESTIRPG_PATH_TRACER_SAMPLES_GLSL

#include "edge.glsl"
#include "restir/path_reservoir.glsl"

#if SAMPLES
/// An edge of the tree, from x_u to x_{u+1}.
struct TreeEdge {
    PathVertex vertex;  ///< x_u
    vec3 scatter;  ///< f |cos| over the density
    vec3 absorption;  ///< along the edge
    vec3 incident;  ///< estimate of the radiance that arrives at x_u
    float density;  ///< of the direction, 1/sr
    float distance;  ///< m
};
TreeEdge tree_edges[PATH_MAX_EDGES];
uint tree_bounces;  ///< so far
#endif

void begin_samples()
{
#if SAMPLES
    tree_bounces = 0u;
#endif
}

/// Bounce u of the tree, in direction wi by `label`; `value`: its f |cos|, `density`: of wi, 1/sr.
void note_bounce(uint u, Vertex v, uint label, vec3 wi, vec3 value, float density, Arrival a)
{
#if SAMPLES
    tree_bounces = u;
    PathVertex vertex = record_bounce(v.point, v.material, label, wi, value);
    tree_edges[u - 1u] = TreeEdge(vertex, value / density, a.absorption, vec3(0.0), density, a.distance);
#endif
}

/// Radiance that leaves x_u towards x_{u-1}: it arrives at every vertex before, scattered and absorbed on the way.
void note_light(uint u, vec3 radiance)
{
#if SAMPLES
    for (uint edge = u - 1u; edge >= 1u; --edge) {
        radiance *= tree_edges[edge - 1u].absorption;
        tree_edges[edge - 1u].incident += radiance;
        radiance *= tree_edges[edge - 1u].scatter;
    }
#endif
}

/// Every bounce of the tree, whether it found light or not. A delta has no density: its vertex is none. `tree`: its number, of all pixels'.
void write_samples(uint tree)
{
#if SAMPLES
    for (uint i = 0u; i < params.guidedBounces; ++i) {
        GuidingSample s = GuidingSample(no_path_vertex(), 0.0, 0.0);
        if (i < tree_bounces)
            s = GuidingSample(tree_edges[i].vertex, luminance(tree_edges[i].incident) / tree_edges[i].density, tree_edges[i].distance);
        GuidingSampleArray(params.samples).at[tree * params.guidedBounces + i] = s;
    }
#endif
}

#endif
