// A progress bar on standard error, when that is a terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace restirpg {

/// "label [=====>    ] 12/64  0.8 s each  ETA 0:42", redrawn in place and cleared at the end.
class Progress {
public:
    Progress(std::string label, uint32_t total);
    ~Progress();  ///< clears the line
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void advance();

private:
    using Clock = std::chrono::steady_clock;

    void draw(double elapsed) const;

    std::string label_;
    uint32_t total_;
    uint32_t done_ = 0;
    bool terminal_;
    Clock::time_point start_ = Clock::now();
    Clock::time_point drawn_{};
};

/// 75 s as "1:15", 3700 s as "1:01:40".
std::string clockText(double seconds);

}  // namespace restirpg
