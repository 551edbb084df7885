// The normal distribution on the plane. A covariance is written (xx, yy, xy), its Cholesky factor (L11, L21, L22).
#ifndef RESTIRPG_GAUSSIAN_GLSL
#define RESTIRPG_GAUSSIAN_GLSL

#include "prelude.glsl"

/// The covariance with its eigenvalues clamped, its axes kept.
vec3 clamp_covariance(vec3 covariance, float smallest, float largest)
{
    float centre = 0.5 * (covariance.x + covariance.y);
    vec2 deviator = vec2(0.5 * (covariance.x - covariance.y), covariance.z);
    float radius = length(deviator);
    vec2 eigenvalues = clamp(vec2(centre - radius, centre + radius), smallest, largest);
    vec2 axis = radius > 0.0 ? deviator / radius : vec2(0.0);
    vec2 kept = 0.5 * (eigenvalues.y - eigenvalues.x) * axis;
    float middle = 0.5 * (eigenvalues.x + eigenvalues.y);
    return vec3(middle + kept.x, middle - kept.x, kept.y);
}

/// The factor L of a positive definite covariance.
vec3 cholesky_factor(vec3 covariance)
{
    float l11 = sqrt(covariance.x);
    float l21 = covariance.z / l11;
    return vec3(l11, l21, sqrt(covariance.y - l21 * l21));
}

/// Density over the plane.
float gaussian_pdf(vec2 x, vec2 mean, vec3 factor)
{
    vec2 d = x - mean;
    float a = d.x / factor.x;
    float b = (d.y - factor.y * a) / factor.z;
    return 0.5 * INV_PI / (factor.x * factor.z) * exp(-0.5 * (a * a + b * b));
}

/// A point with density gaussian_pdf. Box & Muller 1958.
vec2 sample_gaussian(vec2 mean, vec3 factor, vec2 u)
{
    float r = sqrt(-2.0 * log(1.0 - u.x));
    float phi = 2.0 * PI * u.y;
    vec2 n = r * vec2(cos(phi), sin(phi));
    return mean + vec2(factor.x * n.x, factor.y * n.x + factor.z * n.y);
}

#endif
