// The stack of the software traversal: a plain array, written and read at every step without a condition. CPU devices turn a condition
// into a branch per lane, which a processor predicts badly.
#ifndef RESTIRPG_STACK_GLSL
#define RESTIRPG_STACK_GLSL

#include "scene/scene_types.h"

const int STACK_EMPTY = int(0x80000001);

struct Stack {
    int top;  ///< STACK_EMPTY where there is nothing
    int depth;
};

/// The entries from 1 on; above the topmost one is room for what step_stack writes and does not keep.
int stack_entries[BVH_STACK + 2u];

Stack empty_stack()
{
    stack_entries[0] = STACK_EMPTY;
    return Stack(STACK_EMPTY, 0);
}

/// Push the value, or pop, or neither. Pop from an empty stack, and its top stays STACK_EMPTY.
void step_stack(inout Stack stack, bool push, bool pop, int value)
{
    stack_entries[stack.depth + 1] = value;
    stack.depth = max(stack.depth + int(push) - int(pop), 0);
    stack.top = stack_entries[stack.depth];
}

#endif
