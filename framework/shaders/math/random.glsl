// Random numbers by address: every number is a pure function of (pixel, frame, seed, bounce, dimension), so that a path
// can be replayed from its key and no branch can shift the numbers of a later decision [shaders/README: Random numbers].
#ifndef RESTIRPG_RANDOM_GLSL
#define RESTIRPG_RANDOM_GLSL

// Dimensions of a bounce. Each address holds four independent numbers.
const uint RANDOM_TECHNIQUE = 1u;   ///< x: BSDF or guide
const uint RANDOM_GUIDE_LOBE = 2u;  ///< x: component of the guide's mixture
const uint RANDOM_DIRECTION = 3u;   ///< xy: direction; z: lobe within a label
const uint RANDOM_LIGHT = 5u;       ///< xyzw: sample_light
const uint RANDOM_PIXEL = 10u;      ///< xy: position inside the pixel (bounce 0)
const uint RANDOM_DIMENSIONS = 16u;

// Streams: XORed into the seed, so that no number of one is a number of another. The numbers that decide which sample is kept must not be
// those of the samples themselves. Paths have the seed as it is.
const uint RANDOM_STREAM_RESAMPLING = 0x9e3779b9u;  ///< which path of a pixel's trees is kept
const uint RANDOM_STREAM_DIRECT = 0x7f4a7c15u;      ///< ReSTIR DI
const uint RANDOM_STREAM_REUSE = 0x51ed270bu;       ///< reuse of paths over frames and pixels
const uint RANDOM_STREAM_SCREEN = 0x2545f491u;      ///< a guide in screen space
const uint RANDOM_STREAM_CHAIN = 0xc2b2ae35u;       ///< how a guide's Markov chains move
const uint RANDOM_STREAM_CHAIN_LOOKUP = 0x85ebca6bu;  ///< which chains guide a bounce

struct RandomKey {
    uint pixel;
    uint frame;
    uint seed;
};

/// The key of a pixel's numbers. Pixel coordinates below 65536.
RandomKey random_key(uvec2 pixel, uint frame_index, uint seed)
{
    return RandomKey(pixel.x | (pixel.y << 16), frame_index, seed);
}

/// The key of one of a pixel's path trees of a frame. Below 16 trees and 2^28 frames no two trees share a number: the upper bits tell them
/// apart. The lower ones are there because the first of a hash's four numbers hardly depends on the upper bits of its input.
RandomKey tree_key(RandomKey key, uint tree)
{
    return RandomKey(key.pixel, key.frame ^ (tree << 28u) ^ (tree << 14u), key.seed);
}

/// Jarzynski & Olano 2020, "Hash Functions for GPU Rendering": a 4D -> 4D hash. Bit b of the input reaches only the
/// bits from b - 16 on of the output.
uvec4 pcg4d(uvec4 v)
{
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

/// The upper 24 bits as floats in [0, 1): every value is exact, 1 is never reached.
vec4 unit_floats(uvec4 bits)
{
    return vec4(bits >> 8u) * (1.0 / 16777216.0);
}

/// Four fresh numbers in [0, 1) from four that have been used.
vec4 hashed_numbers(vec4 u)
{
    return unit_floats(pcg4d(floatBitsToUint(u)));
}

/// The four numbers at an address, in [0, 1).
vec4 random4(RandomKey key, uint bounce, uint dimension)
{
    return unit_floats(pcg4d(uvec4(key.pixel, key.frame, key.seed, bounce * RANDOM_DIMENSIONS + dimension)));
}

float random1(RandomKey key, uint bounce, uint dimension)
{
    return random4(key, bounce, dimension).x;
}

vec2 random2(RandomKey key, uint bounce, uint dimension)
{
    return random4(key, bounce, dimension).xy;
}

#endif
