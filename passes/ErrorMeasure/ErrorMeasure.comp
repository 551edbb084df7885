// The errors of an image against a reference, in four dispatches of one source (STAGE). MAPE of a pixel needs the mean
// luminance of the reference over the valid pixels, hence a reduction before the one of the errors.
#version 460
#include "scene/scene.glsl"
#include "math/double_single.glsl"
#include "Shared.h"

#define SUM_REFERENCE 0
#define TOTAL_REFERENCE 1
#define SUM_ERRORS 2
#define TOTAL_ERRORS 3

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Parameters { ErrorMeasureParameters params; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer SumsArray { ErrorSums at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ErrorsRef { MeasuredErrors e; };

bool is_finite(vec3 v)
{
    return !any(isnan(v)) && !any(isinf(v));
}

/// An exact zero stays zero, whatever it is relative to.
vec3 relative(vec3 difference, float scale)
{
    return mix(difference / scale, vec3(0.0), equal(difference, vec3(0.0)));
}

/// MAPE's denominator of a pixel: 0.01 mean(Y_R) + Y_R.  [Zeng et al. 2025, footnote 4]
float mape_scale(vec3 reference)
{
    ErrorSums total = SumsArray(params.total).at[0];
    return 0.01 * luminance(total.reference.high / float(max(total.valid, 1u))) + luminance(reference);
}

/// Add one pixel's terms to a lane's sums.
void add_reference(inout ErrorSums sums, vec3 reference)
{
    sums.reference = ds_add(sums.reference, reference);
    sums.valid += 1u;
}

/// A squared term stops here, so that no sum of them overflows.
const float LARGEST_SQUARE = 1e30;

void add_errors(inout ErrorSums sums, uint pixel, vec3 value, vec3 reference)
{
    DoubleSingle3 difference = two_sum(value, -reference);
    vec3 d = difference.high;
    vec3 absolute = relative(abs(d), mape_scale(reference));
    sums.absolute = ds_add(sums.absolute, absolute);
    sums.relativeSquared = ds_add(sums.relativeSquared, min(d * (d / (reference * reference + 0.01)), vec3(LARGEST_SQUARE)));
    sums.squared = ds_add(sums.squared, min(d * d, vec3(LARGEST_SQUARE)));
    sums.difference = ds_add(sums.difference, difference);
    if (params.map != 0ul)
        FloatImage(params.map).at[pixel] = dot(absolute, vec3(1.0 / 3.0));
}

/// One lane's sums over its pixels.
void sum_lane(uint lane)
{
    ErrorSums sums = {};
    uint pixels = frame.c.size.x * frame.c.size.y;
    for (uint pixel = lane; pixel < pixels; pixel += LANES) {
        vec3 value = Vec3Image(params.image).at[pixel];
        vec3 reference = Vec3Image(params.reference).at[pixel];
        bool valid = is_finite(value) && is_finite(reference);
#if STAGE == SUM_REFERENCE
        if (valid)
            add_reference(sums, reference);
#else
        if (valid)
            add_errors(sums, pixel, value, reference);
        else if (params.map != 0ul)
            FloatImage(params.map).at[pixel] = 0.0;
#endif
    }
    SumsArray(params.lanes).at[lane] = sums;
}

void total_reference()
{
    ErrorSums total = {};
    for (uint lane = 0u; lane < LANES; ++lane) {
        ErrorSums sums = SumsArray(params.lanes).at[lane];
        total.reference = ds_add(total.reference, sums.reference);
        total.valid += sums.valid;
    }
    SumsArray(params.total).at[0] = total;
}

float channel_sum(vec3 v)
{
    return v.x + v.y + v.z;
}

void total_errors()
{
    ErrorSums total = SumsArray(params.total).at[0];
    for (uint lane = 0u; lane < LANES; ++lane) {
        ErrorSums sums = SumsArray(params.lanes).at[lane];
        total.absolute = ds_add(total.absolute, sums.absolute);
        total.relativeSquared = ds_add(total.relativeSquared, sums.relativeSquared);
        total.squared = ds_add(total.squared, sums.squared);
        total.difference = ds_add(total.difference, sums.difference);
    }
    // Differences of the channels may cancel: their low parts count.
    DoubleSingle3 d = total.difference;
    DoubleSingle3 across = ds_add(ds_add(DoubleSingle3(d.high.xxx, d.low.xxx), DoubleSingle3(d.high.yyy, d.low.yyy)),
                                  DoubleSingle3(d.high.zzz, d.low.zzz));
    // Without a valid pixel there are no means.
    float nan = uintBitsToFloat(0x7fc00000u);
    float count = total.valid == 0u ? nan : 3.0 * float(total.valid);
    MeasuredErrors errors;
    errors.mape = channel_sum(total.absolute.high) / count;
    errors.relMse = channel_sum(total.relativeSquared.high) / count;
    errors.rmse = sqrt(channel_sum(total.squared.high) / count);
    errors.bias = total.valid == 0u ? nan : relative(across.high, channel_sum(total.reference.high)).x;
    errors.invalid = frame.c.size.x * frame.c.size.y - total.valid;
    ErrorsRef(params.errors).e = errors;
}

void main()
{
    frame = FrameRef(params.frame);
    uint lane = gl_GlobalInvocationID.x;
#if STAGE == SUM_REFERENCE || STAGE == SUM_ERRORS
    if (lane < LANES)
        sum_lane(lane);
#elif STAGE == TOTAL_REFERENCE
    if (lane == 0u)
        total_reference();
#else
    if (lane == 0u && params.errors != 0ul)
        total_errors();
#endif
}
