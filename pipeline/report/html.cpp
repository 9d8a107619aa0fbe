#include "pipeline/report/html.h"

#include "pipeline/report/plot_canvas.h"

namespace wry::pipeline {

namespace {

constexpr std::string_view STYLE = R"css(
:root{color-scheme:light dark;--bg:#f4f5f7;--card:#fff;--ink:#1c2128;--soft:#5a6470;--line:#d9dde2;--bad:#b3261e;--link:#1f6fb4}
@media(prefers-color-scheme:dark){:root{--bg:#101316;--card:#16191d;--ink:#e8eaed;--soft:#9aa4af;--line:#2e343b;--bad:#ff8a80;--link:#6db3f2}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:1240px;padding:16px;background:var(--bg);color:var(--ink);font:15px/1.5 system-ui,'DejaVu Sans',sans-serif}
h1{font-size:22px;margin:4px 4px 14px}
h2{font-size:16px;margin:0 0 8px}
section{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:14px;margin:0 0 14px}
dl{display:grid;grid-template-columns:minmax(90px,max-content) 1fr;gap:2px 16px;margin:0;font-variant-numeric:tabular-nums}
dt{color:var(--soft)}dd{margin:0;overflow-wrap:anywhere}
.bad{color:var(--bad)}a{color:var(--link)}
.scroll{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:3px 14px 3px 0;border-bottom:1px solid var(--line);vertical-align:top}
th{color:var(--soft);font-weight:500}
figure{display:inline-block;margin:0 10px 10px 0;max-width:100%;vertical-align:top}
figure img,figure svg{max-width:100%;height:auto;border-radius:4px;display:block}
figcaption{color:var(--soft);font-size:13px}
)css";

} // namespace

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const std::uint32_t word = static_cast<std::uint32_t>(bytes[i]) << 16 |
                               (left > 1 ? static_cast<std::uint32_t>(bytes[i + 1]) << 8 : 0u) |
                               (left > 2 ? static_cast<std::uint32_t>(bytes[i + 2]) : 0u);
    text += LETTERS[word >> 18];
    text += LETTERS[word >> 12 & 63];
    text += left > 1 ? LETTERS[word >> 6 & 63] : '=';
    text += left > 2 ? LETTERS[word & 63] : '=';
  }
  return text;
}

void HtmlPage::section(const std::string& heading) {
  m_body += (m_body.empty() ? "<section><h2>" : "</section>\n<section><h2>") + escape_markup(heading) + "</h2>\n";
}

void HtmlPage::paragraph(const std::string& text) {
  m_body += "<p>" + escape_markup(text) + "</p>\n";
}

void HtmlPage::warning(const std::string& text) {
  m_body += "<p class=\"bad\">" + escape_markup(text) + "</p>\n";
}

void HtmlPage::facts(const std::vector<std::pair<std::string, std::string>>& rows) {
  m_body += "<dl>";
  for (const auto& [what, value] : rows)
    m_body += "<dt>" + escape_markup(what) + "</dt><dd>" + escape_markup(value) + "</dd>\n";
  m_body += "</dl>\n";
}

void HtmlPage::table(const std::vector<std::string>& columns, const std::vector<std::vector<std::string>>& rows) {
  m_body += "<div class=\"scroll\"><table><tr>";
  for (const std::string& column : columns)
    m_body += "<th>" + escape_markup(column) + "</th>";
  m_body += "</tr>\n";
  for (const std::vector<std::string>& row : rows) {
    m_body += "<tr>";
    for (const std::string& cell : row)
      m_body += "<td>" + escape_markup(cell) + "</td>";
    m_body += "</tr>\n";
  }
  m_body += "</table></div>\n";
}

void HtmlPage::plot(const Plot& plot) {
  svg(plot_svg(plot));
}

void HtmlPage::svg(const std::string& svg) {
  m_body += "<figure>" + svg + "</figure>\n";
}

void HtmlPage::picture(const std::vector<std::uint8_t>& png, const std::string& caption) {
  m_body += "<figure><img alt=\"" + escape_markup(caption) + "\" src=\"data:image/png;base64," + base64(png) +
            "\"><figcaption>" + escape_markup(caption) + "</figcaption></figure>\n";
}

void HtmlPage::link(const std::string& href, const std::string& text) {
  m_body += "<p><a href=\"" + escape_markup(href) + "\">" + escape_markup(text) + "</a></p>\n";
}

std::string HtmlPage::finish() const {
  std::string page = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta name=\"viewport\" "
                     "content=\"width=device-width, initial-scale=1\">\n<title>";
  page += escape_markup(m_title) + "</title>\n<style>";
  page += STYLE;
  page += "</style></head>\n<body><h1>" + escape_markup(m_title) + "</h1>\n" + m_body;
  page += m_body.empty() ? "" : "</section>\n";
  return page + "</body></html>\n";
}

} // namespace wry::pipeline
