// The scene as kernels see it. Shared by C++ and GLSL: see types.h.
#ifndef RESTIRPG_SCENE_TYPES_H
#define RESTIRPG_SCENE_TYPES_H
#include "shaders/types.h"
RESTIRPG_SHARED

#ifdef __cplusplus
#define RESTIRPG_CONST constexpr uint
#else
#define RESTIRPG_CONST const uint
#endif

RESTIRPG_CONST INVALID_INDEX = 0xffffffffu;

/// The texels of a texture, rows from the top.
struct TextureImage {
    Address texels;  ///< RGBA, 8 bits each, or vec4 with TEXTURE_FLOAT
    uint64_t shape;  ///< width in the lowest TEXTURE_SIDE_BITS bits, then as many of height, then flags
};

RESTIRPG_CONST TEXTURE_SIDE_BITS = 24u;
RESTIRPG_CONST TEXTURE_SIDE_MASK = (1u << TEXTURE_SIDE_BITS) - 1u;
// The flags: a wrap mode along u and one along v in TEXTURE_WRAP_BITS each, and these.
RESTIRPG_CONST TEXTURE_WRAP_BITS = 2u;
RESTIRPG_CONST TEXTURE_WRAP_MASK = 3u;
RESTIRPG_CONST TEXTURE_REPEAT = 0u;
RESTIRPG_CONST TEXTURE_MIRROR = 1u;
RESTIRPG_CONST TEXTURE_CLAMP = 2u;
RESTIRPG_CONST TEXTURE_NEAREST = 16u;  ///< the nearest texel; else bilinear
RESTIRPG_CONST TEXTURE_SRGB = 32u;  ///< r, g and b of the bytes are sRGB encoded
RESTIRPG_CONST TEXTURE_FLOAT = 64u;

/// A texture as a material refers to it: glTF textureInfo with KHR_texture_transform.
/// uv' = vec2(dot(row0, vec3(uv, 1)), dot(row1, vec3(uv, 1))).
struct TextureRef {
    vec3 row0;
    vec3 row1;
    uint index;  ///< into SceneTable::textures; INVALID_INDEX: no texture
    uint uvSet;  ///< 0 or 1
};

RESTIRPG_CONST MATERIAL_DOUBLE_SIDED = 1u;  ///< emits on both sides; scattering is always two-sided
RESTIRPG_CONST MATERIAL_ALPHA_MASK = 2u;  ///< surface is absent where alpha < alphaCutoff
RESTIRPG_CONST MATERIAL_SOLID = 4u;  ///< KHR_materials_volume with thickness > 0: refracts and absorbs
RESTIRPG_CONST MATERIAL_EMISSIVE = 8u;  ///< emission can be non-zero
RESTIRPG_CONST MATERIAL_TEXTURED = 16u;  ///< some map but the emissive one is there
RESTIRPG_CONST MATERIAL_EMISSION_TEXTURED = 32u;  ///< the emissive one is

/// Layout of energyTable (framework/scene/energy_table.h): rows of roughness, columns of cosine and a mean a row, two
/// sides.
RESTIRPG_CONST ENERGY_ROWS = 32u;
RESTIRPG_CONST ENERGY_COLUMNS = 32u;
RESTIRPG_CONST ENERGY_TABLE = 2u * ENERGY_ROWS * (ENERGY_COLUMNS + 1u);

/// glTF metallic-roughness with KHR_materials_{emissive_strength, transmission, ior, specular, volume}. Linear sRGB.
/// What every hit needs comes first, 64 bytes of it (load_material of scene.glsl).
struct Material {
    vec3 baseColor;
    float metallic;
    vec3 specularColor;
    float roughness;  ///< linear roughness; GGX alpha = roughness^2
    vec3 absorption;  ///< sigma_a inside a solid, 1/m: -log(attenuationColor) / attenuationDistance
    float transmission;
    float specular;
    float ior;  ///< 0: infinite, KHR_materials_ior's total reflection
    float coatAverage;  ///< cosine-weighted mean over the hemisphere of (F(cos) - F0) / (1 - F0) for this ior
    uint flags;  ///< MATERIAL_*
    vec3 emission;  ///< radiance, W/sr/m^2: emissiveFactor * emissiveStrength
    float alpha;  ///< baseColorFactor.a; the vertex colour's and the texture's multiply it
    float alphaCutoff;
    float normalScale;
    uint energyTable;  ///< index of this ior's table in SceneTable::energyTables
    uint unused;
    // In the order of MAP_*.
    TextureRef baseColorMap;  ///< sRGB, alpha in a
    TextureRef metallicRoughnessMap;  ///< roughness in g, metallic in b
    TextureRef specularMap;  ///< a
    TextureRef specularColorMap;  ///< sRGB
    TextureRef transmissionMap;  ///< r
    TextureRef normalMap;
    TextureRef emissiveMap;  ///< sRGB
};

// Maps of a material by number (load_map of scene.glsl). Those before SCATTERING_MAPS change parameters of the BSDF.
RESTIRPG_CONST MAP_BASE_COLOR = 0u, MAP_METALLIC_ROUGHNESS = 1u, MAP_SPECULAR = 2u, MAP_SPECULAR_COLOR = 3u,
               MAP_TRANSMISSION = 4u;
RESTIRPG_CONST SCATTERING_MAPS = 5u;
RESTIRPG_CONST MAP_NORMAL = 5u, MAP_EMISSIVE = 6u;

/// 32 bytes.
struct MeshVertex {
    vec3 position;  ///< object space
    vec3 normal;
    vec2 uv0;
};

/// What most surfaces do without; 40 bytes.
struct VertexExtras {
    vec4 tangent;  ///< w: sign of the bitangent; all zero: no tangent
    vec2 uv1;
    vec4 color;  ///< linear COLOR_0, its alpha in a; 1 when absent
};

/// 16 bytes.
struct MeshTriangle {
    uvec3 vertices;  ///< into the scene's
    uint material;  ///< its index, and TRIANGLE_EXTRAS
};
RESTIRPG_CONST TRIANGLE_EXTRAS = 1u << 31;  ///< the surface depends on VertexExtras
RESTIRPG_CONST TRIANGLE_MATERIAL = TRIANGLE_EXTRAS - 1u;

/// A mesh placed in the world. 64 bytes.
struct Instance {
    mat4x3 objectToWorld;  ///< columns; this frame
    uint firstTriangle;  ///< of its mesh, among the scene's
    uint triangleCount;
    uint lightMap;  ///< base of this instance's triangles in lightOfTriangle; INVALID_INDEX: emits nothing
    uint flipped;  ///< 1: objectToWorld mirrors, so the front face's winding is reversed
};

RESTIRPG_CONST LIGHT_TRIANGLE = 0u;
RESTIRPG_CONST LIGHT_POINT = 1u;
RESTIRPG_CONST LIGHT_SPOT = 2u;
RESTIRPG_CONST LIGHT_DIRECTIONAL = 3u;
RESTIRPG_CONST LIGHT_ENVIRONMENT = 4u;

/// A light of the power-weighted alias table (Walker's method; the entry holds its own pmf).
struct Light {
    uint type;  ///< LIGHT_*
    uint instance;  ///< triangle: instance it belongs to
    uint triangle;  ///< triangle: index within the mesh
    float pmf;  ///< probability that sampling selects this light
    float aliasThreshold;  ///< keep this entry when the fractional random number is below
    uint alias;  ///< else take this one
    vec3 position;  ///< point, spot
    vec3 direction;  ///< spot, directional: from the light
    vec3 intensity;  ///< point, spot: W/sr; directional: irradiance, W/m^2
    float cosInner;  ///< spot: KHR_lights_punctual cone
    float cosOuter;
    uint cells;  ///< triangle: first of its parts in emissionCells; INVALID_INDEX: points are drawn uniformly
    uint cellsASide;  ///< ... whose number is the square of this
};

/// One cell of an alias table over equal parts of a domain.
struct ImportanceCell {
    float pdf;  ///< probability density of this part, over that of a uniform distribution
    float aliasThreshold;
    uint alias;
};

/// Pinhole camera. A pixel-plane point (px, py), in pixels from the top left, is seen along
/// forward + (2 px / width - 1) right + (1 - 2 py / height) up; forward is a unit vector.
struct Camera {
    vec3 position;
    vec3 right;  ///< length tan(xfov / 2)
    vec3 up;  ///< length tan(yfov / 2)
    vec3 forward;
};

/// What the boxes of a hierarchy are counted in: position p has the coordinates (p - origin) * scale, from 0 to 65535.
struct BvhGrid {
    vec3 origin;
    vec3 scale;  ///< cells a metre
    float width;  ///< of its longest axis, m
    float unused;
};

/// A two-child BVH node. A box has a word an axis, its lower side in the low 16 bits, its upper side in the high ones,
/// rounded outwards. A child >= 0 is the index of an inner node; a child < 0 is a leaf of count primitives from first
/// on: child = ~(first << BVH_LEAF_BITS | count - 1). 32 bytes.
struct BvhNode {
    uvec3 box0;
    uvec3 box1;
    int child0;
    int child1;
};
RESTIRPG_CONST BVH_LEAF_BITS = 3u;
/// Entries of the traversal stack: the deepest two-level path, one entry a level and one for the way out of an
/// instance.
RESTIRPG_CONST BVH_STACK = 64u;

/// A triangle as traversal reads it. Corners, not edges: triangles that meet in an edge have the same numbers there. 48
/// bytes.
struct BvhTriangle {
    vec3 corner0;
    vec3 corner1;
    vec3 corner2;
    uint instance;  ///< in the static batch: the instance it belongs to; in a mesh's own hierarchy: not used
    uint triangle;  ///< index within the mesh
    uint unused;
};

/// What a leaf of the software back end's top level refers to: the static batch (triangles of everything that stands
/// still, in world space) or an instance of a mesh with a hierarchy of its own.
struct BvhObject {
    Address nodes;  ///< BvhNode[]
    Address triangles;  ///< BvhTriangle[]
    mat4x3 worldToObject;
    BvhGrid grid;
    uint instance;  ///< INVALID_INDEX: the static batch
    uint masked;  ///< 1: some triangle has an alpha mask
};

RESTIRPG_CONST INSTANCE_BYTES = 64u, POSE_BYTES = 48u, TRIANGLE_BYTES = 16u, VERTEX_BYTES = 32u, MATERIAL_BYTES = 320u,
               MAPS_AT_BYTE = 96u, MAP_BYTES = 32u, BVH_NODE_BYTES = 32u, BVH_TRIANGLE_BYTES = 48u;
#ifdef __cplusplus
static_assert(sizeof(Instance) == INSTANCE_BYTES && sizeof(mat4x3) == POSE_BYTES &&
              sizeof(MeshTriangle) == TRIANGLE_BYTES && sizeof(MeshVertex) == VERTEX_BYTES &&
              sizeof(Material) == MATERIAL_BYTES && sizeof(TextureRef) == MAP_BYTES &&
              offsetof(Material, baseColorMap) == MAPS_AT_BYTE + MAP_BASE_COLOR * MAP_BYTES &&
              offsetof(Material, transmissionMap) == MAPS_AT_BYTE + MAP_TRANSMISSION * MAP_BYTES &&
              offsetof(Material, emissiveMap) == MAPS_AT_BYTE + MAP_EMISSIVE * MAP_BYTES &&
              sizeof(BvhNode) == BVH_NODE_BYTES && sizeof(BvhTriangle) == BVH_TRIANGLE_BYTES);
#endif

/// Everything a kernel reads of the scene; one buffer, by address in FrameConstants.
struct SceneTable {
    Address vertices;  ///< MeshVertex
    Address vertexExtras;  ///< VertexExtras per vertex
    Address triangles;  ///< MeshTriangle
    Address materials;  ///< Material
    Address textures;  ///< TextureImage
    Address instances;  ///< Instance
    Address previousPoses;  ///< mat4x3 per instance: objectToWorld of the frame before
    Address lights;  ///< Light
    Address lightOfTriangle;  ///< uint, see Instance::lightMap
    Address emissionCells;  ///< ImportanceCell, see Light::cells
    Address environmentCells;  ///< ImportanceCell per texel, row by row; 0: constant
    Address energyTables;  ///< vec4, ENERGY_TABLE a table; 0: no energy compensation
    Address tlasNodes;  ///< software back end: BvhNode[]
    Address bvhObjects;  ///< software back end: BvhObject[], in the order of the TLAS's leaves
    BvhGrid tlasGrid;
    uint instanceCount;
    uint lightCount;  ///< lights to select from; 0 also where none has power
    uint environmentLight;  ///< index of the environment in lights; INVALID_INDEX: none
    uint environmentTexture;  ///< index into textures; INVALID_INDEX: constant
    uvec2 environmentSize;  ///< texels
    vec3 environmentRadiance;  ///< constant radiance, or the texture's factor
    float environmentRotation;  ///< radians about +y
    vec3 center;  ///< of the bounding sphere
    float radius;  ///< m
};

/// A primary or secondary hit: enough to rebuild the surface. 16 bytes.
struct Hit {
    uint instance;  ///< INVALID_INDEX: the ray escaped
    uint triangle;  ///< within the mesh
    vec2 barycentrics;  ///< weights of the second and third vertex
};

/// What a pixel sees: the payload type of the graph's "Surface" ports. With the hit stands what reuse compares pixels
/// by, as the camera saw it in its frame, so that to choose neighbours takes no look at the scene. 24 bytes.
struct PrimaryHit {
    Hit hit;
    uint normal;  ///< interpolated normal on the camera's side, packed (pack_direction); not set where the ray escaped
    float distance;  ///< from the camera, m
};
RESTIRPG_CONST PRIMARY_HIT_BYTES = 24u;

RESTIRPG_SHARED_END
#endif
