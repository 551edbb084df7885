#include "app/interruption.h"

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include <unistd.h>

namespace restirpg {
namespace {

constexpr std::array<int, 3> SIGNALS = {SIGINT, SIGTERM, SIGHUP};
volatile std::sig_atomic_t came = 0;

/// Give the signals whose action is `expected` another one.
void setActions(void (*expected)(int), void (*action)(int))
{
    for (const int number : SIGNALS) {
        struct sigaction current;
        sigaction(number, nullptr, &current);
        if (current.sa_handler != expected)
            continue;
        current = {};
        current.sa_handler = action;
        current.sa_flags = SA_RESTART;
        sigaction(number, &current, nullptr);
    }
}

/// Calls only what a signal handler may call.
void note(int number)
{
    constexpr std::string_view TEXT =
        "\ninterrupted: this frame is ended and what there is is written; once more: end at once\n";
    came = number;
    setActions(note, SIG_DFL);
    if (write(STDERR_FILENO, TEXT.data(), TEXT.size()) < 0)
        return;  // nobody listens
}

}  // namespace

Interruption::Interruption()
{
    came = 0;
    setActions(SIG_DFL, note);
}

Interruption::~Interruption()
{
    setActions(note, SIG_DFL);
}

int Interruption::signal() const
{
    return came;
}

void Interruption::end() const
{
    std::fflush(stdout);
    std::raise(came);
    std::_Exit(128 + came);  // the signal is blocked
}

}  // namespace restirpg
