// What the image tests share: a folder of their own, small images with known values, and the message of an Error.
#pragma once

#include "core/error.h"
#include "image/image.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace restirpg {

/// A fresh folder that is removed after the test.
class FolderTest : public testing::Test {
protected:
    void SetUp() override
    {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::temp_directory_path() /
                  (std::string("restirpg-") + test->name() + "-" + std::to_string(getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    size_t filesInFolder() const
    {
        return size_t(
            std::distance(std::filesystem::directory_iterator(folder_), std::filesystem::directory_iterator()));
    }

    std::filesystem::path folder_;
};

/// Values that are all different, beyond [0, 1] on both sides, and exact in half floats.
inline Image ramp(uint32_t width, uint32_t height, uint32_t channels)
{
    Image image{width, height, channels, {}};
    for (uint32_t i = 0; i < width * height * channels; ++i)
        image.data.push_back(0.25f * float(i) - 2.0f);
    return image;
}

inline Image constant(uint32_t width, uint32_t height, std::vector<float> pixel)
{
    Image image{width, height, uint32_t(pixel.size()), {}};
    for (uint32_t i = 0; i < width * height; ++i)
        image.data.insert(image.data.end(), pixel.begin(), pixel.end());
    return image;
}

/// The message of the Error that `action` throws; empty when it throws none.
template <typename Action>
std::string errorOf(Action&& action)
{
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

inline std::vector<char> readBytes(const std::filesystem::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

inline void writeBytes(const std::filesystem::path& file, const std::vector<char>& bytes)
{
    std::ofstream(file, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
}

inline bool contains(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

}  // namespace restirpg
