#include "gpu/shader.h"

#include "core/cache_file.h"
#include "core/error.h"
#include "core/hash.h"
#include "core/log.h"
#include "core/paths.h"

#include <glslang/Include/glslang_c_shader_types.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>
#include <glslang/build_info.h>

#include <cstring>
#include <fstream>
#include <memory>
#include <mutex>
#include <set>
#include <sstream>

extern const TBuiltInResource* GetDefaultResources();

namespace restirpg {
namespace {

namespace fs = std::filesystem;

std::string readText(const fs::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        fail("{}: cannot read this shader; is the installation complete? (RESTIRPG_SHADERS overrides the library's "
             "folder)",
             file.string());
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

/// The file that `#include "name"` in the file `from` means: by the given names, beside the including file, in the
/// shader library. Empty: none.
fs::path resolveInclude(const std::string& name, const fs::path& from, const Includes& includes)
{
    const auto given = includes.find(name);
    const fs::path library = shaderFolder();
    // The library also by its folder, as C++ names it: a pass's Shared.h includes "shaders/frame_types.h".
    for (const fs::path& candidate : {given == includes.end() ? fs::path() : given->second, from.parent_path() / name,
                                      library / name, library.parent_path() / name})
        if (fs::is_regular_file(candidate))
            return fs::weakly_canonical(candidate);  // canonical, so that errors and nested includes find the file
    return {};
}

class Includer final : public glslang::TShader::Includer {
public:
    explicit Includer(const Includes& includes) : includes_(includes) {}

    IncludeResult* includeLocal(const char* name, const char* from, size_t) override
    {
        const fs::path file = resolveInclude(name, from, includes_);
        if (file.empty())
            return nullptr;
        auto text = std::make_unique<std::string>(readText(file));
        const auto* contents = text.get();
        return new IncludeResult(file.string(), contents->data(), contents->size(), text.release());
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

/// The names in the text's #include lines, in comments and branches not taken too.
std::vector<std::string> includedNames(const std::string& text)
{
    std::vector<std::string> names;
    for (size_t hash = text.find('#'); hash != std::string::npos; hash = text.find('#', hash + 1)) {
        const size_t word = text.find_first_not_of(" \t", hash + 1);
        if (word == std::string::npos || text.compare(word, 7, "include") != 0)
            continue;
        const size_t open = text.find_first_of("\"<\n", word), close = text.find_first_of("\">\n", open + 1);
        if (open != std::string::npos && close != std::string::npos && text[open] != '\n' && text[close] != '\n')
            names.push_back(text.substr(open + 1, close - open - 1));
    }
    return names;
}

/// Add a file and all that it may include. Contents and not where they lie, so that clones share what they compiled; a
/// file's includes follow it in order, so which file each name found is told by the contents.
void hashFiles(const fs::path& file, const Includes& includes, std::set<fs::path>& seen, Hash& hash)
{
    const std::string text = readText(file);
    hash.add(text);
    for (const auto& name : includedNames(text)) {
        const fs::path included = resolveInclude(name, file, includes);
        if (!included.empty() && seen.insert(included).second)
            hashFiles(included, includes, seen, hash);
        else
            hash.add(included.filename().string());
    }
}

void setUp(glslang::TShader& shader, const char* const* source, const char* const* name, const std::string& preamble)
{
    shader.setStringsWithLengthsAndNames(source, nullptr, name, 1);
    shader.setPreamble(preamble.c_str());
    shader.setEnvInput(glslang::EShSourceGlsl, EShLangCompute, glslang::EShClientVulkan, 460);
    shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_2);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_5);
}

constexpr auto MESSAGES = EShMessages(EShMsgSpvRules | EShMsgVulkanRules);

fs::path cachedFile(const fs::path& file, const std::string& preamble, const Includes& includes)
{
    const fs::path folder = cacheFolder();
    if (folder.empty()) {
        warn("{}", "no HOME, so there is no cache: kernels are compiled again at every start (RESTIRPG_CACHE_DIR names "
                   "a folder for it)");
        return {};
    }
    Hash hash;
    hash.add(preamble);
    std::set<fs::path> seen{file};
    hashFiles(file, includes, seen, hash);
    return folder / "spirv" / fmt::format("{:016x}-{}.{}", hash.value(), GLSLANG_VERSION_MAJOR, GLSLANG_VERSION_MINOR);
}

Spirv readCached(const fs::path& file)
{
    const auto contents = readCacheFile(file);
    if (!contents || contents->empty() || contents->size() % sizeof(uint32_t) != 0)
        return {};
    Spirv words(contents->size() / sizeof(uint32_t));
    std::memcpy(words.data(), contents->data(), contents->size());
    return words;
}

/// The first mistake of a compiler's log, which stops there, in one line. `place` is given to one that has none, which
/// is the linker's.
Error mistakeIn(const std::string& log, const std::string& place)
{
    const std::string mark = "ERROR: ";
    const size_t found = log.find(mark), begin = found == std::string::npos ? 0 : found + mark.size();
    std::istringstream words(log.substr(begin, log.find("\n" + mark, begin) - begin));
    std::string text = place;
    for (std::string word; words >> word;)
        text += (text.empty() ? "" : " ") + word;
    return Error(text);
}

Spirv translate(const fs::path& file, const std::string& preamble, const Includes& includes)
{
    static std::once_flag initialized;
    std::call_once(initialized, [] { glslang::InitializeProcess(); });
    const std::string text = readText(file), name = file.string();
    const char* source = text.c_str();
    const char* sourceName = name.c_str();
    Includer includer(includes);
    glslang::TShader shader(EShLangCompute);
    setUp(shader, &source, &sourceName, preamble);
    if (!shader.parse(GetDefaultResources(), 460, ECoreProfile, false, false, MESSAGES, includer))
        throw mistakeIn(shader.getInfoLog(), "");
    glslang::TProgram program;
    program.addShader(&shader);
    if (!program.link(MESSAGES))
        throw mistakeIn(program.getInfoLog(), name + ":");
    Spirv words;
    glslang::GlslangToSpv(*program.getIntermediate(EShLangCompute), words);
    return words;
}

}  // namespace

Spirv compileShader(const fs::path& given, const Defines& defines, const Includes& includes)
{
    const fs::path file = fs::weakly_canonical(given);
    std::string preamble = "#extension GL_GOOGLE_include_directive : require\n"
                           "#extension GL_GOOGLE_cpp_style_line_directive : require\n";
    for (const auto& [key, value] : defines)
        preamble += fmt::format("#define {} {}\n", key, value);
    const fs::path cached = cachedFile(file, preamble, includes);
    if (!cached.empty())
        if (auto words = readCached(cached); !words.empty())
            return words;
    Spirv words = translate(file, preamble, includes);
    // Where a file was edited in between, these words are not those of the contents that the name stands for.
    if (!cached.empty() && cachedFile(file, preamble, includes) == cached)
        writeCacheFile(cached, std::as_bytes(std::span(words)));
    return words;
}

LocalSize localSize(const Spirv& spirv)
{
    constexpr uint32_t OP_EXECUTION_MODE = 16, LOCAL_SIZE = 17, HEADER_WORDS = 5;
    for (size_t i = HEADER_WORDS; i < spirv.size(); i += std::max(spirv[i] >> 16, 1u))
        if ((spirv[i] & 0xffffu) == OP_EXECUTION_MODE && spirv[i + 2] == LOCAL_SIZE)
            return {spirv[i + 3], spirv[i + 4], spirv[i + 5]};
    return {};
}

}  // namespace restirpg
