#include "pipeline/cli/command_line.h"

#include <cstdio>
#include <new>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pipeline/assets/import_child.h"
#include "pipeline/cli/verb.h"
#include "pipeline/plan/build_id.h"
#include "pipeline/run/engines/job_process.h"
#include "pipeline/run/signals.h"

namespace wry::pipeline {

namespace {

constexpr const char* FOOTER =
    "Exit codes: 0 done; 1 finished, but an expectation or a check failed; 2 usage; 65 bad shot or mesh;\n"
    "66 missing input; 69 not on this machine or in this build; 70 solver gave up; 71 out of memory;\n"
    "73 cannot write, or locked by another run; 74 i/o error; 75 stopped, resumable.\n"
    "First steps: wry plan shots/bunny.toml, then wry run shots/bunny.toml --frames 1-24";

void add_study_options(CLI::App& command, Invocation& invocation) {
  command.add_option("--engine", invocation.engine, "local or slurm: where the jobs run");
  command.add_option("--jobs", invocation.jobs, "processes at a time (default: one per core)")
      ->check(CLI::Range(0, 10000));
  command.add_option("--chunk", invocation.chunk, "frames per rendering job (default: all in one)")
      ->check(CLI::Range(0, 1000000));
  command.add_flag("--list", invocation.list, "say which jobs there are, run none; with --json: the job graph");
  command.add_flag("--only-failed", invocation.only_failed, "run only what failed before");
  command.add_flag("--collect", invocation.collect, "run nothing: table and pictures of what is there");
}

void add_options(CLI::App& command, const Verb& verb, Invocation& invocation) {
  const auto takes = [&](VerbOption option) { return (verb.options & option) != 0; };
  if (!verb.subject.empty())
    command.add_option(std::string(verb.subject), invocation.subject, "path")->required();
  if (takes(TAKES_SET)) {
    command
        .add_option("--set", invocation.sets,
                    "KEY=VALUE: override any key of the shot, e.g. body.bunny.resolution=0.02")
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false);
    command.add_option("--case", invocation.wedge, "NAME: take a named case of [sweep]");
  }
  if (takes(TAKES_FRAMES))
    command.add_option("--frames", invocation.frames, "e.g. 1001-1100x2,1150; never moves the origin of time");
  if (takes(TAKES_OUT))
    command.add_option("--out", invocation.out, "DIR: this shot's own folder (default out/<shot>)");
  if (takes(TAKES_FRESH))
    command.add_flag("--fresh", invocation.fresh, "throw away what an earlier run left in the folder");
  if (takes(TAKES_THREADS)) {
    command.add_option("--threads", invocation.threads, "number of threads; the answer does not depend on it")
        ->check(CLI::Range(0, 1024));
    command.add_option("--isa", invocation.isa, "auto, sse4, avx2 or avx512: pin it so that a mixed farm agrees");
    command.add_flag("--ignore-limits", invocation.ignore_limits,
                     "run what is predicted to need more memory or disk than there is");
  }
  if (takes(TAKES_GL))
    command.add_option("--gl", invocation.gl, "auto, osmesa or egl");
  if (takes(TAKES_FOLLOW))
    command.add_flag("--follow", invocation.follow, "wait for frames that a running simulation still writes");
  if (takes(TAKES_DRY_RUN))
    command.add_flag("--dry-run", invocation.dry_run, "say what would be done, do nothing");
  if (takes(TAKES_FRAME))
    command.add_option("--frame", invocation.turntable_frame, "which frame to show (default: the last one there is)");
  if (takes(TAKES_MARKDOWN))
    command.add_flag("--markdown", invocation.markdown, "the same as tables for people");
  if (takes(TAKES_WITH)) {
    command.add_option("--with", invocation.with, "DIR: the folder to compare with");
    command.add_option("--mode", invocation.mode, "split (default) or difference");
  }
  if (takes(TAKES_FORMATS))
    command.add_option("--to", invocation.to, "FORMAT[,FORMAT...]: ply, obj, vdb, usda, pc2, xdmf")->required();
  if (takes(TAKES_STUDY))
    add_study_options(command, invocation);
  if (takes(TAKES_TASK)) {
    command.add_option("--stage", invocation.stage)->required();
    command.add_option("--task", invocation.task)->required();
  }
  if (takes(TAKES_GL))
    command.add_option("--part", invocation.part)->group("");
  if (takes(TAKES_THREADS))
    command.add_option("--shared", invocation.shared)->group("");
  if (takes(IS_INTERNAL))
    command.group("");
  command.add_flag("--quiet", invocation.quiet, "errors only");
  command.add_flag("--json", invocation.json, "machine-readable output on standard output");
  command.footer(std::string(verb.help));
}

void print_error(const Error& error, const Invocation& invocation) {
  if (invocation.json) {
    const nlohmann::json report = {{"error", error.message}, {"exit_code", static_cast<int>(error.code)}};
    std::printf("%s\n", report.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  }
  std::fflush(stdout); // where both go to one file, the error comes last
  std::fprintf(stderr, "wry %s: %s\n", invocation.verb.c_str(), error.message.c_str());
}

int run_chosen(const Verb& verb, const Invocation& invocation) {
  try {
    const Status status = verb.run(invocation);
    if (status.ok())
      return 0;
    print_error(status.error(), invocation);
    return static_cast<int>(status.error().code);
  } catch (const std::bad_alloc&) {
    print_error(make_error(ErrorCode::out_of_memory,
                           "out of memory; a coarser resolution needs less, `wry plan` says how much"),
                invocation);
    return static_cast<int>(ErrorCode::out_of_memory);
  } catch (const std::system_error& failure) {
    // Nobody reads on: `wry sweep SHOT --list | head` is no error.
    if (failure.code() == std::errc::broken_pipe)
      return 0;
    // A thread whose stack finds no room ends here.
    const bool no_room =
        failure.code() == std::errc::resource_unavailable_try_again || failure.code() == std::errc::not_enough_memory;
    print_error(make_error(no_room ? ErrorCode::out_of_memory : ErrorCode::io, "{}: {}",
                           no_room ? "out of memory or threads" : "unexpected", failure.what()),
                invocation);
    return static_cast<int>(no_room ? ErrorCode::out_of_memory : ErrorCode::io);
  } catch (const std::exception& exception) {
    print_error(make_error(ErrorCode::io, "unexpected: {}", exception.what()), invocation);
    return static_cast<int>(ErrorCode::io);
  }
}

} // namespace

int run_command_line(int argc, char** argv) {
  if (is_import_child(argc, argv))
    return import_child_main(argc, argv);
  follow_parent();
  if (const Status signals = install_stop_signals(); !signals) {
    std::fprintf(stderr, "wry: %s\n", signals.error().message.c_str());
    return static_cast<int>(signals.error().code);
  }
  CLI::App app{"wry simulates and renders the shots of animation production, offline and headless.", "wry"};
  app.set_version_flag(
      "--version", fmt::format("wry {} (simulation {}, pictures {})", version(), simulation_build(), render_build()));
  app.require_subcommand(1);
  app.footer(FOOTER);
  Invocation invocation;
  for (const Verb& verb : verbs())
    add_options(*app.add_subcommand(std::string(verb.name), std::string(verb.doc)), verb, invocation);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ErrorCode::usage);
  }
  for (int i = 2; i < argc; ++i)
    invocation.original_arguments.emplace_back(argv[i]);
  invocation.verb = app.get_subcommands().front()->get_name();
  for (const Verb& verb : verbs()) {
    if (verb.name == invocation.verb)
      return run_chosen(verb, invocation);
  }
  return static_cast<int>(ErrorCode::usage);
}

} // namespace wry::pipeline
