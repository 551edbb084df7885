// Integrates the light samplers' pdf (x) and the radiance's luminance (y) over each bin of light_sample.comp. Every
// triangle is intersected by the textbook, and none hides another: next event estimation does not know of visibility.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "light_case.glsl"

const uint SUBDIVISIONS = 64u;

/// Moeller & Trumbore 1997. xy: barycentrics, z: distance; false: no hit.
bool intersect(WorldTriangle t, vec3 origin, vec3 d, out vec3 hit)
{
    vec3 p = cross(d, t.edge2);
    float determinant = dot(t.edge1, p);
    vec3 s = origin - t.p0;
    vec3 q = cross(s, t.edge1);
    hit = vec3(dot(s, p), dot(d, q), dot(t.edge2, q)) / determinant;
    return determinant != 0.0 && hit.x >= 0.0 && hit.y >= 0.0 && hit.x + hit.y <= 1.0 && hit.z > 0.0;
}

vec2 triangles_at(vec3 d)
{
    vec2 sum = vec2(0.0);
    for (uint i = 0u; i < SCENE.instanceCount; ++i) {
        uint count = load_instance(i).triangleCount;
        for (uint k = 0u; k < count; ++k) {
            WorldTriangle t = world_triangle(i, k);
            vec3 hit;
            if (!intersect(t, test.x, d, hit))
                continue;
            vec3 emission = triangle_emission(i, k, hit.xy, dot(t.cross_product, d) < 0.0);
            sum += vec2(light_pdf_triangle(i, k, hit.xy, test.x, test.x + hit.z * d), luminance(emission));
        }
    }
    return sum;
}

void main()
{
    uint bin = gl_GlobalInvocationID.x;
    if (bin >= BINS)
        return;
    frame = FrameRef(test.frame);
    vec2 sum = vec2(0.0);
    for (uint k = 0u; k < SUBDIVISIONS * SUBDIVISIONS; ++k) {
        vec2 inside = (vec2(k % SUBDIVISIONS, k / SUBDIVISIONS) + 0.5) / float(SUBDIVISIONS);
        vec2 at = (vec2(bin % BIN_COLUMNS, bin / BIN_COLUMNS) + inside) / vec2(BIN_COLUMNS, BIN_ROWS);
        float phi = 2.0 * PI * (at.x - 0.5);
        float r = sin(PI * at.y);
        vec3 d = vec3(r * cos(phi), r * sin(phi), cos(PI * at.y));
        vec2 value = test.technique == SAMPLE_LIGHTS ? triangles_at(d) + vec2(light_pdf_environment(d), 0.0)
                                                     : vec2(pdf_environment(d), 0.0);
        value.y += luminance(environment_radiance(d));
        sum += 2.0 * PI * PI * r * value;
    }
    sum /= float(BINS * SUBDIVISIONS * SUBDIVISIONS);
    if (test.error == ERROR_PDF)
        sum.x *= 1.02;
    Vec2Image(test.results).at[bin] = sum;
}
