#version 460
#include "prelude.glsl"
#include "KnownSamplesShared.h"
#include "math/random.glsl"
#include "math/vmf_mixture.glsl"
#include "restir/path_vertex.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { KnownSamplesParameters params; };

/// Of the scene's radius, between neighbouring places.
const float SPACING = 0.03;

VmfMixture known_mixture()
{
    return VmfMixture(vec4(0.6, -0.8, 0.0, 0.0), vec4(0.8, 0.6, 0.6, 0.28), vec4(0.0, 0.0, 0.8, -0.96), vec4(6.0, 20.0, 80.0, 300.0),
                      vec4(0.4, 0.3, 0.2, 0.1));
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    uint place = pixel % params.places;
    vec3 position = SCENE.center + SPACING * SCENE.radius * vec3(float(place % 64u) - 31.5, 0.0, float(place / 64u) - 31.5);
    VmfMixture m = known_mixture();
    vec4 u = random4(random_key(at, frame.c.frame, frame.c.seed), 0u, 0u);
    uint lobe = select_lobe(m, u.z);
    vec3 w = params.identical != 0u ? lobe_direction(m, 0u) : sample_vmf(lobe_direction(m, lobe), m.kappa[lobe], u.xy);
    PathVertex vertex = make_path_vertex(position, vec3(0.0, 1.0, 0.0), 3u, w, 1.0, 1.0);
    GuidingSampleArray(params.samples).at[pixel] = GuidingSample(vertex, 1.0, 1.0);
}
