// Sums of many floats in pairs of floats: about 48 bits, so that 10^5 terms add up to the last bit of a float.
// [Dekker 1971, "A floating-point technique for extending the available precision"; Knuth, TAOCP 2, 4.2.2]
#ifndef RESTIRPG_DOUBLE_SINGLE_GLSL
#define RESTIRPG_DOUBLE_SINGLE_GLSL

#include "double_single_types.h"

// `precise` keeps a compiler from contracting or reassociating what is exact only as written.

/// a + b without error: high is the rounded sum, low the rest (Knuth's TwoSum).
DoubleSingle3 two_sum(vec3 a, vec3 b)
{
    precise vec3 sum = a + b;
    precise vec3 b_part = sum - a;
    precise vec3 rest = (a - (sum - b_part)) + (b - b_part);
    return DoubleSingle3(sum, rest);
}

/// As two_sum where |a| >= |b| or a = 0.
DoubleSingle3 quick_two_sum(vec3 a, vec3 b)
{
    precise vec3 sum = a + b;
    precise vec3 rest = b - (sum - a);
    return DoubleSingle3(sum, rest);
}

/// The upper 12 of a float's 24 bits; the rest has 12 too, so products of halves are exact.
vec3 upper_half(vec3 a)
{
    return uintBitsToFloat(floatBitsToUint(a) & 0xfffff000u);
}

/// a * b without error, unless it leaves float's range. Not by fma, which Vulkan lets a device round twice.
DoubleSingle3 two_product(vec3 a, vec3 b)
{
    vec3 a1 = upper_half(a);
    vec3 b1 = upper_half(b);
    precise vec3 a2 = a - a1;
    precise vec3 b2 = b - b1;
    precise vec3 product = a * b;
    precise vec3 rest = ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2;
    return DoubleSingle3(product, rest);
}

DoubleSingle3 ds_add(DoubleSingle3 a, vec3 b)
{
    DoubleSingle3 sum = two_sum(a.high, b);
    precise vec3 low = sum.low + a.low;
    return quick_two_sum(sum.high, low);
}

DoubleSingle3 ds_add(DoubleSingle3 a, DoubleSingle3 b)
{
    DoubleSingle3 sum = two_sum(a.high, b.high);
    DoubleSingle3 rest = two_sum(a.low, b.low);
    precise vec3 low = sum.low + rest.high;
    DoubleSingle3 result = quick_two_sum(sum.high, low);
    low = result.low + rest.low;
    return quick_two_sum(result.high, low);
}

DoubleSingle3 ds_negate(DoubleSingle3 a)
{
    return DoubleSingle3(-a.high, -a.low);
}

#endif
