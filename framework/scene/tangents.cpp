// Tangents for normal maps, for files that carry none.
#include "scene/gltf_file.h"

#include <algorithm>
#include <cmath>

namespace restirpg::gltf {

namespace {

float signedUvArea(const std::array<glm::vec2, 3>& uv)
{
    const auto a = uv[1] - uv[0], b = uv[2] - uv[0];
    return a.x * b.y - a.y * b.x;
}

float angleBetween(glm::vec3 a, glm::vec3 b)
{
    const float lengths = glm::length(a) * glm::length(b);
    return lengths > 0 ? std::acos(std::clamp(glm::dot(a, b) / lengths, -1.0f, 1.0f)) : 0.0f;
}

}  // namespace

bool mirroredUv(const std::array<glm::vec2, 3>& uv)
{
    // v runs downward in glTF: an upright, unmirrored image winds clockwise in (u, v).
    return signedUvArea(uv) > 0;
}

/// As MikkTSpace does it: each triangle's dP/du, projected into the vertex's tangent plane and weighted by the
/// corner's angle.
void generateTangents(const std::vector<glm::uvec3>& triangles, const std::vector<glm::vec3>& positions,
                      const std::vector<glm::vec2>& uv, std::vector<VertexAttributes>& attributes)
{
    for (auto& vertex : attributes)
        vertex.tangent = glm::vec4(0);
    for (const auto& triangle : triangles) {
        const std::array<glm::vec2, 3> t = {uv[triangle[0]], uv[triangle[1]], uv[triangle[2]]};
        const std::array<glm::vec3, 3> p = {positions[triangle[0]], positions[triangle[1]], positions[triangle[2]]};
        const float area = signedUvArea(t);
        if (area == 0)
            continue;
        // The division by the area is left out but for its sign: only the direction counts.
        const auto along =
            ((p[1] - p[0]) * (t[2].y - t[0].y) - (p[2] - p[0]) * (t[1].y - t[0].y)) * std::copysign(1.0f, area);
        for (int corner = 0; corner < 3; ++corner) {
            auto& vertex = attributes[triangle[corner]];
            const auto flat = along - vertex.normal * glm::dot(vertex.normal, along);
            const float length = glm::length(flat);
            if (!(length > 0) || !std::isfinite(length))
                continue;
            const float angle = angleBetween(p[(corner + 1) % 3] - p[corner], p[(corner + 2) % 3] - p[corner]);
            vertex.tangent += glm::vec4(flat * (angle / length), 0);
            vertex.tangent.w = mirroredUv(t) ? -1.0f : 1.0f;
        }
    }
    for (auto& vertex : attributes) {
        const float length = glm::length(glm::vec3(vertex.tangent));
        vertex.tangent = length > 0 ? glm::vec4(glm::vec3(vertex.tangent) / length, vertex.tangent.w) : glm::vec4(0);
    }
}

}  // namespace restirpg::gltf
