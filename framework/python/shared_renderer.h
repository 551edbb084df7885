// A renderer that Python's threads may share.
#pragma once

#include "core/error.h"
#include "render/renderer.h"

#include <pybind11/pybind11.h>

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <unistd.h>

namespace restirpg::python {

/// A lock that is given in the order in which it was asked for: a thread that renders frame after frame would never let
/// another in.
class FairMutex {
public:
    void lock()
    {
        std::unique_lock lock(mutex_);
        const uint64_t ticket = next_++;
        turn_.wait(lock, [&] { return ticket == serving_; });
    }
    void unlock()
    {
        {
            std::lock_guard lock(mutex_);
            ++serving_;
        }
        turn_.notify_all();
    }

private:
    std::mutex mutex_;
    std::condition_variable turn_;
    uint64_t next_ = 0;
    uint64_t serving_ = 0;
};

/// Calls take turns. Each runs without the interpreter's lock, and never asks for it while it has the renderer's: no
/// two locks are waited for at once.
class SharedRenderer {
public:
    /// graphFile: that the graph was read from, or empty. outputs: that it got besides its own. bounces: in place of
    /// the scene's own cap.
    SharedRenderer(std::unique_ptr<Renderer> renderer, std::filesystem::path graphFile,
                   std::vector<std::string> outputs, std::optional<uint32_t> bounces)
        : graphFile(std::move(graphFile)), outputs(std::move(outputs)), bounces(bounces), renderer_(std::move(renderer))
    {
    }
    ~SharedRenderer()
    {
        // The device's threads are not in a forked process: destroying it there would wait for them.
        if (!isOwn())
            static_cast<void>(renderer_.release());
    }

    /// `action(renderer)`, which touches no Python object.
    template <typename Action>
    auto run(Action action)
    {
        if (!isOwn())
            fail("a renderer cannot be used in a forked process; start processes by "
                 "multiprocessing.get_context(\"spawn\") and make a "
                 "renderer in each");
        pybind11::gil_scoped_release release;
        std::lock_guard turn(mutex_);
        if (!renderer_)
            fail("this renderer was closed at the end of its `with`; make another one");
        return action(*renderer_);
    }

    std::filesystem::path graphFile;
    const std::vector<std::string> outputs;
    const std::optional<uint32_t> bounces;

    /// Give back what it has of the device. Later calls throw Error.
    void close()
    {
        if (!isOwn())
            return;  // whose turn it was may have stayed behind in the other process
        pybind11::gil_scoped_release release;
        std::lock_guard turn(mutex_);
        renderer_.reset();
    }

private:
    bool isOwn() const { return getpid() == process_; }

    std::unique_ptr<Renderer> renderer_;
    FairMutex mutex_;
    const pid_t process_ = getpid();
};

/// A method of Python's class that is a call of Renderer's: its arguments and result are no Python objects.
template <typename Result, typename... Arguments>
auto shared(Result (Renderer::*member)(Arguments...))
{
    return [member](SharedRenderer& shared, std::decay_t<Arguments>... arguments) {
        return shared.run([&](Renderer& renderer) -> std::decay_t<Result> { return (renderer.*member)(arguments...); });
    };
}

template <typename Result, typename... Arguments>
auto shared(Result (Renderer::*member)(Arguments...) const)
{
    return [member](SharedRenderer& shared, std::decay_t<Arguments>... arguments) {
        return shared.run(
            [&](const Renderer& renderer) -> std::decay_t<Result> { return (renderer.*member)(arguments...); });
    };
}

/// Defined in binding_edit.cpp: what can be changed of the scene.
void bindEdits(pybind11::class_<SharedRenderer>& renderer);

}  // namespace restirpg::python
