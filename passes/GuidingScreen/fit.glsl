// From weighted directions to moments, from moments to a lobe [shaders/README: The lobe per pixel].
#ifndef RESTIRPG_SCREEN_FIT_GLSL
#define RESTIRPG_SCREEN_FIT_GLSL

#include "lobe.glsl"

/// Eigenvalues of a Gaussian's covariance in the unit square are clamped to these. The upper one is a little above the uniform
/// distribution's 1/12.
const float SMALLEST_VARIANCE = 1e-4;
const float LARGEST_VARIANCE = 0.1;
/// That of the most concentrated vMF lobe.
const float LARGEST_KAPPA = 1e4;
/// Weights are kept between the inverse of this and this, so that their squares are finite and not zero.
const float LARGEST_WEIGHT = 1e15;

ScreenStatistics no_statistics()
{
    return ScreenStatistics(vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0);
}

/// Take one direction of the upper hemisphere into the means: with the share of a plain mean at first, of a decaying one from
/// 1 / smoothing_floor samples on.
ScreenStatistics add_sample(ScreenStatistics s, uint kind, mat3 local_frame, vec3 w, float weight, float smoothing_floor)
{
    weight = clamp(weight, 1.0 / LARGEST_WEIGHT, LARGEST_WEIGHT);
    vec2 z = square_of_hemisphere(to_local(local_frame, w));
    vec3 first = kind == SCREEN_LOBE_VMF ? w : vec3(z, 0.0);
    vec3 second = kind == SCREEN_LOBE_VMF ? vec3(0.0) : vec3(z * z, z.x * z.y);
    float share = max(1.0 / (s.samples + 1.0), smoothing_floor);
    s.first = mix(s.first, weight * first, share);
    s.second = mix(s.second, weight * second, share);
    s.weight = mix(s.weight, weight, share);
    s.squaredWeight = mix(s.squaredWeight, weight * weight, share);
    s.samples = 1.0 / share;
    return s;
}

/// How far the samples outweigh a prior of so many uniform ones, in [0, 1]. Samples count by their effective number (Kish 1965): one
/// firefly among dim samples is one sample.
float data_share(ScreenStatistics s, float prior)
{
    float effective = s.samples * s.weight * s.weight / s.squaredWeight;
    return effective / (effective + prior);
}

/// Mean and covariance of the samples and the prior, whose moments are those of the uniform square.
ScreenLobe fit_gaussian(ScreenStatistics s, float prior, float regularisation)
{
    float share = data_share(s, prior);
    vec2 mean = mix(vec2(1.0 / 2.0), s.first.xy / s.weight, share);
    vec3 moment = mix(vec3(1.0 / 3.0, 1.0 / 3.0, 1.0 / 4.0), s.second / s.weight, share);
    vec3 covariance = moment - vec3(mean * mean, mean.x * mean.y) + vec3(regularisation, regularisation, 0.0);
    covariance = clamp_covariance(covariance, SMALLEST_VARIANCE, LARGEST_VARIANCE);
    return ScreenLobe(SCREEN_LOBE_GAUSSIAN, mean, cholesky_factor(covariance));
}

/// Mean direction and concentration (Banerjee et al. 2005) of the samples and the prior, whose mean is that of the uniform hemisphere.
/// A variance v of the square is one of 2 pi v sr about the mean, and 1 / kappa is a narrow lobe's variance.
ScreenLobe fit_vmf(ScreenStatistics s, mat3 local_frame, float prior, float regularisation)
{
    vec3 mean = mix(0.5 * local_frame[2], s.first / s.weight, data_share(s, prior));
    float r = length(mean);
    // 1 - r^2 of samples that agree is rounding: the inverse is clamped instead.
    float inverse_kappa = max((1.0 - r * r) / max(r * (3.0 - r * r), 1e-9), 1.0 / LARGEST_KAPPA);
    float kappa = 1.0 / (inverse_kappa + 2.0 * PI * regularisation);
    vec2 place = square_of_hemisphere(to_local(local_frame, r > 0.0 ? mean / r : local_frame[2]));
    return ScreenLobe(SCREEN_LOBE_VMF, place, vec3(kappa < LEAST_KAPPA ? 0.0 : kappa, 0.0, 0.0));
}

/// The lobe of a pixel; kind NONE before it has seen light.
ScreenLobe fit_lobe(ScreenStatistics s, uint kind, mat3 local_frame, float prior, float regularisation)
{
    if (s.weight <= 0.0)
        return ScreenLobe(SCREEN_LOBE_NONE, vec2(0.0), vec3(0.0));
    return kind == SCREEN_LOBE_VMF ? fit_vmf(s, local_frame, prior, regularisation) : fit_gaussian(s, prior, regularisation);
}

#endif
