// Tables for people: aligned text and Markdown.
#pragma once

#include <string>
#include <vector>

namespace restirpg {

/// Text that starts at the column `from`, broken between words where it would pass `width`, but never into lines of
/// less than 24.
std::string wrapped(const std::string& text, size_t from, size_t width);

class Table {
public:
    explicit Table(std::vector<std::string> headers) : rows_{std::move(headers)} {}

    /// A row with as many cells as there are headers.
    void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
    bool empty() const { return rows_.size() == 1; }

    /// Columns aligned by spaces, each line indented. Lines longer than `width` are broken between words of the last
    /// column; 0: none is.
    std::string text(const std::string& indent = "  ", size_t width = 0) const;
    std::string markdown() const;

private:
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace restirpg
