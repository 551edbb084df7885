#include "scene/emission.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace restirpg {
namespace {

/// Parts a side at most, and in the whole scene: what finer ones would save in noise is not worth their memory.
constexpr double MOST_PARTS_A_SIDE = 256;
constexpr double MOST_PARTS = 1 << 20;
/// Parts a texel, along a side.
constexpr double PARTS_A_TEXEL = 2;
/// Parts are kept where their mean square is larger than their squared mean by this part of it, at least.
constexpr double LEAST_GAIN = 0.1;

/// A linear combination of prefix sums along one axis: sum of factor * prefix[at].
struct Terms {
    struct Term {
        double factor;
        uint32_t at;
    };
    std::array<Term, 6> terms;
    size_t count = 0;

    void add(double factor, double at)
    {
        if (factor != 0 && at != 0)
            terms[count++] = {factor, uint32_t(at)};
    }

    /// Add `sign` times the sum of all texels before `end`, an integer, of a line of n texels that goes on by its wrap
    /// mode.
    void addPrefix(double sign, double end, double n, Texture::Wrap wrap)
    {
        if (wrap == Texture::Wrap::clampToEdge) {
            add(sign * std::min(end, 0.0), 1);
            add(sign, std::clamp(end, 0.0, n));
            add(sign * std::max(end - n, 0.0), n);
            add(-sign * std::max(end - n, 0.0), n - 1);
            return;
        }
        const bool mirrored = wrap == Texture::Wrap::mirroredRepeat;
        const double period = mirrored ? 2 * n : n;
        const double turns = std::floor(end / period), rest = end - turns * period;
        const bool backwards = rest > n;
        add(sign * (mirrored ? 2 * turns + (backwards ? 2 : 0) : turns), n);
        add(backwards ? -sign : sign, backwards ? 2 * n - rest : rest);
    }
};

/// The texels that lookups between two coordinates can read, along one axis.
struct TexelRange {
    double first;
    double count;
};

TexelRange texelsBetween(double low, double high, double size, const Texture& texture, Texture::Wrap wrap)
{
    constexpr double FARTHEST = 1e9;  // texels; beyond, floats hold no texture coordinates
    const bool linear = texture.filter == Texture::Filter::linear;
    // What the shader's arithmetic in floats may be off.
    const double margin = 1e-3 + 1e-6 * size * std::max(std::abs(low), std::abs(high));
    const auto texel = [&](double coordinate) {
        const double x = std::floor(coordinate - (linear ? 0.5 : 0));
        return std::isfinite(x) ? std::clamp(x, -FARTHEST, FARTHEST) : 0;
    };
    double first = texel(low * size - margin);
    const double count = texel(high * size + margin) - first + (linear ? 2 : 1);
    if (wrap != Texture::Wrap::clampToEdge)
        first -= 2 * size * std::floor(first / (2 * size));
    return {first, count};
}

/// Sums of a texture's luminance over any rectangle of texels, wrapped. In whole units of a millionth of the brightest
/// texel, rounded up, so that sums are exact and only black is 0.  [Crow 1984, "Summed-Area Tables for Texture
/// Mapping"]
class TexelSums {
public:
    /// `factor`: of each channel, before luminance.
    TexelSums(const Texture& texture, const glm::dvec3& factor)
        : texture_(texture), stride_(texture.width + 1), sums_(size_t(stride_) * (texture.height + 1))
    {
        const auto value = [&](uint32_t x, uint32_t y) { return luminance(factor * glm::dvec3(texture.texel(x, y))); };
        double brightest = 0;
        for (uint32_t y = 0; y < texture.height; ++y)
            for (uint32_t x = 0; x < texture.width; ++x)
                brightest = std::max(brightest, value(x, y));
        if (!(brightest > 0))
            return;
        unit_ = brightest / (1 << 20);
        for (uint32_t y = 0; y < texture.height; ++y) {
            double row = 0;
            for (uint32_t x = 0; x < texture.width; ++x) {
                row += std::ceil(value(x, y) / unit_);
                sums_[size_t(y + 1) * stride_ + x + 1] = sums_[size_t(y) * stride_ + x + 1] + row;
            }
        }
    }

    /// Mean over all texels that lookups inside the box from `low` to `high` can read.
    double mean(const glm::dvec2& low, const glm::dvec2& high) const
    {
        const auto u = texelsBetween(low.x, high.x, texture_.width, texture_, texture_.wrapU);
        const auto v = texelsBetween(low.y, high.y, texture_.height, texture_, texture_.wrapV);
        const Terms columns = termsOf(u, texture_.width, texture_.wrapU),
                    rows = termsOf(v, texture_.height, texture_.wrapV);
        double sum = 0;
        for (size_t j = 0; j < rows.count; ++j)
            for (size_t i = 0; i < columns.count; ++i)
                sum += rows.terms[j].factor * columns.terms[i].factor *
                       sums_[size_t(rows.terms[j].at) * stride_ + columns.terms[i].at];
        return unit_ * sum / (u.count * v.count);
    }

private:
    static Terms termsOf(const TexelRange& range, double n, Texture::Wrap wrap)
    {
        Terms terms;
        terms.addPrefix(1, range.first + range.count, n, wrap);
        terms.addPrefix(-1, range.first, n, wrap);
        return terms;
    }

    const Texture& texture_;
    uint32_t stride_;
    std::vector<double> sums_;  ///< of all texels above and to the left
    double unit_ = 0;
};

using Corners = std::array<glm::dvec2, 3>;

/// Texture coordinates of a triangle's corners, by the material's map.
Corners cornersOf(const TextureRef& map, const Scene& scene, const SceneMesh& mesh, const glm::uvec3& triangle)
{
    Corners corners;
    for (int i = 0; i < 3; ++i) {
        const auto& vertex = scene.attributes[mesh.firstVertex + triangle[i]];
        const glm::dvec3 point(map.uvSet == 0 ? vertex.uv0 : vertex.uv1, 1);
        corners[size_t(i)] = {glm::dot(glm::dvec3(map.row0), point), glm::dot(glm::dvec3(map.row1), point)};
    }
    return corners;
}

/// Parts a side that follow the texels.
double wantedSide(const Texture& texture, const Corners& uv)
{
    double longest = 0;
    for (size_t i = 0; i < 3; ++i)
        longest = std::max(longest, glm::length((uv[(i + 1) % 3] - uv[i]) * glm::dvec2(texture.width, texture.height)));
    return longest < MOST_PARTS_A_SIDE ? std::clamp(std::ceil(PARTS_A_TEXEL * longest), 1.0, MOST_PARTS_A_SIDE)
                                       : MOST_PARTS_A_SIDE;
}

/// The mean luminance that lookups in a triangle of texture coordinates can read: over its quarters' bounding boxes,
/// whose texels are fewer than those of its own.
double meanOfTriangle(const TexelSums& sums, const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c)
{
    const auto box = [&](const glm::dvec2& p, const glm::dvec2& q, const glm::dvec2& r) {
        return sums.mean(glm::min(p, glm::min(q, r)), glm::max(p, glm::max(q, r)));
    };
    const glm::dvec2 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    return 0.25 * (box(a, ab, ca) + box(ab, b, bc) + box(ca, bc, c) + box(ab, bc, ca));
}

/// ... of part (x, y) of side x side.
double meanOfPart(const TexelSums& sums, const Corners& uv, uint32_t side, uint32_t x, uint32_t y)
{
    const bool upper = x + y >= side;
    const double step = upper ? -1 : 1, i = upper ? side - x : x, j = upper ? side - y : y;
    const auto corner = [&](double b1, double b2) {
        b1 /= side;
        b2 /= side;
        return uv[0] * (1 - b1 - b2) + uv[1] * b1 + uv[2] * b2;
    };
    return meanOfTriangle(sums, corner(i, j), corner(i + step, j), corner(i, j + step));
}

void measureTriangle(Emission& emission, uint32_t triangle, const TexelSums& sums, const Corners& uv, uint32_t side)
{
    EmissionParts parts{side, std::vector<double>(size_t(side) * side)};
    const double count = double(parts.luminances.size());
    double sum = 0, squares = 0;
    for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x) {
            const double mean = parts.luminances[size_t(y) * side + x] = meanOfPart(sums, uv, side, x, y);
            sum += mean;
            squares += mean * mean;
        }
    emission.mean[triangle] = sum / count;
    if (squares * count > (1 + LEAST_GAIN) * sum * sum)
        emission.parts.emplace(triangle, std::move(parts));
}

/// A triangle whose emission a texture varies.
struct Textured {
    uint32_t material;
    uint32_t triangle;  ///< of the scene's
    Corners uv;
    double side;
};

/// All textured emitters, one material after the other.
std::vector<Textured> findTextured(const Scene& scene)
{
    std::vector<Textured> found;
    for (const auto& mesh : scene.meshes)
        for (uint32_t t = mesh.firstTriangle; t < mesh.firstTriangle + mesh.triangleCount; ++t) {
            const auto& material = scene.materials[scene.materialOfTriangle[t]];
            if (!(material.flags & MATERIAL_EMISSIVE) || material.emissiveMap.index == INVALID_INDEX)
                continue;
            const auto uv = cornersOf(material.emissiveMap, scene, mesh, scene.triangles[t]);
            found.push_back(
                {scene.materialOfTriangle[t], t, uv, wantedSide(scene.textures[material.emissiveMap.index], uv)});
        }
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.material < b.material; });
    return found;
}

}  // namespace

Emission measureEmission(const Scene& scene)
{
    Emission emission;
    emission.mean.resize(scene.triangles.size());
    for (size_t t = 0; t < emission.mean.size(); ++t) {
        const auto& material = scene.materials[scene.materialOfTriangle[t]];
        if (material.flags & MATERIAL_EMISSIVE)
            emission.mean[t] = luminance(material.emission);
    }
    const auto textured = findTextured(scene);
    double wanted = 0;
    for (const auto& emitter : textured)
        wanted += emitter.side * emitter.side;
    const double share = std::min(1.0, std::sqrt(MOST_PARTS / std::max(wanted, 1.0)));
    std::optional<TexelSums> sums;
    for (size_t i = 0; i < textured.size(); ++i) {
        const auto& material = scene.materials[textured[i].material];
        if (i == 0 || textured[i].material != textured[i - 1].material)
            sums.emplace(scene.textures[material.emissiveMap.index], material.emission);
        const auto side = uint32_t(std::max(1.0, textured[i].side * share));
        measureTriangle(emission, textured[i].triangle, *sums, textured[i].uv, side);
    }
    return emission;
}

}  // namespace restirpg
