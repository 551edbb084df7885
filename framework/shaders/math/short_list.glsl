// A list of up to SHORT_LIST_SIZE words in registers. An array that is indexed at run time is slow on CPU devices: each access is a branch per element.
#ifndef RESTIRPG_SHORT_LIST_GLSL
#define RESTIRPG_SHORT_LIST_GLSL

#include "short_list_types.h"

struct ShortList {
    uvec4 a, b, c, d;
};

uint list_get(ShortList list, uint i)
{
    uvec4 low = mix(list.a, list.b, bvec4(i >= 4u));
    uvec4 high = mix(list.c, list.d, bvec4(i >= 12u));
    uvec4 four = mix(low, high, bvec4(i >= 8u));
    uvec2 two = mix(four.xy, four.zw, bvec2((i & 2u) != 0u));
    return mix(two.x, two.y, (i & 1u) != 0u);
}

void list_set(inout ShortList list, uint i, uint value)
{
    const uvec4 FIRST = uvec4(0u, 1u, 2u, 3u);
    list.a = mix(list.a, uvec4(value), equal(FIRST, uvec4(i)));
    list.b = mix(list.b, uvec4(value), equal(FIRST + 4u, uvec4(i)));
    list.c = mix(list.c, uvec4(value), equal(FIRST + 8u, uvec4(i)));
    list.d = mix(list.d, uvec4(value), equal(FIRST + 12u, uvec4(i)));
}

#endif
