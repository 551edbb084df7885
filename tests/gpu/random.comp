// Counts pairs of random numbers along one coordinate of their address.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "math/random.glsl"
#include "random_case.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Parameters { RandomCase test; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CountsRef { RandomCounts c; };

/// pcg4d's congruential step and first mixing alone: what a hurried hash would be.
vec4 weak_random4(RandomKey key, uint bounce, uint dimension)
{
    uvec4 v = uvec4(key.pixel, key.frame, key.seed, bounce * RANDOM_DIMENSIONS + dimension) * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return unit_floats(v);
}

vec4 number(uint index)
{
    // Everything but the walking coordinate stands at a place where a render would be.
    uvec2 pixel = uvec2(17u, 5u);
    uint frame_index = 3u, seed = test.seed, bounce = 1u, dimension = RANDOM_DIRECTION, tree = 0u;
    switch (test.walk) {
    case WALK_PIXEL_X: pixel = uvec2(index & 0xffffu, 5u + (index >> 16)); break;
    case WALK_PIXEL_Y: pixel = uvec2(17u + (index >> 16), index & 0xffffu); break;
    case WALK_FRAME: frame_index = index; break;
    case WALK_SEED: seed += index; break;
    case WALK_BOUNCE: bounce = index & 0xfu; pixel.x += index >> 4; break;
    case WALK_DIMENSION: dimension = index & 0xfu; pixel.x += index >> 4; break;
    default: tree = (index & 1u) << ((index >> 1) & 3u); pixel = uvec2((index >> 1) & 0xffffu, 5u + (index >> 17)); break;
    }
    RandomKey key = tree_key(random_key(pixel, frame_index, seed), tree);
    return test.weak != 0u ? weak_random4(key, bounce, dimension) : random4(key, bounce, dimension);
}

void count(uint pair, vec2 numbers)
{
    uvec2 cell = min(uvec2(numbers * float(GRID)), GRID - 1u);
    atomicAdd(CountsRef(test.results).c.cells[(pair * GRID + cell.y) * GRID + cell.x], 1u);
}

void main()
{
    vec4 here = number(gl_GlobalInvocationID.x);
    vec4 next = number(gl_GlobalInvocationID.x + 1u);
    count(0u, here.xy);
    count(1u, here.zw);
    count(2u, vec2(here.x, next.x));
    count(3u, vec2(here.y, next.y));
    if (any(lessThan(here, vec4(0.0))) || any(greaterThanEqual(here, vec4(1.0))))
        atomicAdd(CountsRef(test.results).c.outside, 1u);
}
