#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <thread>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/run/engines/captured_program.h"
#include "pipeline/run/engines/engine.h"
#include "pipeline/run/engines/job_process.h"
#include "pipeline/run/signals.h"

namespace wry::pipeline {

namespace {

constexpr auto ASK_EVERY = std::chrono::milliseconds(500);
constexpr int MOST_SILENT_ASKS = 240; ///< the controller may be down for two minutes

/// A word within single quotes of a shell.
std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word)
    text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// One array of Slurm: the jobs of one stage, a task per variant.
struct Stage {
  std::string name;
  std::vector<const Job*> jobs;
  std::string farm_id; ///< what sbatch answered
};

/// One run over a graph on a farm that Slurm runs.
class SlurmRun {
public:
  SlurmRun(const JobGraph& graph, const EngineSettings& settings)
      : m_graph(graph)
      , m_settings(settings) {
    for (const Job& job : graph.jobs) {
      m_states.push_back({&job, JobPhase::waiting, -1});
      stage_named(job.stage).jobs.push_back(&job);
    }
  }

  Status go() {
    if (m_graph.jobs.empty())
      return {};
    if (Status status = check_farm(); !status)
      return status;
    if (Status status = write_file_atomically(graph_path(), job_graph_json(m_graph, this_program())); !status)
      return status;
    for (Stage& stage : m_stages) {
      if (Status status = submit(stage); !status) {
        cancel();
        return status;
      }
    }
    return wait();
  }

private:
  std::filesystem::path graph_path() const { return m_graph.folder / "farm" / "jobs.json"; }

  Stage& stage_named(const std::string& name) {
    const auto found =
        std::find_if(m_stages.begin(), m_stages.end(), [&](const Stage& stage) { return stage.name == name; });
    if (found != m_stages.end())
      return *found;
    m_stages.push_back({name, {}, {}});
    return m_stages.back();
  }

  Status check_farm() const {
    const Result<CapturedProgram> version = run_program({"sbatch", "--version"});
    if (!version || version->exit_code != 0)
      return make_error(ErrorCode::unavailable,
                        "--engine slurm: there is no Slurm on this machine (sbatch {}); submit from a machine of the "
                        "farm, or use --engine local, or hand `--list --json` to another farm",
                        version ? version->err : "is not found");
    const Result<CapturedProgram> ping = run_program({"sinfo", "--noheader"});
    if (!ping || ping->exit_code != 0)
      return make_error(ErrorCode::unavailable, "--engine slurm: its controller does not answer: {}",
                        ping ? ping->err : ping.error().message);
    return prepare_folder(m_graph.folder / "farm");
  }

  /// Arrays whose task of the same number must have succeeded, and jobs that must have ended.
  std::string dependency(const Stage& stage) {
    std::set<std::string> same_task, ended;
    for (const Job* job : stage.jobs) {
      for (const std::string& id : job->after) {
        const Job* before = m_graph.find(id);
        if (before == nullptr)
          continue; // done in an earlier run
        const std::string& farm_id = stage_named(before->stage).farm_id;
        (job->after_what == Job::After::any ? ended : same_task).insert(farm_id);
      }
    }
    std::string text;
    for (const std::string& id : same_task)
      text += (text.empty() ? "aftercorr:" : ",aftercorr:") + id;
    for (const std::string& id : ended)
      text += (text.empty() ? "afterany:" : ",afterany:") + id;
    return text;
  }

  /// The shell that a node runs: `wry job` with the task's number; a stop (75) puts the task back into the queue.
  std::string script(const Stage& stage) const {
    return fmt::format("#!/bin/sh\n"
                       "trap 'kill -TERM $child 2>/dev/null' TERM INT\n"
                       "{} job {} --stage {} --task \"$SLURM_ARRAY_TASK_ID\" &\n"
                       "child=$!\n"
                       "wait $child; code=$?\n"
                       "while kill -0 $child 2>/dev/null; do wait $child; code=$?; done\n"
                       "if [ $code -eq {} ] && [ \"${{SLURM_RESTART_COUNT:-0}}\" -lt {} ]; then\n"
                       "  scontrol requeue \"$SLURM_JOB_ID\" && sleep 60\n"
                       "fi\n"
                       "exit $code\n",
                       quoted(this_program()), quoted(graph_path().string()), quoted(stage.name),
                       static_cast<int>(ErrorCode::stopped), MOST_REQUEUES);
  }

  Status submit(Stage& stage) {
    std::string tasks;
    int threads = 1;
    for (const Job* job : stage.jobs) {
      tasks += (tasks.empty() ? "" : ",") + std::to_string(job->index);
      for (std::size_t i = 0; i + 1 < job->arguments.size(); ++i) {
        if (job->arguments[i] == "--threads")
          threads = std::max(threads, std::atoi(job->arguments[i + 1].c_str()));
      }
    }
    std::vector<std::string> words = {"sbatch",
                                      "--parsable",
                                      "--requeue",
                                      "--kill-on-invalid-dep=yes",
                                      "--export=ALL",
                                      "--job-name=wry-" + stage.name,
                                      "--ntasks=1",
                                      fmt::format("--cpus-per-task={}", threads),
                                      fmt::format("--array={}%{}", tasks, std::max(m_settings.jobs, 1)),
                                      "--chdir=" + std::filesystem::current_path().string(),
                                      "--open-mode=append",
                                      "--output=" + (m_graph.folder / "farm" / (stage.name + "-%a.log")).string()};
    if (const std::string after = dependency(stage); !after.empty())
      words.push_back("--dependency=" + after);
    const Result<CapturedProgram> answer = run_program(words, script(stage));
    if (!answer)
      return answer.error();
    if (answer->exit_code != 0)
      return make_error(ErrorCode::unavailable, "sbatch refuses stage {}: {}", stage.name, answer->err);
    stage.farm_id = answer->out.substr(0, answer->out.find_first_of(";\n"));
    return {};
  }

  void cancel() const {
    for (const Stage& stage : m_stages) {
      if (!stage.farm_id.empty())
        static_cast<void>(run_program({"scancel", stage.farm_id}));
    }
  }

  /// Ids of tasks that the farm still has, "12_3", by their state. Errors: io when the controller does not answer.
  Result<std::map<std::string, std::string>> queue() const {
    std::string ids;
    for (const Stage& stage : m_stages)
      ids += (ids.empty() ? "" : ",") + stage.farm_id;
    // --array: a line per task. Ids that Slurm has forgotten are an error when all are: then nothing is left.
    const Result<CapturedProgram> answer =
        run_program({"squeue", "--noheader", "--array", "--jobs=" + ids, "--format=%i %T"});
    if (!answer)
      return answer.error();
    if (answer->exit_code != 0 && answer->err.find("Invalid job id") == std::string::npos)
      return make_error(ErrorCode::io, "squeue: {}", answer->err);
    std::map<std::string, std::string> tasks;
    std::size_t begin = 0;
    while (begin < answer->out.size()) {
      const std::size_t end = std::min(answer->out.find('\n', begin), answer->out.size());
      const std::string line = answer->out.substr(begin, end - begin);
      if (const std::size_t space = line.find(' '); space != std::string::npos)
        tasks[line.substr(0, space)] = line.substr(space + 1);
      begin = end + 1;
    }
    return tasks;
  }

  Status wait() {
    int silent = 0;
    while (true) {
      const Result<std::map<std::string, std::string>> tasks = queue();
      if (!tasks && ++silent > MOST_SILENT_ASKS)
        return tasks.error();
      if (tasks) {
        silent = 0;
        update(*tasks);
        if (tasks->empty())
          return {};
      }
      if (stop_requested()) {
        cancel();
        return stopped_by_signal(
            "the farm's jobs were told to stop where they can be resumed; the same command goes on");
      }
      std::this_thread::sleep_for(ASK_EVERY);
    }
  }

  void update(const std::map<std::string, std::string>& tasks) {
    bool changed = false;
    for (JobState& state : m_states) {
      const auto task = tasks.find(fmt::format("{}_{}", stage_named(state.job->stage).farm_id, state.job->index));
      JobPhase phase = JobPhase::failed;
      if (task != tasks.end() && task->second != "COMPLETING" && task->second != "COMPLETED")
        phase = task->second == "RUNNING" ? JobPhase::running : JobPhase::waiting;
      else if (const Result<JobRecord> record = read_job_record(*state.job); record)
        phase = record->exit_code == 0 ? JobPhase::done : JobPhase::failed;
      else if (task != tasks.end())
        phase = JobPhase::running; // its record may still be on the way
      changed = changed || phase != state.phase;
      state.phase = phase;
    }
    if (changed && m_settings.observer)
      m_settings.observer(m_states);
  }

  const JobGraph& m_graph;
  const EngineSettings& m_settings;
  std::vector<JobState> m_states;
  std::vector<Stage> m_stages;
};

class SlurmEngine final : public Engine {
public:
  Status run(const JobGraph& graph, const EngineSettings& settings) override { return SlurmRun(graph, settings).go(); }
};

} // namespace

std::unique_ptr<Engine> make_slurm_engine() {
  return std::make_unique<SlurmEngine>();
}

} // namespace wry::pipeline
