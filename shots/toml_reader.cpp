#include "shots/toml_reader.h"

#include <algorithm>
#include <sstream>

// toml++ 3.3 asserts on keys that it goes on to refuse properly, so its assertions are off in every build. With NDEBUG
// they would become promises to the compiler instead.
#undef NDEBUG
#define TOML_ASSERT(expr) static_assert(true)
// The program links no shared parser: the one file that needs it carries it.
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>

#include "shots/load.h"

namespace wry::shots {
namespace {

constexpr std::size_t MAX_KEYS = 4096;

/// Copies toml++'s tree into ours; stops at the first table that is too large.
class Converter {
public:
  Converter(std::shared_ptr<const std::string> file, Origin origin, int layer)
      : m_file(std::move(file))
      , m_origin(origin)
      , m_layer(layer) {}

  Result<Table> table(const toml::table& source) {
    if (source.size() > MAX_KEYS) {
      const Place where = place(source.source());
      return make_error(ErrorCode::bad_input, "{}:{}:{}: a table with {} keys; at most {} are read", *m_file,
                        where.line, where.column, source.size(), MAX_KEYS);
    }
    Table table;
    for (const auto& [key, node] : source) {
      Result<Value> converted = value(node);
      if (!converted) {
        return converted.error();
      }
      table.entries().push_back(Entry{std::string(key.str()), place(key.source()), std::move(converted).value()});
    }
    std::stable_sort(table.entries().begin(), table.entries().end(), [](const Entry& a, const Entry& b) {
      return std::pair(a.key_place.line, a.key_place.column) < std::pair(b.key_place.line, b.key_place.column);
    });
    return table;
  }

private:
  Place place(const toml::source_region& region) const {
    return Place{m_file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column), m_origin, m_layer};
  }

  Result<Value> value(const toml::node& node) {
    const Place where = place(node.source());
    switch (node.type()) {
    case toml::node_type::boolean:
      return Value(node.ref<bool>(), where);
    case toml::node_type::integer:
      return Value(node.ref<std::int64_t>(), where);
    case toml::node_type::floating_point:
      return Value(node.ref<double>(), where);
    case toml::node_type::string:
      return Value(node.ref<std::string>(), where);
    case toml::node_type::array:
      return array(*node.as_array(), where);
    case toml::node_type::table: {
      Result<Table> converted = table(*node.as_table());
      if (!converted) {
        return converted.error();
      }
      return Value(std::move(converted).value(), where);
    }
    default:
      return Value(Unsupported{"a date or time"}, where);
    }
  }

  Result<Value> array(const toml::array& source, const Place& where) {
    Array items;
    items.reserve(source.size());
    for (const toml::node& node : source) {
      Result<Value> item = value(node);
      if (!item) {
        return item.error();
      }
      items.push_back(std::move(item).value());
    }
    return Value(std::move(items), where);
  }

  std::shared_ptr<const std::string> m_file;
  Origin m_origin;
  int m_layer;
};

Error parse_failure(const toml::parse_error& problem, const std::string& file) {
  return make_error(ErrorCode::bad_input, "{}:{}:{}: this is not TOML: {}", file, problem.source().begin.line,
                    problem.source().begin.column, excerpt(problem.description()));
}

} // namespace

Result<Table> parse_toml(std::string_view text, const std::string& file, int layer) {
  if (text.size() > MAX_FILE_BYTES) {
    return make_error(ErrorCode::bad_input, "{}:1:1: {} bytes; a shot file has at most {}", file, text.size(),
                      MAX_FILE_BYTES);
  }
  if (const Status nesting = check_toml_nesting(text, file); !nesting) {
    return nesting.error();
  }
  try {
    const toml::table parsed = toml::parse(text, std::string_view(file));
    return Converter(std::make_shared<const std::string>(file), Origin::file, layer).table(parsed);
  } catch (const toml::parse_error& problem) {
    return parse_failure(problem, file);
  } catch (const std::exception& problem) {
    return make_error(ErrorCode::bad_input, "{}:1:1: cannot be read as TOML: {}", file, problem.what());
  }
}

std::optional<Value> parse_toml_value(std::string_view text, const Place& place) {
  const std::string line = "value = " + std::string(text);
  if (text.size() > MAX_FILE_BYTES || text.find('\n') != std::string_view::npos || !check_toml_nesting(line, "")) {
    return std::nullopt;
  }
  try {
    const toml::table parsed = toml::parse(line);
    Result<Table> table = Converter(place.file, place.origin, place.layer).table(parsed);
    if (!table || table->entries().size() != 1) {
      return std::nullopt;
    }
    return std::move(table->entries().front().value);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

} // namespace wry::shots
