// Ctrl-C and its like in a long rendering: end it, but keep what there is.
#pragma once

namespace restirpg {

/// While it lives, the first SIGINT, SIGTERM or SIGHUP is noted, and said so on standard error; the next one ends the
/// program at once, as all do at other times. A signal that the program was told to ignore (nohup) stays ignored.
class Interruption {
public:
    Interruption();
    ~Interruption();
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    /// Number of the signal that came; 0: none.
    int signal() const;
    /// End the program by the signal that came, so that whoever started it sees that it was interrupted.
    [[noreturn]] void end() const;
};

}  // namespace restirpg
