// What the kernels that test GuidingScreen's lobes have in common. Compiled with GUIDED = 1 and the pass's module.
#include "guide/guide.glsl"
#include "math/random.glsl"
#include "screen_lobe_case.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Parameters { LobeCase test; };

/// The lobe, as a path at its primary hit finds it; false: it does not guide there.
bool find_lobe(uint bounce, out Guide g)
{
    frame = FrameRef(test.frame);
    return guide_lookup(test.guide, GuideQuery(vec3(0.0), test.normal, test.normal, 0u, uvec2(0u), bounce), g);
}
