#include "app/progress.h"

#include "core/log.h"

#include <cmath>

#include <fmt/format.h>

#include <unistd.h>

namespace restirpg {
namespace {

constexpr int WIDTH = 24;  // characters of the bar
constexpr std::chrono::milliseconds REDRAW_INTERVAL(100);
constexpr const char* CLEAR_LINE = "\r\x1b[K";

}  // namespace

Progress::Progress(std::string label, uint32_t total)
    : label_(std::move(label)), total_(total), terminal_(isatty(STDERR_FILENO) == 1)
{
    if (terminal_)
        draw(0);
}

Progress::~Progress()
{
    if (terminal_)
        printError(CLEAR_LINE);
}

void Progress::advance()
{
    ++done_;
    const auto now = Clock::now();
    if (!terminal_ || now - drawn_ < REDRAW_INTERVAL)
        return;
    drawn_ = now;
    draw(std::chrono::duration<double>(now - start_).count());
}

void Progress::draw(double elapsed) const
{
    const int filled = int(int64_t(WIDTH) * done_ / total_);
    const std::string bar = std::string(filled, '=') + (filled < WIDTH ? ">" : "");
    std::string text = fmt::format("{}{} [{:<{}}] {}/{}", CLEAR_LINE, label_, bar, WIDTH, done_, total_);
    if (done_ > 0) {
        const double each = elapsed / done_;
        text += fmt::format("  {:.3g} s each  ETA {}", each, clockText(each * (total_ - done_)));
    }
    printError(text);
}

std::string clockText(double seconds)
{
    const int64_t whole = std::llround(seconds);
    if (whole >= 3600)
        return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
    return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace restirpg
