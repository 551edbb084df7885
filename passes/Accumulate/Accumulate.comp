// Adds a frame to each pixel's running mean and variance.
#version 460
#include "scene/scene.glsl"
#include "math/double_single.glsl"
#include "Shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Parameters { AccumulateParameters params; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer StateArray { AccumulatorState at[]; };

/// The sum of 10^8 values, the most frames that are rendered, stays within float's range.
const float MAX_VALUE = 1e30;
/// Squares of such values do not: sums of them stop here, so that two still add up.
const float MAX_DEVIATION = 1e38;

vec3 frame_value(uint pixel)
{
    vec3 value = vec3(0.0);
    if (params.direct != 0ul)
        value += Vec3Image(params.direct).at[pixel];
    if (params.indirect != 0ul)
        value += Vec3Image(params.indirect).at[pixel];
    if (params.emission != 0ul)
        value += Vec3Image(params.emission).at[pixel];
    return value;
}

/// Youngs and Cramer's update, which never subtracts large sums of squares: with n values summing to S before x,
/// M' = M + (n x - S)^2 / (n (n + 1)).  [Chan, Golub, LeVeque 1983, eq. 1.5]
AccumulatorState add(AccumulatorState state, vec3 x)
{
    float n = float(state.count);
    if (state.count > 0u) {
        DoubleSingle3 distance = ds_add(two_product(vec3(n), x), ds_negate(state.sum));
        vec3 square = distance.high * (distance.high / (n * (n + 1.0)));
        state.deviation = ds_add(state.deviation, min(square, vec3(MAX_DEVIATION)));
        bvec3 full = greaterThan(state.deviation.high, vec3(MAX_DEVIATION));
        state.deviation.high = mix(state.deviation.high, vec3(MAX_DEVIATION), full);
        state.deviation.low = mix(state.deviation.low, vec3(0.0), full);
    }
    state.sum = ds_add(state.sum, x);
    state.count += 1u;
    return state;
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;

    AccumulatorState state = StateArray(params.history).at[pixel];
    vec3 x = frame_value(pixel);
    // A NaN fails every comparison.
    if (all(lessThanEqual(abs(x), vec3(MAX_VALUE))))
        state = add(state, x);
    else
        state.invalid += 1u;

    if (params.sums != 0ul)
        StateArray(params.sums).at[pixel] = state;
    if (params.value != 0ul)
        Vec3Image(params.value).at[pixel] = x;
    if (params.mean != 0ul)
        Vec3Image(params.mean).at[pixel] = state.sum.high / float(max(state.count, 1u));
    if (params.variance != 0ul)
        Vec3Image(params.variance).at[pixel] = state.deviation.high / float(max(state.count, 2u) - 1u);
    if (params.invalid != 0ul)
        FloatImage(params.invalid).at[pixel] = float(state.invalid);
}
