// Which pixels a pixel merges with. By G-buffer and random numbers alone: a choice that looked at the reservoirs would be biased.
#ifndef RESTIRPG_RESTIR_DI_PARTICIPANTS_GLSL
#define RESTIRPG_RESTIR_DI_PARTICIPANTS_GLSL

#include "merge.glsl"

vec3 normal_towards(Surface s, vec3 camera)
{
    return dot(s.geometric_normal, camera - s.position) < 0.0 ? -s.shading_normal : s.shading_normal;
}

/// Do two surfaces, as the camera sees them, look alike enough that sharing light between them pays?
bool is_similar(Surface a, Surface b, vec3 camera, float normal_threshold, float depth_threshold)
{
    float depth = distance(a.position, camera);
    return dot(normal_towards(a, camera), normal_towards(b, camera)) >= normal_threshold &&
           abs(depth - distance(b.position, camera)) <= depth_threshold * depth;
}

/// Add the pixel that showed this surface in the frame before, when there is one. Of the four pixels around the reprojected point,
/// one by the bilinear weights.
void add_previous(ReSTIRDIParameters params, RandomKey key, uvec2 at, Hit hit, vec2 motion)
{
    vec2 u = random2(key, RANDOM_PARTICIPANTS + TEMPORAL_ROUND, 0u);
    vec2 found = floor(vec2(at) + motion + u);
    if (any(lessThan(found, vec2(0.0))) || any(greaterThanEqual(found, vec2(frame.c.size))) || any(isnan(motion)))
        return;
    uint pixel = uint(found.y) * frame.c.size.x + uint(found.x);
    Hit before = merge.surfaces.at[pixel];
    if (before.instance == INVALID_INDEX)
        return;
    if (!is_similar(load_surface(hit, true), load_surface(before, true), frame.c.previousCamera.position,
                    params.normalThreshold, params.depthThreshold))
        return;
    float confidence = merge.reservoirs.at[pixel].confidence;
    add_neighbour(pixel, min(confidence, params.cap));
}

/// Add up to params.neighbours pixels, uniformly from the disk of params.radius pixels about this one.
void add_around(ReSTIRDIParameters params, RandomKey key, uvec2 at, Hit hit)
{
    Surface centre = load_surface(hit, false);
    for (uint i = 0u; i < params.neighbours; ++i) {
        vec2 u = random2(key, RANDOM_PARTICIPANTS + params.round, i);
        float angle = 2.0 * PI * u.y;
        ivec2 found = ivec2(at) + ivec2(round(params.radius * sqrt(u.x) * vec2(cos(angle), sin(angle))));
        if (any(lessThan(found, ivec2(0))) || any(greaterThanEqual(found, ivec2(frame.c.size))) || found == ivec2(at))
            continue;
        uint pixel = uint(found.y) * frame.c.size.x + uint(found.x);
        Hit there = merge.surfaces.at[pixel];
        if (there.instance == INVALID_INDEX ||
            !is_similar(centre, load_surface(there, false), frame.c.camera.position, params.normalThreshold, params.depthThreshold))
            continue;
        add_neighbour(pixel, merge.reservoirs.at[pixel].confidence);
    }
}

#endif
