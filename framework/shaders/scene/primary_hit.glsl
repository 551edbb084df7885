// What a pixel shows, as GBuffer writes it into the "Surface" port and others read it.
#ifndef RESTIRPG_PRIMARY_HIT_GLSL
#define RESTIRPG_PRIMARY_HIT_GLSL

#include "surface.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PrimaryHitArray { PrimaryHit at[]; };

/// The hit of a pixel.
Hit primary_hit(Address surfaces, uint pixel)
{
    WordArray record = record_at(surfaces, pixel, PRIMARY_HIT_BYTES);
    uvec2 ids = uints_of(record, 0u);
    return Hit(ids.x, ids.y, floats_of(record, 1u));
}

/// The shading normal on the camera's side.
vec3 normal_towards(Surface s, vec3 camera)
{
    return dot(s.geometric_normal, camera - s.position) < 0.0 ? -s.shading_normal : s.shading_normal;
}

/// What pixels are compared by.
struct Appearance {
    vec3 normal;  ///< interpolated, on the camera's side
    float distance;  ///< from the camera, m
};

Appearance appearance(Surface s, vec3 camera)
{
    return Appearance(normal_towards(s, camera), distance(s.position, camera));
}

/// That of a pixel's surface in the frame of the "Surface" port.
Appearance load_appearance(Address surfaces, uint pixel)
{
    uvec2 word = uints_of(record_at(surfaces, pixel, PRIMARY_HIT_BYTES), 2u);
    return Appearance(unpack_direction(word.x), uintBitsToFloat(word.y));
}

PrimaryHit make_primary_hit(Hit hit, Surface s, vec3 camera)
{
    Appearance seen = appearance(s, camera);
    return PrimaryHit(hit, pack_direction(seen.normal), seen.distance);
}

#endif
