// Temporal reuse of one bounce that never reconnects, after which light is met or not: the prefix of a path, alone. What is carried
// from frame to frame is the direction (variant U, what ReSTIRReuse does) or the random numbers that the guided sampler drew it from
// (as Lin et al. 2022 replay them).
// [shaders/README: Why guided directions are copied and not replayed]
#version 460
#include "prelude.glsl"
#include "Shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ReplayParameters params; };

#include "scene/primary_hit.glsl"
#include "scene/lights.glsl"
#include "trace/trace.glsl"
#include "restir/path_vertex.glsl"
#include "../../../passes/PathTracerGuided/vertex.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ReplayReservoirArray { ReplayReservoir at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ImageArray { vec3 at[]; };

const uint BOUNCE = 1u;
const uint RANDOM_STREAM_REPLAY = 0x2545f491u;

/// Light that arrives at the vertex from wi, without bounces.
vec3 incident(Vertex v, vec3 wi)
{
    Hit hit;
    float t;
    if (!trace_closest(leave_surface(ray_end(v.point), wi), wi, RAY_INFINITY, hit, t))
        return environment_radiance(wi);
    ShadingPoint light = shade_surface(load_surface(hit, false), -wi);
    return triangle_emission(hit.instance, hit.triangle, hit.barycentrics, light.front);
}

/// What a reservoir's sample carries here and now; its direction is set to that of this frame's sampler when replayed.
/// Replayed: f / Q in the space of random numbers, else f |cos| in solid angle.
vec3 carried(Vertex v, inout ReplayReservoir r)
{
    if (params.replay != 0u) {
        BsdfSample s = scatter(v, RandomKey(r.pixel, r.frame, frame.c.seed), BOUNCE);
        r.wi = to_world(v.point.local_frame, s.wi);
        return s.pdf > 0.0 && s.weight != vec3(0.0) ? s.weight * incident(v, r.wi) : vec3(0.0);
    }
    vec3 local = to_local(v.point.local_frame, r.wi);
    return local.z > 0.0 ? bsdf_eval(v.point.bsdf, v.point.wo, local, LOBE_ALL) * local.z * incident(v, r.wi) : vec3(0.0);
}

/// This frame's own sample.
ReplayReservoir draw(Vertex v, RandomKey key)
{
    ReplayReservoir r = ReplayReservoir(key.pixel, key.frame, vec3(0.0), 1.0, 1.0);
    BsdfSample s = scatter(v, key, BOUNCE);
    r.wi = to_world(v.point.local_frame, s.wi);
    if (params.replay == 0u)
        r.ucw = s.pdf > 0.0 ? 1.0 / s.pdf : 0.0;
    return r;
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    RandomKey key = random_key(at, frame.c.frame, frame.c.seed);
    ReplayReservoir kept = ReplayReservoir(key.pixel, key.frame, vec3(0.0), 0.0, 1.0);
    vec3 radiance = vec3(0.0);
    GuidingSample bounce = GuidingSample(no_path_vertex(), 0.0, 0.0);
    Hit hit = primary_hit(params.surface, pixel);
    if (hit.instance != INVALID_INDEX) {
        Surface surface = load_surface(hit, false);
        Vertex v = make_vertex(surface, normalize(frame.c.camera.position - surface.position), at, BOUNCE, params.guide, params.alpha);
        kept = draw(v, key);
        vec3 value = carried(v, kept);
        float sum = luminance(value) * kept.ucw;
        if (params.history != 0ul && frame.c.reset == 0u) {
            // A still camera: both domains are this pixel's, under this frame's guide, so that the weights are the confidences' alone.
            ReplayReservoir before = ReplayReservoirArray(params.history).at[pixel];
            float confidence = min(before.confidence, params.cap);
            vec3 value_before = carried(v, before);
            float weight_before = confidence * luminance(value_before) * before.ucw;
            sum = (sum + weight_before) / (1.0 + confidence);
            RandomKey choice = random_key(at, frame.c.frame, frame.c.seed ^ RANDOM_STREAM_REPLAY);
            if (random1(choice, BOUNCE, 0u) * sum * (1.0 + confidence) < weight_before) {
                kept = before;
                value = value_before;
            }
            kept.confidence = 1.0 + confidence;
        }
        kept.ucw = sum > 0.0 ? sum / luminance(value) : 0.0;
        radiance = value * kept.ucw;
        if (sum > 0.0) {
            PathVertex vertex = make_path_vertex(v.point.position, v.point.normal, v.material, kept.wi, 1.0, 1.0);
            bounce = GuidingSample(vertex, 1.0, 1.0);
        }
    }
    if (params.reservoirs != 0ul)
        ReplayReservoirArray(params.reservoirs).at[pixel] = kept;
    if (params.samples != 0ul)
        GuidingSampleArray(params.samples).at[pixel] = bounce;
    ImageArray(params.radiance).at[pixel] = radiance;
}
