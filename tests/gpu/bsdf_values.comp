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
    vec3 probabilities = bsdf_lobe_probabilities(b, pair.wo);
    values.pdf = bsdf_pdf(b, probabilities, pair.wo, pair.wi, test.lobe);
    values.probabilities = probabilities;
    values.pdfSum = 0.0;
    for (uint lobe = LOBE_DIFFUSE; lobe <= LOBE_TRANSMIT; lobe <<= 1u)
        if ((lobe & test.lobe) != 0u)
            values.pdfSum += probability_of_lobe(probabilities, lobe) * bsdf_lobe_pdf(b, pair.wo, pair.wi, lobe);
    values.labelPdfSum = 0.0;
    for (uint label = LABEL_SMOOTH; label <= LABEL_SHARP_TRANSMIT; ++label) {
        values.labelProbabilities[label] = label_probability(b, probabilities, label);
        values.labelPdfSum += values.labelProbabilities[label] * label_pdf(b, probabilities, pair.wo, pair.wi, label);
    }
    ValuesArray(test.results).at[gl_GlobalInvocationID.x] = values;
}
