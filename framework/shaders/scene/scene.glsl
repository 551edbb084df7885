// The scene's arrays by device address.
#ifndef RESTIRPG_SCENE_GLSL
#define RESTIRPG_SCENE_GLSL

#include "texture.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintArray { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer VertexExtrasArray { VertexExtras at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MaterialArray { Material at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightArray { Light at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ImportanceCellArray { ImportanceCell at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer WordArray { uint64_t at[]; };

// Records are read in words of 64 bits: CPU devices load component by component, whatever its width.

/// A record of so many bytes in an array of them.
WordArray record_at(Address array, uint index, uint bytes)
{
    return WordArray(array + uint64_t(index) * bytes);
}

uvec2 uints_of(WordArray record, uint word)
{
    return unpackUint2x32(record.at[word]);
}

vec2 floats_of(WordArray record, uint word)
{
    return uintBitsToFloat(unpackUint2x32(record.at[word]));
}

/// Six words from the record's first on.
mat4x3 matrix_of(WordArray record)
{
    vec2 a = floats_of(record, 0u), b = floats_of(record, 1u), c = floats_of(record, 2u);
    vec2 d = floats_of(record, 3u), e = floats_of(record, 4u), f = floats_of(record, 5u);
    return mat4x3(vec3(a, b.x), vec3(b.y, c), vec3(d, e.x), vec3(e.y, f));
}

Instance load_instance(uint index)
{
    WordArray record = record_at(SCENE.instances, index, INSTANCE_BYTES);
    uvec2 a = uints_of(record, 6u), b = uints_of(record, 7u);
    return Instance(matrix_of(record), a.x, a.y, b.x, b.y);
}

/// objectToWorld of an instance, or with `previous` that of the frame before.
mat4x3 load_pose(uint instance, Instance placed, bool previous)
{
    if (previous)
        return matrix_of(record_at(SCENE.previousPoses, instance, POSE_BYTES));
    return placed.objectToWorld;
}

MeshTriangle load_triangle(Instance placed, uint triangle)
{
    WordArray record = record_at(SCENE.triangles, placed.firstTriangle + triangle, TRIANGLE_BYTES);
    uvec2 a = uints_of(record, 0u), b = uints_of(record, 1u);
    return MeshTriangle(uvec3(a, b.x), b.y);
}

MeshVertex load_vertex(uint index)
{
    WordArray record = record_at(SCENE.vertices, index, VERTEX_BYTES);
    vec2 a = floats_of(record, 0u), b = floats_of(record, 1u), c = floats_of(record, 2u);
    return MeshVertex(vec3(a, b.x), vec3(b.y, c), floats_of(record, 3u));
}

/// The corners of a triangle.
struct Corners {
    MeshVertex a;
    MeshVertex b;
    MeshVertex c;
};

Corners load_corners(uvec3 vertices)
{
    return Corners(load_vertex(vertices.x), load_vertex(vertices.y), load_vertex(vertices.z));
}

/// A material without its maps, which MATERIAL_TEXTURED announces.
struct PlainMaterial {
    vec3 baseColor;
    float metallic;
    vec3 specularColor;
    float roughness;
    vec3 absorption;
    float transmission;
    float specular;
    float ior;
    float coatAverage;
    uint flags;
    vec3 emission;
    float alpha;
};

PlainMaterial load_material(uint index)
{
    WordArray record = record_at(SCENE.materials, index, MATERIAL_BYTES);
    vec2 a = floats_of(record, 0u), b = floats_of(record, 1u), c = floats_of(record, 2u), d = floats_of(record, 3u);
    vec2 e = floats_of(record, 4u), f = floats_of(record, 5u), g = floats_of(record, 6u), h = floats_of(record, 7u);
    vec2 i = floats_of(record, 8u), j = floats_of(record, 9u);
    return PlainMaterial(vec3(a, b.x), b.y, vec3(c, d.x), d.y, vec3(e, f.x), f.y, g.x, g.y, h.x, floatBitsToUint(h.y), vec3(i, j.x), j.y);
}

/// A material's map by number, MAP_*.
TextureRef load_map(uint material, uint map)
{
    WordArray record = record_at(SCENE.materials + MAPS_AT_BYTE + uint64_t(map) * MAP_BYTES, material, MATERIAL_BYTES);
    vec2 a = floats_of(record, 0u), b = floats_of(record, 1u), c = floats_of(record, 2u);
    uvec2 d = uints_of(record, 3u);
    return TextureRef(vec3(a, b.x), vec3(b.y, c), d.x, d.y);
}

/// A material's texture at the surface's coordinates.
vec4 fetch_texture(TextureRef map, vec2 uv0, vec2 uv1)
{
    vec3 uv = vec3(map.uvSet == 0u ? uv0 : uv1, 1.0);
    return sample_texture(map.index, vec2(dot(map.row0, uv), dot(map.row1, uv)));
}

/// A texture at a point of a triangle of these vertices.
vec4 fetch_texture_on(TextureRef map, uvec3 vertices, vec2 barycentrics)
{
    vec3 weight = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
    VertexExtrasArray extras = VertexExtrasArray(SCENE.vertexExtras);
    Corners corners = load_corners(vertices);
    vec2 uv0 = mat3x2(corners.a.uv0, corners.b.uv0, corners.c.uv0) * weight;
    vec2 uv1 = mat3x2(extras.at[vertices.x].uv1, extras.at[vertices.y].uv1, extras.at[vertices.z].uv1) * weight;
    return fetch_texture(map, uv0, uv1);
}

#endif
