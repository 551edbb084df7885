// Invariants of sampling.glsl that hold for every input: the worst violation over many.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "math/random.glsl"
#include "math/sampling.glsl"
#include "sampling_case.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Parameters { SamplingCase test; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer WorstRef { SamplingWorst w; };

/// Unit directions all over the sphere, with a good share within 1e-3 of the poles, where frames are hard.
vec3 direction(vec4 u)
{
    vec3 d = sample_sphere(u.xy);
    if (u.z < 0.3)
        d = normalize(vec3(1e-3 * d.xy, u.w < 0.5 ? -1.0 : 1.0));
    return u.z < 0.01 ? vec3(0.0, 0.0, u.w < 0.5 ? -1.0 : 1.0) : d;
}

float frame_error(mat3 m, vec3 n)
{
    mat3 gram = transpose(m) * m - mat3(1.0);
    float worst = max(max(length(gram[0]), length(gram[1])), length(gram[2]));
    worst = max(worst, abs(determinant(m) - 1.0));
    return max(worst, length(m[2] - n));
}

void main()
{
    WorstRef worst = WorstRef(test.results);
    RandomKey key = random_key(uvec2(gl_GlobalInvocationID.x, 0u), 0u, 11u);
    vec4 u = random4(key, 0u, 0u);
    vec3 n = direction(u);
    mat3 m = make_frame(n);
    atomicMax(worst.w.basis, floatBitsToUint(frame_error(m, n)));
    vec3 w = sample_sphere(random2(key, 0u, 1u));
    atomicMax(worst.w.roundTrip, floatBitsToUint(length(to_world(m, to_local(m, w)) - w)));
    vec3 c = sample_cosine_hemisphere(random2(key, 0u, 2u));
    atomicMax(worst.w.cosineLength, floatBitsToUint(c.z > 0.0 ? abs(length(c) - 1.0) : 1.0));

    // The largest numbers there are must still select a column that exists.
    vec2 largest = vec2(1.0 - 1.0 / 16777216.0);
    uint columns = u.w < 0.5 ? 1u + uint(u.z * 16777215.0) : 1u + uint(u.z * 4294967040.0);
    AliasDraw last = draw_alias(columns, largest);
    AliasDraw first = draw_alias(columns, vec2(0.0));
    AliasDraw any_draw = draw_alias(columns, u.xy);
    bool right = last.column == columns - 1u && last.fraction < 1.0 && first.column == 0u && first.fraction == 0.0;
    right = right && any_draw.column < columns && any_draw.fraction >= 0.0 && any_draw.fraction < 1.0;
    // Column and fraction are the number itself, in units of columns.
    float position = (float(any_draw.column) + any_draw.fraction) / float(columns);
    atomicMax(worst.w.alias, floatBitsToUint(right ? abs(position - u.x) : 1.0));
}
