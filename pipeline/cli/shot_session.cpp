#include "pipeline/cli/shot_session.h"

#include <algorithm>
#include <cstring>
#include <thread>

#include <csignal>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "pipeline/run/engines/job_process.h"
#include "pipeline/run/signals.h"

extern char** environ;

namespace wry::pipeline {

Result<shots::ShotDocument> open_document(const Invocation& invocation) {
  std::vector<shots::Override> overrides;
  if (!invocation.wedge.empty())
    overrides.push_back({"case", invocation.wedge, {}});
  for (const std::string& text : invocation.sets) {
    Result<shots::Override> parsed = shots::parse_override(text);
    if (!parsed)
      return parsed.error();
    overrides.push_back(std::move(*parsed));
  }
  const Result<shots::ShotDocument> document = shots::read_document(invocation.subject);
  return document ? shots::apply_overrides(*document, overrides) : document;
}

Result<ShotSession> open_session(const Invocation& invocation) {
  const Result<shots::ShotDocument> document = open_document(invocation);
  if (!document)
    return document.error();
  Result<shots::Shot> shot = shots::make_shot(*document);
  if (!shot)
    return shot.error();
  ShotSession session{std::move(*shot), {}, {}, Isa::sse4, invocation.shared};
  session.out = invocation.out.empty() ? std::filesystem::path("out") / *session.shot.shot.name
                                       : std::filesystem::path(invocation.out);
  session.frames = session.shot.shot.frames->frames();
  if (!invocation.frames.empty()) {
    const Result<shots::FrameRange> asked = shots::FrameRange::parse(invocation.frames);
    if (!asked)
      return make_error(ErrorCode::usage, "--frames {}: {}", invocation.frames, asked.error().message);
    if (asked->first() < session.shot.shot.frames->first())
      return make_error(ErrorCode::usage, "--frames {}: the shot begins at frame {}", invocation.frames,
                        session.shot.shot.frames->first());
    session.frames = asked->frames();
  }
  const Result<Isa> isa = parse_isa(invocation.isa);
  if (!isa)
    return isa.error();
  session.isa = *isa;
  return session;
}

Result<ScenePlan> plan_session(const ShotSession& session) {
  return compile_scene(session.shot, {session.frames, session.isa, session.shared});
}

Result<std::vector<ChildOutcome>> run_self(const std::vector<std::vector<std::string>>& command_lines) {
  std::vector<pid_t> children;
  announce_parent();
  for (const std::vector<std::string>& words : command_lines) {
    std::vector<char*> arguments = {const_cast<char*>("wry")};
    for (const std::string& word : words)
      arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    pid_t child = 0;
    const int failed = posix_spawn(&child, "/proc/self/exe", nullptr, nullptr, arguments.data(), environ);
    if (failed != 0) {
      for (const pid_t started : children)
        kill(started, SIGTERM);
      return make_error(ErrorCode::unavailable, "cannot start another process of wry: {}", std::strerror(failed));
    }
    children.push_back(child);
  }
  std::vector<ChildOutcome> outcomes(children.size());
  std::size_t running = children.size();
  bool passed_on = false;
  while (running > 0) {
    for (std::size_t i = 0; i < children.size(); ++i) {
      int status = 0;
      if (children[i] == 0 || waitpid(children[i], &status, WNOHANG) == 0)
        continue;
      outcomes[i].exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      children[i] = 0;
      --running;
    }
    if (stop_requested() && !passed_on) {
      for (const pid_t child : children) {
        if (child != 0)
          kill(child, SIGTERM);
      }
      passed_on = true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return outcomes;
}

Status run_self_to_success(const std::vector<std::vector<std::string>>& command_lines) {
  const Result<std::vector<ChildOutcome>> outcomes = run_self(command_lines);
  if (!outcomes)
    return outcomes.error();
  for (const ChildOutcome& outcome : *outcomes) {
    if (outcome.exit_code == 0)
      continue;
    const bool killed = outcome.exit_code > 128;
    return make_error(killed ? ErrorCode::io : static_cast<ErrorCode>(outcome.exit_code), "a process {} ({} {})",
                      killed ? "was killed" : "did not finish", killed ? "signal" : "exit code",
                      killed ? outcome.exit_code - 128 : outcome.exit_code);
  }
  return {};
}

int rendering_processes(const Invocation& invocation, std::size_t pictures) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int wanted = invocation.threads > 0 ? invocation.threads : cores;
  return std::clamp(static_cast<int>(pictures), 1, wanted);
}

} // namespace wry::pipeline
