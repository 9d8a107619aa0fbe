#include "tests/shots/mutation_support.h"

#include <algorithm>
#include <fstream>
#include <random>
#include <regex>
#include <sstream>

#include "shots/resolved.h"
#include "shots/sweep.h"
#include "tests/shots/shots_support.h"

namespace wry::shots {
namespace {

/// Values that shots get wrong.
const std::vector<std::string> AWKWARD{"nan",
                                       "-inf",
                                       "1e400",
                                       "-1",
                                       "0",
                                       "1e-320",
                                       "0x7fffffffffffffff",
                                       "99999999999999999999",
                                       "\"\"",
                                       "\"\\u0000\"",
                                       "\"auto\"",
                                       "\"last\"",
                                       "\"../..\"",
                                       "\"1-1000000000\"",
                                       "\"1-9x0\"",
                                       "[]",
                                       "{}",
                                       "[[]]",
                                       "[nan, inf, 1]",
                                       "[1, 2, 3]",
                                       "[1, \"a\"]",
                                       "[{}, {}]",
                                       "{ a = 1 }",
                                       "true",
                                       "1979-05-27",
                                       "07:32:00",
                                       "'''\n\n'''",
                                       "\"\xc3\xa9\"",
                                       "\xff\xfe",
                                       "0.5",
                                       "1",
                                       "{ from = 1 }",
                                       "\"x\"",
                                       "\"skin\"",
                                       "1_000",
                                       "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"};
const std::vector<std::string> LINES{"[shot]",         "[[body]]",    "[material]",   "[material.skin]", "[sweep]",
                                     "[[sweep.case]]", "extends = 1", "[a.b.c]",      "name = \"x\"",    "[[fixed]]",
                                     "[mpm]",          "body = 1",    "[[material]]", "x.y.z = 1",       "\"\" = 1",
                                     "[[measure]]",    "[expect.x]",  "where = {}",   "[render.heat]",   "case = 3"};

class Mutator {
public:
  explicit Mutator(std::uint64_t seed)
      : m_random(seed) {}

  /// key=value with a key of the shot that may have a typo, and an awkward value.
  std::string override_text(const std::vector<FlatKey>& keys) {
    std::string key = keys[pick(keys.size())].key;
    switch (pick(4)) {
    case 0:
      std::swap(key[pick(key.size())], key[pick(key.size())]);
      break;
    case 1:
      key.erase(pick(key.size()));
      break;
    case 2:
      key.insert(pick(key.size()), 1, ".\"'=[x0"[pick(7)]);
      break;
    default:
      break;
    }
    return key + "=" + AWKWARD[pick(AWKWARD.size())];
  }

  std::string mutate(std::string text) {
    const int times = 1 + static_cast<int>(pick(3));
    for (int i = 0; i < times; ++i) {
      text = pick(3) == 0 ? mutate_bytes(std::move(text)) : mutate_lines(std::move(text));
    }
    return text;
  }

  std::size_t pick(std::size_t count) { return count == 0 ? 0 : m_random() % count; }

private:
  std::string mutate_bytes(std::string text) {
    const std::size_t at = pick(text.size());
    switch (pick(5)) {
    case 0:
      return text.erase(at, 1 + pick(8));
    case 1:
      return text.insert(at, 1, static_cast<char>(pick(256)));
    case 2:
      return text.insert(at, 1, "[]{}=\"'.,#\n\\"[pick(12)]);
    case 3:
      return text.substr(0, at);
    default:
      if (!text.empty()) {
        text[at] = static_cast<char>(pick(256));
      }
      return text;
    }
  }

  std::string mutate_lines(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
      lines.push_back(line);
    }
    if (lines.empty()) {
      return LINES[pick(LINES.size())];
    }
    const std::size_t at = pick(lines.size());
    std::string& line = lines[at];
    switch (pick(7)) {
    case 0:
      lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(at));
      break;
    case 1:
      lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(pick(lines.size())), std::string(line));
      break;
    case 2:
      std::swap(line, lines[pick(lines.size())]);
      break;
    case 3:
      lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(at), LINES[pick(LINES.size())]);
      break;
    case 4: { // a typo in a key
      const std::size_t equals = std::min(line.find('='), line.size());
      if (equals > 1 && equals < line.size()) {
        std::swap(line[pick(equals)], line[pick(equals)]);
      }
      break;
    }
    default: { // another value
      const std::size_t equals = line.find(" = ");
      if (equals != std::string::npos) {
        line = line.substr(0, equals + 3) + AWKWARD[pick(AWKWARD.size())];
      }
    }
    }
    std::string joined;
    for (const std::string& item : lines) {
      joined += item + "\n";
    }
    return joined;
  }

  std::mt19937_64 m_random;
};

void check_error(const Error& error, const std::string& text) {
  static const std::regex SYNTAX(R"(^t\.toml:\d+:\d+: (this is not TOML: .+|.* nested more than .*))");
  static const std::regex PLACED(R"(^t\.toml:(\d+):\d+: ([A-Za-z0-9_"-].*?)( = |: | is ).+)");
  EXPECT_TRUE(error.code == ErrorCode::bad_input || error.code == ErrorCode::missing_input);
  std::istringstream lines(error.message);
  const auto last = std::count(text.begin(), text.end(), '\n') + 1;
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    const bool placed = std::regex_search(line, match, PLACED, std::regex_constants::match_continuous);
    if (placed) {
      EXPECT_GE(std::stol(match[1]), 1) << line;
      EXPECT_LE(std::stol(match[1]), last) << line;
    }
    const bool known = placed || line.rfind("and ", 0) == 0 ||
                       std::regex_search(line, match, SYNTAX, std::regex_constants::match_continuous);
    EXPECT_TRUE(known) << "no place or key: " << line << "\n--- in\n" << text;
  }
}

void check_override_error(const Error& error, const std::string& text) {
  std::istringstream lines(error.message);
  for (std::string line; std::getline(lines, line);) {
    // What an override breaks elsewhere, a name that others refer to, stands in the file.
    const bool known = line.rfind("--set: ", 0) == 0 || line.rfind("t.toml:", 0) == 0 || line.rfind("and ", 0) == 0 ||
                       (error.code == ErrorCode::usage && line.rfind("--set ", 0) == 0);
    EXPECT_TRUE(known) << "no place: " << line << "\n--- for --set " << text;
  }
}

void check_accepted(const Shot& shot, const std::string& text) {
  const std::string resolved = write_resolved(shot);
  const Result<ShotDocument> document = read_document_text(resolved, shot.file, shot.directory);
  ASSERT_TRUE(document.ok()) << document.error().message << "\n--- from\n" << text;
  const Result<Shot> again = make_shot(*document);
  ASSERT_TRUE(again.ok()) << again.error().message << "\n--- from\n" << text;
  EXPECT_TRUE(compare(flatten(shot), flatten(*again)).empty()) << text;
}

} // namespace

MutationCounts load_mutations(std::uint64_t seed, int count) {
  std::ifstream stream(data_file("every_key.toml"));
  const std::string every_key((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  EXPECT_FALSE(every_key.empty());
  Mutator mutator(seed);
  MutationCounts counts;
  for (int i = 0; i < count && !testing::Test::HasFailure(); ++i) {
    const std::string text = mutator.mutate(mutator.pick(2) == 0 ? every_key : std::string(SMALL_SHOT));
    const Result<ShotDocument> document = read_document_text(text, "t.toml", ".");
    if (!document) {
      check_error(document.error(), text);
      ++counts.syntax;
      continue;
    }
    if (const Result<std::vector<Wedge>> wedges = expand_sweep(*document); !wedges) {
      check_error(wedges.error(), text);
    }
    if (const Result<Shot> shot = make_shot(*document); shot) {
      check_accepted(*shot, text);
      ++counts.accepted;
    } else {
      check_error(shot.error(), text);
      ++counts.refused;
    }
  }
  return counts;
}

MutationCounts set_mutations(std::uint64_t seed, int count) {
  const Result<ShotDocument> document = read_document_text(SMALL_SHOT, "t.toml", ".");
  const std::vector<FlatKey> keys = flatten(*make_shot(*document));
  Mutator mutator(seed);
  MutationCounts counts;
  for (int i = 0; i < count && !testing::Test::HasFailure(); ++i) {
    const std::string text = mutator.override_text(keys);
    const Result<Override> change = parse_override(text);
    if (!change) {
      check_override_error(change.error(), text);
      ++counts.syntax;
      continue;
    }
    const Result<ShotDocument> changed = apply_overrides(*document, {*change});
    const Result<Shot> shot = changed ? make_shot(*changed) : Result<Shot>(changed.error());
    if (shot) {
      check_accepted(*shot, text);
      ++counts.accepted;
    } else {
      check_override_error(shot.error(), text);
      ++counts.refused;
    }
  }
  return counts;
}

} // namespace wry::shots
