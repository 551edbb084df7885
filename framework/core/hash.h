// FNV-1a, 64 bits (Fowler, Noll, Vo).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace restirpg {

/// The hash of these bytes, continued from `hash`.
inline uint64_t hashBytes(const void* data, size_t bytes, uint64_t hash = 0xcbf29ce484222325ull)
{
    const auto* next = static_cast<const unsigned char*>(data);
    for (size_t i = 0; i < bytes; ++i)
        hash = (hash ^ next[i]) * 0x100000001b3ull;
    return hash;
}

/// The hash of all that was added. Texts are told apart from their concatenation.
class Hash {
public:
    void add(const void* data, size_t bytes) { value_ = hashBytes(data, bytes, value_); }
    void add(std::string_view text)
    {
        const uint64_t length = text.size();
        add(&length, sizeof length);
        add(text.data(), text.size());
    }
    uint64_t value() const { return value_; }

private:
    uint64_t value_ = hashBytes(nullptr, 0);
};

}  // namespace restirpg
