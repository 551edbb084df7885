// What is fuzzed: each reader of files that a user may have got from anybody.
#pragma once

#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace restirpg::fuzz {

using Bytes = std::vector<uint8_t>;

enum class Target {
    gltf,  ///< scenes: a GLB, read, posed and lit
    image,  ///< PNG and JPEG in scenes
    exr,
    hdr,
    graph,  ///< graph descriptions, checked and ordered over passes that touch no GPU
};

/// The one that the environment variable RESTIRPG_FUZZ names; ends the process when there is none.
Target target();

/// Read the bytes as the target's file. An Error is an answer; anything else ends the process.
void read(Target target, const uint8_t* data, size_t size);

/// Small files that between them use every feature of the reader.
std::vector<Bytes> seeds(Target target);

/// A change that leaves a file of the target's kind; an empty result means that bytes should be changed instead.
Bytes mutated(Target target, const uint8_t* data, size_t size, std::mt19937& random);

}  // namespace restirpg::fuzz
