// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cassert>

#include "base/output_file.h"
#include "compare/report/page.h"

namespace alidade {

std::string fill_page(std::string_view page,
                      const std::vector<std::pair<std::string_view, std::string_view>>& values) {
  std::string filled;
  std::size_t begin = 0;
  for (std::size_t open = page.find("{{"); open != std::string_view::npos; open = page.find("{{", begin)) {
    const std::size_t close = page.find("}}", open);
    const std::string_view name = page.substr(open + 2, close - open - 2);
    const auto value = std::ranges::find(values, name, &std::pair<std::string_view, std::string_view>::first);
    assert(close != std::string_view::npos && value != values.end());
    filled.append(page.substr(begin, open - begin)).append(value->second);
    begin = close + 2;
  }
  return filled.append(page.substr(begin));
}

std::string html_text(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string script_json(std::string json) {
  for (std::size_t place = json.find('<'); place != std::string::npos; place = json.find('<', place))
    json.replace(place, 1, "\\u003c");
  return json;
}

void write_page(const std::string& page, const std::filesystem::path& file, bool overwrite) {
  OutputFile output(file, overwrite);
  output.write(std::as_bytes(std::span(page)));
  output.commit();
}

}  // namespace alidade
