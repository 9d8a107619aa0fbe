#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/plan/shared_mesh.h"
#include "pipeline/run/engines/engine.h"
#include "pipeline/run/engines/job_process.h"
#include "pipeline/study/accuracy.h"
#include "pipeline/study/stress.h"
#include "pipeline/study/study_display.h"
#include "pipeline/study/study_page.h"
#include "pipeline/study/study_table.h"
#include "pipeline/study/variant.h"
#include "shots/load.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

std::vector<Variant> variants_of(const std::vector<std::string>& values) {
  std::vector<Variant> variants;
  for (const std::string& value : values)
    variants.push_back(make_variant(value, {{"fem.time_step", value}}));
  return variants;
}

std::vector<int> numbers_of(const std::vector<Variant>& variants) {
  std::vector<int> numbers;
  for (const Variant& variant : variants)
    numbers.push_back(variant.index);
  return numbers;
}

TEST(Variants, KeepTheirNumbersAsTheStudyGrowsAndShrinks) {
  TemporaryFolder folder;
  std::vector<Variant> first = variants_of({"0.1", "0.2"});
  ASSERT_TRUE(number_variants(first, folder.path()).ok());
  EXPECT_THAT(numbers_of(first), ElementsAre(0, 1));
  std::vector<Variant> more = variants_of({"0.05", "0.1", "0.2", "0.4"});
  ASSERT_TRUE(number_variants(more, folder.path()).ok());
  EXPECT_THAT(numbers_of(more), ElementsAre(2, 0, 1, 3));
  std::vector<Variant> fewer = variants_of({"0.4", "0.8"});
  ASSERT_TRUE(number_variants(fewer, folder.path()).ok());
  EXPECT_THAT(numbers_of(fewer), ElementsAre(3, 4)) << "numbers of those that went away stay reserved";
  std::vector<Variant> twice = variants_of({"0.1", "0.1"});
  EXPECT_FALSE(number_variants(twice, folder.path()).ok());
}

std::vector<StudyRow> rows_of(const std::vector<std::vector<Parameter>>& parameters) {
  std::vector<StudyRow> rows;
  for (const std::vector<Parameter>& own : parameters) {
    rows.emplace_back();
    rows.back().variant = make_variant("", own);
  }
  return rows;
}

TEST(StudyGrid, HasTheLongestParameterAcrossAndItsNumbersInOrder) {
  const auto grid = study_grid(rows_of({{{"case", "\"up\""}, {"collider.bed.friction", "0.5"}},
                                        {{"case", "\"up\""}, {"collider.bed.friction", "0.25"}},
                                        {{"case", "\"up\""}, {"collider.bed.friction", "1e1"}},
                                        {{"case", "\"down\""}, {"collider.bed.friction", "1e1"}},
                                        {{"case", "\"down\""}, {"collider.bed.friction", "0.5"}},
                                        {{"case", "\"down\""}, {"collider.bed.friction", "0.25"}}}));
  ASSERT_TRUE(grid);
  EXPECT_THAT(grid->column_heads, ElementsAre("friction 0.25", "friction 0.5", "friction 1e1"));
  EXPECT_THAT(grid->row_heads, ElementsAre("up", "down"));
  EXPECT_THAT(grid->order, ElementsAre(1, 0, 2, 5, 4, 3));
}

TEST(StudyGrid, PutsAllOtherParametersDown) {
  std::vector<std::vector<Parameter>> parameters;
  for (const char* a : {"1", "2"})
    for (const char* b : {"1", "2", "3"})
      for (const char* c : {"5", "6"})
        parameters.push_back({{"x.a", a}, {"x.b", b}, {"x.c", c}, {"x.same", "7"}});
  const auto grid = study_grid(rows_of(parameters));
  ASSERT_TRUE(grid);
  EXPECT_THAT(grid->column_heads, ElementsAre("b 1", "b 2", "b 3"));
  EXPECT_THAT(grid->row_heads, ElementsAre("a 1, c 5", "a 1, c 6", "a 2, c 5", "a 2, c 6"));
  EXPECT_THAT(grid->order, ElementsAre(0, 2, 4, 1, 3, 5, 6, 8, 10, 7, 9, 11));
}

TEST(StudyGrid, IsNoneWhereVariantsAreNotEachCombinationOnce) {
  EXPECT_FALSE(study_grid(rows_of({{{"a", "1"}}, {{"a", "2"}}}))) << "one parameter";
  EXPECT_FALSE(study_grid(rows_of({{{"a", "1"}, {"b", "1"}}, {{"a", "2"}, {"b", "2"}}}))) << "a diagonal";
  EXPECT_FALSE(study_grid(rows_of(
      {{{"a", "1"}, {"b", "1"}}, {{"a", "1"}, {"b", "2"}}, {{"a", "1"}, {"b", "2"}}, {{"a", "2"}, {"b", "2"}}})))
      << "one twice, one missing";
}

TEST(Variants, ADamagedRegisterIsSaidSo) {
  TemporaryFolder folder;
  std::ofstream(folder.path() / "variants.json") << "[{";
  std::vector<Variant> variants = variants_of({"0.1"});
  const Status status = number_variants(variants, folder.path());
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message, HasSubstr("variants.json"));
}

JobGraph small_graph(const std::filesystem::path& folder) {
  JobGraph graph{folder, {}};
  for (const char* stage : {"simulate", "render-0"}) {
    Job job;
    job.id = std::string("000-aa.") + stage;
    job.stage = stage;
    job.variant = "000-aa";
    job.index = 7;
    job.arguments = {"simulate", "a b.toml", "--set", "x=\"y\""};
    job.record = folder / (job.stage + ".json");
    job.log = folder / (job.stage + ".log");
    job.key = "k";
    job.time_limit_seconds = 2.5;
    if (!graph.jobs.empty())
      job.after = {graph.jobs.front().id};
    graph.jobs.push_back(job);
  }
  return graph;
}

TEST(JobGraph, IsReadBackAsItWasPrinted) {
  TemporaryFolder folder;
  const JobGraph graph = small_graph(folder.path());
  std::ofstream(folder.path() / "g.json") << job_graph_json(graph, "/usr/bin/wry");
  const Result<JobGraph> read = read_job_graph(folder.path() / "g.json");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->jobs.size(), 2u);
  EXPECT_EQ(read->jobs[0].arguments, graph.jobs[0].arguments);
  EXPECT_EQ(read->jobs[1].after, graph.jobs[1].after);
  EXPECT_EQ(read->jobs[1].index, 7);
  EXPECT_EQ(read->jobs[0].time_limit_seconds, 2.5);
  std::ofstream(folder.path() / "g.json") << "{\"jobs\": 3}";
  EXPECT_FALSE(read_job_graph(folder.path() / "g.json").ok());
}

TEST(JobRecord, OfOtherInputsDoesNotCount) {
  TemporaryFolder folder;
  Job job = small_graph(folder.path()).jobs[0];
  JobRecord record;
  record.exit_code = 70;
  record.reason = "gave up at \"t\" = 1";
  ASSERT_TRUE(write_job_record(job, record).ok());
  const Result<JobRecord> read = read_job_record(job);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->exit_code, 70);
  EXPECT_EQ(read->reason, record.reason);
  job.key = "other";
  EXPECT_FALSE(read_job_record(job).ok());
}

TEST(LastWords, AreTheErrorOfTheProgramRatherThanItsTail) {
  TemporaryFolder folder;
  std::ofstream(folder.path() / "log") << "progress 4%\nwry simulate: a.toml:3: bad\n  try less\n";
  EXPECT_EQ(last_words(folder.path() / "log"), "wry simulate: a.toml:3: bad\n  try less");
  std::ofstream(folder.path() / "log") << "one\nterminate called\n";
  EXPECT_EQ(last_words(folder.path() / "log"), "terminate called");
  EXPECT_EQ(last_words(folder.path() / "none"), "");
}

TEST(Engines, AreListedAndOthersAreRefused) {
  EXPECT_TRUE(make_engine("local").ok());
  const auto none = make_engine("deadline");
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(none.error().message, HasSubstr("local, slurm"));
}

TEST(StudyDisplay, RunningJobsCountByTheirPercentage) {
  const JobGraph graph = small_graph("/x");
  const std::vector<JobState> states = {{&graph.jobs[0], JobPhase::running, 50},
                                        {&graph.jobs[1], JobPhase::waiting, -1}};
  EXPECT_DOUBLE_EQ(fraction_done(states), 0.25);
  EXPECT_EQ(describe_jobs(states), "0 of 2 jobs; running 000-aa.simulate 50%");
}

TEST(Accuracy, OrdersOfPowerLawsAreFound) {
  std::vector<double> values, errors;
  for (int i = 0; i < 5; ++i) {
    values.push_back(std::pow(2.0, -i));
    errors.push_back(3.0 * std::pow(values.back(), 1.5));
  }
  EXPECT_NEAR(observed_order(values, errors), 1.5, 1e-12);
  EXPECT_TRUE(std::isnan(observed_order({1.0}, {1.0})));
  EXPECT_TRUE(std::isnan(observed_order({1.0, 1.0}, {1.0, 2.0})));
}

TEST(Accuracy, TheFrontHasWhatNoOtherBeats) {
  const double nan = std::nan("");
  EXPECT_THAT(pareto_front({4, 1, 2, 3, 5, 0.5}, {0.1, 1.0, 0.5, 0.6, 0.1, nan}), ElementsAre(1, 2, 0));
  EXPECT_TRUE(pareto_front({}, {}).empty());
}

TEST(Accuracy, LaddersHaveFinerReferencesAndRungsAreShared) {
  const auto none = [](const std::string&, const std::string&) { return false; };
  shots::AccuracySection section;
  section.ladders = {{"fem.time_step", {}, {"0.04", "0.02"}}, {"body.bar.cells", {}, {"4", "8"}}};
  const Result<AccuracyStudy> study = plan_accuracy_study(section, none);
  ASSERT_TRUE(study.ok()) << study.error().message;
  std::vector<std::string> references;
  for (const Rung& rung : study->rungs) {
    if (rung.is_reference)
      references.push_back(study->variants[rung.row].parameters.at(0).value);
  }
  EXPECT_THAT(references, ElementsAre("0.005", "32")) << "smaller steps, more cells: the way each ladder goes";
  section.reference = {{"fem.time_step", "0.02", {}}};
  const Result<AccuracyStudy> shared = plan_accuracy_study(section, none);
  EXPECT_EQ(shared->variants.size(), 5u) << "the reference is a rung that is there already, and is run once";
  section.reference.clear();
  section.ladders = {{"material.skin.model", {}, {"\"stvk\"", "\"corotated\""}}};
  EXPECT_FALSE(plan_accuracy_study(section, none).ok()) << "words have no finer word";
}

TEST(Accuracy, ARungThatTheShotIsAtAnywayIsNotRunAgain) {
  shots::AccuracySection section;
  section.ladders = {{"fem.time_step", {}, {"0.04", "0.02"}}};
  const Result<AccuracyStudy> study =
      plan_accuracy_study(section, [](const std::string& key, const std::string& value) {
        return key == "fem.time_step" && value == "0.02";
      });
  ASSERT_TRUE(study.ok()) << study.error().message;
  EXPECT_EQ(study->variants.size(), 3u) << "the shot, the coarser step, the reference";
  EXPECT_EQ(study->rungs.at(1).row, study->base);
}

TEST(Stress, PairsAreTheEndsOfEveryTwoKnobs) {
  const auto any = [](const std::string&, const std::string&) { return true; };
  shots::StressSection section;
  section.knobs = {{"a.x", {}, {"1", "2", "3"}}, {"b.y", {}, {"4", "5"}}, {"c.z", {}, {"6", "7"}}};
  const StressStudy study = plan_stress_study(section, {}, any);
  EXPECT_EQ(study.cases.size(), 3u + 2u + 2u + 3u * 4u);
  EXPECT_EQ(study.variants.size(), 1u + study.cases.size());
  section.pairs = false;
  EXPECT_EQ(plan_stress_study(section, {}, any).cases.size(), 7u);
}

TEST(Stress, PairsLeaveOutWhatIsRefusedAlone) {
  shots::StressSection section;
  section.knobs = {{"a.x", {}, {"1", "2", "3"}}, {"b.y", {}, {"4", "5"}}};
  const auto accepts = [](const std::string& key, const std::string& value) {
    return !(key == "a.x" && value == "3") && !(key == "b.y" && value == "4");
  };
  const StressStudy study = plan_stress_study(section, {}, accepts);
  ASSERT_EQ(study.cases.size(), 5u + 2u) << "alone they are run, to be refused";
  for (std::size_t c = 5; c < study.cases.size(); ++c) {
    EXPECT_THAT(study.cases[c].values, ::testing::ElementsAre(c - 5, 1u));
  }
}

std::vector<std::string> knob_keys(const std::string& name) {
  const Result<shots::Shot> shot = shots::load_shot(std::string(WRY_SOURCE_DIR) + "/shots/" + name + ".toml");
  EXPECT_TRUE(shot) << shot.error().message;
  std::vector<std::string> keys;
  for (const shots::Ladder& knob : knobs_of(*shot).knobs)
    keys.push_back(knob.key);
  return keys;
}

TEST(Stress, AShotsKnobsAreThoseThatItsMethodsRead) {
  using ::testing::Contains;
  using ::testing::Not;
  const std::vector<std::string> truck = knob_keys("dump_truck");
  for (const char* key : {"material.straw.youngs_modulus", "material.straw.youngs_modulus.z", "mpm.cell_size",
                          "material.straw.plastic_scale.z", "collider.bed.friction", "collider.bed.keys"})
    EXPECT_THAT(truck, Contains(key));
  for (const char* key : {"material.straw.couple_modulus_ratio", "fem.time_step", "collider.floor.keys"})
    EXPECT_THAT(truck, Not(Contains(key)));
  const std::vector<std::string> cantilever = knob_keys("cantilever");
  for (const char* key : {"material.soft.couple_modulus_ratio", "fem.time_step", "drive.left.keys"})
    EXPECT_THAT(cantilever, Contains(key));
  EXPECT_THAT(cantilever, Not(Contains("mpm.time_step")));
  EXPECT_THAT(knob_keys("helix"), Contains("material.third.rest_curvature"));
  EXPECT_THAT(knob_keys("lotus_bowl"), Contains("contact.friction"));
}

TEST(Stress, EveryValueOfAKnobIsOneThatTheShotTakesOrRefusesWithItsKey) {
  for (const char* name : {"dump_truck", "cantilever", "helix", "plate"}) {
    const std::string path = std::string(WRY_SOURCE_DIR) + "/shots/" + name + ".toml";
    for (const shots::Ladder& knob : knobs_of(*shots::load_shot(path)).knobs) {
      ASSERT_FALSE(knob.values.empty()) << knob.key;
      for (std::size_t v = 0; v < knob.values.size(); ++v) {
        const Result<shots::Shot> turned = shots::load_shot(path, {{knob.key, knob.values[v], {}}});
        EXPECT_TRUE(turned ||
                    turned.error().message.find(knob.key.substr(knob.key.rfind('.') + 1)) != std::string::npos)
            << name << ": " << turned.error().message;
        EXPECT_LT(value_label(knob, v).size(), 12u) << knob.key;
      }
    }
  }
}

TEST(StudyPage, DataCannotEndItsScript) {
  EXPECT_EQ(json_for_script("{\"a\":\"</script><b>\"}").find('<'), std::string::npos);
}

TEST(SharedMesh, ComesBackBitForBitAndDamageIsNoticed) {
  geometry::TetMesh mesh;
  mesh.vertices = Points::Random(7, 3);
  mesh.tets = Tets::Constant(2, 4, 3);
  mesh.body_coordinates = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>::Random(7, 2);
  mesh.attributes = {{"w", 1, {1, 2, 3, 4, 5, 6, 0.1}}};
  MeshedBody body;
  body.mesh = std::make_shared<const geometry::TetMesh>(mesh);
  body.report.notes = {"a note"};
  body.report.min_edge = 0.1;
  body.assets = {{"a.obj", "ff"}};
  const std::string bytes = encode_meshed_body(body);
  const Result<MeshedBody> read = decode_meshed_body(bytes, "x");
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->mesh->vertices, mesh.vertices);
  EXPECT_EQ(read->mesh->tets, mesh.tets);
  EXPECT_EQ(read->mesh->body_coordinates, mesh.body_coordinates);
  EXPECT_EQ(read->mesh->attributes.at(0).values, mesh.attributes[0].values);
  EXPECT_EQ(read->report.notes, body.report.notes);
  EXPECT_EQ(read->report.min_edge, 0.1);
  EXPECT_EQ(read->assets.at(0).sha256, "ff");
  for (std::size_t at = 0; at < bytes.size(); at += 13) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x21);
    EXPECT_FALSE(decode_meshed_body(damaged, "x").ok()) << "byte " << at;
    EXPECT_FALSE(decode_meshed_body(bytes.substr(0, at), "x").ok()) << "cut at " << at;
  }
}

} // namespace
} // namespace wry::pipeline
