// Where alpha masks take surfaces away: for rays and for lights alike.
#ifndef RESTIRPG_ALPHA_MASK_GLSL
#define RESTIRPG_ALPHA_MASK_GLSL

#include "scene.glsl"

/// Is the surface there at all, at this point of it? Without masks in the scene (RESTIRPG_ALPHA_MASK) it always is.
bool passes_alpha_mask(MeshTriangle triangle, vec2 barycentrics)
{
#if RESTIRPG_ALPHA_MASK
    uint material_index = triangle.material & TRIANGLE_MATERIAL;
    if ((load_material(material_index).flags & MATERIAL_ALPHA_MASK) == 0u)
        return true;
    Material material = MaterialArray(SCENE.materials).at[material_index];
    uvec3 index = triangle.vertices;
    VertexExtrasArray extras = VertexExtrasArray(SCENE.vertexExtras);
    vec3 corner = vec3(extras.at[index.x].color.a, extras.at[index.y].color.a, extras.at[index.z].color.a);
    // Differences, so that equal corners give exactly their alpha: it may equal the cutoff.
    float alpha = material.alpha * (corner.x + dot(barycentrics, corner.yz - corner.x));
    TextureRef map = load_map(material_index, MAP_BASE_COLOR);
    if (map.index != INVALID_INDEX)
        alpha *= fetch_texture_on(map, index, barycentrics).a;
    return alpha >= material.alphaCutoff;
#else
    return true;
#endif
}

#endif
