#include "scene/fresnel.h"

#include <cmath>

namespace restirpg {

double fresnelDielectric(double cosine, double ior)
{
    if (ior == 1)
        return 0;
    const double inside2 = 1 - (1 - cosine * cosine) / (ior * ior);
    if (inside2 <= 0)
        return 1;
    const double inside = std::sqrt(inside2);
    const double parallel = (ior * cosine - inside) / (ior * cosine + inside);
    const double perpendicular = (cosine - ior * inside) / (cosine + ior * inside);
    return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

float fresnelCoatAverage(float ior)
{
    if (ior == 0)
        return 1.0f / 21;  // of Schlick's (1 - cos)^5
    if (ior == 1)
        return 0;
    const double normal = fresnelDielectric(1, ior);
    // Midpoint rule; 1024 cells agree with 65536 to 1e-6 for every ior from 1.01 to 100.
    constexpr int CELLS = 1024;
    double sum = 0;
    for (int i = 0; i < CELLS; ++i) {
        const double cosine = (i + 0.5) / CELLS;
        sum += 2 * (fresnelDielectric(cosine, ior) - normal) / (1 - normal) * cosine;
    }
    return float(sum / CELLS);
}

}  // namespace restirpg
