// Labels of a bounce [shaders/README: Labels]: all smooth lobes together, or one sharp lobe. A label is drawn first, from the
// BSDF alone, and is part of the path.
#ifndef RESTIRPG_LABELS_GLSL
#define RESTIRPG_LABELS_GLSL

#include "bsdf.glsl"

const uint LABEL_SMOOTH = 0u;
const uint LABEL_SHARP_REFLECT = 1u;
const uint LABEL_SHARP_TRANSMIT = 2u;

uint label_of_lobe(Bsdf b, uint lobe)
{
    if (!bsdf_is_sharp(b, lobe))
        return LABEL_SMOOTH;
    return lobe == LOBE_REFLECT ? LABEL_SHARP_REFLECT : LABEL_SHARP_TRANSMIT;
}

/// The lobes that make up a label here; 0: the label does not exist on this surface.
uint label_lobes(Bsdf b, uint label)
{
    uint sharp = (bsdf_is_sharp(b, LOBE_REFLECT) ? LOBE_REFLECT : 0u) | (bsdf_is_sharp(b, LOBE_TRANSMIT) ? LOBE_TRANSMIT : 0u);
    uint sharp_lobe = sharp & (label == LABEL_SHARP_REFLECT ? LOBE_REFLECT : LOBE_TRANSMIT);
    return b.lobes & (label == LABEL_SMOOTH ? ~sharp : sharp_lobe);
}

/// P(label | x, wo): a function of the BSDF and wo only. `probabilities`: bsdf_lobe_probabilities.
float label_probability(Bsdf b, vec3 probabilities, uint label)
{
    return sum_over_lobes(probabilities, label_lobes(b, label));
}

/// Density of a draw within a label: bsdf_pdf restricted to its lobes and renormalised, 1/sr. Delta labels: 0.
float label_pdf(Bsdf b, vec3 probabilities, vec3 wo, vec3 wi, uint label)
{
    float probability = label_probability(b, probabilities, label);
    return probability > 0.0 ? bsdf_pdf(b, probabilities, wo, wi, label_lobes(b, label)) / probability : 0.0;
}

/// f |cos| of the rough lobes in one direction, label by label.
struct LabelValues {
    vec3 smooth_value;
    vec3 sharp_value;
    uint sharp_label;  ///< whose value that is: of the two only one scatters to this side
};

LabelValues label_values(Bsdf b, vec3 wo, vec3 wi)
{
    LobeValues f = bsdf_lobe_values(b, wo, wi, LOBE_ALL);
    bool reflects = wi.z > 0.0;
    bool sharp = bsdf_is_sharp(b, reflects ? LOBE_REFLECT : LOBE_TRANSMIT);
    vec3 none = vec3(0.0);
    return LabelValues((f.diffuse + (sharp ? none : f.facets)) * abs(wi.z), (sharp ? f.facets : none) * abs(wi.z),
                       reflects ? LABEL_SHARP_REFLECT : LABEL_SHARP_TRANSMIT);
}

vec3 value_of_label(LabelValues values, uint label)
{
    return label == LABEL_SMOOTH ? values.smooth_value : label == values.sharp_label ? values.sharp_value : vec3(0.0);
}

#endif
