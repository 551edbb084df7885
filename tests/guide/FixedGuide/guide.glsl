#include "FixedGuideShared.h"
#include "math/vmf.glsl"

#define Guide FixedGuideLobe
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LobeBuffer { FixedGuideLobe lobe; };

bool guide_lookup(Address guide, GuideQuery query, out Guide g)
{
    g = LobeBuffer(guide).lobe;
    return true;
}

vec3 guide_sample(Guide g, vec3 u)
{
    return sample_vmf(g.mu, g.kappa, u.xy);
}

#ifndef DENSITY_FACTOR
#define DENSITY_FACTOR 1.0
#endif

float guide_pdf(Guide g, vec3 w)
{
    return DENSITY_FACTOR * vmf_pdf(w, g.mu, g.kappa);
}

float guide_alpha(Guide g, float alpha)
{
    return alpha;
}
