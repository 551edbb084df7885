// The hemisphere about +z as a unit square, equal areas to equal areas: the concentric map of Shirley & Chiu 1997 to the disk, then
// Lambert's azimuthal equal-area projection. A density over the square is 2 pi times that over solid angle.
#ifndef RESTIRPG_HEMISPHERE_SQUARE_GLSL
#define RESTIRPG_HEMISPHERE_SQUARE_GLSL

#include "sampling.glsl"

/// The place in the unit square of a point of the unit disk: the inverse of sample_disk.
vec2 square_of_disk(vec2 p)
{
    bool wide = abs(p.x) > abs(p.y);
    float radius = length(p) * sign(wide ? p.x : p.y);
    float angle = 4.0 * INV_PI * atan(wide ? p.y / p.x : p.x / (p.y == 0.0 ? 1.0 : p.y));
    return 0.5 + 0.5 * radius * (wide ? vec2(1.0, angle) : vec2(angle, 1.0));
}

/// The unit direction at a place of the unit square; z >= 0 but for rounding.
vec3 hemisphere_of_square(vec2 place)
{
    vec2 p = sample_disk(place);
    float r2 = dot(p, p);
    return vec3(p * sqrt(max(2.0 - r2, 0.0)), 1.0 - r2);
}

/// The place of a unit direction of the upper hemisphere.
vec2 square_of_hemisphere(vec3 w)
{
    return square_of_disk(w.xy * inversesqrt(1.0 + w.z));
}

#endif
