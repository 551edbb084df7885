// Next event estimation: select a light by power, take a point of it. Every pdf includes the selection's probability.
#ifndef RESTIRPG_LIGHTS_GLSL
#define RESTIRPG_LIGHTS_GLSL

#include "alpha_mask.glsl"
#include "environment.glsl"
#include "math/random.glsl"
#include "triangle.glsl"

/// Distance to what is infinitely far away.
const float INFINITE_DISTANCE = 1e30;

/// A light as seen from a point x. Direct light is f |cos| radiance / pdf when nothing lies between.
struct LightSample {
    vec3 wi;  ///< unit, from x towards the light
    float distance;  ///< m; INFINITE_DISTANCE for directional lights and the environment
    vec3 radiance;  ///< W/sr/m^2; of a delta light: irradiance on a surface facing it, W/m^2
    float pdf;  ///< 1/sr, selection included; of a delta light: the probability of selecting it. 0: no sample
    uint light;  ///< index into the light table
    bool delta;  ///< punctual: scattering can never find it
    vec3 position;  ///< of the point on the light, world space; not set where distance is infinite
    vec3 normal;  ///< geometric, on the front side; -wi for lights without a surface
    float clearance;  ///< as in RayEnd
    vec3 absorption;  ///< sigma_a on x's side of the light's surface, 1/m
    vec2 barycentrics;  ///< of the point on a triangle
};

WorldTriangle world_triangle(uint instance, uint triangle)
{
    Instance placed = load_instance(instance);
    return place_triangle(placed, triangle, placed.objectToWorld);
}

/// What a triangle sends to one side of it.
struct Emission {
    vec3 radiance;  ///< W/sr/m^2
    vec3 absorption;  ///< sigma_a on that side, 1/m: behind the surface of a solid
};

/// What a triangle of a placed mesh emits at a point of it: nothing where an alpha mask takes it away. `front`: to the side its winding faces.
Emission emit_from_triangle(MeshTriangle triangle, vec2 barycentrics, bool front)
{
    uint index = triangle.material & TRIANGLE_MATERIAL;
    PlainMaterial material = load_material(index);
    bool dark = (material.flags & MATERIAL_EMISSIVE) == 0u || (!front && (material.flags & MATERIAL_DOUBLE_SIDED) == 0u);
    if (dark || !passes_alpha_mask(triangle, barycentrics))
        return Emission(vec3(0.0), vec3(0.0));
    Emission e = Emission(material.emission, front ? vec3(0.0) : material.absorption);
    if ((material.flags & MATERIAL_EMISSION_TEXTURED) != 0u)
        e.radiance *= fetch_texture_on(load_map(index, MAP_EMISSIVE), triangle.vertices, barycentrics).rgb;
    return e;
}

Emission emit_from_triangle(uint instance, uint triangle, vec2 barycentrics, bool front)
{
    return emit_from_triangle(load_triangle(load_instance(instance), triangle), barycentrics, front);
}

/// Its radiance alone.
vec3 triangle_emission(uint instance, uint triangle, vec2 barycentrics, bool front)
{
    return emit_from_triangle(instance, triangle, barycentrics, front).radiance;
}

/// Number of the part of a triangle, of side^2 equal ones, that a point lies in. The triangle is cut into upright and inverted small
/// ones along its edges; part y * side + x is the upright one at column x of row y where x + y < side, and the inverted ones fill the
/// other half of the square, turned about its middle.
uint emission_part(vec2 barycentrics, uint side)
{
    ivec2 last = ivec2(int(side) - 1);
    vec2 place = barycentrics * float(side);
    ivec2 cell = clamp(ivec2(floor(place)), ivec2(0), last);
    cell.y = min(cell.y, last.x - cell.x);
    vec2 inside = place - vec2(cell);
    if (inside.x + inside.y > 1.0 && cell.x + cell.y < last.x)
        cell = last - cell;
    return uint(cell.y) * side + uint(cell.x);
}

/// A uniform point of a part.
vec2 sample_part(uint part, uint side, vec2 u)
{
    uvec2 cell = uvec2(part % side, part / side);
    vec2 inside = sample_triangle(u);
    vec2 place = cell.x + cell.y < side ? vec2(cell) + inside : vec2(uvec2(side) - cell) - inside;
    return place / float(side);
}

/// Density with which points of a triangle light are drawn, over that of uniform ones.
float emission_density(Light light, vec2 barycentrics)
{
    if (light.cells == INVALID_INDEX)
        return 1.0;
    return ImportanceCellArray(SCENE.emissionCells).at[light.cells + emission_part(barycentrics, light.cellsASide)].pdf;
}

/// A point of a triangle light: uniform, or where a texture makes it bright.
vec2 sample_emission(Light light, vec4 u)
{
    if (light.cells == INVALID_INDEX)
        return sample_triangle(u.zw);
    vec4 fresh = hashed_numbers(u);
    uint side = light.cellsASide;
    uint part = sample_cell(ImportanceCellArray(SCENE.emissionCells), light.cells, side * side, fresh.xy);
    return sample_part(part, side, fresh.zw);
}

/// Density with which sample_light takes this point of a triangle, selection included, over that of uniform points of the triangle;
/// 0 when it is no light.
float triangle_light_density(uint instance, uint triangle, vec2 barycentrics)
{
    uint base = load_instance(instance).lightMap;
    if (base == INVALID_INDEX)
        return 0.0;
    uint index = UintArray(SCENE.lightOfTriangle).at[base + triangle];
    if (index == INVALID_INDEX)
        return 0.0;
    Light light = LightArray(SCENE.lights).at[index];
    return light.pmf * emission_density(light, barycentrics);
}

/// Uniform density over a triangle's area as seen from x at its point y, 1/sr: d^2 / (A |cos|).
float triangle_solid_angle_pdf(WorldTriangle t, vec3 x, vec3 y)
{
    vec3 d = y - x;
    float distance2 = dot(d, d);
    float facing = abs(dot(t.cross_product, d));
    return facing > 0.0 ? 2.0 * distance2 * sqrt(distance2) / facing : 0.0;
}

/// Density with which sample_light from x takes the point y of a triangle that scattering has hit, 1/sr. For MIS.
float light_pdf_triangle(uint instance, uint triangle, vec2 barycentrics, vec3 x, vec3 y)
{
    float density = triangle_light_density(instance, triangle, barycentrics);
    return density > 0.0 ? density * triangle_solid_angle_pdf(world_triangle(instance, triangle), x, y) : 0.0;
}

/// Density with which sample_light takes the environment in direction wi, 1/sr. For MIS.
float light_pdf_environment(vec3 wi)
{
    if (SCENE.environmentLight == INVALID_INDEX)
        return 0.0;
    return LightArray(SCENE.lights).at[SCENE.environmentLight].pmf * pdf_environment(wi);
}

/// KHR_lights_punctual: smooth fall-off between the cones, squared; 1 for a light that is no spot.
float spot_attenuation(Light light, vec3 wi)
{
    if (light.type != LIGHT_SPOT)
        return 1.0;
    float scale = 1.0 / max(light.cosInner - light.cosOuter, 1e-3);
    float fall_off = clamp((dot(light.direction, -wi) - light.cosOuter) * scale, 0.0, 1.0);
    return fall_off * fall_off;
}

LightSample no_light_sample(uint light)
{
    return LightSample(vec3(0.0, 0.0, 1.0), 0.0, vec3(0.0), 0.0, light, false, vec3(0.0), vec3(0.0, 0.0, -1.0), 0.0, vec3(0.0), vec2(0.0));
}

/// The given point of a triangle light, seen from x.
LightSample connect_triangle_light(uint index, Light light, vec2 barycentrics, vec3 x)
{
    LightSample s = no_light_sample(index);
    Instance placed = load_instance(light.instance);
    MeshTriangle triangle = load_triangle(placed, light.triangle);
    WorldTriangle t = place_triangle(placed, load_corners(triangle.vertices), placed.objectToWorld);
    s.position = point_on(t, barycentrics);
    vec3 d = s.position - x;
    s.distance = length(d);
    if (s.distance <= 0.0)
        return s;
    s.wi = d / s.distance;
    s.normal = normalize(t.cross_product);
    s.clearance = find_clearance(t, placed, s.position, s.normal);
    Emission emission = emit_from_triangle(triangle, barycentrics, dot(s.normal, s.wi) < 0.0);
    s.radiance = emission.radiance;
    s.absorption = emission.absorption;
    s.barycentrics = barycentrics;
    s.pdf = light.pmf * emission_density(light, barycentrics) * triangle_solid_angle_pdf(t, x, s.position);
    return s;
}

/// A punctual light seen from x.
LightSample connect_punctual_light(uint index, Light light, vec3 x)
{
    LightSample s = no_light_sample(index);
    s.delta = true;
    s.pdf = light.pmf;
    s.distance = INFINITE_DISTANCE;
    s.wi = -light.direction;
    s.radiance = light.intensity;
    if (light.type != LIGHT_DIRECTIONAL) {
        s.position = light.position;
        vec3 d = light.position - x;
        float distance2 = dot(d, d);
        if (distance2 <= 0.0)
            return no_light_sample(index);
        s.distance = sqrt(distance2);
        s.wi = d / s.distance;
        s.radiance *= spot_attenuation(light, s.wi) / distance2;
    }
    s.normal = -s.wi;
    return s;
}

/// The environment in direction wi.
LightSample connect_environment(vec3 wi)
{
    vec3 radiance = environment_radiance(wi);
    float pdf = light_pdf_environment(wi);
    return LightSample(wi, INFINITE_DISTANCE, radiance, pdf, SCENE.environmentLight, false, vec3(0.0), -wi, 0.0, vec3(0.0), vec2(0.0));
}

/// The light that two random numbers select, by the power-weighted alias table; INVALID_INDEX: the scene has none.
uint select_light(vec2 u)
{
    if (SCENE.lightCount == 0u)
        return INVALID_INDEX;
    AliasDraw draw = draw_alias(SCENE.lightCount, u);
    Light column = LightArray(SCENE.lights).at[draw.column];
    return draw.fraction < column.aliasThreshold ? draw.column : column.alias;
}

/// One sample of the direct light at x, visibility not tested. u: xy select the light, zw the point on it.
LightSample sample_light(vec3 x, vec4 u)
{
    uint index = select_light(u.xy);
    if (index == INVALID_INDEX)
        return no_light_sample(index);
    Light light = LightArray(SCENE.lights).at[index];
    if (light.type == LIGHT_TRIANGLE)
        return connect_triangle_light(index, light, sample_emission(light, u), x);
    if (light.type != LIGHT_ENVIRONMENT)
        return connect_punctual_light(index, light, x);
    return connect_environment(sample_environment(hashed_numbers(u)));  // a texel, and a place in it
}

#endif
