// A path shifted to another domain and back is the path it was, and the Jacobians of the two ways multiply to 1. Writes kind, largest
// relative difference of f, |J J' - 1|, and how the trip ended.
#version 460
#include "prelude.glsl"
#include "probe.glsl"

/// Largest difference of two spectra, relative to their largest channel.
float difference(vec3 a, vec3 b)
{
    vec3 d = abs(a - b);
    vec3 m = max(abs(a), abs(b));
    return max(d.x, max(d.y, d.z)) / max(m.x, max(m.y, m.z));
}

bool same_path(PathReservoir a, PathReservoir b)
{
    // The light point of a path that is all replayed is found anew: it may lie on the other triangle of an edge.
    bool same_end = a.anchor == b.anchor || reconnection_index(a) == 0u;
    return a.shape == b.shape && a.labels == b.labels && a.prefix == b.prefix && a.direction == b.direction && same_end;
}

vec4 round_trip(PathReservoir path, ShadingPoint here, ShadingPoint there)
{
    PathReservoir moved = path, image;
    ShadingPoint domain = here, other = there;
    uint kind;
    float f_error = 0.0, product = 1.0;
    for (uint leg = 0u; leg < 2u; ++leg) {  // there and back: one place of the code, not two, for compilers copy it
        bool canonical;
        uint found = inspect(moved, domain, canonical);
        kind = leg == 0u ? found : kind;
        if (!canonical)
            return vec4(kind, 0.0, 0.0, TRIP_MISFILED);
        float jacobian;
        if (!shift_to(moved, other, image, jacobian))
            return vec4(kind, 0.0, 0.0, leg == 0u ? TRIP_NO_IMAGE : TRIP_LOST);
        // Where the path stays, its image is the path, and each J alone has to be 1.
        product = params.way == WAY_STAY && leg == 1u ? product : product * jacobian;
        if (params.way == WAY_STAY || leg == 1u)
            f_error = max(f_error, difference(path.f, image.f));
        moved = image;
        domain = there;
        other = here;
    }
    return vec4(kind, f_error, abs(product - 1.0), same_path(path, moved) ? TRIP_RETURNED : TRIP_CHANGED);
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    PathReservoir path;
    ShadingPoint here, there;
    vec4 result = vec4(0.0, 0.0, 0.0, TRIP_NO_PATH);
    if (load_case(at, path, here, there))
        result = round_trip(path, here, there);
    Vec4Array(params.result).at[pixel] = result;
}
