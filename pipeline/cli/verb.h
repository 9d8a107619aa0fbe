#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/result.h"

namespace wry::pipeline {

/// What the command line said, for every verb alike.
struct Invocation {
  std::string verb;
  std::string subject;           ///< SHOT, MESH or DIR
  std::vector<std::string> sets; ///< --set key=value, in order
  std::string wedge;             ///< --case: one named case of [sweep]
  std::string frames;            ///< --frames; empty: those of the shot
  std::string out;               ///< --out; empty: out/<shot>
  std::string isa = "auto";
  std::string gl = "auto";
  std::string with;             ///< --with: the other folder of compare
  std::string mode;             ///< --mode: split or difference
  std::string part;             ///< internal: "i/n", which frames this rendering process draws
  std::string shared;           ///< internal: folder of meshes that the variants of a study share
  std::string to;               ///< formats of `wry export`, with commas between
  std::string engine = "local"; ///< where a study's jobs run
  std::string stage;            ///< of `wry job`
  int task = 0;                 ///< of `wry job`
  int jobs = 0;                 ///< processes at a time; 0: one per core
  int chunk = 0;                ///< frames per rendering job of a study; 0: all
  int threads = 0;              ///< 0: all cores
  int turntable_frame = 0;      ///< --frame: which frame a turntable shows; 0: the last one that is there
  bool fresh = false;
  bool follow = false;
  bool quiet = false;
  bool json = false;
  bool dry_run = false;
  bool ignore_limits = false; ///< runs what is predicted to need more memory or disk than there is
  bool markdown = false;
  bool list = false;                           ///< only say which jobs a study has
  bool only_failed = false;                    ///< only what failed before
  bool collect = false;                        ///< run nothing: table and pictures of what is there
  std::vector<std::string> original_arguments; ///< behind the verb, to start the same again
};

/// Options that a verb takes beside --quiet and --json.
enum VerbOption : std::uint32_t {
  TAKES_SHOT = 1u << 0,
  TAKES_SET = 1u << 1,
  TAKES_FRAMES = 1u << 2,
  TAKES_OUT = 1u << 3,
  TAKES_FRESH = 1u << 4,
  TAKES_THREADS = 1u << 5,
  TAKES_GL = 1u << 6,
  TAKES_FOLLOW = 1u << 7,
  TAKES_DRY_RUN = 1u << 8,
  TAKES_FRAME = 1u << 9,
  TAKES_MARKDOWN = 1u << 10,
  TAKES_WITH = 1u << 15,
  TAKES_STUDY = 1u << 11, ///< --list --jobs --engine --only-failed --collect --chunk
  TAKES_TASK = 1u << 12,  ///< --stage --task
  TAKES_FORMATS = 1u << 14,
  IS_INTERNAL = 1u << 13, ///< not in `wry --help`
};

/// One command of `wry`.
struct Verb {
  std::string_view name;
  std::string_view subject; ///< "SHOT", "SHOT-or-DIR", "" when there is none
  std::string_view doc;     ///< a line for `wry --help`
  std::string_view help;    ///< what `wry VERB --help` adds: what it does, an example
  std::uint32_t options;
  Status (*run)(const Invocation&);
};

/// Every verb of this build, in the order of `wry --help`. A new verb is one .cpp and one line of this table.
std::span<const Verb> verbs();

Status run_verb(const Invocation&);
Status simulate_verb(const Invocation&);
Status render_verb(const Invocation&);
Status plan_verb(const Invocation&);
Status turntable_verb(const Invocation&);
Status compare_verb(const Invocation&);
Status sweep_verb(const Invocation&);
Status accuracy_verb(const Invocation&);
Status stress_verb(const Invocation&);
Status export_verb(const Invocation&);
Status job_verb(const Invocation&);
Status check_verb(const Invocation&);
Status list_verb(const Invocation&);
Status schema_verb(const Invocation&);

} // namespace wry::pipeline
