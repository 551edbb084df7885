// Fresnel reflectance.
#ifndef RESTIRPG_FRESNEL_GLSL
#define RESTIRPG_FRESNEL_GLSL

/// Exact, unpolarised, dielectric. `cosine` >= 0 on the incident side; eta = n_transmitted / n_incident. 1 under total
/// internal reflection.
float fresnel_dielectric(float cosine, float eta)
{
    float sin2_transmitted = (1.0 - cosine * cosine) / (eta * eta);
    float cos_transmitted = sqrt(1.0 - sin2_transmitted);
    float parallel = (eta * cosine - cos_transmitted) / (eta * cosine + cos_transmitted);
    float perpendicular = (cosine - eta * cos_transmitted) / (cosine + eta * cos_transmitted);
    return sin2_transmitted >= 1.0 ? 1.0 : 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

/// Reflectance at normal incidence.
float fresnel_f0(float eta)
{
    float r = (eta - 1.0) / (eta + 1.0);
    return r * r;
}

/// Schlick's weight (1 - cos)^5.
float schlick_weight(float cosine)
{
    float m = clamp(1.0 - cosine, 0.0, 1.0);
    float m2 = m * m;
    return m2 * m2 * m;
}

/// Schlick 1994, from f0 to white at grazing: the metals of glTF.
vec3 fresnel_schlick(vec3 f0, float cosine)
{
    return f0 + (1.0 - f0) * schlick_weight(cosine);
}

/// The direction refracted at h (unit, dot(w, h) > 0); eta = n_transmitted / n_incident. false: total internal
/// reflection.
bool refract_direction(vec3 w, vec3 h, float eta, out vec3 refracted)
{
    float cosine = dot(w, h);
    float sin2_transmitted = max(1.0 - cosine * cosine, 0.0) / (eta * eta);
    refracted = vec3(0.0);
    if (sin2_transmitted >= 1.0)
        return false;
    refracted = normalize((cosine / eta - sqrt(1.0 - sin2_transmitted)) * h - w / eta);
    return true;
}

#endif
