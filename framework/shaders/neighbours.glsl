// Which pixels a pixel may merge with, by G-buffer and random numbers alone: a choice that looked at reservoirs would be biased.
#ifndef RESTIRPG_NEIGHBOURS_GLSL
#define RESTIRPG_NEIGHBOURS_GLSL

#include "surface.glsl"

/// The shading normal on the camera's side.
vec3 normal_towards(Surface s, vec3 camera)
{
    return dot(s.geometric_normal, camera - s.position) < 0.0 ? -s.shading_normal : s.shading_normal;
}

/// Do two surfaces, as the camera sees them, look alike enough that sharing samples between them pays?
bool is_similar(Surface a, Surface b, vec3 camera, float normal_threshold, float depth_threshold)
{
    float depth = distance(a.position, camera);
    return dot(normal_towards(a, camera), normal_towards(b, camera)) >= normal_threshold &&
           abs(depth - distance(b.position, camera)) <= depth_threshold * depth;
}

/// Index of the pixel that showed this one's surface in the frame before; false: outside of the image. Of the four pixels around
/// the reprojected point one, by the bilinear weights.
bool find_previous_pixel(uvec2 at, vec2 motion, vec2 u, out uint pixel)
{
    vec2 found = floor(vec2(at) + motion + u);
    pixel = 0u;
    if (any(isnan(motion)) || any(lessThan(found, vec2(0.0))) || any(greaterThanEqual(found, vec2(frame.c.size))))
        return false;
    pixel = uint(found.y) * frame.c.size.x + uint(found.x);
    return true;
}

/// Radius in pixels of this image of a disk of neighbours whose radius is given in pixels of an image of 1080 lines; never so small that no
/// neighbours are left [shaders/README: Sizes relative to the image].
float disk_radius(float radius_at_1080)
{
    const float LEAST_RADIUS = 3.0;
    return max(radius_at_1080 * float(frame.c.size.y) / 1080.0, LEAST_RADIUS);
}

/// Index of a pixel drawn uniformly from the disk about this one, radius in pixels; false: outside of the image, or this one.
bool find_neighbour_pixel(uvec2 at, float radius, vec2 u, out uint pixel)
{
    float angle = 2.0 * PI * u.y;
    ivec2 found = ivec2(at) + ivec2(round(radius * sqrt(u.x) * vec2(cos(angle), sin(angle))));
    pixel = 0u;
    if (any(lessThan(found, ivec2(0))) || any(greaterThanEqual(found, ivec2(frame.c.size))) || found == ivec2(at))
        return false;
    pixel = uint(found.y) * frame.c.size.x + uint(found.x);
    return true;
}

#endif
