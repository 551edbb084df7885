#include "core/table.h"

#include <algorithm>
#include <sstream>

namespace restirpg {
namespace {

/// Code points, which is what a terminal's columns count for the Latin and Greek we print.
size_t columns(const std::string& text)
{
    return size_t(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string escapedPipes(const std::string& cell)
{
    std::string result;
    for (const char c : cell)
        result += c == '|' ? std::string("\\|") : std::string(1, c);
    return result;
}

}  // namespace

std::string wrapped(const std::string& text, size_t from, size_t width)
{
    const size_t room = std::max(width, from + 24) - from;
    std::string result, line;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        if (!line.empty() && columns(line) + 1 + columns(word) > room) {
            result += line + '\n' + std::string(from, ' ');
            line.clear();
        }
        line += (line.empty() ? "" : " ") + word;
    }
    return result + line;
}

std::string Table::text(const std::string& indent, size_t width) const
{
    std::vector<size_t> widths(rows_.front().size(), 0);
    for (const auto& row : rows_)
        for (size_t i = 0; i < row.size(); ++i)
            widths[i] = std::max(widths[i], columns(row[i]));
    std::string result;
    for (const auto& row : rows_) {
        std::string line = indent;
        for (size_t i = 0; i + 1 < row.size(); ++i)
            line += row[i] + std::string(widths[i] - columns(row[i]) + 2, ' ');
        line += width > 0 ? wrapped(row.back(), columns(line), width) : row.back();
        line.erase(line.find_last_not_of(' ') + 1);
        result += line + '\n';
    }
    return result;
}

std::string Table::markdown() const
{
    std::string result;
    for (size_t i = 0; i < rows_.size(); ++i) {
        for (const auto& cell : rows_[i])
            result += "| " + escapedPipes(cell) + " ";
        result += "|\n";
        if (i > 0)
            continue;
        for (size_t column = 0; column < rows_[i].size(); ++column)
            result += "| --- ";
        result += "|\n";
    }
    return result;
}

}  // namespace restirpg
