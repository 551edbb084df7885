#include "scene/energy_table.h"

#include "scene/fresnel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace restirpg {

namespace {

using glm::dvec3;
using glm::dvec4;

/// How far from F0 to F90 the interface is; Schlick's weight where the index is infinite.
double position(double cosine, double eta)
{
    if (eta == 0)
        return std::pow(1 - cosine, 5);
    const double normal = std::pow((eta - 1) / (eta + 1), 2);
    return (fresnelDielectric(cosine, eta) - normal) / (1 - normal);
}

double smithLambda(double cosine, double alpha)
{
    const double tangent2 = (1 - cosine * cosine) / (cosine * cosine);
    return 0.5 * (std::sqrt(1 + alpha * alpha * tangent2) - 1);
}

/// What one facet, seen at `facetCosine`, returns of both kinds of light.
dvec4 facetReturn(const dvec3& wo, const dvec3& h, double alpha, double eta)
{
    const double o = glm::dot(wo, h), along = position(o, eta), masked = 1 + smithLambda(wo.z, alpha);
    dvec4 sum(0);
    const double reflected = 2 * o * h.z - wo.z;
    if (reflected > 0) {
        const double weight = masked / (masked + smithLambda(reflected, alpha));
        sum += dvec4(weight, weight * along, 0, 0);
    }
    const double cosine2 = eta == 0 ? 0 : 1 - (1 - o * o) / (eta * eta);
    if (cosine2 > 0) {
        const double refracted = (o / eta - std::sqrt(cosine2)) * h.z - wo.z / eta;
        if (refracted < 0) {
            const double weight = masked / (masked + smithLambda(-refracted, alpha));
            sum += dvec4(0, 0, weight, weight * along);
        }
    }
    return sum;
}

/// The directional integral: the mean over the normals visible from a cosine (Dupuy & Benyoub 2023), half of the
/// circle.
dvec4 directional(double cosine, double alpha, double eta)
{
    constexpr int AROUND = 32, ALONG = 64;
    const dvec3 wo(std::sqrt(1 - cosine * cosine), 0, cosine);
    const dvec3 stretched = glm::normalize(dvec3(alpha * wo.x, 0, wo.z));
    dvec4 sum(0);
    for (int i = 0; i < AROUND; ++i)
        for (int j = 0; j < ALONG; ++j) {
            const double phi = std::numbers::pi * (i + 0.5) / AROUND;
            const double z = (1 - (j + 0.5) / ALONG) * (1 + stretched.z) - stretched.z;
            const double r = std::sqrt(std::max(1 - z * z, 0.0));
            const dvec3 h = dvec3(r * std::cos(phi), r * std::sin(phi), z) + stretched;
            sum += facetReturn(wo, glm::normalize(dvec3(alpha * h.x, alpha * h.y, std::max(h.z, 1e-9))), alpha, eta);
        }
    return sum / double(AROUND * ALONG);
}

/// Cosine-weighted mean of a row, 2 int E(c) c dc, exactly as the shader interpolates it: linearly in s = sqrt(c).
dvec4 rowMean(const std::vector<dvec4>& row)
{
    dvec4 sum(0);
    const double width = 1.0 / double(row.size() - 1);
    for (size_t cell = 0; cell + 1 < row.size(); ++cell)
        for (int point = -1; point <= 1; ++point) {  // three points of Gauss: exact to degree 5
            const double t = 0.5 + 0.5 * std::sqrt(0.6) * point;
            const double s = width * (double(cell) + t);
            sum += (point == 0 ? 8.0 : 5.0) / 18 * width * 4 * s * s * s * glm::mix(row[cell], row[cell + 1], t);
        }
    return sum;
}

}  // namespace

std::vector<glm::vec4> energyTable(float ior)
{
    std::vector<glm::vec4> table;
    table.reserve(ENERGY_TABLE);
    for (const double eta : {double(ior), ior == 0 ? 0.0 : 1.0 / ior})
        for (uint row = 0; row < ENERGY_ROWS; ++row) {
            const double roughness = std::max(double(row) / (ENERGY_ROWS - 1), 1e-3);
            std::vector<dvec4> values;
            for (uint column = 0; column < ENERGY_COLUMNS; ++column) {
                const double root = std::max(double(column) / (ENERGY_COLUMNS - 1), 1e-2);
                values.push_back(directional(root * root, roughness * roughness, eta));
            }
            table.insert(table.end(), values.begin(), values.end());
            table.emplace_back(rowMean(values));
        }
    return table;
}

}  // namespace restirpg
