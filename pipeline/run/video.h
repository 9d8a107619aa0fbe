#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/base/result.h"

namespace wry::pipeline {

/// A film made from pictures.
struct VideoSettings {
  double fps = 24.0;
  int crf = 18;                   ///< x264's quality: 0 lossless, 18 hard to tell apart, 23 its default
  std::string program = "ffmpeg"; ///< a name looked up in PATH, or a path
  int threads = 2;                ///< the bytes of a film depend on it, so it is not the machine's
  std::chrono::seconds patience = std::chrono::minutes(5); ///< for the program to take or give something
};

/// Whether `program` can be started.
bool has_video_program(const std::string& program = "ffmpeg");

/// Encodes PNG pictures of one size, in that order, as H.264 in MP4 (yuv420p, tagged bt709, the index first), written
/// aside and renamed. An odd row or column at the edge is cut off, as yuv420p wants. The program gets the pictures
/// through its standard input, so frame numbers may have gaps. Errors: unavailable when there is no such program;
/// missing_input for a picture that is not there; cannot_write; io with the program's last words; stopped after a stop
/// signal.
Status encode_video(const std::vector<std::filesystem::path>& pictures, const std::filesystem::path& film,
                    const VideoSettings& settings);

} // namespace wry::pipeline
