// Light from infinitely far away: constant, or an equirectangular texture importance sampled texel by texel.
#ifndef RESTIRPG_ENVIRONMENT_GLSL
#define RESTIRPG_ENVIRONMENT_GLSL

#include "math/sampling.glsl"
#include "scene.glsl"

/// Rotate about +y: z towards x for a positive angle.
vec3 rotate_about_y(vec3 w, float angle)
{
    float c = cos(angle);
    float s = sin(angle);
    return vec3(c * w.x + s * w.z, w.y, c * w.z - s * w.x);
}

/// Texture coordinates of a world direction: u = 0.5 + atan(x, -z) / 2 pi, v = acos(y) / pi, in the environment's own
/// frame.
vec2 environment_uv(vec3 w)
{
    vec3 d = rotate_about_y(w, -SCENE.environmentRotation);
    // atan instead of acos: drivers are allowed coarse inverse cosines, and this one goes into a pdf.
    return vec2(0.5 + atan(d.x, -d.z) * (0.5 * INV_PI), atan(length(d.xz), d.y) * INV_PI);
}

/// The inverse of environment_uv.
vec3 environment_direction(vec2 uv)
{
    float phi = 2.0 * PI * (uv.x - 0.5);
    float theta = PI * uv.y;
    return rotate_about_y(vec3(sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi)), SCENE.environmentRotation);
}

bool has_environment_texture()
{
    return SCENE.environmentTexture != INVALID_INDEX;
}

/// Radiance that arrives from world direction w, W/sr/m^2.
vec3 environment_radiance(vec3 w)
{
    vec3 radiance = SCENE.environmentRadiance;
    if (has_environment_texture())
        radiance *= sample_texture(SCENE.environmentTexture, environment_uv(w)).rgb;
    return radiance;
}

/// Density of sample_environment over world directions, 1/sr. Uniform over the sphere when the environment is constant.
float pdf_environment(vec3 w)
{
    if (SCENE.environmentCells == 0ul)
        return 0.25 * INV_PI;
    vec2 size = vec2(SCENE.environmentSize);
    uvec2 cell = uvec2(min(environment_uv(w) * size, size - 1.0));
    float sine = length(w.xz);  // the rotation about y keeps it
    float density = ImportanceCellArray(SCENE.environmentCells).at[cell.y * SCENE.environmentSize.x + cell.x].pdf;
    // The unit square maps to the sphere with |d(omega) / d(uv)| = 2 pi^2 sin(theta).
    return density / (2.0 * PI * PI * max(sine, 1e-6));
}

/// Draw one of `count` cells of an alias table, from `first` on; its number among them.
uint sample_cell(ImportanceCellArray cells, uint first, uint count, vec2 u)
{
    AliasDraw draw = draw_alias(count, u);
    ImportanceCell cell = cells.at[first + draw.column];
    return draw.fraction < cell.aliasThreshold ? draw.column : cell.alias;
}

/// A world direction by the alias table over texels, uniform within the texel; u selects (two numbers) and places
/// (two).
vec3 sample_environment(vec4 u)
{
    if (SCENE.environmentCells == 0ul)
        return sample_sphere(u.zw);
    uvec2 size = SCENE.environmentSize;
    uint texel = sample_cell(ImportanceCellArray(SCENE.environmentCells), 0u, size.x * size.y, u.xy);
    return environment_direction((vec2(texel % size.x, texel / size.x) + u.zw) / vec2(size));
}

#endif
