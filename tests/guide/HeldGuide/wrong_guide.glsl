// GuidingFit's guide with a density that is 10% too small.
#define guide_pdf right_guide_pdf
#include "../../../passes/GuidingFit/guide.glsl"
#undef guide_pdf

float guide_pdf(Guide g, vec3 w)
{
    return 0.9 * right_guide_pdf(g, w);
}
