// Pieces of an HTML page.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace creepctl {

/// Text with the five characters that mean something to HTML written as entities.
std::string html_escape(std::string_view text);

/// A table; cells are escaped here and "_{...}" in them is lowered. `numbers`: all columns but the first are
/// set flush right.
std::string html_table(const std::vector<std::string>& head,
                       const std::vector<std::vector<std::string>>& rows, bool numbers);

/// Head, style for screen (light and dark) and print, and body: a whole document that refers to nothing
/// outside.
std::string html_document(std::string_view title, std::string_view body);

/// An SVG file as an element of such a document: without its XML head and name spaces, which HTML implies.
std::string html_figure(std::string_view svg, std::string_view caption);

}  // namespace creepctl
