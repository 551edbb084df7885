#include "gpu/shader.h"

#include "core/error.h"
#include "core/paths.h"

#include <glslang/Include/glslang_c_shader_types.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>
#include <glslang/build_info.h>

#include <fstream>
#include <memory>
#include <mutex>
#include <sstream>
#include <unistd.h>

extern const TBuiltInResource* GetDefaultResources();

namespace restirpg {
namespace {

namespace fs = std::filesystem;

std::string readText(const fs::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        fail("{}: cannot read this shader; is the installation complete? (RESTIRPG_SHADERS overrides the library's folder)",
             file.string());
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

/// Resolves #include by the given names, beside the including file, then in the shader library.
class Includer final : public glslang::TShader::Includer {
public:
    explicit Includer(const Includes& includes) : includes_(includes) {}

    IncludeResult* includeLocal(const char* name, const char* from, size_t) override
    {
        const auto given = includes_.find(name);
        const fs::path library = shaderFolder();
        // The library also by its folder, as C++ names it: a pass's Shared.h includes "shaders/frame_types.h".
        for (const fs::path& candidate : {given == includes_.end() ? fs::path() : given->second,
                                          fs::path(from).parent_path() / name, library / name, library.parent_path() / name})
            if (fs::is_regular_file(candidate)) {
                auto text = std::make_unique<std::string>(readText(candidate));
                const auto* contents = text.get();
                // The canonical name, so that errors and nested includes find the file.
                return new IncludeResult(fs::weakly_canonical(candidate).string(), contents->data(), contents->size(),
                                         text.release());
            }
        return nullptr;
    }

    IncludeResult* includeSystem(const char* name, const char* from, size_t depth) override
    {
        return includeLocal(name, from, depth);
    }

    void releaseInclude(IncludeResult* result) override
    {
        if (!result)
            return;
        delete static_cast<std::string*>(result->userData);
        delete result;
    }

private:
    const Includes& includes_;
};

/// FNV-1a, 64 bits: the cache key.
uint64_t hashText(const std::string& text)
{
    uint64_t hash = 0xcbf29ce484222325ull;
    for (unsigned char c : text)
        hash = (hash ^ c) * 0x100000001b3ull;
    return hash;
}

void setUp(glslang::TShader& shader, const char* const* source, const char* const* name, const std::string& preamble)
{
    shader.setStringsWithLengthsAndNames(source, nullptr, name, 1);
    shader.setPreamble(preamble.c_str());
    shader.setEnvInput(glslang::EShSourceGlsl, EShLangCompute, glslang::EShClientVulkan, 460);
    shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_2);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_5);
}

std::vector<uint32_t> readCached(const fs::path& file)
{
    std::ifstream stream(file, std::ios::binary | std::ios::ate);
    if (!stream)
        return {};
    std::vector<uint32_t> words(size_t(stream.tellg()) / 4);
    stream.seekg(0);
    stream.read(reinterpret_cast<char*>(words.data()), std::streamsize(words.size() * 4));
    return stream && words.size() > 5 && words[0] == 0x07230203u ? words : std::vector<uint32_t>{};
}

void writeCached(const fs::path& file, const std::vector<uint32_t>& words)
{
    std::error_code ignored;
    fs::create_directories(file.parent_path(), ignored);
    const fs::path temporary = file.string() + fmt::format(".{}", getpid());
    std::ofstream(temporary, std::ios::binary)
        .write(reinterpret_cast<const char*>(words.data()), std::streamsize(words.size() * 4));
    fs::rename(temporary, file, ignored);
}

}  // namespace

std::vector<uint32_t> compileShader(const fs::path& file, const Defines& defines, const Includes& includes)
{
    static std::once_flag initialized;
    std::call_once(initialized, [] { glslang::InitializeProcess(); });

    const std::string text = readText(file);
    const std::string name = fs::weakly_canonical(file).string();
    const char* source = text.c_str();
    const char* sourceName = name.c_str();
    std::string preamble = "#extension GL_GOOGLE_include_directive : require\n"
                           "#extension GL_GOOGLE_cpp_style_line_directive : require\n";
    for (const auto& [key, value] : defines)
        preamble += fmt::format("#define {} {}\n", key, value);
    const auto messages = EShMessages(EShMsgSpvRules | EShMsgVulkanRules);
    Includer includer(includes);

    std::string preprocessed;
    glslang::TShader preprocessor(EShLangCompute);
    setUp(preprocessor, &source, &sourceName, preamble);
    if (!preprocessor.preprocess(GetDefaultResources(), 460, ECoreProfile, false, false, messages, &preprocessed, includer))
        fail("{}", preprocessor.getInfoLog());
    const fs::path cached =
        cacheFolder() / "spirv" /
        fmt::format("{:016x}-{}.{}.spv", hashText(preamble + preprocessed), GLSLANG_VERSION_MAJOR, GLSLANG_VERSION_MINOR);
    if (auto words = readCached(cached); !words.empty())
        return words;

    glslang::TShader shader(EShLangCompute);
    setUp(shader, &source, &sourceName, preamble);
    if (!shader.parse(GetDefaultResources(), 460, ECoreProfile, false, false, messages, includer))
        fail("{}", shader.getInfoLog());
    glslang::TProgram program;
    program.addShader(&shader);
    if (!program.link(messages))
        fail("{}: {}", name, program.getInfoLog());
    std::vector<uint32_t> words;
    glslang::GlslangToSpv(*program.getIntermediate(EShLangCompute), words);
    writeCached(cached, words);
    return words;
}

LocalSize localSize(const std::vector<uint32_t>& spirv)
{
    constexpr uint32_t OP_EXECUTION_MODE = 16, LOCAL_SIZE = 17, HEADER_WORDS = 5;
    for (size_t i = HEADER_WORDS; i < spirv.size(); i += std::max(spirv[i] >> 16, 1u))
        if ((spirv[i] & 0xffffu) == OP_EXECUTION_MODE && spirv[i + 2] == LOCAL_SIZE)
            return {spirv[i + 3], spirv[i + 4], spirv[i + 5]};
    return {};
}

}  // namespace restirpg
