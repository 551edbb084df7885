// What guides are trained on: the bounces of the kept path, and all bounces of the trees with the light that came back along each. The
// kept path's bounces are written as the tree goes: an array of them, indexed at run time, is slow on CPU devices.
// Compiled away where nobody reads the ports (VERTICES, SAMPLES).
#ifndef RESTIRPG_PATH_TRACER_TRAINING_GLSL
#define RESTIRPG_PATH_TRACER_TRAINING_GLSL

#include "push.glsl"
#include "restir/path_reservoir_types.h"
#include "restir/path_vertex.glsl"

/// Bounces of the tree so far, and where its first one stands in the arrays of vertices and of samples.
uint tree_bounces;
uint first_vertex;
uint first_sample;

#if VERTICES
/// The array that the tree's bounces are written to, and the one that holds those of the kept path: the port's, or the spare one.
Address tree_vertices;
Address kept_vertices;
/// The last bounce of the kept path; those before it are its tree's.
PathVertex kept_last;
#endif

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
#endif

void begin_training()
{
#if VERTICES
    kept_vertices = params.vertices;
    tree_vertices = params.vertices;
#endif
}

void begin_tree(uint pixel, uint number)
{
    tree_bounces = 0u;
    first_vertex = pixel * params.guidedBounces;
    first_sample = (pixel * params.trees + number) * params.guidedBounces;
#if VERTICES
    if (number > 0u && tree_vertices == kept_vertices)
        tree_vertices = tree_vertices == params.vertices ? params.spareVertices : params.vertices;
#endif
}

/// The kept path ends with this bounce.
void keep_last_vertex(PathVertex last, bool light_sampled)
{
#if VERTICES
    kept_vertices = tree_vertices;
    kept_last = last;
    set_final(kept_last, light_sampled);
#endif
}

/// Bounce u of the tree: its scattering, over the density; the absorption along its edge, and the edge's length.
void note_bounce(uint u, PathVertex v, vec3 scatter, vec3 absorption, float density, float distance)
{
    tree_bounces = u;
#if VERTICES
    if (u <= params.guidedBounces)
        PathVertexArray(tree_vertices).at[first_vertex + u - 1u] = v;
#endif
#if SAMPLES
    tree_edges[u - 1u] = TreeEdge(v, scatter, absorption, vec3(0.0), density, distance);
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

#if VERTICES
/// The kept path's bounces, which are its tree's but for the last; after them nothing.
void end_vertices(uint bounces)
{
    uint count = min(bounces, params.guidedBounces);
    if (kept_vertices != params.vertices) {
        for (uint i = 0u; i < min(count, bounces - 1u); ++i)
            PathVertexArray(params.vertices).at[first_vertex + i] = PathVertexArray(kept_vertices).at[first_vertex + i];
    }
    if (bounces > 0u && bounces <= params.guidedBounces)
        PathVertexArray(params.vertices).at[first_vertex + bounces - 1u] = kept_last;
    for (uint i = count; i < params.guidedBounces; ++i)
        PathVertexArray(params.vertices).at[first_vertex + i] = no_path_vertex();
}
#endif

#if SAMPLES
/// Every bounce of the tree, whether it found light or not. A delta has no density: its vertex is none.
void write_samples()
{
    for (uint i = 0u; i < params.guidedBounces; ++i) {
        GuidingSample s = GuidingSample(no_path_vertex(), 0.0, 0.0);
        if (i < tree_bounces)
            s = GuidingSample(tree_edges[i].vertex, luminance(tree_edges[i].incident) / tree_edges[i].density, tree_edges[i].distance);
        GuidingSampleArray(params.samples).at[first_sample + i] = s;
    }
}
#endif

void end_tree()
{
#if SAMPLES
    write_samples();
#endif
}

/// `bounces`: of the kept path; 0: there is none.
void end_training(uint bounces)
{
#if VERTICES
    end_vertices(bounces);
#endif
}

#endif
