#include "pipeline/assets/sandbox.h"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <span>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "pipeline/assets/import_process.h"
#include "pipeline/assets/import_protocol.h"
#include "sim/geometry/primitives.h"
#include "tests/pipeline/import_files_support.h"

namespace wry::pipeline {
namespace {

// Runs the deed in a process of its own, locked in; gives back its wait status.
int locked_in(const std::function<int()>& deed, const SandboxLimits& limits = {}) {
  const pid_t pid = fork();
  if (pid == 0) {
    if (!limit_resources(limits))
      _exit(101);
    if (!forbid_system_calls())
      _exit(102);
    _exit(deed());
  }
  int status = 0;
  waitpid(pid, &status, 0);
  return status;
}

// 0 when the call failed with EPERM.
int is_denied(long result) {
  return result < 0 && errno == EPERM ? 0 : 1;
}

TEST(Sandbox, MemoryAndTheEndAreAllowed) {
  const int status = locked_in([] {
    std::string big(50 << 20, 'x');
    return big[12345] == 'x' ? 7 : 8;
  });
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 7);
}

TEST(Sandbox, FilesSocketsProgramsProcessesAndSignalsAreDenied) {
  const pid_t parent = getpid();
  const std::function<int()> deeds[] = {
      [] { return is_denied(open("/etc/passwd", O_RDONLY)); },
      [] { return is_denied(open("/tmp/wry_never", O_WRONLY | O_CREAT, 0600)); },
      [] { return is_denied(unlink("/tmp/wry_never")); },
      [] { return is_denied(socket(AF_INET, SOCK_STREAM, 0)); },
      [] { return is_denied(socket(AF_UNIX, SOCK_STREAM, 0)); },
      [] { return is_denied(execl("/bin/true", "true", nullptr)); },
      [] { return is_denied(fork()); },
      [parent] { return is_denied(kill(parent, SIGUSR1)); },
      [] {
        return is_denied(
            mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED ? -1 : 0);
      },
  };
  int number = 0;
  for (const std::function<int()>& deed : deeds) {
    const int status = locked_in(deed);
    ASSERT_TRUE(WIFEXITED(status)) << number;
    EXPECT_EQ(WEXITSTATUS(status), 0) << number;
    ++number;
  }
}

TEST(Sandbox, AbortStillWorksAndLeavesNoCore) {
  const int status = locked_in([]() -> int { abort(); });
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGABRT);
  EXPECT_FALSE(WCOREDUMP(status));
}

TEST(Sandbox, ProcessorTimeAndMemoryEnd) {
  SandboxLimits limits;
  limits.cpu_seconds = 1;
  const int spun = locked_in(
      []() -> int {
        std::atomic<int> spins = 0;
        while (spins >= 0)
          spins = 1;
        return 0;
      },
      limits);
  ASSERT_TRUE(WIFSIGNALED(spun));
  EXPECT_EQ(WTERMSIG(spun), SIGXCPU);
#if !defined(__SANITIZE_ADDRESS__)
  limits.memory_bytes = 1ULL << 30;
  const int grown = locked_in([] { return malloc(std::size_t{2} << 30) == nullptr ? 0 : 1; }, limits);
  ASSERT_TRUE(WIFEXITED(grown));
  EXPECT_EQ(WEXITSTATUS(grown), 0);
#endif
}

// A stand-in for the reader: a shell script that gets the same arguments.
Result<std::string> run_script(const std::string& script, int wall_seconds = 5) {
  TemporaryFolder folder;
  ImportProcess process;
  process.program = folder.write("reader.sh", "#!/bin/sh\n" + script);
  chmod(process.program.c_str(), 0700);
  process.path = "bunny.obj";
  process.limits.wall_seconds = wall_seconds;
  return run_import_process(process);
}

TEST(ImportProcess, EveryWayToEndIsReported) {
  EXPECT_EQ(*run_script("printf hello >&3"), "hello");
  const Result<std::string> crashed = run_script("kill -SEGV $$");
  EXPECT_EQ(crashed.error().code, ErrorCode::bad_input);
  EXPECT_NE(crashed.error().message.find("SIGSEGV"), std::string::npos) << crashed.error().message;
  EXPECT_NE(run_script("kill -XCPU $$").error().message.find("processor time"), std::string::npos);
  EXPECT_NE(run_script("exit 71").error().message.find("MiB of memory"), std::string::npos);
  EXPECT_EQ(run_script("exit 3").error().code, ErrorCode::io);
  ImportProcess none;
  none.program = "/nowhere/wry";
  EXPECT_EQ(run_import_process(none).error().code, ErrorCode::io);
}

TEST(ImportProcess, ReadersThatHangAreKilledInTime) {
  const auto begin = std::chrono::steady_clock::now();
  for (const char* script : {"exec sleep 60", "exec 3>&-; exec sleep 60"}) {
    const Result<std::string> hung = run_script(script, 1);
    ASSERT_FALSE(hung);
    EXPECT_NE(hung.error().message.find("longer than 1 s"), std::string::npos) << hung.error().message;
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(8));
}

TEST(ImportProcess, EndlessAnswersAreCutOff) {
  TemporaryFolder folder;
  ImportProcess process;
  process.program = folder.write("reader.sh", "#!/bin/sh\nexec cat /dev/zero >&3\n");
  chmod(process.program.c_str(), 0700);
  process.limits.memory_bytes = 10 << 20;
  EXPECT_NE(run_import_process(process).error().message.find("10 MiB"), std::string::npos);
}

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

TEST(ImportProtocol, MeshesAndErrorsComeBackAsTheyWere) {
  RawMesh raw;
  raw.mesh = geometry::make_sphere(1.0, 0.5).value();
  raw.mesh.attributes = {{"heat", 1, std::vector<double>(static_cast<std::size_t>(raw.mesh.vertices.rows()), 0.5)}};
  raw.notes = {"a", "b"};
  const Result<RawMesh> back = decode_answer(bytes_of(encode_answer(raw)));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->mesh.vertices, raw.mesh.vertices);
  EXPECT_EQ(back->mesh.triangles, raw.mesh.triangles);
  EXPECT_EQ(back->mesh.attributes[0].values, raw.mesh.attributes[0].values);
  EXPECT_EQ(back->notes, raw.notes);
  const Result<RawMesh> failed = decode_answer(bytes_of(encode_answer(Error{ErrorCode::bad_input, "broken\x1b[2J"})));
  EXPECT_EQ(failed.error().code, ErrorCode::bad_input);
  EXPECT_EQ(failed.error().message, "broken [2J");
}

TEST(ImportProtocol, EveryDamageIsNoticedOrHarmless) {
  RawMesh raw;
  raw.mesh = geometry::make_sphere(1.0, 0.8).value();
  raw.mesh.attributes = {{"heat", 1, std::vector<double>(static_cast<std::size_t>(raw.mesh.vertices.rows()), 0.5)}};
  raw.notes = {"note"};
  const std::string good = encode_answer(raw);
  for (std::size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(decode_answer(bytes_of(good.substr(0, length))));
  EXPECT_FALSE(decode_answer(bytes_of(good + "x")));
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const char value : {'\x00', '\x01', '\x7f', '\xff'}) {
      std::string damaged = good;
      damaged[at] = value;
      const Result<RawMesh> back = decode_answer(bytes_of(damaged));
      if (!back)
        continue;
      EXPECT_EQ(back->mesh.vertices.rows(), raw.mesh.vertices.rows());
      EXPECT_GE(back->mesh.triangles.minCoeff(), 0);
      EXPECT_LT(back->mesh.triangles.maxCoeff(), back->mesh.vertices.rows());
    }
  }
}

} // namespace
} // namespace wry::pipeline
