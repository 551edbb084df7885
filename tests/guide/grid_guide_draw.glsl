// Drawing from a case, and its density.
#include "grid_guide_case.glsl"

layout(push_constant, scalar) uniform Parameters { GridGuideCase params; };

#include "../../passes/PathTracerGuided/vertex.glsl"

/// A surface of normal +z at the cell's place, under the case's BSDF and guide.
Vertex test_vertex()
{
    Vertex v;
    v.point.position = cell_position();
    v.point.normal = CELL_NORMAL;
    v.point.local_frame = mat3(1.0);
    v.point.wo = params.wo;
    v.point.bsdf = make_bsdf(BsdfParameters(vec3(0.6), params.metallic, params.roughness, 1.0, vec3(1.0), 0.0, 1.5, 0.09, false, true));
    v.point.lobe_probabilities = bsdf_lobe_probabilities(v.point.bsdf, v.point.wo);
    v.material = CELL_MATERIAL;
    v.guided = guide_lookup(params.guide, GuideQuery(v.point.position, CELL_NORMAL, params.wo, CELL_MATERIAL, uvec2(0u), 1u), v.guide);
    v.alpha = guide_alpha(v.guide, params.alpha);
    return v;
}

/// The bins' frame, by the same formula as in the test.
mat3 bin_frame()
{
    vec3 x = normalize(cross(vec3(0.47, -0.63, 0.618), params.axis));
    return mat3(x, cross(params.axis, x), params.axis);
}
