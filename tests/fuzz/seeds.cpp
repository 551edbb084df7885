#include "targets.h"

#include "../graph/describing.h"
#include "../scene/gltf_builder.h"

#include "image/image.h"

namespace restirpg::fuzz {
namespace {

namespace fs = std::filesystem;

Bytes bytesOf(const std::string& text)
{
    return {text.begin(), text.end()};
}

Image ramp(uint32_t width, uint32_t height, uint32_t channels)
{
    Image image{width, height, channels, {}};
    for (uint32_t i = 0; i < width * height * channels; ++i)
        image.data.push_back(0.25f * float(i) - 2.0f);
    return image;
}

std::vector<Bytes> scenes()
{
    std::vector<Bytes> result;
    for (const auto& builder : {squareScene(), geometryScene(), texturedScene(), animatedScene()})
        result.push_back(restirpg::readBytes(builder.write(scratch() / "seed.glb")));
    return result;
}

std::vector<Bytes> images()
{
    const std::vector<uint8_t> rgba = {255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 255, 0, 9, 9, 9, 9};
    return {encodePng(2, 2, rgba), encodeJpeg(2, 2, rgba), encodePng(16, 16, std::vector<uint8_t>(1024, 77)),
            encodeJpeg(16, 16, std::vector<uint8_t>(1024, 77))};
}

std::vector<Bytes> exrs()
{
    std::vector<Bytes> result;
    const auto add = [&](const std::vector<Layer>& layers, PixelType type) {
        const fs::path file = scratch() / "seed.exr";
        writeExr(file, layers, type, {{"graph", "{}"}});
        result.push_back(restirpg::readBytes(file));
    };
    add({{"", ramp(4, 3, 3)}}, PixelType::half);
    add({{"", ramp(4, 3, 1)}}, PixelType::full);
    add({{"Layer.Combined", ramp(2, 2, 4)}, {"motion", ramp(2, 2, 2)}}, PixelType::full);
    return result;
}

std::vector<Bytes> hdrs()
{
    const std::string pixels("\2\2\0\10\x88\x80\4\1\2\3\4\x84\5\x88\x20\x88\x88", 17);
    return {bytesOf("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 1 +X 8\n" + pixels),
            bytesOf("#?RGBE\r\nFORMAT=32-bit_rle_xyze\r\nCOLORCORR=1 2 3\r\n\r\n+X 1 +Y 2\r\n12341\1\1\1"),
            bytesOf("#?RADIANCE\nPRIMARIES=0.68 0.32 0.265 0.69 0.15 0.06 0.3127 0.329\n\n-Y 1 +X 3\nabcd" +
                    std::string("\1\1\1\2", 4))};
}

std::vector<Bytes> graphs()
{
    auto guided = test::pathTracer({{"bounces", 3}, {"roughness", 0.5}, {"cells", "screen"}, {"nee", false}});
    guided.add("fit", "Fit", {{"vertices", "paths.vertices"}})
        .add("more", "Paths", {{"surface", "gbuffer.surface"}, {"guide", "~fit.guide"}})
        .output("more", "more.radiance");
    return {bytesOf(test::pathTracer().graph.dump()), bytesOf(guided.graph.dump())};
}

}  // namespace

std::vector<Bytes> seeds(Target target)
{
    switch (target) {
    case Target::gltf:
        return scenes();
    case Target::image:
        return images();
    case Target::exr:
        return exrs();
    case Target::hdr:
        return hdrs();
    default:
        return graphs();
    }
}

}  // namespace restirpg::fuzz
