#include "pipeline/study/study_page.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/report/csv_table.h"
#include "pipeline/report/plot_canvas.h"
#include "pipeline/study/study_table.h"

namespace wry::pipeline {

namespace {

using nlohmann::json;

constexpr std::size_t MOST_CURVE_POINTS = 400;

json parameters_json(const std::vector<StudyRow>& rows) {
  json list = json::array();
  for (const ParameterAxis& axis : parameter_axes(rows))
    list.push_back({{"key", axis.key}, {"label", axis.label}, {"numeric", axis.numeric}, {"values", axis.values}});
  return list;
}

/// Every column of measure.csv over the frames, thinned; what is no number becomes null.
json curves_json(const StudyRow& row) {
  const CsvTable table = read_csv_table(row.folder / "measure.csv");
  json curves = json::object();
  const std::size_t stride = 1 + table.rows.size() / MOST_CURVE_POINTS;
  for (const std::string& column : table.columns) {
    const std::vector<double> numbers = table.numbers(column);
    json values = json::array();
    for (std::size_t i = 0; i < numbers.size(); i += stride)
      values.push_back(std::isfinite(numbers[i]) ? json(numbers[i]) : json());
    curves[column] = std::move(values);
  }
  return curves;
}

json wedge_json(const StudyRow& row, const StudyPictures& pictures, const std::string& part) {
  json parameters = json::object(), measures = json::object();
  for (const Parameter& parameter : row.variant.parameters)
    parameters[parameter.key] = plain_value(parameter.value);
  for (const auto& [name, value] : row.measures) {
    if (const double number = number_of(value); std::isfinite(number) && name != "frame" && name != "time_s")
      measures[name] = number;
  }
  json wedge = {{"id", row.variant.id()},       {"index", row.variant.index},
                {"name", row.variant.name},     {"outcome", outcome_name(row.outcome)},
                {"reason", row.reason},         {"parameters", parameters},
                {"measures", measures},         {"curves", curves_json(row)},
                {"wall_s", row.wall_seconds},   {"cpu_s", row.cpu_seconds},
                {"peak_bytes", row.peak_bytes}, {"folder", part + "/" + row.variant.id()}};
  if (const auto strip = pictures.strips.find(row.variant.id()); strip != pictures.strips.end()) {
    wedge["strip"] = {{"file", strip->second.file},
                      {"width", strip->second.cell_width},
                      {"height", strip->second.cell_height},
                      {"columns", strip->second.columns},
                      {"frames", strip->second.frames}};
    wedge["image"] = fmt::format("{}/{}/images/{}.{}.", part, row.variant.id(), *row.shot->shot.name, pictures.view);
  }
  return wedge;
}

} // namespace

std::string json_for_script(const std::string& text) {
  std::string safe;
  for (const char c : text)
    safe += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return safe;
}

std::string study_page_json(const std::string& name, const std::vector<StudyRow>& rows, const StudyPictures& pictures) {
  json wedges = json::array();
  for (const StudyRow& row : rows)
    wedges.push_back(wedge_json(row, pictures, row.folder.parent_path().filename().string()));
  const json page = {{"name", name},
                     {"summary", study_summary(rows)},
                     {"sheet", pictures.sheet},
                     {"mosaic", pictures.mosaic},
                     {"parameters", parameters_json(rows)},
                     {"measures", measure_names(rows)},
                     {"wedges", wedges}};
  return page.dump(-1, ' ', true, json::error_handler_t::replace);
}

Status write_study_page(const std::filesystem::path& folder, const std::string& name, const std::vector<StudyRow>& rows,
                        const StudyPictures& pictures) {
  std::string page = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
                     "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>";
  page += escape_markup(name) + ": sweep</title>\n<style>";
  page += study_page_style();
  page += "</style></head>\n<body>";
  page += study_page_body();
  page += "<script type=\"application/json\" id=\"study\">";
  page += json_for_script(study_page_json(name, rows, pictures));
  page += "</script>\n<script>";
  page += study_page_script();
  page += "</script>\n</body></html>\n";
  return write_file_atomically(folder / "index.html", page);
}

} // namespace wry::pipeline
