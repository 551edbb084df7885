#include "targets.h"

#include "../graph/fake_passes.h"

#include "core/error.h"
#include "core/output_file.h"
#include "image/image.h"
#include "image/limits.h"
#include "scene/gltf.h"
#include "scene/gltf_file.h"
#include "scene/lights.h"

#include <cstdio>
#include <cstdlib>
#include <map>

#include <unistd.h>

namespace restirpg::fuzz {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, Target> NAMES = {{"gltf", Target::gltf},
                                             {"image", Target::image},
                                             {"exr", Target::exr},
                                             {"hdr", Target::hdr},
                                             {"graph", Target::graph}};

/// A folder of this process alone, in memory where there is such a place: what is read there is what was written.
class Folder {
public:
    Folder()
    {
        std::string name = (fs::is_directory("/dev/shm") ? "/dev/shm" : fs::temp_directory_path().string()) +
                           std::string("/restirpg-fuzz-XXXXXX");
        if (!mkdtemp(name.data()))
            fail("{}: cannot make a folder", name);
        path_ = name;
    }
    ~Folder()
    {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }

    fs::path write(const char* name, const uint8_t* data, size_t size) const
    {
        const fs::path file = path_ / name;
        std::FILE* stream = std::fopen(file.c_str(), "wb");
        if (!stream || std::fwrite(data, 1, size, stream) != size || std::fclose(stream) != 0)
            fail("{}: cannot write", file.string());
        return file;
    }

private:
    fs::path path_;
};

void readScene(const fs::path& file)
{
    const Scene scene = loadGltf(file);
    const auto pose = poseNodes(scene, 0.5f * scene.duration);
    makeCamera(scene.cameras[0], pose[scene.cameras[0].node], 1.5f);
    buildLightTable(scene, pose, 1);
}

void decodeTexture(std::span<const uint8_t> encoded)
{
    const auto check = [&](uint32_t width, uint32_t height, bool sixteenBits) {
        checkImageClaim("image", width, height, encoded.size(), sixteenBits ? BYTES_PER_PIXEL_16 : BYTES_PER_PIXEL_8);
    };
    encoded.size() > 1 && encoded[0] == 0xff ? (void)gltf::decodeJpeg(encoded, check)
                                             : (void)gltf::decodePng(encoded, check);
}

void readGraph(const fs::path& file)
{
    Graph(readGraphFile(file), test::fakePlugins()).dot();
}

void readAs(Target target, const uint8_t* data, size_t size)
{
    static const Folder folder;
    switch (target) {
    case Target::gltf:
        return readScene(folder.write("scene.glb", data, size));
    case Target::image:
        return decodeTexture({data, size});
    case Target::exr: {
        const auto file = folder.write("a.exr", data, size);
        readRadiance(file);
        readExrAttributes(file);
        return;
    }
    case Target::hdr:
        (void)readRadiance(folder.write("a.hdr", data, size));
        return;
    case Target::graph:
        return readGraph(folder.write("g.json", data, size));
    }
}

}  // namespace

Target target()
{
    static const Target chosen = [] {
        const char* name = std::getenv("RESTIRPG_FUZZ");
        const auto found = NAMES.find(name ? name : "");
        if (found == NAMES.end()) {
            std::fputs("RESTIRPG_FUZZ must be one of exr, gltf, graph, hdr, image\n", stderr);
            std::exit(2);
        }
        return found->second;
    }();
    return chosen;
}

void read(Target target, const uint8_t* data, size_t size)
{
    try {
        readAs(target, data, size);
    } catch (const Error& error) {
        const std::string message = error.what();
        // A graph's mistakes are collected, one a line; everything else is one line.
        if (message.empty() || (target != Target::graph && message.find('\n') != message.npos)) {
            std::fprintf(stderr, "not one line: %s\n", message.c_str());
            std::abort();
        }
    }
}

}  // namespace restirpg::fuzz
