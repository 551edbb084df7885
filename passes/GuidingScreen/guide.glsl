// The functions of shaders/guide/guide.glsl for GuidingScreen's guide: one lobe per pixel, for the bounce at the primary hit only.
#include "lobe.glsl"

#define Guide PlacedLobe
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ScreenLobeArray { ScreenLobe at[]; };

bool guide_lookup(Address guide, GuideQuery query, out Guide g)
{
    if (query.bounce != 1u)
        return false;
    ScreenLobe lobe = ScreenLobeArray(guide).at[pixel_index(query.pixel)];
    g = place_lobe(lobe, query.normal);
    return lobe.kind != SCREEN_LOBE_NONE;
}

vec3 guide_sample(Guide g, vec3 u)
{
    return sample_lobe(g, u.xy);
}

float guide_pdf(Guide g, vec3 w)
{
    return lobe_pdf(g, w);
}

float guide_alpha(Guide g, float alpha)
{
    return alpha;
}
