#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/study/study_pictures.h"

namespace wry::pipeline {

/// The study as data for the page: parameters with their values, variants with measures over time, strips.
std::string study_page_json(const std::string& name, const std::vector<StudyRow>& rows, const StudyPictures& pictures);

/// Writes index.html: a grid of variants by parameter, scrubbed together, a slider per parameter, plots of measures,
/// failures with their reason, a filter. One file beside the pictures; it needs no server. Errors: cannot_write, io.
Status write_study_page(const std::filesystem::path& folder, const std::string& name, const std::vector<StudyRow>& rows,
                        const StudyPictures& pictures);

/// JSON that can stand within <script>: no text in it ends the element.
std::string json_for_script(const std::string& text);

// The parts of the page that are the same for every study.
std::string_view study_page_style();
std::string_view study_page_body();
std::string_view study_page_script();

} // namespace wry::pipeline
