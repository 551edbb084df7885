// glTF materials and the textures that they use.
#include "scene/gltf_file.h"
#include "scene/fresnel.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace restirpg::gltf {

namespace {

/// KHR_materials_ior: 0 asks for total reflection. The nearest physical surface.
constexpr float TOTALLY_REFLECTING_IOR = 100;

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

/// uv' = translation * rotation * scale * uv [KHR_texture_transform]. The rotation turns the image clockwise as seen.
void applyTransform(const tinygltf::Value& transform, TextureRef& ref)
{
    const auto pair = [&](const char* name, glm::vec2 otherwise) {
        const auto* value = member(transform, name);
        return value && value->ArrayLen() == 2
            ? glm::vec2(value->Get(0).GetNumberAsDouble(), value->Get(1).GetNumberAsDouble()) : otherwise;
    };
    const auto offset = pair("offset", glm::vec2(0)), scale = pair("scale", glm::vec2(1));
    const float angle = number(transform, "rotation", 0), c = std::cos(angle), s = std::sin(angle);
    ref.row0 = {c * scale.x, s * scale.y, offset.x};
    ref.row1 = {-s * scale.x, c * scale.y, offset.y};
}

class MaterialReader {
public:
    MaterialReader(const File& file, Scene& scene) : file_(file), scene_(scene) {}

    Material read(size_t index)
    {
        const auto& source = file_.model.materials[index];
        place_ = label("material", index, source.name);
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
        material.baseColor = glm::max(glm::vec3(base[0], base[1], base[2]), 0.0f);
        material.alpha = float(base[3]);
        material.metallic = std::clamp(float(pbr.metallicFactor), 0.0f, 1.0f);
        material.roughness = std::clamp(float(pbr.roughnessFactor), 0.0f, 1.0f);
        material.normalScale = float(source.normalTexture.scale);
        material.baseColorMap = reference(coreInfo(pbr.baseColorTexture), true);
        material.metallicRoughnessMap = reference(coreInfo(pbr.metallicRoughnessTexture), false);
        material.normalMap = reference(coreInfo(source.normalTexture), false);
        if (source.doubleSided)
            material.flags |= MATERIAL_DOUBLE_SIDED;
    }

    void readAlpha(const tinygltf::Material& source, Material& material)
    {
        material.alphaCutoff = float(source.alphaCutoff);
        if (source.alphaMode == "BLEND") {
            warn("{}: alphaMode BLEND is treated as MASK with a cutoff of 0.5", file_.name());
            material.alphaCutoff = 0.5f;
        } else if (source.alphaMode != "MASK") {
            return;
        }
        // A surface that is opaque everywhere is spared the test on every ray.
        if (material.baseColorMap.index != INVALID_INDEX || material.alpha < material.alphaCutoff)
            material.flags |= MATERIAL_ALPHA_MASK;
    }

    void readEmission(const tinygltf::Material& source, Material& material)
    {
        const auto& factor = source.emissiveFactor;
        material.emission = glm::max(glm::vec3(factor[0], factor[1], factor[2]), 0.0f);
        if (const auto* strength = extension(source.extensions, "KHR_materials_emissive_strength"))
            material.emission *= std::max(number(*strength, "emissiveStrength", 1), 0.0f);
        if (glm::any(glm::greaterThan(material.emission, glm::vec3(1e30f))))
            fail("{}: {}: emits more than 1e30 W/sr/m^2; lower its emissiveStrength", file_.name(), place_);
        if (material.emission == glm::vec3(0))
            return;
        material.flags |= MATERIAL_EMISSIVE;
        material.emissiveMap = reference(coreInfo(source.emissiveTexture), true);
    }

    void readSpecular(const tinygltf::Material& source, Material& material)
    {
        if (const auto* ior = extension(source.extensions, "KHR_materials_ior"))
            material.ior = number(*ior, "ior", 1.5);
        if (material.ior == 0) {
            warn("{}: {}: ior 0 (total reflection) is approximated by {}", file_.name(), place_,
                 TOTALLY_REFLECTING_IOR);
            material.ior = TOTALLY_REFLECTING_IOR;
        }
        if (material.ior < 1)
            fail("{}: {}: ior {} is below 1; set it to the ratio inside over outside", file_.name(), place_,
                 material.ior);
        if (const auto* specular = extension(source.extensions, "KHR_materials_specular")) {
            material.specular = std::clamp(number(*specular, "specularFactor", 1), 0.0f, 1.0f);
            material.specularColor = glm::max(color(*specular, "specularColorFactor", glm::vec3(1)), 0.0f);
            material.specularMap = reference(extensionInfo(*specular, "specularTexture"), false);
            material.specularColorMap = reference(extensionInfo(*specular, "specularColorTexture"), true);
        }
    }

    void readTransmission(const tinygltf::Material& source, Material& material)
    {
        if (const auto* transmission = extension(source.extensions, "KHR_materials_transmission")) {
            material.transmission = std::clamp(number(*transmission, "transmissionFactor", 0), 0.0f, 1.0f);
            material.transmissionMap = reference(extensionInfo(*transmission, "transmissionTexture"), false);
        }
        const auto* volume = extension(source.extensions, "KHR_materials_volume");
        if (!volume || number(*volume, "thicknessFactor", 0) <= 0)
            return;
        material.flags |= MATERIAL_SOLID;
        if (!member(*volume, "attenuationDistance"))
            return;  // infinite
        const float distance = number(*volume, "attenuationDistance", 0);
        if (!(distance > 0))
            fail("{}: {}: attenuationDistance {} must be above 0; leave it out for clear glass", file_.name(), place_,
                 distance);
        const auto through = glm::clamp(color(*volume, "attenuationColor", glm::vec3(1)), DARKEST_ATTENUATION, 1.0f);
        material.absorption = -glm::log(through) / distance;
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
            applyTransform(*info.transform, ref);
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
        case TINYGLTF_TEXTURE_WRAP_REPEAT: return Texture::Wrap::repeat;
        case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT: return Texture::Wrap::mirroredRepeat;
        case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE: return Texture::Wrap::clampToEdge;
        default: fail("{}: {}: sampler wrap mode {} does not exist; export it again", file_.name(), place_, mode);
        }
    }

    const File& file_;
    Scene& scene_;
    std::string place_;
    std::map<std::tuple<int, int, bool>, uint32_t> textures_;  ///< image, sampler, sRGB
};

}  // namespace

void readMaterials(const File& file, Scene& scene)
{
    MaterialReader reader(file, scene);
    for (size_t i = 0; i < file.model.materials.size(); ++i)
        scene.materials.push_back(reader.read(i));
    scene.materials.push_back(MaterialReader::defaultMaterial());
}

}  // namespace restirpg::gltf
