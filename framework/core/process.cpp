#include "core/process.h"

#include "core/error.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace restirpg {
namespace {

/// A pipe whose two ends are closed with it, and not inherited unless duplicated.
struct Pipe {
    std::array<int, 2> ends{-1, -1};

    Pipe()
    {
        if (pipe2(ends.data(), O_CLOEXEC) != 0)
            fail("cannot create a pipe: {}", std::strerror(errno));
    }
    ~Pipe()
    {
        closeEnd(0);
        closeEnd(1);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    void closeEnd(int end)
    {
        if (ends[end] >= 0)
            close(ends[end]);
        ends[end] = -1;
    }
};

std::vector<std::string> mergedEnvironment(const std::map<std::string, std::string>& added)
{
    std::vector<std::string> merged;
    for (char** entry = environ; *entry; ++entry) {
        const std::string text = *entry;
        if (!added.contains(text.substr(0, text.find('='))))
            merged.push_back(text);
    }
    for (const auto& [name, value] : added)
        merged.push_back(name + "=" + value);
    return merged;
}

/// posix_spawn wants arrays of mutable C strings.
std::vector<char*> pointers(const std::vector<std::string>& texts)
{
    std::vector<char*> result;
    for (const auto& text : texts)
        result.push_back(const_cast<char*>(text.c_str()));
    result.push_back(nullptr);
    return result;
}

using Clock = std::chrono::steady_clock;
constexpr auto NEVER = Clock::time_point::max();

/// Read both pipes to their ends, together: a program that fills one while we wait at the other would hang. Sets
/// `timedOut` when they are still open at the deadline, `tooMuch` when more comes than may. False then.
bool drain(Pipe& output, Pipe& errors, Clock::time_point deadline, ProcessResult& result)
{
    std::array<pollfd, 2> polled{{{output.ends[0], POLLIN, 0}, {errors.ends[0], POLLIN, 0}}};
    const std::array<std::string*, 2> texts{&result.output, &result.errors};
    std::array<char, 65536> chunk;
    while (polled[0].fd >= 0 || polled[1].fd >= 0) {
        int wait = -1;  // ms
        if (deadline != NEVER)
            wait = int(std::clamp<int64_t>(
                std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count(), 0, INT_MAX));
        if (wait == 0) {
            result.timedOut = true;
            return false;
        }
        const int ready = poll(polled.data(), polled.size(), wait);
        if (ready < 0 && errno != EINTR)
            fail("cannot wait for a program's output: {}", std::strerror(errno));
        if (ready <= 0)
            continue;
        for (size_t i = 0; i < polled.size(); ++i) {
            if (polled[i].fd < 0 || polled[i].revents == 0)
                continue;
            const ssize_t count = read(polled[i].fd, chunk.data(), chunk.size());
            if (count > 0) {
                texts[i]->append(chunk.data(), size_t(count));
                result.tooMuch = result.tooMuch || texts[i]->size() > MOST_PRINTED;
            } else if (count == 0 || errno != EINTR)
                polled[i].fd = -1;
        }
        if (result.tooMuch)
            return false;
    }
    return true;
}

/// The process's status when it has ended. nullopt when it runs on at the deadline: it may have closed its pipes long
/// before.
std::optional<int> statusOf(pid_t process, Clock::time_point deadline)
{
    int status = 0;
    while (true) {
        const pid_t ended = waitpid(process, &status, deadline == NEVER ? 0 : WNOHANG);
        if (ended == process)
            return status;
        if (ended < 0 && errno != EINTR)
            fail("cannot wait for a program: {}", std::strerror(errno));
        if (Clock::now() >= deadline)
            return std::nullopt;
        if (ended == 0)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

}  // namespace

ProcessResult runProcess(const std::vector<std::string>& command, const std::map<std::string, std::string>& environment,
                         std::optional<std::chrono::milliseconds> limit)
{
    const auto deadline = limit ? Clock::now() + *limit : NEVER;
    Pipe output, errors;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, output.ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, errors.ends[1], STDERR_FILENO);

    const auto variables = mergedEnvironment(environment);
    pid_t process = 0;
    const int problem = posix_spawnp(&process, command.front().c_str(), &actions, nullptr, pointers(command).data(),
                                     pointers(variables).data());
    posix_spawn_file_actions_destroy(&actions);
    if (problem != 0)
        fail("cannot start {}: {}", command.front(), std::strerror(problem));

    output.closeEnd(1);
    errors.closeEnd(1);
    ProcessResult result;
    std::optional<int> ended;
    if (drain(output, errors, deadline, result)) {
        ended = statusOf(process, deadline);
        result.timedOut = !ended;
    }
    if (!ended)
        kill(process, SIGKILL);
    const int status = ended ? *ended : statusOf(process, NEVER).value();
    result.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return result;
}

}  // namespace restirpg
