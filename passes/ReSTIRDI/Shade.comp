// The light that each reservoir's point sends to the camera. Every merge has seen the point lit from this pixel: no ray
// is needed.
#version 460
#include "prelude.glsl"
#include "push.glsl"
#include "merge.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    LightReservoir r = LightReservoirArray(params.source).at[pixel];
    vec3 radiance = vec3(0.0);
    if (r.ucw > 0.0) {
        ShadingPoint p = load_domain(primary_hit(params.surface, pixel), false).point;
        radiance = r.ucw * direct_contribution(p, edge_to_light(r.point, p.position, false));
    }
    Vec3Image(params.radiance).at[pixel] = radiance;
}
