#include <filesystem>
#include <fstream>

#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/run/resources.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {
namespace {

using pipeline::testing::TemporaryFolder;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::uint64_t MIB = 1u << 20;

/// A machine of files: 1,000 MiB are free, and the program has 100 MiB of which it uses 60.
class FilesOfAMachine : public ::testing::Test {
protected:
  FilesOfAMachine() {
    put("proc/meminfo", "MemTotal:  4096000 kB\nMemAvailable:   1024000 kB\n");
    const auto pages = [](std::uint64_t mebibytes) {
      return std::to_string(mebibytes * MIB / static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)));
    };
    put("proc/self/statm", pages(100) + " " + pages(60) + " 0 0 0 0 0\n");
    put("proc/self/cgroup", "0::/\n");
    limit_address_space("unlimited");
  }

  void put(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories((m_folder.path() / path).parent_path());
    std::ofstream(m_folder.path() / path) << text;
  }
  void limit_address_space(const std::string& bytes) const {
    put("proc/self/limits", "Limit   Soft Limit  Hard Limit  Units\nMax address space   " + bytes +
                                "   unlimited   bytes\nMax nice priority   0   0\n");
  }
  Machine machine() const {
    const Result<Machine> read = read_machine(m_folder.path(), {m_folder.path() / "proc", m_folder.path() / "cgroup"});
    EXPECT_TRUE(read.ok());
    return read.ok() ? *read : Machine{};
  }
  std::uint64_t least_memory() const {
    std::uint64_t least = ~0ull;
    for (const Room& room : machine().memory)
      least = std::min(least, room.bytes);
    return least / MIB;
  }

  const TemporaryFolder m_folder;
};

TEST_F(FilesOfAMachine, CountWhatIsFreeAndWhatTheProgramHas) {
  EXPECT_EQ(least_memory(), 1060u);
  std::filesystem::remove(m_folder.path() / "proc/meminfo");
  EXPECT_TRUE(machine().memory.empty()) << "nothing is known, so nothing is refused";
}

TEST_F(FilesOfAMachine, LimitTheAddressSpace) {
  limit_address_space("419430400");
  EXPECT_EQ(least_memory(), 400u - 100u + 60u);
}

TEST_F(FilesOfAMachine, LimitAControlGroupByAllAboveIt) {
  put("proc/self/cgroup", "0::/farm/job\n");
  put("cgroup/farm/job/memory.max", "max\n");
  put("cgroup/farm/memory.max", "524288000\n");
  put("cgroup/farm/memory.current", "419430400\n");
  put("cgroup/farm/memory.stat", "anon 1\ninactive_file 104857600\nactive_file 7\n");
  EXPECT_EQ(least_memory(), 500u - (400u - 100u) + 60u);
  put("proc/self/cgroup", "0::/elsewhere/that/is/not/mounted\n");
  put("cgroup/memory.max", "314572800\n");
  put("cgroup/memory.current", "104857600\n");
  EXPECT_EQ(least_memory(), 260u);
}

TEST_F(FilesOfAMachine, LimitAControlGroupOfTheFirstVersion) {
  put("proc/self/cgroup", "9:cpu,cpuacct:/a\n4:memory:/a\n");
  put("cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(least_memory(), 1060u) << "no limit";
  put("cgroup/memory/a/memory.limit_in_bytes", "209715200\n");
  put("cgroup/memory/a/memory.usage_in_bytes", "104857600\n");
  put("cgroup/memory/a/memory.stat", "inactive_file 1\ntotal_inactive_file 52428800\n");
  EXPECT_EQ(least_memory(), 200u - 50u + 60u);
}

TEST_F(FilesOfAMachine, CountTheFramesThatAreThereAsRoom) {
  const std::uint64_t before = machine().disk.front().bytes;
  put("frames/0001.h5", std::string(64 * MIB, 'x'));
  EXPECT_NEAR(double(machine().disk.front().bytes), double(before), double(32 * MIB))
      << "what is kept is not needed anew";
}

CostEstimate estimate() {
  CostEstimate cost;
  cost.memory_bytes = 900 * MIB;
  cost.bytes_per_frame = 10 * MIB;
  cost.shares = {
      {"the 5 grains of body heap", "fewer body.heap.sub_particles.per_particle need less", 700 * MIB, 90 * MIB},
      {"2 checkpoints", "a smaller fem.keep needs less", 0, 800 * MIB}};
  return cost;
}

Machine with(std::uint64_t memory, std::uint64_t disk) {
  return {{{2 * memory, "this machine's memory"}, {memory, "a group's memory"}}, {{disk, "the disk of out/heap"}}};
}

TEST(Resources, ThatSufficeAreNotSpokenOf) {
  EXPECT_TRUE(require_resources("heap", estimate(), 10, with(900 * MIB, 100 * MIB)).ok());
  EXPECT_TRUE(require_resources("heap", estimate(), 10, {}).ok());
}

TEST(Resources, TooLittleMemorySaysWhoseLimitWhatTakesMostAndHowItTakesLess) {
  const Status refused = require_resources("heap", estimate(), 10, with(899 * MIB, 100 * MIB));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory);
  for (const char* part :
       {"heap: needs about 900 MiB of memory", "899 MiB of a group's memory", "the 5 grains of body heap", "700 MiB",
        "body.heap.sub_particles.per_particle", "--ignore-limits"})
    EXPECT_THAT(refused.error().message, HasSubstr(part));
}

TEST(Resources, TooLittleDiskIsSaidInTheSameWay) {
  const Status refused = require_resources("heap", estimate(), 11, with(900 * MIB, 100 * MIB));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::cannot_write);
  for (const char* part : {"needs about 110 MiB of disk", "100 MiB of the disk of out/heap", "2 checkpoints",
                           "fem.keep", "--frames", "--out", "--ignore-limits"})
    EXPECT_THAT(refused.error().message, HasSubstr(part));
  EXPECT_THAT(refused.error().message, Not(HasSubstr("grains")));
}

} // namespace
} // namespace wry::pipeline
