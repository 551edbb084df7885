// Textures, read from plain memory and filtered here: every device gives the same texel values and weights. Samplers may
// decode sRGB within half a unit of 8 bits and interpolate with 8 fractional bits.
#ifndef RESTIRPG_TEXTURE_GLSL
#define RESTIRPG_TEXTURE_GLSL

#include "prelude.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer TextureArray { TextureImage at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ByteTexels { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FloatTexels { vec4 at[]; };

/// sRGB to linear. Above the straight part ((c + 0.055) / 1.055)^2.4 = s^4.8 with s the square root; a polynomial in s, fitted to
/// the 8-bit levels, is within 2e-6 of it. Drivers are allowed a coarse pow.
vec3 srgb_to_linear(vec3 c)
{
    vec3 s = sqrt((c + 0.055) / 1.055);
    vec3 curve = ((((-0.0404219404 * s + 0.826479077) * s + 0.284767807) * s - 0.0903042033) * s + 0.0226295535) * s;
    curve = (curve - 0.00337040424) * s + 0.000218783651;
    return mix(curve, c / 12.92, lessThanEqual(c, vec3(0.04045)));
}

/// Along one axis: the left of the two texels that a coordinate lies between, before wrapping, and the right one's weight. The
/// coordinate is brought to one period first, where floats are finest.
vec2 texel_position(float coordinate, float size, uint wrap, bool nearest)
{
    float period = wrap == TEXTURE_REPEAT ? 1.0 : 2.0;
    float inside = wrap == TEXTURE_CLAMP ? clamp(coordinate, -1.0, 2.0) : coordinate - period * floor(coordinate / period);
    float x = inside * size - (nearest ? 0.0 : 0.5);
    float left = floor(x);
    return vec2(left, nearest ? 0.0 : x - left);
}

/// The texel that a number from texel_position, or the next, stands for [Vulkan 1.3, 16.6].
uint wrap_texel(int texel, int size, uint wrap)
{
    if (wrap == TEXTURE_REPEAT)
        texel += texel < 0 ? size : texel >= size ? -size : 0;
    else if (wrap == TEXTURE_MIRROR)
        texel = texel < size ? texel : 2 * size - 1 - texel;
    return uint(clamp(texel, 0, size - 1));
}

vec4 load_texel(TextureImage image, uint index, uint flags)
{
    if ((flags & TEXTURE_FLOAT) != 0u)
        return FloatTexels(image.texels).at[index];
    uint word = ByteTexels(image.texels).at[index];
    vec4 value = vec4(uvec4(word, word >> 8u, word >> 16u, word >> 24u) & 0xffu) / 255.0;
    if ((flags & TEXTURE_SRGB) != 0u)
        value.rgb = srgb_to_linear(value.rgb);
    return value;
}

/// The texture at uv, with its own wrap modes and filter. Always of the full resolution: a replayed path must see the texels that
/// the first trace saw.
vec4 sample_texture(uint index, vec2 uv)
{
    TextureImage image = TextureArray(SCENE.textures).at[index];
    int width = int(uint(image.shape) & TEXTURE_SIDE_MASK);
    int height = int(uint(image.shape >> TEXTURE_SIDE_BITS) & TEXTURE_SIDE_MASK);
    uint flags = uint(image.shape >> (2u * TEXTURE_SIDE_BITS));
    uint wrap_u = flags & TEXTURE_WRAP_MASK;
    uint wrap_v = (flags >> TEXTURE_WRAP_BITS) & TEXTURE_WRAP_MASK;
    bool nearest = (flags & TEXTURE_NEAREST) != 0u;
    vec2 across = texel_position(uv.x, float(width), wrap_u, nearest);
    vec2 down = texel_position(uv.y, float(height), wrap_v, nearest);
    vec4 sum = vec4(0.0);
    vec4 first;
    vec4 spread = vec4(0.0);
    [[dont_unroll]] for (int tap = 0; tap < 4; ++tap) {
        int right = tap & 1;
        int lower = tap >> 1;
        uint x = wrap_texel(int(across.x) + right, width, wrap_u);
        uint y = wrap_texel(int(down.x) + lower, height, wrap_v);
        float weight = (right != 0 ? across.y : 1.0 - across.y) * (lower != 0 ? down.y : 1.0 - down.y);
        vec4 texel = load_texel(image, y * uint(width) + x, flags);
        if (tap == 0)
            first = texel;
        spread = max(spread, abs(texel - first));
        sum += weight * texel;
    }
    // The weights' sum is 1 but for rounding. Equal texels give exactly their value: an alpha may equal the cutoff, a metallicity 1.
    return mix(sum, first, equal(spread, vec4(0.0)));
}

#endif
