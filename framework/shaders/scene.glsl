// The scene's arrays by device address.
#ifndef RESTIRPG_SCENE_GLSL
#define RESTIRPG_SCENE_GLSL

#include "texture.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec3Array { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Uvec3Array { uvec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintArray { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer AttributesArray { VertexAttributes at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MaterialArray { Material at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer MeshArray { Mesh at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer InstanceArray { Instance at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightArray { Light at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ImportanceCellArray { ImportanceCell at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PrimaryHitArray { PrimaryHit at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer WordArray { uint64_t at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FloatImage { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Vec3Image { vec3 at[]; };

/// The hit of a pixel, from a "Surface" port.
Hit primary_hit(Address surfaces, uint pixel)
{
    // In 64-bit words: on CPU devices a load costs the same whatever its width.
    WordArray words = WordArray(surfaces + uint64_t(pixel) * PRIMARY_HIT_BYTES);
    uvec2 ids = unpackUint2x32(words.at[0]);
    return Hit(ids.x, ids.y, uintBitsToFloat(unpackUint2x32(words.at[1])));
}

/// A material's texture at the surface's coordinates.
vec4 fetch_texture(TextureRef map, vec2 uv0, vec2 uv1)
{
    vec3 uv = vec3(map.uvSet == 0u ? uv0 : uv1, 1.0);
    return sample_texture(map.index, vec2(dot(map.row0, uv), dot(map.row1, uv)));
}

#endif
