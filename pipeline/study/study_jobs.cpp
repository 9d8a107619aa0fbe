#include "pipeline/study/study_jobs.h"

#include <fmt/format.h>

#include "pipeline/cache/sha256.h"
#include "pipeline/plan/build_id.h"
#include "shots/resolved.h"

namespace wry::pipeline {

namespace {

/// Hash of all that a variant's outputs depend on: a record with another one is stale.
Result<std::string> key_of(const StudyRequest& request, const StudyRow& row) {
  std::string inputs = fmt::format("{} {} {} {} {}\n", simulation_build(), render_build(), isa_name(request.isa),
                                   request.frames, static_cast<int>(request.stages));
  for (const shots::FlatKey& key : shots::flatten(*row.shot)) {
    inputs += key.key + "=" + key.value + "\n";
    if (!key.key.ends_with(".mesh"))
      continue;
    const Result<std::string> hash =
        sha256_of_file(std::filesystem::path(row.shot->directory) / plain_value(key.value));
    if (!hash && hash.error().code != ErrorCode::missing_input)
      return hash.error();
    inputs += hash ? *hash + "\n" : "missing\n";
  }
  return sha256_of_bytes(inputs);
}

/// What one variant's jobs have in common.
class JobMaker {
public:
  JobMaker(const StudyRequest& request, const StudyRow& row, std::string key)
      : m_request(request)
      , m_row(row)
      , m_key(std::move(key)) {}

  Job make(const std::string& verb, const std::string& stage, const std::string& frames) const {
    return make(verb, stage, frames, m_row.folder);
  }

  Job make(const std::string& verb, const std::string& stage, const std::string& frames,
           const std::filesystem::path& folder) const {
    Job job;
    job.id = m_row.variant.id() + "." + stage;
    job.stage = stage;
    job.variant = m_row.variant.id();
    job.index = m_row.variant.index;
    job.arguments = {verb, m_request.shot};
    for (const std::string& text : m_request.sets)
      job.arguments.insert(job.arguments.end(), {"--set", text});
    const std::vector<std::string> own = m_row.variant.arguments();
    job.arguments.insert(job.arguments.end(), own.begin(), own.end());
    job.arguments.insert(job.arguments.end(),
                         {"--out", folder.string(), "--isa", std::string(isa_name(m_request.isa)), "--threads",
                          std::to_string(m_request.threads), "--shared", (m_request.folder / "shared").string()});
    if (!frames.empty())
      job.arguments.insert(job.arguments.end(), {"--frames", frames});
    if (m_request.shortage == Shortage::go_on)
      job.arguments.push_back("--ignore-limits");
    if (verb != "simulate")
      job.arguments.insert(job.arguments.end(), {"--gl", m_request.gl});
    job.record = m_row.folder / "jobs" / (stage + ".json");
    job.log = m_row.folder / "jobs" / (stage + ".log");
    job.key = m_key;
    return job;
  }

  Job simulate() const {
    Job job = make("simulate", "simulate", m_request.frames);
    job.outputs = {(m_row.folder / "frames").string(), (m_row.folder / "measure.csv").string()};
    job.time_limit_seconds = m_request.time_limit_seconds;
    return job;
  }

  /// Rendering jobs, numbered, each of a chunk of frames.
  std::vector<Job> render(const std::string& after) const {
    const std::size_t count = m_row.frames.size();
    const std::size_t chunk = m_request.frames_per_job > 0 ? static_cast<std::size_t>(m_request.frames_per_job) : count;
    std::vector<Job> jobs;
    for (std::size_t begin = 0; begin < count; begin += chunk) {
      std::string frames;
      for (std::size_t i = begin; i < std::min(begin + chunk, count); ++i)
        frames += (frames.empty() ? "" : ",") + std::to_string(m_row.frames[i]);
      Job job = make("render", fmt::format("render-{}", jobs.size()), chunk < count ? frames : m_request.frames);
      job.after = {after};
      job.outputs = {(m_row.folder / "images").string()};
      jobs.push_back(std::move(job));
    }
    return jobs;
  }

  /// The same work again in folders of its own, one after the other, for its time alone.
  void add_repeats(const std::string& verb, std::vector<Job>& jobs) const {
    for (int k = 1; k < m_request.repeats; ++k) {
      Job job = make(verb, timing_stage(k), m_request.frames, m_row.folder / timing_stage(k));
      job.after = {jobs.back().id};
      job.time_limit_seconds = m_request.time_limit_seconds;
      jobs.push_back(std::move(job));
    }
  }

  Job finish(const std::vector<Job>& before) const {
    Job job = make("run", "finish", m_request.frames);
    for (const Job& other : before)
      job.after.push_back(other.id);
    job.outputs = {m_row.folder.string()};
    return job;
  }

private:
  const StudyRequest& m_request;
  const StudyRow& m_row;
  std::string m_key;
};

} // namespace

std::string timing_stage(int repeat) {
  return fmt::format("timing-{}", repeat);
}

Result<std::vector<Job>> jobs_of(const StudyRequest& request, const StudyRow& row) {
  const Result<std::string> key = key_of(request, row);
  if (!key)
    return key.error();
  const JobMaker maker(request, row, *key);
  std::vector<Job> jobs;
  if (request.stages == StudyStages::draw) {
    jobs.push_back(maker.make("render", "render-0", request.frames));
    maker.add_repeats("render", jobs);
    return jobs;
  }
  jobs.push_back(maker.simulate());
  if (request.stages == StudyStages::simulate) {
    maker.add_repeats("simulate", jobs);
    return jobs;
  }
  const std::vector<Job> render = maker.render(jobs.front().id);
  jobs.insert(jobs.end(), render.begin(), render.end());
  jobs.push_back(maker.finish(jobs));
  return jobs;
}

Job collecting_job(const StudyRequest& request, const JobGraph& graph) {
  Job job;
  job.id = "sheet";
  job.stage = "sheet";
  job.arguments = request.collect;
  for (const Job& other : graph.jobs) {
    const bool last_of_its_variant = other.stage == "finish" || request.stages != StudyStages::pictures;
    if (last_of_its_variant)
      job.after.push_back(other.id);
  }
  job.after_what = Job::After::any;
  job.record = request.folder / "jobs" / "sheet.json";
  job.log = request.folder / "jobs" / "sheet.log";
  job.key = "sheet";
  job.outputs = {(request.folder / "sweep.csv").string(), (request.folder / "index.html").string()};
  return job;
}

} // namespace wry::pipeline
