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
    uint lobes = 0u;
    for (uint lobe = LOBE_DIFFUSE; lobe <= LOBE_TRANSMIT; lobe <<= 1u)
        if ((b.lobes & lobe) != 0u && label_of_lobe(b, lobe) == label)
            lobes |= lobe;
    return lobes;
}

/// P(label | x, wo): a function of the BSDF and wo only.
float label_probability(Bsdf b, vec3 wo, uint label)
{
    return dot(bsdf_lobe_probabilities(b, wo), lobe_flags(label_lobes(b, label)));
}

/// Density of a draw within a label: bsdf_pdf restricted to its lobes and renormalised, 1/sr. Delta labels: 0.
float label_pdf(Bsdf b, vec3 wo, vec3 wi, uint label)
{
    float probability = label_probability(b, wo, label);
    return probability > 0.0 ? bsdf_pdf(b, wo, wi, label_lobes(b, label)) / probability : 0.0;
}

#endif
