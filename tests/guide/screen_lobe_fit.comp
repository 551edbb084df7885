// Fits a lobe to a list of samples.
#version 460
#include "prelude.glsl"
#include "../../passes/GuidingScreen/fit.glsl"
#include "screen_lobe_case.h"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Parameters { FitCase test; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Samples { FitSample at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Result { ScreenLobe lobe; };

void main()
{
    mat3 local_frame = screen_frame(test.normal);
    ScreenStatistics statistics = no_statistics();
    for (uint i = 0u; i < test.count; ++i) {
        FitSample s = Samples(test.samples).at[i];
        statistics = add_sample(statistics, test.kind, local_frame, s.direction, s.weight, test.smoothingFloor);
    }
    Result(test.results).lobe = fit_lobe(statistics, test.kind, local_frame, test.prior, test.regularisation);
}
