// Counts draws of a lobe over bins of the sphere, or of a window about the lobe's centre.
#version 460
#include "prelude.glsl"
#include "screen_lobe_case.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CountsRef { LobeCounts c; };

/// The bin of a unit direction; BINS: none.
uint bin_of(vec3 w, vec3 centre)
{
    vec2 at = vec2(0.5 + 0.5 * INV_PI * atan(w.y, w.x), atan(length(w.xy), w.z) * INV_PI);
    if (test.zoom > 0.0) {
        vec3 local = to_local(make_frame(centre), w);
        at = 0.5 + 0.5 * local.xy / test.zoom;
        if (local.z <= 0.0 || any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, vec2(1.0))))
            return BINS;
    }
    uvec2 cell = min(uvec2(at * vec2(BIN_COLUMNS, BIN_ROWS)), uvec2(BIN_COLUMNS - 1u, BIN_ROWS - 1u));
    return cell.y * BIN_COLUMNS + cell.x;
}

void main()
{
    Guide g, other;
    CountsRef counts = CountsRef(test.results);
    if (!find_lobe(1u, g) || find_lobe(2u, other))
        return;
    RandomKey key = random_key(uvec2(gl_GlobalInvocationID.x, 0u), 0u, test.seed);
    for (uint k = 0u; k < DRAWS_A_THREAD; ++k) {
        vec4 u = random4(key, k, RANDOM_DIRECTION);
        if (test.error == ERROR_BEND)
            u += 0.05 * u * (u - 1.0);
        vec3 w = guide_sample(g, u.xyz);
        uint bin = w == vec3(0.0) ? BINS : bin_of(w, g.centre);
        if (bin < BINS)
            atomicAdd(counts.c.bins[bin], 1u);
        else
            atomicAdd(counts.c.lost, 1u);
    }
}
