// From radiance to what an sRGB display is sent. Errors are measured before it, on linear values.
#version 460
#include "prelude.glsl"
#include "Shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ToneMapParameters params; };

/// Above it the curve is a straight line, and its terms are still finite.
const float LARGEST_LUMINANCE = 1e30;

/// The extended curve on luminance: `white` becomes 1, hue and saturation stay.  [Reinhard et al. 2002, equation 4]
vec3 reinhard(vec3 rgb)
{
    float l = min(luminance(rgb), LARGEST_LUMINANCE);
    return rgb * ((1.0 + l / (params.white * params.white)) / (1.0 + l));
}

/// The sRGB transfer function.  [IEC 61966-2-1]
vec3 encode_srgb(vec3 rgb)
{
    return mix(12.92 * rgb, 1.055 * pow(max(rgb, vec3(1e-8)), vec3(1.0 / 2.4)) - 0.055, greaterThan(rgb, vec3(0.0031308)));
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    vec3 rgb = max(Vec3Image(params.image).at[pixel] * params.gain, vec3(0.0));
    if (params.curve == TONE_CURVE_REINHARD)
        rgb = reinhard(rgb);
    Vec3Image(params.display).at[pixel] = encode_srgb(min(rgb, vec3(1.0)));
}
