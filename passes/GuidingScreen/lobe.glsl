// A pixel's lobe: its frame, density and sampler.
#ifndef RESTIRPG_SCREEN_LOBE_GLSL
#define RESTIRPG_SCREEN_LOBE_GLSL

#include "Shared.h"
#include "math/gaussian.glsl"
#include "math/hemisphere_square.glsl"
#include "math/vmf.glsl"

/// No surface of a scene is likely to be normal to this.
const vec3 UNLIKELY_NORMAL = vec3(0.47, -0.63, 0.618);

/// The frame about n in which places in the square are meant. It is continuous in n but at +-UNLIKELY_NORMAL, where make_frame breaks
/// along a great circle that the walls of most rooms lie on: moments are carried from one frame to the next in it.
mat3 screen_frame(vec3 n)
{
    vec3 t = cross(UNLIKELY_NORMAL, n);
    if (dot(t, t) < 1e-6)
        return make_frame(n);
    t = normalize(t);
    return mat3(t, cross(n, t), n);
}

/// A lobe in its place: the distribution of world-space directions.
struct PlacedLobe {
    ScreenLobe lobe;
    mat3 local_frame;  ///< z: the geometric normal on wo's side
    vec3 centre;  ///< mean direction, world space
};

PlacedLobe place_lobe(ScreenLobe lobe, vec3 normal)
{
    PlacedLobe p;
    p.lobe = lobe;
    p.local_frame = screen_frame(normal);
    p.centre = to_world(p.local_frame, hemisphere_of_square(lobe.mean));
    return p;
}

/// Density of the unit direction w, 1/sr. That of a Gaussian integrates to less than 1: what lies outside of the square is lost.
float lobe_pdf(PlacedLobe p, vec3 w)
{
    if (p.lobe.kind == SCREEN_LOBE_VMF)
        return vmf_pdf(w, p.centre, p.lobe.spread.x);
    vec3 local = to_local(p.local_frame, w);
    if (local.z <= 0.0)
        return 0.0;
    return gaussian_pdf(square_of_hemisphere(local), p.lobe.mean, p.lobe.spread) * (0.5 * INV_PI);
}

/// A unit direction with density lobe_pdf; 0: the draw fell outside of the square.
vec3 sample_lobe(PlacedLobe p, vec2 u)
{
    if (p.lobe.kind == SCREEN_LOBE_VMF)
        return sample_vmf(p.centre, p.lobe.spread.x, u);
    vec2 place = sample_gaussian(p.lobe.mean, p.lobe.spread, u);
    if (any(lessThan(place, vec2(0.0))) || any(greaterThan(place, vec2(1.0))))
        return vec3(0.0);
    return to_world(p.local_frame, hemisphere_of_square(place));
}

#endif
