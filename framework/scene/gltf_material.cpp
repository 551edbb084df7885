// glTF materials and the textures that they use.
#include "scene/fresnel.h"
#include "scene/gltf_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace restirpg::gltf {

namespace {

/// Far beyond any matter's. KHR_materials_ior's 0, total reflection, is kept as it is: shaders take it for infinite.
constexpr float LARGEST_IOR = 100;

/// Where the specification sets no limit: beyond any use, and so small that products and squares stay finite.
constexpr float BOUNDLESS = 1e6f;
constexpr float SHORTEST_ATTENUATION = 1e-20f;

/// An attenuation colour of 0 would mean infinite absorption; this is one part in a million per attenuation distance.
constexpr float DARKEST_ATTENUATION = 1e-6f;

/// A textureInfo, from core glTF or from an extension.
struct TextureInfo {
    int index = -1;
    int uvSet = 0;
    const tinygltf::Value* transform = nullptr;  ///< KHR_texture_transform
};

template <typename CoreInfo>
TextureInfo coreInfo(const CoreInfo& info)
{
    return {info.index, info.texCoord, extension(info.extensions, "KHR_texture_transform")};
}

TextureInfo extensionInfo(const tinygltf::Value& object, const char* name)
{
    const auto* info = member(object, name);
    if (!info)
        return {};
    const auto* extensions = member(*info, "extensions");
    return {int(number(*info, "index", -1)), int(number(*info, "texCoord", 0)),
            extensions ? member(*extensions, "KHR_texture_transform") : nullptr};
}

/// Reads factors within the range that the specification gives each, and remembers what was not, for one warning a
/// file.
class Factors {
public:
    explicit Factors(const File& file) : file_(file) {}

    void enter(std::string place) { place_ = std::move(place); }

    float number(double value, const char* name, float least, float most)
    {
        if (!(value >= double(least) && value <= double(most)) && clamped_++ == 0)
            first_ = fmt::format("{}: {} {:.6g} lies outside of {:g}..{:g}", place_, name, value, least, most);
        return float(std::clamp(value, double(least), double(most)));
    }

    glm::vec3 color(const glm::dvec3& value, const char* name, float most)
    {
        return {number(value.x, name, 0, most), number(value.y, name, 0, most), number(value.z, name, 0, most)};
    }

    void report() const
    {
        if (clamped_ == 1)
            warn("{}: {} and is clamped to that range", file_.name(), first_);
        else if (clamped_ > 1)
            warn("{}: {} and is clamped to that range, like {} more numbers of the materials", file_.name(), first_,
                 clamped_ - 1);
    }

private:
    const File& file_;
    std::string place_, first_;
    size_t clamped_ = 0;
};

/// uv' = translation * rotation * scale * uv [KHR_texture_transform]. The rotation turns the image clockwise as seen.
void applyTransform(const tinygltf::Value& transform, Factors& factors, TextureRef& ref)
{
    const auto pair = [&](const char* name, glm::vec2 otherwise) {
        const auto* value = member(transform, name);
        const auto component = [&](int i) {
            return factors.number(value->Get(i).GetNumberAsDouble(), name, -BOUNDLESS, BOUNDLESS);
        };
        return value && value->ArrayLen() == 2 ? glm::vec2(component(0), component(1)) : otherwise;
    };
    const auto offset = pair("offset", glm::vec2(0)), scale = pair("scale", glm::vec2(1));
    const float angle = number(transform, "rotation", 0), c = std::cos(angle), s = std::sin(angle);
    ref.row0 = {c * scale.x, s * scale.y, offset.x};
    ref.row1 = {-s * scale.x, c * scale.y, offset.y};
}

class MaterialReader {
public:
    MaterialReader(const File& file, Scene& scene) : file_(file), scene_(scene), factors_(file) {}

    Material read(size_t index)
    {
        const auto& source = file_.model.materials[index];
        place_ = label("material", index, source.name);
        factors_.enter(place_);
        Material material = defaultMaterial();
        readCore(source, material);
        readAlpha(source, material);
        readEmission(source, material);
        readSpecular(source, material);
        readTransmission(source, material);
        if (extension(source.extensions, "KHR_materials_unlit"))
            makeUnlit(material);
        material.coatAverage = fresnelCoatAverage(material.ior);
        return material;
    }

    void report() const { factors_.report(); }

    static Material defaultMaterial()
    {
        Material material{};
        material.baseColor = glm::vec3(1);
        material.metallic = 1;
        material.roughness = 1;
        material.specularColor = glm::vec3(1);
        material.specular = 1;
        material.ior = 1.5f;
        material.coatAverage = fresnelCoatAverage(material.ior);
        material.alpha = 1;
        material.alphaCutoff = 0.5f;
        material.normalScale = 1;
        for (auto* map :
             {&material.baseColorMap, &material.metallicRoughnessMap, &material.normalMap, &material.emissiveMap,
              &material.transmissionMap, &material.specularMap, &material.specularColorMap})
            *map = {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), INVALID_INDEX, 0};
        return material;
    }

private:
    void readCore(const tinygltf::Material& source, Material& material)
    {
        const auto& pbr = source.pbrMetallicRoughness;
        const auto& base = pbr.baseColorFactor;
        material.baseColor = factors_.color({base[0], base[1], base[2]}, "baseColorFactor", 1);
        material.alpha = factors_.number(base[3], "baseColorFactor", 0, 1);
        material.metallic = factors_.number(pbr.metallicFactor, "metallicFactor", 0, 1);
        material.roughness = factors_.number(pbr.roughnessFactor, "roughnessFactor", 0, 1);
        material.normalScale =
            factors_.number(source.normalTexture.scale, "normalTexture.scale", -BOUNDLESS, BOUNDLESS);
        material.baseColorMap = reference(coreInfo(pbr.baseColorTexture), true);
        material.metallicRoughnessMap = reference(coreInfo(pbr.metallicRoughnessTexture), false);
        material.normalMap = reference(coreInfo(source.normalTexture), false);
        if (source.doubleSided)
            material.flags |= MATERIAL_DOUBLE_SIDED;
    }

    void readAlpha(const tinygltf::Material& source, Material& material)
    {
        material.alphaCutoff = factors_.number(source.alphaCutoff, "alphaCutoff", 0, BOUNDLESS);
        if (source.alphaMode == "BLEND") {
            warn("{}: alphaMode BLEND is treated as MASK with a cutoff of 0.5", file_.name());
            material.alphaCutoff = 0.5f;
        } else if (source.alphaMode != "MASK") {
            return;
        }
        material.flags |= MATERIAL_ALPHA_MASK;
    }

    void readEmission(const tinygltf::Material& source, Material& material)
    {
        const auto& factor = source.emissiveFactor;
        material.emission = factors_.color({factor[0], factor[1], factor[2]}, "emissiveFactor", 1);
        if (const auto* strength = extension(source.extensions, "KHR_materials_emissive_strength"))
            material.emission *=
                factors_.number(number(*strength, "emissiveStrength", 1), "emissiveStrength", 0, 1e30f);
        if (material.emission != glm::vec3(0))
            material.flags |= MATERIAL_EMISSIVE;
        // A dark emitter has its map, too: an edit may light it.
        material.emissiveMap = reference(coreInfo(source.emissiveTexture), true);
    }

    void readSpecular(const tinygltf::Material& source, Material& material)
    {
        const auto* extended = extension(source.extensions, "KHR_materials_ior");
        const float ior = extended ? number(*extended, "ior", 1.5) : 1.5f;
        material.ior = ior == 0 ? 0 : factors_.number(ior, "ior", 1, LARGEST_IOR);
        if (const auto* specular = extension(source.extensions, "KHR_materials_specular")) {
            material.specular = factors_.number(number(*specular, "specularFactor", 1), "specularFactor", 0, 1);
            material.specularColor =
                factors_.color(color(*specular, "specularColorFactor", glm::vec3(1)), "specularColorFactor", BOUNDLESS);
            material.specularMap = reference(extensionInfo(*specular, "specularTexture"), false);
            material.specularColorMap = reference(extensionInfo(*specular, "specularColorTexture"), true);
        }
    }

    void readTransmission(const tinygltf::Material& source, Material& material)
    {
        if (const auto* transmission = extension(source.extensions, "KHR_materials_transmission")) {
            material.transmission =
                factors_.number(number(*transmission, "transmissionFactor", 0), "transmissionFactor", 0, 1);
            material.transmissionMap = reference(extensionInfo(*transmission, "transmissionTexture"), false);
        }
        const auto* volume = extension(source.extensions, "KHR_materials_volume");
        if (!volume || factors_.number(number(*volume, "thicknessFactor", 0), "thicknessFactor", 0, 1e30f) == 0)
            return;
        material.flags |= MATERIAL_SOLID;
        const auto* given = member(*volume, "attenuationDistance");
        if (!given)
            return;  // infinite
        const float distance = factors_.number(given->GetNumberAsDouble(), "attenuationDistance", SHORTEST_ATTENUATION,
                                               std::numeric_limits<float>::max());
        const auto through = factors_.color(color(*volume, "attenuationColor", glm::vec3(1)), "attenuationColor", 1);
        material.absorption = -glm::log(glm::max(through, DARKEST_ATTENUATION)) / distance;
    }

    /// KHR_materials_unlit wants a constant colour, which light transport has no place for: a Lambert surface of
    /// that albedo.
    void makeUnlit(Material& material)
    {
        warn("{}: unlit materials are shown as diffuse surfaces of their colour", file_.name());
        Material diffuse = defaultMaterial();
        diffuse.baseColor = material.baseColor;
        diffuse.baseColorMap = material.baseColorMap;
        diffuse.metallic = 0;
        diffuse.specular = 0;
        diffuse.alpha = material.alpha;
        diffuse.alphaCutoff = material.alphaCutoff;
        diffuse.flags = material.flags & (MATERIAL_DOUBLE_SIDED | MATERIAL_ALPHA_MASK);
        material = diffuse;
    }

    TextureRef reference(TextureInfo info, bool srgb)
    {
        TextureRef ref{glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), INVALID_INDEX, 0};
        if (info.index < 0)
            return ref;
        if (info.transform) {
            applyTransform(*info.transform, factors_, ref);
            info.uvSet = int(number(*info.transform, "texCoord", info.uvSet));
        }
        if (info.uvSet > 1) {
            warn("{}: {}: TEXCOORD_{} is not read; TEXCOORD_0 stands in", file_.name(), place_, info.uvSet);
            info.uvSet = 0;
        }
        ref.uvSet = uint32_t(info.uvSet);
        ref.index = texture(info.index, srgb);
        return ref;
    }

    /// The scene's texture for a glTF texture in one encoding; decoded on first use.
    uint32_t texture(int index, bool srgb)
    {
        const auto& source = file_.model.textures[size_t(index)];
        if (source.source < 0)
            fail("{}: textures[{}]: has no PNG or JPEG image (KTX2 or WebP only?); export it with one", file_.name(),
                 index);
        const auto key = std::make_tuple(source.source, source.sampler, srgb);
        if (const auto found = textures_.find(key); found != textures_.end())
            return found->second;

        const auto& image = file_.model.images[size_t(source.source)];
        Texture result;
        result.name = !source.name.empty() ? source.name : image.name;
        result.srgb = srgb;
        if (source.sampler >= 0) {
            const auto& sampler = file_.model.samplers[size_t(source.sampler)];
            result.wrapU = wrap(sampler.wrapS);
            result.wrapV = wrap(sampler.wrapT);
            if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST)
                result.filter = Texture::Filter::nearest;
        }
        decodeImage(file_, source.source, result);
        scene_.textures.push_back(std::move(result));
        return textures_[key] = uint32_t(scene_.textures.size() - 1);
    }

    Texture::Wrap wrap(int mode) const
    {
        switch (mode) {
        case TINYGLTF_TEXTURE_WRAP_REPEAT:
            return Texture::Wrap::repeat;
        case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
            return Texture::Wrap::mirroredRepeat;
        case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
            return Texture::Wrap::clampToEdge;
        default:
            fail("{}: {}: sampler wrap mode {} does not exist; export it again", file_.name(), place_, mode);
        }
    }

    const File& file_;
    Scene& scene_;
    Factors factors_;
    std::string place_;
    std::map<std::tuple<int, int, bool>, uint32_t> textures_;  ///< image, sampler, sRGB
};

}  // namespace

void readMaterials(const File& file, Scene& scene)
{
    MaterialReader reader(file, scene);
    for (size_t i = 0; i < file.model.materials.size(); ++i) {
        scene.materials.push_back(reader.read(i));
        scene.materialNames.push_back(file.model.materials[i].name);
    }
    reader.report();
    scene.materials.push_back(MaterialReader::defaultMaterial());
    scene.materialNames.emplace_back();
}

}  // namespace restirpg::gltf
