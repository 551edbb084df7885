// The Jacobian that a shift claims, against finite differences. Of each rough replayed bounce the random numbers are varied, of the
// edge that reconnects its end; what the directions then span, in the image's domain over that in the path's own, is the bounce's part of
// the Jacobian, whose matrix is block triangular. Its measure is the one that the shift's f is in: a solid angle counts as many times as f
// has been divided by. Delta bounces and copied directions count 1.
// Writes kind, measured over claimed Jacobian, the claimed one, and whether there was one.
#version 460
#include "prelude.glsl"
#include "probe.glsl"

/// Step of the differences: of a random number, or of a place in units of the distance it is seen from. Float32 leaves 1e-5 of such a
/// difference in doubt, the third derivatives 1e-4.
const float STEP = 0.01;
const vec2 OFFSETS[4] = vec2[](vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0));

/// Solid angle a unit of what is varied, by central differences of step h.
float density(vec3 directions[4], vec2 h)
{
    return length(cross(directions[0] - directions[1], directions[2] - directions[3])) / (4.0 * h.x * h.y);
}

/// Of the directions of a rough bounce at p over its random numbers; 0: some of them give none.
float replayed_density(PathReservoir r, uint bounce, ShadingPoint p)
{
    uint lobes = label_lobes(p.bsdf, path_label(r.labels, bounce));
    vec2 numbers = random2(RandomKey(r.pixel, r.frame, frame.c.seed), bounce, RANDOM_DIRECTION);
    vec2 h = STEP * min(vec2(1.0), 2.0 * min(numbers, 1.0 - numbers));
    vec3 directions[4];
    for (uint i = 0u; i < 4u; ++i) {
        BsdfSample s = bsdf_sample_lobe(p.bsdf, p.wo, lobes, numbers + h * OFFSETS[i]);
        if (s.pdf <= 0.0)
            return 0.0;
        directions[i] = s.wi;
    }
    return density(directions, h);
}

/// The density that a shift divides the value of a replayed bounce by: f |cos| over what the bounce, from where `path` stands, is in f.
float measure_of_bounce(PathReservoir r, uint bounce, PartialPath path)
{
    ShadingPoint p = path.point;
    path.f = vec3(1.0);
    if (!replay_bounce(r, bounce, path))
        return 0.0;
    vec3 local = to_local(p.local_frame, path.wi);
    vec3 value = bsdf_eval(p.bsdf, p.wo, local, label_lobes(p.bsdf, path_label(r.labels, bounce))) * abs(local.z);
    return luminance(value) / luminance(path.f);
}

/// Of the directions from p to the place where the path reconnects. Punctual lights have no place to vary: 1.
float connected_density(PathReservoir r, ShadingPoint p)
{
    if (kind_of_end(r) == END_PUNCTUAL)
        return 1.0;
    vec2 place = r.place;
    vec2 h = vec2(STEP);
    if (r.anchor.x != INVALID_INDEX) {
        WorldTriangle t = world_triangle(r.anchor.x, r.anchor.y);
        h *= distance(p.position, t.p0 + place.x * t.edge1 + place.y * t.edge2) / vec2(length(t.edge1), length(t.edge2));
    }
    vec3 directions[4];
    for (uint i = 0u; i < 4u; ++i) {
        r.place = place + h * OFFSETS[i];
        directions[i] = connection_direction(r, p);
    }
    return density(directions, h);
}

/// Of all bounces that a shift makes anew in the domain x1: the product, for each depends on those before it. 0: not to be had.
float path_density(PathReservoir r, ShadingPoint x1)
{
    uint replayed = replayed_bounces(r);
    uint last = reconnection_index(r) > 0u ? replayed + 1u : replayed;
    float product = 1.0;
    for (uint u = 1u; u <= last; ++u) {
        if (u <= replayed && (path_label(r.labels, u) == LABEL_SMOOTH || is_delta_bounce(r, u)))
            continue;
        PartialPath path;
        if (!replay(r, x1, u - 1u, path))
            return 0.0;
        product *= u <= replayed ? replayed_density(r, u, path.point) * measure_of_bounce(r, u, path) : connected_density(r, path.point);
    }
    return product;
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    PathReservoir path, image;
    ShadingPoint here, there;
    vec4 result = vec4(0.0);
    float claimed;
    if (load_case(at, path, here, there) && shift_to(path, there, image, claimed)) {
        ShadingPoint domains[2] = ShadingPoint[](here, there);
        float densities[2];
        for (uint i = 0u; i < 2u; ++i)  // one place of the code, not two: compilers copy it
            densities[i] = path_density(path, domains[i]);
        float measured = densities[0] > 0.0 ? densities[1] / densities[0] : 0.0;
        bool canonical;
        result = vec4(float(inspect(path, here, canonical)), measured / claimed, claimed, measured > 0.0 ? 1.0 : 0.0);
    }
    Vec4Array(params.result).at[pixel] = result;
}
