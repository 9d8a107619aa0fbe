#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/report/plot.h"

namespace wry::pipeline {

/// A self-contained page of sections: no server, no other files, dark and light, wide screens and phones.
class HtmlPage {
public:
  explicit HtmlPage(std::string title)
      : m_title(std::move(title)) {}

  void section(const std::string& heading);
  void paragraph(const std::string& text);
  /// Red when bad.
  void warning(const std::string& text);
  /// Two columns: what, and its value.
  void facts(const std::vector<std::pair<std::string, std::string>>& rows);
  void table(const std::vector<std::string>& columns, const std::vector<std::vector<std::string>>& rows);
  void plot(const Plot& plot);
  /// Any SVG document of ours.
  void svg(const std::string& svg);
  /// The picture itself is in the page.
  void picture(const std::vector<std::uint8_t>& png, const std::string& caption);
  void link(const std::string& href, const std::string& text);

  std::string finish() const;

private:
  std::string m_title, m_body;
};

std::string base64(const std::vector<std::uint8_t>& bytes);

} // namespace wry::pipeline
