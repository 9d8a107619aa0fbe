#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/study/study.h"

namespace wry::pipeline {

/// All frames of one variant in one picture, small, row by row: what the page scrubs through without loading anything.
struct FrameStrip {
  std::string file; ///< relative to the study's folder; empty: the variant has no pictures
  int cell_width = 0, cell_height = 0;
  int columns = 0;
  std::vector<int> frames; ///< in the order of the cells
};

/// The pictures of a study.
struct StudyPictures {
  std::string view;                         ///< which view they show
  std::string sheet;                        ///< the labelled contact sheet; relative to the study's folder
  std::string mosaic;                       ///< the film of all variants side by side; empty: no ffmpeg, or one frame
  std::map<std::string, FrameStrip> strips; ///< by variant id
};

/// Makes a labelled contact sheet of the last frames, a film mosaic, and a strip per variant from whatever pictures
/// there are; failed variants keep their place with their reason. Errors: cannot_write, io, stopped.
Result<StudyPictures> make_study_pictures(const std::filesystem::path& folder, const std::vector<StudyRow>& rows);

} // namespace wry::pipeline
