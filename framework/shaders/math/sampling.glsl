// Maps from the unit square to the domains of light transport, their densities, and frames about a normal.
#ifndef RESTIRPG_SAMPLING_GLSL
#define RESTIRPG_SAMPLING_GLSL

#include "prelude.glsl"

/// An orthonormal frame; the third column is n. Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
mat3 make_frame(vec3 n)
{
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

vec3 to_world(mat3 local_frame, vec3 w)
{
    return local_frame * w;
}

vec3 to_local(mat3 local_frame, vec3 w)
{
    return w * local_frame;
}

/// Uniform on the unit disk, area preserving and continuous. Shirley & Chiu 1997.
vec2 sample_disk(vec2 u)
{
    vec2 p = 2.0 * u - 1.0;
    if (p == vec2(0.0))
        return p;
    bool wide = abs(p.x) > abs(p.y);
    float radius = wide ? p.x : p.y;
    float phi = wide ? 0.25 * PI * (p.y / p.x) : 0.5 * PI - 0.25 * PI * (p.x / p.y);
    return radius * vec2(cos(phi), sin(phi));
}

/// Cosine-weighted on the hemisphere about +z (Malley's method). z > 0 always.
vec3 sample_cosine_hemisphere(vec2 u)
{
    vec2 p = sample_disk(u);
    return vec3(p, sqrt(max(1.0 - dot(p, p), 1e-12)));
}

float pdf_cosine_hemisphere(float cosine)
{
    return max(cosine, 0.0) * INV_PI;
}

/// Uniform on the unit sphere; density 1 / (4 pi).
vec3 sample_sphere(vec2 u)
{
    float z = 1.0 - 2.0 * u.x;
    float r = 2.0 * sqrt(u.x * (1.0 - u.x));
    float phi = 2.0 * PI * u.y;
    return vec3(r * cos(phi), r * sin(phi), z);
}

/// Octahedral map of the unit sphere onto [-1, 1]^2. Meyer et al. 2010, "On Floating-Point Normal Vectors".
vec2 encode_octahedral(vec3 w)
{
    vec2 p = w.xy / (abs(w.x) + abs(w.y) + abs(w.z));
    vec2 side = vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return w.z >= 0.0 ? p : (1.0 - abs(p.yx)) * side;
}

vec3 decode_octahedral(vec2 p)
{
    vec3 w = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    vec2 side = vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    if (w.z < 0.0)
        w.xy = (1.0 - abs(w.yx)) * side;
    return normalize(w);
}

/// A unit direction in 32 bits, octahedral. A direction is packed before it is traced, so that a copy of it is exact.
uint pack_direction(vec3 w)
{
    return packSnorm2x16(encode_octahedral(w));
}

vec3 unpack_direction(uint bits)
{
    return decode_octahedral(unpackSnorm2x16(bits));
}

/// Uniform barycentrics: weights of the second and third vertex.
vec2 sample_triangle(vec2 u)
{
    float r = sqrt(u.x);
    return vec2(1.0 - r, u.y * r);
}

/// A draw from an alias table's uniform columns: the column, and the fraction to compare with its threshold.
struct AliasDraw {
    uint column;
    float fraction;
};

/// One 40-bit uniform number from two floats of 24 bits, times the number of columns, split into integer and fraction.
/// With one float alone a table of 20,000 columns would select some of them 0.1% too often.
AliasDraw draw_alias(uint columns, vec2 u)
{
    uvec2 bits = uvec2(u * 16777216.0);
    // The product without its last 16 bits. By its two parts, which have room for any number of columns.
    uint64_t product = uint64_t(bits.x) * uint64_t(columns) + ((uint64_t(bits.y >> 8) * uint64_t(columns)) >> 16);
    return AliasDraw(uint(product >> 24), float(uint(product) & 0xffffffu) * (1.0 / 16777216.0));
}

/// The balance heuristic for one sample of each of two techniques.
float balance_heuristic(float pdf, float other)
{
    return pdf > 0.0 ? pdf / (pdf + other) : 0.0;
}

#endif
