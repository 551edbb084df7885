// Tables for people: aligned text and Markdown.
#pragma once

#include <string>
#include <vector>

namespace restirpg {

class Table {
public:
    explicit Table(std::vector<std::string> headers) : rows_{std::move(headers)} {}

    /// A row with as many cells as there are headers.
    void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
    bool empty() const { return rows_.size() == 1; }

    /// Columns aligned by spaces, each line indented.
    std::string text(const std::string& indent = "  ") const;
    std::string markdown() const;

private:
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace restirpg
