#version 460
#include "prelude.glsl"
#include "HeldGuideShared.h"
#include "guide/guiding_mixture.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { HeldGuideParameters params; };

void main()
{
    frame = FrameRef(params.frame);
    uint slot = gl_GlobalInvocationID.x;
    uint capacity = GuidingHeaderRef(params.guide).at.capacity;
    if (slot >= capacity || GuidingKeyArray(guiding_keys(params.guide)).at[slot] == 0ul)
        return;
    VmfMixture m = new_mixture(vec3(0.0, 1.0, 0.0));
    for (uint k = 0u; k < GUIDING_LOBES; ++k) {
        vec3 w = sample_sphere(random2(RandomKey(slot, frame.c.frame, frame.c.seed), k, 0u));
        m.x[k] = w.x;
        m.y[k] = w.y;
        m.z[k] = w.z;
        m.kappa[k] = 1000.0;
    }
    guiding_cells(params.guide, capacity).at[slot] = pack_mixture(m, 0.5, 0u, 1.0);
}
