#version 460
#include "prelude.glsl"
#include "FixedGuideShared.h"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { FixedGuideParameters params; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Lobe { FixedGuideLobe lobe; };

void main()
{
    Lobe(params.lobe).lobe = FixedGuideLobe(vec3(0.0, 1.0, 0.0), params.kappa);
}
