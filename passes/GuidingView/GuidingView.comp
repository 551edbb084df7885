#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "scene/primary_hit.glsl"
#include "guide/guiding_mixture.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { GuidingViewParameters params; };

// What is white in each scale.
const float HIGHEST_LEVEL = 12.0;
const float MOST_SAMPLES = 4096.0;
const float OLDEST = 16.0;

/// Blue, green, yellow, red from 0 to 1.
vec3 heat(float x)
{
    return clamp(vec3(2.0 * x - 0.5, 2.0 - abs(4.0 * x - 2.0), 1.5 - 3.0 * x), 0.0, 1.0);
}

/// log(1 + x), as a fraction of that of the largest value.
float on_log_scale(float x, float largest)
{
    return log(1.0 + x) / log(1.0 + largest);
}

vec3 color_of(uint64_t key, GuidingCell cell)
{
    float kappa = 0.0;
    float weight = 0.0;
    for (uint k = 0u; k < GUIDING_LOBES; ++k) {
        kappa = max(kappa, cell.lobes[k].kappa);
        weight = max(weight, cell.lobes[k].weight);
    }
    switch (params.show) {
    case VIEW_CELL: return 0.2 + 0.8 * unit_floats(pcg4d(uvec4(uint(key), uint(key >> 32u), 1u, 0u))).xyz;
    case VIEW_LEVEL: return heat(float(key_level(key)) / HIGHEST_LEVEL);
    case VIEW_SAMPLES: return heat(on_log_scale(cell.samples, MOST_SAMPLES));
    case VIEW_AGE: return heat(float(cell_age(cell)) / OLDEST);
    case VIEW_KAPPA: return heat(on_log_scale(kappa, LARGEST_VMF_KAPPA));
    case VIEW_WEIGHT: return heat(weight);
    default: return heat(1.0 - cell_alpha(cell));
    }
}

vec3 view(Hit hit)
{
    GuidingHeader header = GuidingHeaderRef(params.guide).at;
    if (hit.instance == INVALID_INDEX || header.capacity == 0u)
        return vec3(0.0);
    Surface s = load_surface(hit, false);
    vec3 normal = shade_surface(s, normalize(frame.c.camera.position - s.position)).normal;
    uint64_t key = guiding_key(header.grid, s.position, face_of(normal), s.material);
    uint slot = find_slot(params.guide, header.capacity, key);
    if (slot == INVALID_INDEX)
        return vec3(0.0);
    GuidingCell cell = guiding_cells(params.guide, header.capacity).at[slot];
    return cell.samples > 0.0 ? color_of(key, cell) : vec3(0.0);
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    Vec3Image(params.image).at[pixel] = view(primary_hit(params.surface, pixel));
}
