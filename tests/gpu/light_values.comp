// Lights and the environment at points and directions that the host chose.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "light_case.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer QueryArray { LightQuery at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ValuesArray { LightValues at[]; };

void main()
{
    frame = FrameRef(test.frame);
    uint index = gl_GlobalInvocationID.x;
    LightQuery query = QueryArray(test.inputs).at[index];
    LightValues values;
    values.environment = environment_radiance(query.direction);
    values.uv = environment_uv(query.direction);
    values.roundTrip = environment_direction(values.uv);
    Light light = LightArray(SCENE.lights).at[query.light];
    LightSample s = connect_punctual_light(query.light, light, query.x);
    if (light.type == LIGHT_TRIANGLE)
        s = connect_triangle_light(query.light, light, query.barycentrics, query.x);
    values.wi = s.wi;
    values.distance = s.distance;
    values.radiance = s.radiance;
    values.pdf = s.pdf;
    ValuesArray(test.results).at[index] = values;
}
