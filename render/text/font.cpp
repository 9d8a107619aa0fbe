#include "render/text/font.h"

#include <algorithm>
#include <map>
#include <string>

namespace wry::render {
namespace {

// Each stroke: '-' straight through its points, '~' a curve from the first to the last, 'o' a closed curve; then points
// as two digits x y. The baseline is y = 2, capitals end at 9, small letters at 7, descenders at 0.
const std::map<char32_t, std::string_view> DRAWINGS = {
    {U'0', "o02094942 -1437"},
    {U'1', "-072922 -0242"},
    {U'2', "~0709494602 -0242"},
    {U'3', "~0809494616 ~1646420203"},
    {U'4', "-32390444"},
    {U'5', "-490906 ~0647420203"},
    {U'6', "~4829090242460604"},
    {U'7', "-094912"},
    {U'8', "o06094946 o02064642"},
    {U'9', "~0322424909054547"},
    {U'A', "-022942 -1434"},
    {U'B', "-0209 ~09494606 ~06464202"},
    {U'C', "~474909024244"},
    {U'D', "-0209 ~09494202"},
    {U'E', "-49090242 -0636"},
    {U'F', "-490902 -0636"},
    {U'G', "~474909024245 -4525"},
    {U'H', "-0209 -4249 -0646"},
    {U'I', "-1219 -0222 -0929"},
    {U'J', "~39320204"},
    {U'K', "-0209 -490542"},
    {U'L', "-090242"},
    {U'M', "-0209254942"},
    {U'N', "-02094249"},
    {U'O', "o02094942"},
    {U'P', "-0209 ~09494505"},
    {U'Q', "o02094942 -2451"},
    {U'R', "-0209 ~09494505 -2542"},
    {U'S', "~4849090645420203"},
    {U'T', "-0949 -2229"},
    {U'U', "~09024249"},
    {U'V', "-092249"},
    {U'W', "-0912273249"},
    {U'X', "-0249 -0942"},
    {U'Y', "-092649 -2622"},
    {U'Z', "-09490242"},
    {U'a', "o02074742 -4742"},
    {U'b', "-0209 o02074742"},
    {U'c', "~464707024243"},
    {U'd', "o02074742 -4942"},
    {U'e', "~454707024243 -0545"},
    {U'f', "~391916 -1612 -0737"},
    {U'g', "o02074742 -4742 ~42400001"},
    {U'h', "-0209 ~04074744 -4442"},
    {U'i', "-0207 -0909"},
    {U'j', "-1712 ~121000 -1919"},
    {U'k', "-0209 -370432"},
    {U'l', "-0903 ~031222"},
    {U'm', "-0207 ~05073735 -3532 ~35376765 -6562"},
    {U'n', "-0207 ~05074745 -4542"},
    {U'o', "o02074742"},
    {U'p', "-0007 o02074742"},
    {U'q', "-4047 o02074742"},
    {U'r', "-0207 ~05073736"},
    {U's', "~4647070544420203"},
    {U't', "-1914 ~141232 -0737"},
    {U'u', "-0705 ~05024245 -4742"},
    {U'v', "-072247"},
    {U'w', "-0712263247"},
    {U'x', "-0247 -0742"},
    {U'y', "-0722 -4710"},
    {U'z', "-07470242"},
    {U'.', "-0202"},
    {U',', "-1201"},
    {U':', "-0303 -0606"},
    {U';', "-1301 -1616"},
    {U'-', "-0535"},
    {U'+', "-0545 -2327"},
    {U'=', "-0444 -0646"},
    {U'_', "-0141"},
    {U'/', "-0149"},
    {U'\\', "-0941"},
    {U'(', "~29070421"},
    {U')', "~09272401"},
    {U'[', "-29090121"},
    {U']', "-09292101"},
    {U'{', "~29190515 ~05111121"},
    {U'}', "~09192515 ~25211101"},
    {U'%', "-0249 o07092927 o22244442"},
    {U'*', "-0446 -0644 -2723"},
    {U'<', "-480542"},
    {U'>', "-084502"},
    {U'\'', "-0907"},
    {U'"', "-0907 -2927"},
    {U'`', "-0918"},
    {U'!', "-0904 -0202"},
    {U'?', "~0809494625 -2524 -2222"},
    {U'#', "-1218 -3238 -0444 -0646"},
    {U'$', "~4747080645420304 -2119"},
    {U'&', "~4217291906024244"},
    {U'@', "~353725243446490902 -0242"},
    {U'^', "-072947"},
    {U'|', "-0009"},
    {U'~', "~05173547"},
    {U'\u00b0', "o07092927"},
    {U'\u00b5', "-0007 -0705 ~05024245 -4742"},
    {U'\u00b7', "-0505"},
};
constexpr std::string_view MISSING = "-0209494202";

using Point = std::array<double, 2>;

std::vector<Point> points_of(std::string_view digits) {
  std::vector<Point> points;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
    points.push_back({static_cast<double>(digits[i] - '0'), static_cast<double>(digits[i + 1] - '2')});
  return points;
}

/// Corner cutting (Chaikin 1974), three times: tends to a quadratic B-spline.
std::vector<Point> rounded(std::vector<Point> points, bool closed) {
  for (int round = 0; round < 3; ++round) {
    std::vector<Point> cut;
    const std::size_t edges = closed ? points.size() : points.size() - 1;
    for (std::size_t i = 0; i < edges; ++i) {
      const Point& a = points[i];
      const Point& b = points[(i + 1) % points.size()];
      const auto between = [&](double t) { return Point{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])}; };
      cut.push_back(!closed && i == 0 ? a : between(0.22));
      cut.push_back(!closed && i + 1 == edges ? b : between(0.78));
    }
    points = std::move(cut);
  }
  if (closed)
    points.push_back(points.front());
  return points;
}

Glyph drawn(std::string_view drawing) {
  Glyph made;
  double width = 0.0;
  while (!drawing.empty()) {
    const std::size_t end = std::min(drawing.find(' '), drawing.size());
    const char kind = drawing.front();
    std::vector<Point> points = points_of(drawing.substr(1, end - 1));
    for (const Point& point : points)
      width = std::max(width, point[0]);
    if (kind != '-')
      points = rounded(std::move(points), kind == 'o');
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
      made.strokes.push_back({points[i], points[i + 1]});
    drawing.remove_prefix(std::min(end + 1, drawing.size()));
  }
  made.advance = width + 2.0;
  return made;
}

std::map<char32_t, Glyph> draw_all() {
  std::map<char32_t, Glyph> glyphs;
  for (const auto& [letter, drawing] : DRAWINGS)
    glyphs[letter] = drawn(drawing);
  glyphs[U' '] = Glyph{{}, 4.0};
  return glyphs;
}

} // namespace

const Glyph& glyph(char32_t letter) {
  static const std::map<char32_t, Glyph> glyphs = draw_all();
  static const Glyph missing = drawn(MISSING);
  const auto found = glyphs.find(letter);
  return found != glyphs.end() ? found->second : missing;
}

std::u32string letters_of(std::string_view utf8) {
  std::u32string letters;
  for (std::size_t i = 0; i < utf8.size();) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(utf8[k]); };
    const unsigned char first = byte(i);
    const std::size_t more = first < 0x80 ? 0 : first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : first >= 0xC0 ? 1 : 0;
    char32_t letter = more == 0 ? first : first & (0x3FU >> more);
    bool good = (first < 0x80 || first >= 0xC0) && i + more < utf8.size();
    for (std::size_t k = 1; good && k <= more; ++k) {
      good = (byte(i + k) & 0xC0U) == 0x80U;
      letter = (letter << 6) | (byte(i + k) & 0x3FU);
    }
    letters.push_back(good ? letter : U'\uFFFD');
    i += good ? more + 1 : 1;
  }
  return letters;
}

} // namespace wry::render
