#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "scene/camera.glsl"
#include "scene/environment.glsl"
#include "scene/lights.glsl"
#include "bsdf/transmittance.glsl"
#include "math/random.glsl"
#include "scene/primary_hit.glsl"
#include "trace/trace.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { GBufferParameters params; };

/// From where a point is on the pixel plane to where camera_project found it in the frame before. NaN where it was behind the camera: there
/// the projection is that of its mirror image.
vec2 motion_to(vec3 before, vec2 now)
{
    return before.z > 0.0 ? before.xy - now : vec2(uintBitsToFloat(0x7fc00000u));
}

vec2 motion_of(Hit hit, vec3 position, vec2 size)
{
    vec3 now = camera_project(frame.c.camera, position, size);
    vec3 before = camera_project(frame.c.previousCamera, load_surface(hit, true).position, size);
    return motion_to(before, now.xy);
}

void write_surface(uint pixel, Hit hit, vec3 direction, vec2 size)
{
    Surface surface = load_surface(hit, false);
    ShadingPoint point = shade_surface(surface, -direction);
    if (params.surface != 0ul)
        PrimaryHitArray(params.surface).at[pixel] = make_primary_hit(hit, surface, frame.c.camera.position);
    if (params.emission != 0ul)
        Vec3Image(params.emission).at[pixel] = triangle_emission(hit.instance, hit.triangle, hit.barycentrics, point.front) *
                                               transmittance_to_camera(point, frame.c.camera.position);
    if (params.normal != 0ul)
        Vec3Image(params.normal).at[pixel] = point.local_frame[2];
    if (params.geometricNormal != 0ul)
        Vec3Image(params.geometricNormal).at[pixel] = point.normal;
    if (params.albedo != 0ul)
        Vec3Image(params.albedo).at[pixel] = point.base_color;
    if (params.depth != 0ul)
        FloatImage(params.depth).at[pixel] = dot(surface.position - frame.c.camera.position, frame.c.camera.forward);
    if (params.motion != 0ul)
        Vec2Image(params.motion).at[pixel] = motion_of(hit, surface.position, size);
    if (params.material != 0ul)
        FloatImage(params.material).at[pixel] = float(surface.material);
}

void write_miss(uint pixel, Hit hit, vec3 direction, vec2 point, vec2 size)
{
    if (params.surface != 0ul)
        PrimaryHitArray(params.surface).at[pixel] = PrimaryHit(hit, 0u, 0.0);
    if (params.emission != 0ul)
        Vec3Image(params.emission).at[pixel] = environment_radiance(direction);
    if (params.normal != 0ul)
        Vec3Image(params.normal).at[pixel] = vec3(0.0);
    if (params.geometricNormal != 0ul)
        Vec3Image(params.geometricNormal).at[pixel] = vec3(0.0);
    if (params.albedo != 0ul)
        Vec3Image(params.albedo).at[pixel] = vec3(0.0);
    if (params.depth != 0ul)
        FloatImage(params.depth).at[pixel] = 0.0;
    if (params.motion != 0ul) {
        // Infinitely far: only the camera's rotation moves it.
        vec3 before = camera_project_direction(frame.c.previousCamera, direction, size);
        Vec2Image(params.motion).at[pixel] = motion_to(before, point);
    }
    if (params.material != 0ul)
        FloatImage(params.material).at[pixel] = -1.0;
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    vec2 size = vec2(frame.c.picture);
    vec2 inside = vec2(0.5);
    if (params.jitter != 0u)
        inside = random2(random_key(picture_pixel(at), frame.c.frame, frame.c.seed), 0u, RANDOM_PIXEL);
    vec2 point = vec2(picture_pixel(at)) + inside;
    vec3 direction = camera_direction(frame.c.camera, point, size);

    Hit hit;
    float t;
    bool found = trace_closest(frame.c.camera.position, direction, RAY_INFINITY, hit, t);
    if (found)
        write_surface(pixel, hit, direction, size);
    else
        write_miss(pixel, hit, direction, point, size);
}
