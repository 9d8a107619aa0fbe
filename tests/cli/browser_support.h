#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>
#include <sys/types.h>

namespace wry::cli_test {

/// A headless Chromium that shows one page, driven over the DevTools protocol through two pipes.
class Browser {
public:
  Browser(int width, int height);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  static bool is_installed();
  /// Empty when it runs; else why not.
  const std::string& problem() const { return m_problem; }

  /// Opens a file and waits until it has loaded.
  void open(const std::filesystem::path& file);
  /// The value of a JavaScript expression; a promise is waited for. An exception becomes a string beginning with
  /// "threw".
  nlohmann::json evaluate(const std::string& script);
  /// Presses, moves and lets go of the left mouse button, at page coordinates.
  void drag(double from_x, double from_y, double to_x, double to_y);
  void click(double x, double y) { drag(x, y, x, y); }
  void save_screenshot(const std::filesystem::path& file);
  /// Errors that the page's scripts threw or logged.
  const std::string& complaints() const { return m_complaints; }

private:
  nlohmann::json call(const std::string& method, const nlohmann::json& parameters);
  nlohmann::json read_message();
  pid_t m_child = 0;
  int m_to = -1, m_from = -1;
  int m_next = 1;
  std::string m_buffer, m_session, m_problem, m_complaints;
  std::filesystem::path m_profile;
};

} // namespace wry::cli_test
