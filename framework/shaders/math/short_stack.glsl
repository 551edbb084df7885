// The stack of the software traversal. Its topmost entries are variables that a push and a pop shift by selects: an array indexed at run
// time, as all of it was, takes lavapipe eight branches or scalar loads an access, and holds here only what overflows.
#ifndef RESTIRPG_SHORT_STACK_GLSL
#define RESTIRPG_SHORT_STACK_GLSL

#include "scene/scene_types.h"

const int REGISTERS = 10;
const int STACK_EMPTY = int(0x80000001);

struct ShortStack {
    ivec4 a;  ///< the topmost first
    ivec4 b;
    ivec2 c;
    int depth;
};

int overflow[BVH_STACK];

ShortStack empty_stack()
{
    return ShortStack(ivec4(STACK_EMPTY), ivec4(STACK_EMPTY), ivec2(STACK_EMPTY), 0);
}

/// Push the value, or pop, or neither; written as one step without branches. The top of an empty stack is STACK_EMPTY.
void step_stack(inout ShortStack s, bool push, bool pop, int value)
{
    if (push && s.depth >= REGISTERS)
        overflow[s.depth - REGISTERS] = s.c.y;
    int refill = STACK_EMPTY;
    if (pop && s.depth > REGISTERS)
        refill = overflow[s.depth - REGISTERS - 1];
    ShortStack pushed = ShortStack(ivec4(value, s.a.xyz), ivec4(s.a.w, s.b.xyz), ivec2(s.b.w, s.c.x), s.depth + 1);
    ShortStack popped = ShortStack(ivec4(s.a.yzw, s.b.x), ivec4(s.b.yzw, s.c.x), ivec2(s.c.y, refill), s.depth - 1);
    bvec4 pushes = bvec4(push), pops = bvec4(pop);
    s.a = mix(mix(s.a, popped.a, pops), pushed.a, pushes);
    s.b = mix(mix(s.b, popped.b, pops), pushed.b, pushes);
    s.c = mix(mix(s.c, popped.c, pops.xy), pushed.c, pushes.xy);
    s.depth = push ? pushed.depth : pop ? popped.depth : s.depth;
}

#endif
