// Every file that the program writes: whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace restirpg {

/// A file being written. The bytes go to a temporary name in the same folder; `commit` gives the file its name after
/// everything lies on the disk. Without `commit` the temporary is removed and the file that was there stays. What a
/// process that was killed left of its own is removed by one that writes to the folder a day later or more.
/// All members throw Error, one line that names the file and the reason (a full disk, a limit, a missing folder). After
/// one failure `commit` fails too, so that a library may swallow the first.
/// A file that is replaced keeps its permissions; a symbolic link goes on pointing to the file that is written.
class OutputFile {
public:
    explicit OutputFile(const std::filesystem::path& file);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    void write(const void* bytes, size_t size);
    /// Bytes from the file's beginning.
    uint64_t position() const { return position_; }
    void seek(uint64_t position);
    void commit();

private:
    [[noreturn]] void failWith(int error);

    std::filesystem::path file_;  ///< as the user named it
    std::filesystem::path target_;  ///< without symbolic links
    std::filesystem::path temporary_;
    int descriptor_ = -1;
    int error_ = 0;  ///< of the first failure
    uint64_t position_ = 0;
};

/// Write a whole file from memory.
void writeFile(const std::filesystem::path& file, std::string_view bytes);

/// Throws the Error that writing `file` would throw, without changing it: to be asked before a long rendering.
void checkWritable(const std::filesystem::path& file);

}  // namespace restirpg
