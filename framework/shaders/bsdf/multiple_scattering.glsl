// The light that a rough surface scatters more than once, which single-scattering GGX loses: one more lobe, after Kulla & Conty 2017
// ("Revisiting Physically Based Shading at Imageworks"). Part of bsdf_model.glsl, where RESTIRPG_ENERGY_COMPENSATION is on.
//
//   f = k L(wo) L(wi) / (pi <L>),   L(w) = 1 - (what single scattering returns of light from w), by the tables of energy.glsl
//
// It is a product of one function of each direction, so reciprocity is exact. <L> is L's cosine-weighted mean: with k = 1 a white
// surface returns 1 from every direction. MultipleScattering has k / <L>. It belongs to LOBE_DIFFUSE: drawn by the cosine, above or across. An
// opaque dielectric needs no lobe of it: its base gets all that the coat does not reflect (coat_passage).
#ifndef RESTIRPG_MULTIPLE_SCATTERING_GLSL
#define RESTIRPG_MULTIPLE_SCATTERING_GLSL

const float SMALLEST_LOSS = 1e-6;

/// What the coat takes by single scattering (coat_share), from an entry of the table.
float coat_energy(Bsdf b, vec4 energy)
{
    float coat0 = largest(b.coat0);
    return coat0 * energy.x + (b.coat90 - coat0) * energy.y;
}

/// What a transmitting dielectric loses. A thin sheet mirrors what it transmits, so it loses what a metal loses.
float dielectric_loss(Bsdf b, vec4 energy)
{
    if (!b.solid)
        return 1.0 - energy.x;
    float coat0 = largest(b.coat0);
    float refracted = (1.0 - coat0) * energy.z - (b.coat90 - coat0) * energy.w;
    return max(1.0 - coat_energy(b, energy) - refracted, 0.0);
}

/// k / <L> of light that meets metal facets again and again: k is the series F^2 E / (1 - F <L>), E = 1 - <L> the mean that returns at once.
vec3 metal_factor(Bsdf b, float mean)
{
    vec3 f = b.metal + (1.0 - b.metal) / 21.0;  // Schlick's mean over the hemisphere
    float lost = max(1.0 - mean, SMALLEST_LOSS);
    return b.metallic * f * f * mean / (1.0 - f * lost) / lost;
}

/// Split of a solid's loss. The share X that crosses must satisfy X_near mean(L_near) = eta^2 X_far mean(L_far) for reciprocity;
/// means T of a smooth interface's transmittance satisfy T_near = eta^2 T_far, so X = T min(1, mean(L_far) / mean(L_near)) does.
void split_solid_loss(Bsdf b, float smooth_average, bool inside, inout MultipleScattering multiple)
{
    float near = max(dielectric_loss(b, energy_mean(multiple.table, multiple.near)), SMALLEST_LOSS);
    float far = max(dielectric_loss(b, energy_mean(multiple.table, multiple.far)), SMALLEST_LOSS);
    float transmitted = 1.0 - mix(largest(b.coat0), b.coat90, smooth_average);
    transmitted *= inside ? b.eta * b.eta : 1.0;  // T outside is given
    float crossing = transmitted * min(far / near, 1.0);
    multiple.reflected = vec3((1.0 - crossing) / near);
    multiple.across = vec3(crossing / (far * b.eta * b.eta));
}

MultipleScattering multiple_scattering(Bsdf b, BsdfParameters p, bool inside)
{
    EnergyRows near = energy_rows(inside, p.roughness);
    EnergyRows far = energy_rows(b.solid && !inside, p.roughness);
    MultipleScattering multiple = MultipleScattering(p.energyTable, near, far, vec3(0.0), vec3(0.0), vec3(0.0));
    if (b.alpha == 0.0)
        return multiple;
    float mean = energy_mean(multiple.table, near).x;
    multiple.metal = metal_factor(b, mean);
    float share = (1.0 - p.metallic) * p.transmission;
    if (share == 0.0 || (b.solid && b.eta == 1.0))  // a solid of ior 1 is not there
        return multiple;
    if (b.solid) {
        split_solid_loss(b, p.coatAverage, inside, multiple);
    } else {
        float reflected = pane_fresnel(mix(largest(b.coat0), b.coat90, p.coatAverage));
        float lost = max(1.0 - mean, SMALLEST_LOSS);
        multiple.reflected = vec3(reflected / lost);
        multiple.across = vec3((1.0 - reflected) / lost);
    }
    multiple.reflected *= share;
    multiple.across *= share * p.baseColor;
    return multiple;
}

/// f of the lobe.
vec3 eval_multiple(Bsdf b, vec3 wo, vec3 wi)
{
    if (b.alpha == 0.0)
        return vec3(0.0);
    vec4 o = energy_returned(b.multiple.table, b.multiple.near, wo.z);
    bool above = wi.z > 0.0;
    vec4 i = energy_returned(b.multiple.table, above ? b.multiple.near : b.multiple.far, abs(wi.z));
    vec3 f = (above ? b.multiple.reflected : b.multiple.across) * dielectric_loss(b, o) * dielectric_loss(b, i);
    if (above)
        f += b.multiple.metal * (1.0 - o.x) * (1.0 - i.x);
    return f * INV_PI;
}

/// Luminance that the lobe scatters above (x) and across (y).
vec2 multiple_energy(Bsdf b, vec3 wo)
{
    if (b.alpha == 0.0)
        return vec2(0.0);
    vec4 o = energy_returned(b.multiple.table, b.multiple.near, wo.z);
    vec4 near = energy_mean(b.multiple.table, b.multiple.near);
    float lost = dielectric_loss(b, o);
    vec3 above = b.multiple.metal * (1.0 - o.x) * (1.0 - near.x) + b.multiple.reflected * lost * dielectric_loss(b, near);
    vec3 across = b.multiple.across * lost * dielectric_loss(b, energy_mean(b.multiple.table, b.multiple.far));
    return vec2(luminance(above), luminance(across));
}

/// How often LOBE_DIFFUSE is drawn across the surface.
float across_probability(Bsdf b, vec3 wo)
{
    vec2 multiple = multiple_energy(b, wo);
    float above = luminance(b.diffuse * (1.0 - coat_share(b, coat_cosine(wo.z, b.alpha)))) + multiple.x;
    return multiple.y > 0.0 ? clamp(multiple.y / (above + multiple.y), 0.05, 1.0) : 0.0;
}

#endif
