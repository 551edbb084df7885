// Which pixels a pixel may merge with, by G-buffer and random numbers alone: a choice that looked at reservoirs would be biased.
#ifndef RESTIRPG_NEIGHBOURS_GLSL
#define RESTIRPG_NEIGHBOURS_GLSL

#include "restir/neighbour_types.h"
#include "restir/resampling.glsl"
#include "scene/camera.glsl"
#include "math/random.glsl"
#include "scene/primary_hit.glsl"

/// The round of temporal reuse, for random numbers; rounds of spatial reuse count from 0.
const uint TEMPORAL_ROUND = 0xffffu;

/// Where the numbers of a round begin that choose from pools, those of round 0 beginning at `first`: MAX_POOL addresses a neighbour.
uint pool_round(uint first, uint round)
{
    return first + round * (MAX_NEIGHBOURS * MAX_POOL / RANDOM_DIMENSIONS);
}

/// Do two surfaces look alike enough that sharing samples between them pays?
bool is_similar(Appearance a, Appearance b, float normal_threshold, float depth_threshold)
{
    return dot(a.normal, b.normal) >= normal_threshold && abs(a.distance - b.distance) <= depth_threshold * a.distance;
}

/// Where the surface of a pixel is, of which the appearance is known.
vec3 seen_position(uvec2 at, Appearance a)
{
    return frame.c.camera.position + a.distance * camera_direction(frame.c.camera, vec2(picture_pixel(at)) + 0.5, vec2(frame.c.picture));
}

/// How well a pixel's samples serve another one, from 0 to 1 [shaders/README: Compatible neighbours]. It falls to 1/e where the places
/// are an eighth of the distance from the camera apart, or where the normals are 28 degrees apart.
float compatibility(Appearance a, vec3 position_a, Appearance b, vec3 position_b)
{
    const float REACH = 0.126;  // of the distance from the camera
    float n = max(dot(a.normal, b.normal), 0.0);
    n *= n;
    n *= n;
    return n * n * exp(-distance(position_a, position_b) / (REACH * a.distance));
}

/// Index of the pixel that showed this one's surface in the frame before; false: outside of the image, or behind the camera, where motion is
/// NaN. Of the four pixels around the reprojected point one, by the bilinear weights.
bool find_previous_pixel(uvec2 at, vec2 motion, vec2 u, out uint pixel)
{
    vec2 found = floor(vec2(at) + motion + u);
    pixel = 0u;
    if (any(isnan(motion)) || any(lessThan(found, vec2(0.0))) || any(greaterThanEqual(found, vec2(frame.c.size))))
        return false;
    pixel = pixel_index(uvec2(found));
    return true;
}

/// The pixel that showed this one's surface in the frame before, if what it shows is similar.
bool find_history(Address previous_surfaces, Hit hit, uvec2 at, vec2 motion, vec2 u, NeighbourRules rules, out uint pixel)
{
    if (!find_previous_pixel(at, motion, u, pixel) || primary_hit(previous_surfaces, pixel).instance == INVALID_INDEX)
        return false;
    Appearance today = appearance(load_surface(hit, true), frame.c.previousCamera.position);
    return is_similar(today, load_appearance(previous_surfaces, pixel), rules.normalThreshold, rules.depthThreshold);
}

/// Radius in pixels of this image of a disk of neighbours: its share of the height, but never below the least, so that small images have
/// neighbours left [shaders/README: Sizes relative to the image].
float disk_radius(NeighbourRules rules)
{
    return max(rules.radius * float(frame.c.picture.y) / 1080.0, rules.leastRadius);
}

/// Index of a pixel drawn uniformly from the disk about this one, radius in pixels; false: outside of the image, or this one.
bool find_neighbour_pixel(uvec2 at, float radius, vec2 u, out uint pixel)
{
    float angle = 2.0 * PI * u.y;
    ivec2 found = ivec2(at) + ivec2(round(radius * sqrt(u.x) * vec2(cos(angle), sin(angle))));
    pixel = 0u;
    if (any(lessThan(found, ivec2(0))) || any(greaterThanEqual(found, ivec2(frame.c.size))) || found == ivec2(at))
        return false;
    pixel = pixel_index(uvec2(found));
    return true;
}

/// A pixel of the disk about this one, if its surface is similar to this one's.
bool draw_neighbour(Address surfaces, uvec2 at, Appearance centre, NeighbourRules rules, vec2 u, out uint pixel, out Appearance there)
{
    if (!find_neighbour_pixel(at, disk_radius(rules), u, pixel) || primary_hit(surfaces, pixel).instance == INVALID_INDEX)
        return false;
    there = load_appearance(surfaces, pixel);
    return is_similar(centre, there, rules.normalThreshold, rules.depthThreshold);
}

/// Chooses one of rules.pool pixels of the disk in proportion to their compatibility with this one [shaders/README: Compatible neighbours].
/// `address`: of the first of rules.pool random addresses.
bool choose_compatible(Address surfaces, uvec2 at, Appearance centre, NeighbourRules rules, RandomKey key, uint bounce, uint address,
                       out uint pixel)
{
    vec3 position = seen_position(at, centre);
    float sum = 0.0;
    pixel = 0u;
    for (uint k = 0u; k < rules.pool; ++k) {
        vec4 u = random4(key, bounce, address + k);
        uint candidate;
        Appearance there;
        if (!draw_neighbour(surfaces, at, centre, rules, u.xy, candidate, there))
            continue;
        float score = compatibility(centre, position, there, seen_position(pixel_place(candidate), there));
        if (resample(sum, score, u.z))
            pixel = candidate;
    }
    return sum > 0.0;
}

/// Neighbour i of a pixel in a round of spatial reuse, if there is one whose surface is similar. `u` draws it; where there are pools of
/// pixels to choose from, the numbers of `key` from `pools` on do (pool_round).
bool find_neighbour(Address surfaces, uvec2 at, Appearance centre, NeighbourRules rules, uint i, vec2 u, RandomKey key, uint pools,
                    out uint pixel)
{
    Appearance there;
    if (rules.pool > 1u)
        return choose_compatible(surfaces, at, centre, rules, key, pools, i * MAX_POOL, pixel);
    return draw_neighbour(surfaces, at, centre, rules, u, pixel, there);
}

#endif
