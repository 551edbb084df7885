// libFuzzer's entry points. RESTIRPG_FUZZ names the target; scripts/fuzz runs all of them.
#include "targets.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>

using namespace restirpg;

/// libFuzzer's own change of bytes.
extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t largest);

extern "C" int LLVMFuzzerInitialize(int*, char***)
{
    const auto target = fuzz::target();
    // With RESTIRPG_FUZZ_SEEDS: only write the seeds into that folder.
    const char* folder = std::getenv("RESTIRPG_FUZZ_SEEDS");
    if (!folder)
        return 0;
    size_t index = 0;
    for (const auto& seed : fuzz::seeds(target))
        std::ofstream(std::filesystem::path(folder) / std::to_string(index++), std::ios::binary)
            .write(reinterpret_cast<const char*>(seed.data()), std::streamsize(seed.size()));
    std::exit(0);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz::read(fuzz::target(), data, size);
    return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t largest, unsigned int seed)
{
    std::mt19937 random(seed);
    const auto bytes = random() % 16 == 0 ? fuzz::Bytes() : fuzz::mutated(fuzz::target(), data, size, random);
    if (bytes.empty() || bytes.size() > largest)
        return LLVMFuzzerMutate(data, size, largest);
    std::copy(bytes.begin(), bytes.end(), data);
    return bytes.size();
}
