// The GL_EXT_ray_query back end. See trace.glsl for the interface.
#ifndef RESTIRPG_TRACE_RAYQUERY_GLSL
#define RESTIRPG_TRACE_RAYQUERY_GLSL

#extension GL_EXT_ray_query : require

layout(set = 0, binding = 0) uniform accelerationStructureEXT world;

/// Run the query to its end. Only instances with an alpha mask report candidates.
void run_query(rayQueryEXT query)
{
    while (rayQueryProceedEXT(query)) {
#if RESTIRPG_ALPHA_MASK
        if (rayQueryGetIntersectionTypeEXT(query, false) == gl_RayQueryCandidateIntersectionTriangleEXT &&
            passes_alpha_mask(rayQueryGetIntersectionInstanceCustomIndexEXT(query, false),
                              rayQueryGetIntersectionPrimitiveIndexEXT(query, false),
                              rayQueryGetIntersectionBarycentricsEXT(query, false)))
            rayQueryConfirmIntersectionEXT(query);
#endif
    }
}

bool trace_closest(vec3 origin, vec3 direction, float t_max, out Hit hit, out float t)
{
    rayQueryEXT query;
    rayQueryInitializeEXT(query, world, gl_RayFlagsNoneEXT, 0xff, origin, 0.0, direction, t_max);
    run_query(query);
    bool found = rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionTriangleEXT;
    hit = Hit(INVALID_INDEX, 0u, vec2(0.0));
    t = t_max;
    if (found) {
        t = rayQueryGetIntersectionTEXT(query, true);
        hit = Hit(rayQueryGetIntersectionInstanceCustomIndexEXT(query, true),
                  rayQueryGetIntersectionPrimitiveIndexEXT(query, true), rayQueryGetIntersectionBarycentricsEXT(query, true));
    }
    return found;
}

bool trace_any(vec3 origin, vec3 direction, float t_max)
{
    rayQueryEXT query;
    rayQueryInitializeEXT(query, world, gl_RayFlagsTerminateOnFirstHitEXT, 0xff, origin, 0.0, direction, t_max);
    run_query(query);
    return rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
}

#endif
