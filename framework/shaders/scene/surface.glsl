// From a hit to the surface there: position, normals, material.
#ifndef RESTIRPG_SURFACE_GLSL
#define RESTIRPG_SURFACE_GLSL

#include "bsdf/bsdf.glsl"
#include "triangle.glsl"

/// The geometry of a hit point, in world space. Normals are unit and on the front side (the side the winding faces).
struct Surface {
    vec3 position;
    vec3 geometric_normal;
    float clearance;  ///< as in RayEnd
    vec3 shading_normal;  ///< interpolated; shade_surface applies the normal map
    vec4 tangent;  ///< w: sign of the bitangent in world space; 0: no tangent
    vec2 uv0;
    vec2 uv1;
    vec3 color;  ///< vertex colour
    uint material;
    uint instance;
    uint triangle;
    vec2 barycentrics;
};

void load_extras(uvec3 vertices, vec3 weight, Instance placed, mat4x3 to_world, inout Surface s)
{
    VertexExtrasArray extras = VertexExtrasArray(SCENE.vertexExtras);
    VertexExtras a = extras.at[vertices.x];
    VertexExtras b = extras.at[vertices.y];
    VertexExtras c = extras.at[vertices.z];
    vec4 tangent = weight.x * a.tangent + weight.y * b.tangent + weight.z * c.tangent;
    // A mirroring matrix turns the cross product of normal and tangent round: det(M) (M^-T n) x (M t) = M (n x t) for orthogonal M.
    s.tangent = vec4(mat3(to_world) * tangent.xyz, placed.flipped != 0u ? -tangent.w : tangent.w);
    s.uv1 = weight.x * a.uv1 + weight.y * b.uv1 + weight.z * c.uv1;
    s.color = weight.x * a.color.rgb + weight.y * b.color.rgb + weight.z * c.color.rgb;
}

/// The hit point as it stands in this frame, or, with `previous`, as it stood in the frame before.
Surface load_surface(Hit hit, bool previous)
{
    Instance placed = load_instance(hit.instance);
    mat4x3 to_world = load_pose(hit.instance, placed, previous);
    MeshTriangle record = load_triangle(placed, hit.triangle);
    Corners corners = load_corners(record.vertices);
    WorldTriangle triangle = place_triangle(placed, corners, to_world);
    vec3 weight = vec3(1.0 - hit.barycentrics.x - hit.barycentrics.y, hit.barycentrics);

    Surface s;
    s.position = point_on(triangle, hit.barycentrics);
    s.geometric_normal = normalize(triangle.cross_product);
    s.clearance = find_clearance(triangle, placed, s.position, s.geometric_normal);
    vec3 normal = mat3(corners.a.normal, corners.b.normal, corners.c.normal) * weight;
    // Their sign is the determinant's where the matrix mirrors.
    s.shading_normal = normalize(cofactors(of_unit_size(mat3(to_world))) * (placed.flipped != 0u ? -normal : normal));
    if (dot(s.shading_normal, s.geometric_normal) <= 0.0 || isnan(s.shading_normal.x))
        s.shading_normal = s.geometric_normal;
    s.uv0 = mat3x2(corners.a.uv0, corners.b.uv0, corners.c.uv0) * weight;
    s.tangent = vec4(0.0);
    s.uv1 = vec2(0.0);
    s.color = vec3(1.0);
    if ((record.material & TRIANGLE_EXTRAS) != 0u)
        load_extras(record.vertices, weight, placed, to_world, s);
    s.material = record.material & TRIANGLE_MATERIAL;
    s.instance = hit.instance;
    s.triangle = hit.triangle;
    s.barycentrics = hit.barycentrics;
    return s;
}

/// A surface with its material evaluated for light leaving towards wo.
struct ShadingPoint {
    vec3 position;
    vec3 normal;  ///< geometric, on wo's side
    float clearance;  ///< as in RayEnd
    mat3 local_frame;  ///< z: the shading normal, on wo's side
    vec3 wo;  ///< in local_frame
    Bsdf bsdf;
    vec3 lobe_probabilities;  ///< bsdf_lobe_probabilities for wo
    vec3 base_color;
    vec3 absorption;  ///< sigma_a behind the surface, 1/m; zero unless its material is a solid's
    bool front;  ///< wo is on the side the winding faces
    vec3 to_camera;  ///< transmittance of the edge to the camera that sees the point (shade_for_camera); else 1
};

/// The normal of a normal-mapped surface, glTF's convention; on the front side.
vec3 apply_normal_map(Surface s)
{
    TextureRef map = load_map(s.material, MAP_NORMAL);
    vec3 n = s.shading_normal;
    vec3 tangent = s.tangent.xyz - n * dot(n, s.tangent.xyz);
    if (map.index == INVALID_INDEX || dot(tangent, tangent) <= 0.0 || s.tangent.w == 0.0)
        return n;
    tangent = normalize(tangent);
    vec3 bitangent = cross(n, tangent) * sign(s.tangent.w);
    vec3 m = fetch_texture(map, s.uv0, s.uv1).xyz * 2.0 - 1.0;
    float scale = MaterialArray(SCENE.materials).at[s.material].normalScale;
    vec3 mapped = m.x * scale * tangent + m.y * scale * bitangent + m.z * n;
    float len = length(mapped);
    return len > 0.0 ? mapped / len : n;
}

/// The maps' parts of the parameters. The fetch stands in a loop and once: drivers copy a function to each of its calls.
void apply_textures(Surface s, inout BsdfParameters p)
{
    [[dont_unroll]] for (uint i = 0u; i < SCATTERING_MAPS; ++i) {
        TextureRef map = load_map(s.material, i);
        if (map.index == INVALID_INDEX)
            continue;
        vec4 texel = fetch_texture(map, s.uv0, s.uv1);
        if (i == MAP_BASE_COLOR)
            p.baseColor *= texel.rgb;
        if (i == MAP_METALLIC_ROUGHNESS) {
            p.roughness *= texel.g;
            p.metallic *= texel.b;
        }
        if (i == MAP_SPECULAR)
            p.specular *= texel.a;
        if (i == MAP_SPECULAR_COLOR)
            p.specularColor *= texel.rgb;
        if (i == MAP_TRANSMISSION)
            p.transmission *= texel.r;
    }
}

BsdfParameters evaluate_parameters(Surface s, PlainMaterial material, bool front)
{
    BsdfParameters p;
    p.baseColor = material.baseColor * s.color;
    p.metallic = material.metallic;
    p.roughness = material.roughness;
    p.specular = material.specular;
    p.specularColor = material.specularColor;
    p.transmission = material.transmission;
    if ((material.flags & MATERIAL_TEXTURED) != 0u)
        apply_textures(s, p);
    p.ior = material.ior;
    p.coatAverage = material.coatAverage;
    p.solid = (material.flags & MATERIAL_SOLID) != 0u;
    p.entering = front;
#if RESTIRPG_ENERGY_COMPENSATION
    p.energyTable = SCENE.energyTables + MaterialArray(SCENE.materials).at[s.material].energyTable * ENERGY_TABLE * 16u;
#endif
    return p;
}

/// Evaluate the material of a surface for the unit direction wo (world space, away from the surface).
ShadingPoint shade_surface(Surface s, vec3 wo)
{
    PlainMaterial material = load_material(s.material);
    ShadingPoint p;
    p.position = s.position;
    p.clearance = s.clearance;
    p.front = dot(s.geometric_normal, wo) >= 0.0;
    p.normal = p.front ? s.geometric_normal : -s.geometric_normal;
    vec3 n = s.shading_normal;
    if ((material.flags & MATERIAL_TEXTURED) != 0u)
        n = apply_normal_map(s);
    n = p.front ? n : -n;
    // A shading normal that faces away from wo has no upper hemisphere to scatter into: fall back to the geometric one.
    if (dot(n, wo) <= 1e-4)
        n = p.normal;
    p.local_frame = make_frame(n);
    p.wo = to_local(p.local_frame, wo);
    BsdfParameters parameters = evaluate_parameters(s, material, p.front);
    p.bsdf = make_bsdf(parameters);
    p.lobe_probabilities = bsdf_lobe_probabilities(p.bsdf, p.wo);
    p.base_color = parameters.baseColor;
    p.absorption = material.absorption;
    p.to_camera = vec3(1.0);
    return p;
}

RayEnd ray_end(Surface s)
{
    return RayEnd(s.position, s.geometric_normal, s.clearance);
}

RayEnd ray_end(ShadingPoint p)
{
    return RayEnd(p.position, p.normal, p.clearance);
}

/// Does the local direction leave on the same side for the shading and the geometric normal? Else light would leak through.
bool is_consistent(ShadingPoint p, vec3 wi_local, vec3 wi_world)
{
    return (wi_local.z > 0.0) == (dot(p.normal, wi_world) > 0.0);
}

#endif
