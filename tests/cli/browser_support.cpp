#include "tests/cli/browser_support.h"

#include <csignal>
#include <cstdlib>
#include <fstream>

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/cli/slurm_support.h"

namespace wry::cli_test {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int PATIENCE_MS = 30000;

std::string decoded_base64(const std::string& text) {
  std::string bytes;
  unsigned word = 0;
  int bits = 0;
  for (const char c : text) {
    const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+'             ? 62
                      : c == '/'             ? 63
                                             : -1;
    if (value < 0)
      continue;
    word = word << 6 | static_cast<unsigned>(value);
    bits += 6;
    if (bits >= 8)
      bytes += static_cast<char>(word >> (bits -= 8) & 255);
  }
  return bytes;
}

} // namespace

bool Browser::is_installed() {
  return shell("command -v chromium");
}

Browser::Browser(int width, int height) {
  std::string pattern = (fs::temp_directory_path() / "wry-browser-XXXXXX").string();
  m_profile = mkdtemp(pattern.data());
  int to_child[2], from_child[2];
  if (pipe(to_child) != 0 || pipe(from_child) != 0) {
    m_problem = "no pipes";
    return;
  }
  m_child = fork();
  if (m_child == 0) {
    // The protocol wants its two ends as 3 and 4; move ours out of the way first.
    const int in = fcntl(to_child[0], F_DUPFD, 20), out = fcntl(from_child[1], F_DUPFD, 20);
    dup2(in, 3);
    dup2(out, 4);
    for (int file = 5; file < 64; ++file)
      close(file);
    const int quiet = ::open("/dev/null", O_WRONLY);
    dup2(quiet, 1);
    dup2(quiet, 2);
    const std::string profile = "--user-data-dir=" + m_profile.string();
    const std::string size = "--window-size=" + std::to_string(width) + "," + std::to_string(height);
    execlp("chromium", "chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
           "--hide-scrollbars", "--remote-debugging-pipe", profile.c_str(), size.c_str(), "about:blank", nullptr);
    _exit(127);
  }
  close(to_child[0]);
  close(from_child[1]);
  m_to = to_child[1];
  m_from = from_child[0];
  const json target = call("Target.createTarget", {{"url", "about:blank"}});
  if (!target.contains("targetId")) {
    m_problem = "chromium does not answer: " + target.dump();
    return;
  }
  m_session =
      call("Target.attachToTarget", {{"targetId", target["targetId"]}, {"flatten", true}}).value("sessionId", "");
  call("Page.enable", json::object());
  call("Runtime.enable", json::object());
  call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
}

Browser::~Browser() {
  if (m_to >= 0)
    close(m_to);
  if (m_from >= 0)
    close(m_from);
  if (m_child > 0) {
    kill(m_child, SIGTERM);
    waitpid(m_child, nullptr, 0);
  }
  std::error_code ignored;
  fs::remove_all(m_profile, ignored);
}

json Browser::read_message() {
  while (true) {
    if (const std::size_t end = m_buffer.find('\0'); end != std::string::npos) {
      const json message = json::parse(m_buffer.substr(0, end), nullptr, false);
      m_buffer.erase(0, end + 1);
      return message;
    }
    pollfd file{m_from, POLLIN, 0};
    char bytes[65536];
    if (poll(&file, 1, PATIENCE_MS) <= 0)
      return {};
    const ssize_t got = read(m_from, bytes, sizeof bytes);
    if (got <= 0)
      return {};
    m_buffer.append(bytes, static_cast<std::size_t>(got));
  }
}

json Browser::call(const std::string& method, const json& parameters) {
  const int id = m_next++;
  json message = {{"id", id}, {"method", method}, {"params", parameters}};
  if (!m_session.empty())
    message["sessionId"] = m_session;
  std::string text = message.dump();
  text += '\0';
  if (write(m_to, text.data(), text.size()) != static_cast<ssize_t>(text.size()))
    return {};
  while (true) {
    const json answer = read_message();
    if (!answer.is_object())
      return answer;
    if (answer.value("method", "") == "Runtime.exceptionThrown")
      m_complaints += answer["params"].dump() + "\n";
    if (answer.value("id", 0) == id)
      return answer.contains("result") ? answer["result"] : answer;
  }
}

void Browser::open(const fs::path& file) {
  call("Page.navigate", {{"url", "file://" + file.string()}});
  evaluate(
      "new Promise(done => { const look = () => document.readyState === 'complete' && location.protocol === 'file:' ? "
      "done(1) : setTimeout(look, 20); look(); })");
}

json Browser::evaluate(const std::string& script) {
  const json answer =
      call("Runtime.evaluate", {{"expression", script}, {"returnByValue", true}, {"awaitPromise", true}});
  if (answer.contains("exceptionDetails"))
    return "threw " + answer["exceptionDetails"].dump();
  return answer.contains("result") && answer["result"].contains("value") ? answer["result"]["value"] : json();
}

void Browser::drag(double from_x, double from_y, double to_x, double to_y) {
  const auto mouse = [&](const char* type, double x, double y) {
    call("Input.dispatchMouseEvent",
         {{"type", type}, {"x", x}, {"y", y}, {"button", "left"}, {"buttons", 1}, {"clickCount", 1}});
  };
  mouse("mousePressed", from_x, from_y);
  if (from_x != to_x || from_y != to_y)
    mouse("mouseMoved", to_x, to_y);
  mouse("mouseReleased", to_x, to_y);
}

void Browser::save_screenshot(const fs::path& file) {
  const json answer = call("Page.captureScreenshot", {{"format", "png"}});
  std::ofstream(file, std::ios::binary) << decoded_base64(answer.value("data", ""));
}

} // namespace wry::cli_test
