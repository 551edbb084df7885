// What guides are trained on: the bounces of the kept path, and all bounces of the tree with the light that came back along each.
// Compiled away where nobody reads the ports (VERTICES, SAMPLES).
#ifndef RESTIRPG_PATH_TRACER_TRAINING_GLSL
#define RESTIRPG_PATH_TRACER_TRAINING_GLSL

#include "path_vertex.glsl"

#if VERTICES || SAMPLES
/// The tree's bounces; number u - 1 is bounce u.
PathVertex tree_vertices[PATH_MAX_EDGES];
uint tree_bounces;
#endif

#if VERTICES
/// The last bounce of the kept path; those before it are the tree's.
PathVertex kept_last;
#endif

#if SAMPLES
/// An edge of the tree, from x_u to x_{u+1}.
struct TreeEdge {
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
#if VERTICES || SAMPLES
    tree_bounces = 0u;
#endif
}

/// The kept path ends with this bounce.
void keep_last_vertex(PathVertex last, bool light_sampled)
{
#if VERTICES
    kept_last = last;
    set_final(kept_last, light_sampled);
#endif
}

/// Bounce u of the tree: its scattering, over the density; the absorption along its edge, and the edge's length.
void note_bounce(uint u, PathVertex v, vec3 scatter, vec3 absorption, float density, float distance)
{
#if VERTICES || SAMPLES
    tree_vertices[u - 1u] = v;
    tree_bounces = u;
#endif
#if SAMPLES
    tree_edges[u - 1u] = TreeEdge(scatter, absorption, vec3(0.0), density, distance);
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
/// The kept path's bounces, and nothing after them.
void write_vertices(uint pixel)
{
    uint stride = params.bounces + 1u;
    uint count = kept.ucw > 0.0 ? path_edges(kept) - 1u : 0u;
    for (uint i = 0u; i < stride; ++i) {
        PathVertex v = i + 1u < count ? tree_vertices[i] : i + 1u == count ? kept_last : no_path_vertex();
        PathVertexArray(params.vertices).at[pixel * stride + i] = v;
    }
}
#endif

#if SAMPLES
/// Every bounce of the tree, whether it found light or not. A delta has no density: its vertex is none.
void write_samples(uint pixel)
{
    uint stride = params.bounces + 1u;
    for (uint i = 0u; i < stride; ++i) {
        GuidingSample s = GuidingSample(no_path_vertex(), 0.0, 0.0);
        if (i < tree_bounces)
            s = GuidingSample(tree_vertices[i], luminance(tree_edges[i].incident) / tree_edges[i].density, tree_edges[i].distance);
        GuidingSampleArray(params.samples).at[pixel * stride + i] = s;
    }
}
#endif

void write_training(uint pixel)
{
#if VERTICES
    write_vertices(pixel);
#endif
#if SAMPLES
    write_samples(pixel);
#endif
}

#endif
