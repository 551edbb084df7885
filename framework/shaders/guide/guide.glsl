// The interface of a guide: the functions by which PathTracerGuided samples directions from it. A pass that makes a guide names the
// GLSL file with these functions (PortType::module, interface.h). A kernel that reads the guide is compiled with GUIDED = 1 and with
// that file as guide_module.glsl. The file defines
//
//   struct Guide { ... };                                                  one place's distribution, in registers
//   bool guide_lookup(Address guide, GuideQuery query, out Guide g);       false: no guidance here
//   vec3 guide_sample(Guide g, vec3 u);                                    a unit direction in world space, from three numbers; 0: this
//                                                                          draw has none, and guide_pdf integrates to less than 1
//   float guide_pdf(Guide g, vec3 w);                                      its density, 1/sr, over the whole sphere
//   float guide_alpha(Guide g, float alpha);                               probability of sampling the BSDF instead: what it was given,
//                                                                          the knob of the tracing pass, or what the place has learnt
//
// as pure functions: a lookup must give the same answer wherever it is repeated in a frame.
#ifndef RESTIRPG_GUIDE_GLSL
#define RESTIRPG_GUIDE_GLSL

#include "scene/surface.glsl"

/// Where guidance is asked for.
struct GuideQuery {
    vec3 position;
    vec3 normal;  ///< geometric, on wo's side
    vec3 wo;  ///< world space
    uint material;
    uvec2 pixel;
    uint bounce;  ///< 1: the primary hit
};

#if GUIDED
#include "guide_module.glsl"
#else
struct Guide {
    float unused;
};

bool guide_lookup(Address guide, GuideQuery query, out Guide g)
{
    g = Guide(0.0);
    return false;
}

vec3 guide_sample(Guide g, vec3 u)
{
    return vec3(0.0, 0.0, 1.0);
}

float guide_pdf(Guide g, vec3 w)
{
    return 0.0;
}

float guide_alpha(Guide g, float alpha)
{
    return alpha;
}
#endif

#endif
