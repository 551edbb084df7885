// The random numbers of all rounds of ReSTIRReuse: SPATIAL_NUMBERS of each spatial round, and as many of temporal reuse last.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "../../passes/ReSTIRReuse/rounds.glsl"
#include "random_case.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Parameters { ReuseNumbersCase test; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer NumbersArray { vec2 at[]; };

void main()
{
    uint index = gl_GlobalInvocationID.x;
    uint round = index / REUSE_NUMBERS;
    if (round > test.rounds || REUSE_NUMBERS != SPATIAL_NUMBERS)
        return;
    uint bounce = round == test.rounds ? TEMPORAL_ROUND : test.overlapping != 0u ? round : spatial_round(round);
    NumbersArray(test.results).at[index] = random2(random_key(uvec2(17u, 5u), 3u, 0u), bounce, index % REUSE_NUMBERS);
}
