#include <algorithm>
#include <chrono>
#include <map>
#include <thread>

#include "pipeline/run/engines/engine.h"
#include "pipeline/run/engines/job_process.h"
#include "pipeline/run/signals.h"

namespace wry::pipeline {

namespace {

constexpr auto LOOK_EVERY = std::chrono::milliseconds(10);
constexpr int LOOKS_PER_PERCENT = 50; ///< logs are read twice a second

/// One run over a graph on this machine.
class LocalRun {
public:
  LocalRun(const JobGraph& graph, const EngineSettings& settings)
      : m_settings(settings) {
    for (const Job& job : graph.jobs) {
      m_places[job.id] = m_states.size();
      m_states.push_back({&job, JobPhase::waiting, -1});
    }
  }

  Status go() {
    for (int looks = 0; !finished(); ++looks) {
      if (Status status = look_at_running(); !status)
        return status;
      if (stop_requested())
        tell_to_stop();
      else if (Status status = start_more(); !status)
        return status;
      if (looks % LOOKS_PER_PERCENT == 0)
        look_at_progress();
      if (m_changed)
        report();
      if (m_running.empty() && stop_requested())
        break;
      std::this_thread::sleep_for(LOOK_EVERY);
    }
    return stop_requested() ? Status(stopped_by_signal("the same command goes on from here")) : Status();
  }

private:
  bool finished() const {
    return m_running.empty() && std::none_of(m_states.begin(), m_states.end(),
                                             [](const JobState& state) { return state.phase == JobPhase::waiting; });
  }

  JobState& state_of(const std::string& id) { return m_states[m_places.at(id)]; }

  void set_phase(JobState& state, JobPhase phase) {
    state.phase = phase;
    m_changed = true;
  }

  Status look_at_running() {
    for (std::size_t i = 0; i < m_running.size();) {
      Result<std::optional<JobRecord>> ended = m_running[i].poll();
      if (!ended)
        return ended.error();
      if (!*ended) {
        ++i;
        continue;
      }
      const int code = (*ended)->exit_code;
      JobState& state = state_of(m_running[i].job().id);
      const bool stopped = code == static_cast<int>(ErrorCode::stopped) && !(*ended)->timed_out;
      set_phase(state, code == 0 ? JobPhase::done : stopped ? JobPhase::stopped : JobPhase::failed);
      m_running.erase(m_running.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return {};
  }

  /// Whether a job can begin; one that never can is marked.
  bool is_ready(JobState& state) {
    for (const std::string& id : state.job->after) {
      const auto place = m_places.find(id);
      if (place == m_places.end())
        continue; // done in an earlier run
      const JobPhase phase = m_states[place->second].phase;
      if (phase == JobPhase::waiting || phase == JobPhase::running)
        return false;
      if (state.job->after_what == Job::After::success && phase != JobPhase::done) {
        set_phase(state, JobPhase::skipped);
        return false;
      }
    }
    return true;
  }

  Status start_more() {
    for (JobState& state : m_states) {
      if (m_running.size() >= static_cast<std::size_t>(std::max(m_settings.jobs, 1)))
        return {};
      if (state.phase != JobPhase::waiting || !is_ready(state))
        continue;
      Result<JobProcess> process = JobProcess::start(*state.job);
      if (!process)
        return process.error();
      m_running.push_back(std::move(*process));
      set_phase(state, JobPhase::running);
    }
    return {};
  }

  void tell_to_stop() {
    if (m_told)
      return;
    m_told = true;
    for (JobProcess& process : m_running)
      process.ask_to_stop();
  }

  void look_at_progress() {
    for (const JobProcess& process : m_running) {
      JobState& state = state_of(process.job().id);
      const int percent = process.percent();
      m_changed = m_changed || percent != state.percent;
      state.percent = percent;
    }
  }

  void report() {
    m_changed = false;
    if (m_settings.observer)
      m_settings.observer(m_states);
  }

  const EngineSettings& m_settings;
  std::vector<JobState> m_states;
  std::map<std::string, std::size_t> m_places;
  std::vector<JobProcess> m_running;
  bool m_changed = true;
  bool m_told = false;
};

class LocalEngine final : public Engine {
public:
  Status run(const JobGraph& graph, const EngineSettings& settings) override { return LocalRun(graph, settings).go(); }
};

} // namespace

std::unique_ptr<Engine> make_local_engine() {
  return std::make_unique<LocalEngine>();
}

} // namespace wry::pipeline
