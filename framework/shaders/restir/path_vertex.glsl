// Reading and writing PathVertex.
#ifndef RESTIRPG_PATH_VERTEX_GLSL
#define RESTIRPG_PATH_VERTEX_GLSL

#include "path_vertex_types.h"
#include "math/sampling.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PathVertexArray { PathVertex at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer GuidingSampleArray { GuidingSample at[]; };

/// Lower corner and side of the cube that positions are quantised in, m.
vec4 position_cube()
{
    float side = float(POSITION_EXTENT) * SCENE.radius;
    return vec4(SCENE.center - 0.5 * side, side);
}

uvec2 pack_position(vec3 position)
{
    vec4 cube = position_cube();
    float steps = float(1u << POSITION_BITS);
    uvec3 q = uvec3(clamp((position - cube.xyz) / cube.w * steps, vec3(0.0), vec3(steps - 1.0)));
    uint64_t bits = uint64_t(q.x) | (uint64_t(q.y) << POSITION_BITS) | (uint64_t(q.z) << (2u * POSITION_BITS));
    return uvec2(uint(bits), uint(bits >> 32u));
}

vec3 unpack_position(uvec2 packed)
{
    uint64_t bits = uint64_t(packed.x) | (uint64_t(packed.y) << 32u);
    uint mask = (1u << POSITION_BITS) - 1u;
    uvec3 q = uvec3(uint(bits), uint(bits >> POSITION_BITS), uint(bits >> (2u * POSITION_BITS))) & mask;
    vec4 cube = position_cube();
    return cube.xyz + (vec3(q) + 0.5) / float(1u << POSITION_BITS) * cube.w;
}

/// 0 to 5: 2 axis + (1 when negative), of the component that is largest in magnitude.
uint face_of(vec3 normal)
{
    vec3 m = abs(normal);
    uint axis = m.x >= m.y && m.x >= m.z ? 0u : m.y >= m.z ? 1u : 2u;
    return 2u * axis + (normal[axis] < 0.0 ? 1u : 0u);
}

/// The axis of a face, unit.
vec3 face_normal(uint face)
{
    vec3 n = vec3(0.0);
    n[face >> 1u] = (face & 1u) != 0u ? -1.0 : 1.0;
    return n;
}

/// A positive number on a logarithmic scale of 7 bits: 2^-16 to 2^16 in steps of 19%.
uint pack_logarithm(float x)
{
    return uint(clamp(log2(max(x, 1e-30)) * 4.0 + 64.5, 0.0, 127.0));
}

float unpack_logarithm(uint bits)
{
    return exp2((float(bits & ((1u << VERTEX_LOGARITHM_BITS) - 1u)) - 64.0) / 4.0);
}

/// `scatter`: luminance of f |cos| of the bounce; `density`: the BSDF's own of wi, within the smooth label, 1/sr.
PathVertex make_path_vertex(vec3 position, vec3 normal, uint material, vec3 wi, float scatter, float density)
{
    uvec2 place = pack_position(position);
    place.y |= (face_of(normal) << VERTEX_FACE_SHIFT) | VERTEX_VALID;
    uint surface = (material & VERTEX_MATERIAL_MASK) | (pack_logarithm(density) << VERTEX_DENSITY_SHIFT) |
                   (pack_logarithm(scatter) << VERTEX_SCATTER_SHIFT);
    return PathVertex(place, pack_direction(wi), surface);
}

bool is_valid(PathVertex v)
{
    return (v.position.y & VERTEX_VALID) != 0u;
}

uint vertex_face(PathVertex v)
{
    return (v.position.y >> VERTEX_FACE_SHIFT) & 7u;
}

uint vertex_material(PathVertex v)
{
    return v.surface & VERTEX_MATERIAL_MASK;
}

float vertex_scatter(PathVertex v)
{
    return unpack_logarithm(v.surface >> VERTEX_SCATTER_SHIFT);
}

float vertex_density(PathVertex v)
{
    return unpack_logarithm(v.surface >> VERTEX_DENSITY_SHIFT);
}

/// Mark a vertex as the last before the light.
void set_final(inout PathVertex v, bool light_sampled)
{
    if (is_valid(v))
        v.surface |= VERTEX_FINAL | (light_sampled ? VERTEX_LIGHT_SAMPLED : 0u);
}

PathVertex no_path_vertex()
{
    return PathVertex(uvec2(0u), 0u, 0u);
}

#endif
