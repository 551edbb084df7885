// Carries each pixel's moments over from the frame before, adds that frame's samples of this pixel and of some around it, and fits
// the lobe that guides this frame's paths at their primary hit.
#version 460
#include "prelude.glsl"
#include "fit.glsl"
#include "scene/lights.glsl"
#include "restir/neighbours.glsl"
#include "restir/path_vertex.glsl"
#include "math/random.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { GuidingScreenParameters params; };

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer StatisticsArray { ScreenStatistics at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ScreenLobeArray { ScreenLobe at[]; };

/// The point that a pixel shows, as it stood in the frame before: samples and moments are of that frame.
struct Place {
    Surface surface;
    mat3 local_frame;  ///< z: the geometric normal on the camera's side
};

Place load_place(Hit hit)
{
    Place p;
    p.surface = load_surface(hit, true);
    vec3 n = p.surface.geometric_normal;
    p.local_frame = screen_frame(dot(n, frame.c.previousCamera.position - p.surface.position) < 0.0 ? -n : n);
    return p;
}

/// Did a pixel of the frame before show a surface like this one?
bool find_similar(Place here, uint pixel, out Surface there)
{
    Hit hit = primary_hit(params.previousSurface, pixel);
    if (hit.instance == INVALID_INDEX)
        return false;
    there = load_surface(hit, true);
    return there.material == here.surface.material &&
           is_similar(appearance(here.surface, frame.c.previousCamera.position), load_appearance(params.previousSurface, pixel),
                      params.normalThreshold, params.depthThreshold);
}

/// Take the sample of a pixel's first bounce into the moments, seen from here: towards the point it met.
ScreenStatistics add_sample_of(ScreenStatistics statistics, Place here, Surface there, uint pixel)
{
    GuidingSample s = GuidingSampleArray(params.samples).at[pixel * params.stride];
    if (!is_valid(s.vertex) || s.weight <= 0.0)
        return statistics;
    vec3 w = unpack_direction(s.vertex.direction);
    if (s.distance < INFINITE_DISTANCE) {
        vec3 to = there.position + s.distance * w - here.surface.position;
        float len = length(to);
        if (len <= 0.0)
            return statistics;
        w = to / len;
    }
    if (dot(w, here.local_frame[2]) <= 0.0)
        return statistics;
    float weight = s.weight * (params.product != 0u ? vertex_scatter(s.vertex) : 1.0);
    return add_sample(statistics, params.kind, here.local_frame, w, weight, params.smoothingFloor);
}

/// The pixel's moments after the frame before.
ScreenStatistics gather(Place here, uvec2 at, uint previous)
{
    ScreenStatistics statistics = no_statistics();
    Surface there;
    if (find_similar(here, previous, there)) {
        statistics = StatisticsArray(params.history).at[previous];
        statistics = add_sample_of(statistics, here, there, previous);
    }
    // A walk over the window from a random place in random steps, which have no factor in common with its 24 places, meets none twice.
    const uint STEPS[8] = uint[](1u, 5u, 7u, 11u, 13u, 17u, 19u, 23u);
    vec2 u = random2(random_key(picture_pixel(at), frame.c.frame, frame.c.seed ^ RANDOM_STREAM_SCREEN), 0u, 0u);
    uint place = uint(u.x * float(SCREEN_NEIGHBOURS));
    uint stride = STEPS[uint(u.y * 8.0)];
    ivec2 centre = ivec2(pixel_place(previous));
    for (uint i = 0u; i < params.neighbours; ++i) {
        uint cell = place < SCREEN_NEIGHBOURS / 2u ? place : place + 1u;
        ivec2 found = centre + ivec2(cell % SCREEN_WINDOW, cell / SCREEN_WINDOW) - int(SCREEN_WINDOW / 2u);
        place = (place + stride) % SCREEN_NEIGHBOURS;
        if (any(lessThan(found, ivec2(0))) || any(greaterThanEqual(found, ivec2(frame.c.size))))
            continue;
        uint pixel = pixel_index(uvec2(found));
        if (find_similar(here, pixel, there))
            statistics = add_sample_of(statistics, here, there, pixel);
    }
    return statistics;
}

/// Write what the pass makes for one pixel.
void write_pixel(uint pixel, ScreenStatistics statistics, ScreenLobe lobe, vec3 normal)
{
    if (params.statistics != 0ul)
        StatisticsArray(params.statistics).at[pixel] = statistics;
    if (params.guide != 0ul)
        ScreenLobeArray(params.guide).at[pixel] = lobe;
    bool guidable = lobe.kind != SCREEN_LOBE_NONE;
    PlacedLobe placed = place_lobe(lobe, normal);
    if (params.direction != 0ul)
        Vec3Image(params.direction).at[pixel] = guidable ? 0.5 + 0.5 * placed.centre : vec3(0.0);
    if (params.peak != 0ul)
        FloatImage(params.peak).at[pixel] = guidable ? lobe_pdf(placed, placed.centre) : 0.0;
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    Hit hit = primary_hit(params.surface, pixel);
    ScreenStatistics statistics = no_statistics();
    ScreenLobe lobe = ScreenLobe(SCREEN_LOBE_NONE, vec2(0.0), vec3(0.0));
    vec3 normal = vec3(0.0, 0.0, 1.0);
    if (hit.instance != INVALID_INDEX) {
        Place here = load_place(hit);
        uint previous;
        if (frame.c.reset == 0u && find_previous_pixel(at, Vec2Image(params.motion).at[pixel], vec2(0.5), previous))
            statistics = gather(here, at, previous);
        lobe = fit_lobe(statistics, params.kind, here.local_frame, params.prior, params.regularisation);
        normal = here.local_frame[2];
    }
    write_pixel(pixel, statistics, lobe, normal);
}
