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
    PathReservoir image, back;
    float jacobian, inverse;
    bool has_image = shift_to(path, there, image, jacobian);
    uint kind;
    bool canonical = true;
    PathReservoir inspected = path;
    ShadingPoint domain = here;
    for (uint i = 0u; i < (has_image ? 2u : 1u); ++i) {  // one place of the code, not two: compilers copy it
        bool filed;
        uint found = inspect(inspected, domain, filed);
        kind = i == 0u ? found : kind;
        canonical = canonical && filed;
        inspected = image;
        domain = there;
    }
    if (!canonical)
        return vec4(kind, 0.0, 0.0, TRIP_MISFILED);
    if (!has_image)
        return vec4(kind, 0.0, 0.0, TRIP_NO_IMAGE);
    if (!shift_to(image, here, back, inverse))
        return vec4(kind, 0.0, 0.0, TRIP_LOST);
    float f_error = difference(path.f, back.f);
    if (params.way == WAY_STAY) {
        // Here the image is the path, and J alone has to be 1.
        f_error = max(f_error, difference(path.f, image.f));
        inverse = 1.0;
    }
    return vec4(kind, f_error, abs(jacobian * inverse - 1.0), same_path(path, back) ? TRIP_RETURNED : TRIP_CHANGED);
}

void main()
{
    frame = FrameRef(params.frame);
    uvec2 at = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(at, frame.c.size)))
        return;
    PathReservoir path;
    ShadingPoint here, there;
    vec4 result = vec4(0.0, 0.0, 0.0, TRIP_NO_PATH);
    if (load_case(at, path, here, there))
        result = round_trip(path, here, there);
    Vec4Array(params.result).at[at.y * frame.c.size.x + at.x] = result;
}
