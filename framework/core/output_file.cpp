#include "core/output_file.h"

#include "core/error.h"

#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstring>
#include <ctime>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

/// write(2) beyond RLIMIT_FSIZE sends the thread SIGXFSZ, which ends the process. Here the error is enough: the signal
/// is held back while we write, and taken away if it came.
class HeldSignal {
public:
    HeldSignal()
    {
        sigemptyset(&signals_);
        sigaddset(&signals_, SIGXFSZ);
        pthread_sigmask(SIG_BLOCK, &signals_, &before_);
    }
    ~HeldSignal()
    {
        const int error = errno;
        const timespec now{};
        while (sigtimedwait(&signals_, nullptr, &now) == SIGXFSZ) {
        }
        pthread_sigmask(SIG_SETMASK, &before_, nullptr);
        errno = error;
    }
    HeldSignal(const HeldSignal&) = delete;
    HeldSignal& operator=(const HeldSignal&) = delete;

private:
    sigset_t signals_{};
    sigset_t before_{};
};

/// The file that a name leads to, over symbolic links, also when it is not there yet.
fs::path withoutLinks(fs::path file)
{
    constexpr int MOST_LINKS = 40;  // as Linux follows
    std::error_code error;
    for (int i = 0; i < MOST_LINKS && fs::is_symlink(file, error); ++i)
        file = file.parent_path() / fs::read_symlink(file, error);  // an absolute target replaces the folder
    return file;
}

/// What the names of this machine's temporary files begin with; after it stand the process and a number.
std::string temporaryPrefix()
{
    char host[HOST_NAME_MAX + 1] = {};
    gethostname(host, HOST_NAME_MAX);
    return fmt::format(".restirpg-{}-", host);
}

/// Whether nobody can be writing to it any more. A process of another container is not seen from here.
bool isOld(const fs::path& file)
{
    std::error_code error;
    const auto written = fs::last_write_time(file, error);
    return !error && fs::file_time_type::clock::now() - written > std::chrono::hours(24);
}

/// Removes what killed processes of this machine left unfinished in the folder.
void removeAbandoned(const fs::path& folder)
{
    const std::string prefix = temporaryPrefix();
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        pid_t process = 0;
        uint64_t number = 0;
        if (name.rfind(prefix, 0) != 0)
            continue;
        const char* const stop = name.data() + name.size();
        const auto first = std::from_chars(name.data() + prefix.size(), stop, process);
        if (first.ec != std::errc() || first.ptr == stop || *first.ptr != '-')
            continue;
        const auto second = std::from_chars(first.ptr + 1, stop, number);
        if (second.ec == std::errc() && std::string_view(second.ptr) == ".tmp" && process > 0 &&
            kill(process, 0) != 0 && errno == ESRCH && isOld(entry->path()))
            unlink(entry->path().c_str());
    }
}

/// Opens a new file in the folder; -1 where it cannot. A process of another container may have our number and the
/// machine's name, so a name that is taken is passed over.
int openTemporary(const fs::path& folder, fs::path& file)
{
    static std::atomic<uint64_t> count = 0;
    const std::string prefix = temporaryPrefix();
    int descriptor;
    do {
        file = folder / fmt::format("{}{}-{}.tmp", prefix, getpid(), count++);
        descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (descriptor < 0 && errno == EEXIST);
    return descriptor;
}

/// Permissions of the file that is replaced. A failure is no error: the new file has the usual ones.
void keepPermissions(int descriptor, const fs::path& file)
{
    struct stat before;
    if (stat(file.c_str(), &before) == 0 && fchmod(descriptor, before.st_mode & 07777) != 0)
        errno = 0;
}

/// Some file systems cannot flush, and say so by EINVAL.
bool flush(int descriptor)
{
    return fsync(descriptor) == 0 || errno == EINVAL || errno == ENOTSUP;
}

}  // namespace

OutputFile::OutputFile(const fs::path& file) : file_(file), target_(withoutLinks(file))
{
    const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
    std::error_code ignored;
    if (!fs::is_directory(folder, ignored))
        fail("{}: cannot write: the folder {} does not exist; create it first", file.string(), folder.string());
    if (fs::is_directory(target_, ignored))
        fail("{}: cannot write: it is a folder; name a file", file.string());
    if (fs::exists(target_, ignored) && !fs::is_regular_file(target_, ignored))
        fail("{}: cannot write: it is a device or a pipe; name a file", file.string());
    removeAbandoned(folder);
    descriptor_ = openTemporary(folder, temporary_);
    if (descriptor_ < 0)
        failWith(errno);
    keepPermissions(descriptor_, target_);
}

OutputFile::~OutputFile()
{
    if (descriptor_ < 0)
        return;
    close(descriptor_);
    unlink(temporary_.c_str());
}

void OutputFile::failWith(int error)
{
    error_ = error;
    const char* mend = error == ENOSPC || error == EDQUOT ? "free some space or choose another folder"
                       : error == EFBIG                   ? "raise the limit (ulimit -f) or write a smaller file"
                                                          : "choose another folder";
    fail("{}: cannot write: {}; {}", file_.string(), std::strerror(error), mend);
}

void OutputFile::write(const void* bytes, size_t size)
{
    const HeldSignal held;
    const char* data = static_cast<const char*>(bytes);
    while (size > 0) {
        const ssize_t written = ::write(descriptor_, data, size);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            failWith(written < 0 ? errno : ENOSPC);
        data += written;
        size -= size_t(written);
        position_ += uint64_t(written);
    }
}

void OutputFile::seek(uint64_t position)
{
    if (lseek(descriptor_, off_t(position), SEEK_SET) < 0)
        failWith(errno);
    position_ = position;
}

void OutputFile::commit()
{
    if (error_ != 0 || !flush(descriptor_))
        failWith(error_ != 0 ? error_ : errno);
    // After close the descriptor is gone even when it reports an error.
    const int descriptor = std::exchange(descriptor_, -1);
    if (close(descriptor) != 0 || rename(temporary_.c_str(), target_.c_str()) != 0) {
        const int error = errno;
        unlink(temporary_.c_str());
        failWith(error);
    }
    // The name itself is on the disk once the folder is.
    const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
    const int opened = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (opened >= 0) {
        fsync(opened);
        close(opened);
    }
}

void writeFile(const fs::path& file, std::string_view bytes)
{
    OutputFile output(file);
    output.write(bytes.data(), bytes.size());
    output.commit();
}

void checkWritable(const fs::path& file)
{
    OutputFile output(file);
}

}  // namespace restirpg
