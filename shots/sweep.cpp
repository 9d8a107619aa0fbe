#include "shots/sweep.h"

#include <algorithm>
#include <cmath>

#include "shots/key_path.h"
#include "shots/sweep_plan.h"

namespace wry::shots {
namespace {

/// FNV-1a, so that folder names stay the same on every machine.
std::uint64_t hash_text(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : text) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  return hash;
}

/// SplitMix64: the shot's seed gives the same draws everywhere.
class Random {
public:
  explicit Random(std::uint64_t seed)
      : m_state(seed) {}
  std::uint64_t next() {
    std::uint64_t z = m_state += 0x9e3779b97f4a7c15ULL;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }

private:
  std::uint64_t m_state;
};

/// One sample in each of `count` equal strata of every axis, in shuffled order.
std::vector<Value> draw(const SweepAxis& axis, std::size_t count, Random& random) {
  std::vector<std::size_t> strata(count);
  for (std::size_t i = 0; i < count; ++i) {
    strata[i] = i;
  }
  for (std::size_t i = count; i > 1; --i) {
    std::swap(strata[i - 1], strata[random.next() % i]);
  }
  std::vector<Value> values;
  for (const std::size_t stratum : strata) {
    const double s = (static_cast<double>(stratum) + random.uniform()) / static_cast<double>(count);
    if (!axis.range) {
      values.push_back(axis.values[static_cast<std::size_t>(s * static_cast<double>(axis.values.size()))]);
    } else if (axis.range->logarithmic) {
      values.emplace_back(axis.range->from * std::pow(axis.range->to / axis.range->from, s));
    } else {
      values.emplace_back(axis.range->from + (axis.range->to - axis.range->from) * s);
    }
  }
  return values;
}

std::int64_t seed_of(const Table& root) {
  const Value* shot = root.find("shot");
  const Table* table = shot ? shot->get<Table>() : nullptr;
  const Value* seed = table ? table->find("seed") : nullptr;
  const auto* number = seed ? seed->get<std::int64_t>() : nullptr;
  return number ? *number : 1;
}

/// "length_scale" for material.skin.length_scale, or the whole key where two axes end alike.
std::vector<std::string> labels_of(const std::vector<SweepAxis>& axes) {
  std::vector<std::string> labels;
  for (const SweepAxis& axis : axes) {
    const auto last = [](const std::string& key) { return key.substr(key.rfind('.') + 1); };
    const auto alike = std::count_if(axes.begin(), axes.end(),
                                     [&](const SweepAxis& other) { return last(other.key) == last(axis.key); });
    labels.push_back(alike > 1 ? axis.key : last(axis.key));
  }
  return labels;
}

/// Which value of each axis a row takes: one row per wedge, without the cases.
class Combinations {
public:
  Combinations(SweepPlan& plan, const Table& root)
      : m_plan(plan) {
    if (plan.mode == SweepMode::latin_hypercube) {
      Random random(static_cast<std::uint64_t>(seed_of(root)));
      for (SweepAxis& axis : plan.axes) {
        axis.values = draw(axis, plan.samples, random);
      }
    }
  }

  std::size_t count() const {
    if (m_plan.axes.empty()) {
      return 1;
    }
    if (m_plan.mode != SweepMode::grid) {
      return m_plan.axes.front().values.size();
    }
    std::size_t product = 1;
    for (const SweepAxis& axis : m_plan.axes) {
      product = std::min(product * axis.values.size(), MAX_WEDGES + 1); // lists are short: no overflow
    }
    return product;
  }

  std::vector<const Value*> row(std::size_t index) const {
    std::vector<const Value*> values(m_plan.axes.size());
    for (std::size_t i = values.size(); i-- > 0;) {
      const std::vector<Value>& list = m_plan.axes[i].values;
      const bool grid = m_plan.mode == SweepMode::grid;
      values[i] = &list[grid ? index % list.size() : index];
      index = grid ? index / list.size() : index;
    }
    return values;
  }

private:
  SweepPlan& m_plan;
};

Status check_zip(const SweepPlan& plan) {
  for (const SweepAxis& axis : plan.axes) {
    if (plan.mode == SweepMode::zip && axis.values.size() != plan.axes.front().values.size()) {
      return make_error(ErrorCode::bad_input, "{}: {} values, but {} has {}; zipped lists are equally long",
                        axis.source.text(), axis.values.size(), plan.axes.front().key, plan.axes.front().values.size());
    }
  }
  return {};
}

std::string case_identity(const SweepCase& sweep_case) {
  std::string text = "case=" + sweep_case.name + "\n";
  for (const auto& [key, value] : sweep_case.set) {
    text += key + "=" + to_toml(value) + "\n";
  }
  return text;
}

/// How a wedge is called: "0.1" and "soft" rather than "\"soft\"".
std::string label_value(const Value& value) {
  const auto* text = value.get<std::string>();
  return excerpt(text ? *text : value.get<double>() ? fmt::format("{:.6g}", value.number()) : to_toml(value));
}

Wedge make_wedge(const SweepPlan& plan, const SweepCase* sweep_case, const std::vector<const Value*>& row,
                 const std::vector<std::string>& labels) {
  Wedge wedge;
  std::string identity;
  if (sweep_case) {
    wedge.name = sweep_case->name;
    wedge.overrides.push_back(Override{"case", sweep_case->name, sweep_case->source});
    identity = case_identity(*sweep_case);
  }
  for (std::size_t i = 0; i < row.size(); ++i) {
    const std::string value = to_toml(*row[i]);
    wedge.overrides.push_back(Override{plan.axes[i].key, value, plan.axes[i].source});
    wedge.name += fmt::format("{}{}={}", wedge.name.empty() ? "" : ", ", labels[i], label_value(*row[i]));
    identity += plan.axes[i].key + "=" + value + "\n";
  }
  const std::uint64_t hash = hash_text(identity);
  wedge.hash = fmt::format("{:08x}", static_cast<std::uint32_t>(hash ^ (hash >> 32)));
  return wedge;
}

} // namespace

std::string Wedge::id() const {
  return fmt::format("{:03}-{}", index, hash);
}

Result<std::vector<Wedge>> expand_sweep(const ShotDocument& document) {
  Diagnostics diagnostics;
  SweepPlan plan = plan_sweep(document.root(), diagnostics);
  if (!diagnostics.empty()) {
    return diagnostics.error();
  }
  if (plan.axes.empty() && plan.cases.empty()) {
    return std::vector<Wedge>{};
  }
  if (const Status zipped = check_zip(plan); !zipped) {
    return zipped.error();
  }
  const Combinations combinations(plan, document.root());
  std::vector<const SweepCase*> cases;
  for (const SweepCase& sweep_case : plan.cases) {
    cases.push_back(&sweep_case);
  }
  if (cases.empty()) {
    cases.push_back(nullptr);
  }
  if (combinations.count() > MAX_WEDGES || combinations.count() * cases.size() > MAX_WEDGES) {
    return make_error(ErrorCode::bad_input, "{}: sweep: more than {} wedges; shorten its lists, or zip them",
                      document.file(), MAX_WEDGES);
  }
  const std::vector<std::string> labels = labels_of(plan.axes);
  std::vector<Wedge> wedges;
  for (const SweepCase* sweep_case : cases) {
    for (std::size_t i = 0; i < combinations.count(); ++i) {
      wedges.push_back(make_wedge(plan, sweep_case, combinations.row(i), labels));
      wedges.back().index = static_cast<int>(wedges.size()) - 1;
    }
  }
  return wedges;
}

} // namespace wry::shots
