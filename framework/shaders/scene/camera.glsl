// Pinhole camera.
#ifndef RESTIRPG_CAMERA_GLSL
#define RESTIRPG_CAMERA_GLSL

#include "prelude.glsl"

/// Unit direction seen through a point of the pixel plane (pixels from the top left).
vec3 camera_direction(Camera camera, vec2 point, vec2 size)
{
    vec2 ndc = vec2(2.0 * point.x / size.x - 1.0, 1.0 - 2.0 * point.y / size.y);
    return normalize(camera.forward + ndc.x * camera.right + ndc.y * camera.up);
}

/// Where the camera sees what lies in direction d, of any length: pixel-plane point in xy (pixels from the top left), depth along forward in
/// z (negative: behind).
vec3 camera_project_direction(Camera camera, vec3 d, vec2 size)
{
    float z = dot(d, camera.forward);
    vec2 ndc = vec2(dot(d, camera.right) / dot(camera.right, camera.right), dot(d, camera.up) / dot(camera.up, camera.up)) / z;
    return vec3((0.5 + 0.5 * ndc.x) * size.x, (0.5 - 0.5 * ndc.y) * size.y, z);
}

/// Where the camera sees the point x.
vec3 camera_project(Camera camera, vec3 x, vec2 size)
{
    return camera_project_direction(camera, x - camera.position, size);
}

#endif
