#include "pipeline/cli/verb.h"

#include <array>

namespace wry::pipeline {

namespace {

constexpr std::uint32_t SHOT_OPTIONS = TAKES_SHOT | TAKES_SET | TAKES_FRAMES | TAKES_OUT | TAKES_FRESH | TAKES_THREADS;

constexpr std::array VERBS = {
    Verb{"run", "SHOT", "plan, simulate, render, encode, report: what the shot asks, in one go",
         "Goes on by itself where an earlier run stopped; draws and simulates nothing twice.\n"
         "  wry run shots/bunny.toml --set material.skin.youngs_modulus=1e5 --frames 1-48",
         SHOT_OPTIONS | TAKES_GL | TAKES_DRY_RUN, run_verb},
    Verb{"plan", "SHOT", "what will run and what is left out, and why; nothing is simulated",
         "Prints dofs, mesh quality, memory, disk and predicted time.\n  wry plan shots/bunny.toml --json",
         SHOT_OPTIONS, plan_verb},
    Verb{"simulate", "SHOT", "the first half of run: frames into the cache",
         "  wry simulate shots/bunny.toml --frames 1-24 --threads 1", SHOT_OPTIONS | TAKES_DRY_RUN, simulate_verb},
    Verb{"render", "SHOT", "the second half of run: pictures from the cache",
         "A frame that is not in the cache ends with 66. --follow draws beside a running simulation.\n"
         "  wry render shots/bunny.toml --frames 1-120x10",
         SHOT_OPTIONS | TAKES_GL | TAKES_FOLLOW | TAKES_DRY_RUN, render_verb},
    Verb{"turntable", "SHOT-or-MESH", "an orbit around one frame, or around an artist mesh with no shot at all",
         "  wry turntable shots/bunny.toml --frame 48\n  wry turntable car.glb", SHOT_OPTIONS | TAKES_GL | TAKES_FRAME,
         turntable_verb},
    Verb{"compare", "DIR", "the pictures of two runs or wedges side by side, or how far they are apart",
         "Pairs pictures of the same view and frame.\n"
         "  wry compare out/bunny --with out/bunny-stiff\n"
         "  wry compare out/a --with out/b --mode difference",
         TAKES_OUT | TAKES_WITH, compare_verb},
    Verb{"sweep", "SHOT", "every wedge of [sweep], each in processes of its own, then table, sheet, film and page",
         "Goes on by itself where an earlier sweep stopped. --list --json prints the jobs for any farm.\n"
         "  wry sweep shots/bunny.toml --jobs 2\n  wry sweep shots/bunny.toml --engine slurm --jobs 100 --chunk 24",
         SHOT_OPTIONS | TAKES_GL | TAKES_DRY_RUN | TAKES_STUDY, sweep_verb},
    Verb{"export", "SHOT", "cached frames for Blender, Houdini and ParaView: ply, obj, vdb, usda, pc2, xdmf",
         "  wry export shots/bunny.toml --to usda,vdb",
         TAKES_SHOT | TAKES_SET | TAKES_FRAMES | TAKES_OUT | TAKES_FORMATS, export_verb},
    Verb{"accuracy", "SHOT", "error against run time: the ladders of [accuracy], orders, Pareto front, recommendation",
         "Resumes; nothing is run twice.\n  wry accuracy shots/cantilever.toml --jobs 1",
         SHOT_OPTIONS | TAKES_DRY_RUN | TAKES_STUDY, accuracy_verb},
    Verb{"stress", "SHOT", "stability: turns the shot's own knobs to extremes and reports where it holds",
         "Ends with 1 when a case failed rather than held or refused.\n  wry stress shots/bunny.toml --frames 1-7",
         SHOT_OPTIONS | TAKES_DRY_RUN | TAKES_STUDY, stress_verb},
    Verb{"check", "SHOT-or-DIR", "is this shot valid; is this output folder whole and uncorrupted",
         "  wry check shots/bunny.toml\n  wry check out/bunny", TAKES_SHOT | TAKES_SET, check_verb},
    Verb{"list", "", "what this build has: models, solvers, primitives, measures, views", "", 0, list_verb},
    Verb{"job", "GRAPH", "what a farm's machine runs: one task of a study", "", TAKES_TASK | IS_INTERNAL, job_verb},
    Verb{"schema", "", "JSON Schema of the shot file, for editors",
         "  wry schema > shot.schema.json\n  wry schema --markdown > docs/shot-file.md", TAKES_MARKDOWN, schema_verb},
};

} // namespace

std::span<const Verb> verbs() {
  return VERBS;
}

} // namespace wry::pipeline
