// The BSDF at directions that the host chose.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "prelude.glsl"
#include "bsdf_case.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PairArray { DirectionPair at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ValuesArray { BsdfValues at[]; };

void main()
{
    Bsdf b = test_bsdf();
    DirectionPair pair = PairArray(test.inputs).at[gl_GlobalInvocationID.x];
    BsdfValues values;
    values.f = bsdf_eval(b, pair.wo, pair.wi, test.lobe);
    values.pdf = bsdf_pdf(b, pair.wo, pair.wi, test.lobe);
    values.probabilities = bsdf_lobe_probabilities(b, pair.wo);
    values.pdfSum = 0.0;
    for (uint lobe = LOBE_DIFFUSE; lobe <= LOBE_TRANSMIT; lobe <<= 1u)
        if ((lobe & test.lobe) != 0u)
            values.pdfSum += bsdf_lobe_probability(b, pair.wo, lobe) * bsdf_lobe_pdf(b, pair.wo, pair.wi, lobe);
    values.labelPdfSum = 0.0;
    for (uint label = LABEL_SMOOTH; label <= LABEL_SHARP_TRANSMIT; ++label) {
        values.labelProbabilities[label] = label_probability(b, pair.wo, label);
        values.labelPdfSum += values.labelProbabilities[label] * label_pdf(b, pair.wo, pair.wi, label);
    }
    ValuesArray(test.results).at[gl_GlobalInvocationID.x] = values;
}
