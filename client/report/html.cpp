#include "client/report/html.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace creepctl {
namespace {

constexpr std::string_view kStyle = R"css(
:root { color-scheme: light dark; --ink: #1d1d1f; --muted: #5c5c62; --paper: #ffffff; --line: #d9d9de; --soft: #f4f4f6; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8ea; --muted: #a2a2aa; --paper: #17181b; --line: #3a3b40; --soft: #212226; }
}
body { margin: 2rem auto; padding: 0 1.2rem; max-width: 62rem; color: var(--ink); background: var(--paper);
  font: 15px/1.5 "DejaVu Sans", "Segoe UI", Helvetica, Arial, sans-serif; }
h1 { font-size: 1.6rem; margin: 0 0 .2rem; } h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; }
p { margin: .6rem 0; } .muted { color: var(--muted); } code, pre { font: 12.5px/1.45 "DejaVu Sans Mono", monospace; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; margin: .6rem 0; font-size: .88rem; }
th, td { padding: .28rem .7rem; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
th { border-bottom: 2px solid var(--line); font-weight: 600; }
table.numbers td:not(:first-child), table.numbers th:not(:first-child) { text-align: right; }
table.numbers { font-size: .8rem; } table.numbers th, table.numbers td { padding: .25rem .42rem; }
table.numbers td { font-variant-numeric: tabular-nums; white-space: nowrap; } sub { line-height: 0; }
pre { background: var(--soft); padding: .8rem 1rem; overflow-x: auto; border-radius: 4px; }
code { overflow-wrap: anywhere; }
figure { margin: 1.2rem 0; break-inside: avoid; } figure svg { width: 100%; height: auto; background: #fff; border-radius: 4px; }
figcaption { color: var(--muted); font-size: .86rem; }
.warning { border-left: 4px solid #d55e00; padding: .3rem .8rem; background: var(--soft); }
@media print { body { margin: 0; max-width: none; font-size: 11px; color: #000; background: #fff; }
  table { font-size: 9.5px; } th, td { padding: .15rem .4rem; } h2 { break-after: avoid; } tr { break-inside: avoid; }
  pre { white-space: pre-wrap; } .scroll { overflow: visible; } }
)css";

/// Escaped, with "_{...}" lowered as on the charts.
std::string cell_text(std::string_view text) {
  std::string out = html_escape(text);
  for (std::size_t at = out.find("_{"); at != std::string::npos; at = out.find("_{", at)) {
    const std::size_t close = out.find('}', at);
    if (close == std::string::npos) break;
    out = absl::StrCat(out.substr(0, at), "<sub>", out.substr(at + 2, close - at - 2), "</sub>",
                       out.substr(close + 1));
  }
  return out;
}

}  // namespace

std::string html_escape(std::string_view text) {
  std::string out;
  for (const char letter : text) {
    switch (letter) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += letter;
    }
  }
  return out;
}

std::string html_table(const std::vector<std::string>& head,
                       const std::vector<std::vector<std::string>>& rows, bool numbers) {
  std::string out =
      numbers ? "<div class=\"scroll\"><table class=\"numbers\">\n" : "<div class=\"scroll\"><table>\n";
  if (!head.empty()) {
    out += "<thead><tr>";
    for (const std::string& cell : head) absl::StrAppend(&out, "<th>", cell_text(cell), "</th>");
    out += "</tr></thead>\n";
  }
  out += "<tbody>\n";
  for (const auto& row : rows) {
    out += "<tr>";
    for (const std::string& cell : row) absl::StrAppend(&out, "<td>", cell_text(cell), "</td>");
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string html_document(std::string_view title, std::string_view body) {
  return absl::StrCat("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n",
                      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>",
                      html_escape(title), "</title>\n<style>", std::string(kStyle),
                      "</style>\n</head>\n<body>\n", std::string(body), "</body>\n</html>\n");
}

std::string html_figure(std::string_view svg, std::string_view caption) {
  std::string element(svg.substr(std::min(svg.find("<svg"), svg.size())));
  // The name spaces stand in the <svg> tag alone.
  const std::size_t tag_end = element.find('>');
  for (std::size_t at = element.find(" xmlns"); at < tag_end && at != std::string::npos;
       at = element.find(" xmlns")) {
    const std::size_t open = element.find('"', at);
    const std::size_t close = element.find('"', open + 1);
    element.erase(at, close + 1 - at);
  }
  return absl::StrCat("<figure>\n", element, "<figcaption>", html_escape(caption),
                      "</figcaption>\n</figure>\n");
}

}  // namespace creepctl
