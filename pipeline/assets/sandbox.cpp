#include "pipeline/assets/sandbox.h"

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <vector>

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace wry::pipeline {

namespace {

// Address sanitizers reserve terabytes of address space that they do not use.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool LIMITS_ADDRESS_SPACE = false;
#else
constexpr bool LIMITS_ADDRESS_SPACE = true;
#endif

Status set_limit(int resource, rlim_t soft, rlim_t hard, const char* what) {
  const rlimit limit{soft, hard};
  if (setrlimit(static_cast<__rlimit_resource_t>(resource), &limit) != 0)
    return make_error(ErrorCode::io, "cannot limit {} of the import process: {}", what, std::strerror(errno));
  return {};
}

// What parsing needs once the input is read: memory, the pipe, the end.
constexpr int ALLOWED[] = {
    SYS_read,
    SYS_write,
    SYS_writev,
    SYS_close,
    SYS_fstat,
    SYS_newfstatat,
    SYS_lseek,
    SYS_munmap,
    SYS_mremap,
    SYS_brk,
    SYS_madvise,
    SYS_rt_sigaction,
    SYS_rt_sigprocmask,
    SYS_rt_sigreturn,
    SYS_sigaltstack,
    SYS_futex,
    SYS_gettid,
    SYS_getpid,
    SYS_exit,
    SYS_exit_group,
    SYS_clock_gettime,
    SYS_gettimeofday,
    SYS_time,
    SYS_getrandom,
    SYS_sched_yield,
    SYS_restart_syscall,
    SYS_sysinfo,
    SYS_sched_getaffinity,
    SYS_getrusage,
    // Threads that a library started before main are sometimes still on their way when the filter comes down.
    SYS_rseq,
    SYS_set_robust_list,
};

sock_filter load(std::size_t offset) {
  return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
}

sock_filter answer(std::uint32_t verdict) {
  return BPF_STMT(BPF_RET | BPF_K, verdict);
}

sock_filter skip_unless_equal(std::uint32_t value, std::uint8_t instructions) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, instructions);
}

std::vector<sock_filter> filter_program() {
  const std::uint32_t deny = SECCOMP_RET_ERRNO | EPERM;
  const auto arg = [](int i) { return offsetof(seccomp_data, args) + 8 * static_cast<std::size_t>(i); };
  std::vector<sock_filter> program = {
      load(offsetof(seccomp_data, arch)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AUDIT_ARCH_X86_64, 1, 0),
      answer(SECCOMP_RET_KILL_PROCESS),
      load(offsetof(seccomp_data, nr)),
  };
  for (const int call : ALLOWED) {
    program.push_back(skip_unless_equal(static_cast<std::uint32_t>(call), 1));
    program.push_back(answer(SECCOMP_RET_ALLOW));
  }
  // Memory may be mapped, but not executable.
  for (const int call : {SYS_mmap, SYS_mprotect}) {
    program.push_back(skip_unless_equal(static_cast<std::uint32_t>(call), 4));
    program.push_back(load(arg(2)));
    program.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, PROT_EXEC, 0, 1));
    program.push_back(answer(deny));
    program.push_back(answer(SECCOMP_RET_ALLOW));
  }
  // abort() signals its own process; nobody else's.
  program.push_back(skip_unless_equal(SYS_tgkill, 4));
  program.push_back(load(arg(0)));
  program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(getpid()), 1, 0));
  program.push_back(answer(deny));
  program.push_back(answer(SECCOMP_RET_ALLOW));
  program.push_back(answer(deny));
  return program;
}

} // namespace

Status limit_resources(const SandboxLimits& limits) {
  const auto seconds = static_cast<rlim_t>(limits.cpu_seconds);
  if (LIMITS_ADDRESS_SPACE) {
    if (Status status = set_limit(RLIMIT_AS, limits.memory_bytes, limits.memory_bytes, "the memory"); !status)
      return status;
  }
  // At the soft limit SIGXCPU, at the hard one SIGKILL.
  if (Status status = set_limit(RLIMIT_CPU, seconds, seconds + 1, "the processor time"); !status)
    return status;
  if (Status status = set_limit(RLIMIT_FSIZE, 0, 0, "the file size"); !status)
    return status;
  if (Status status = set_limit(RLIMIT_CORE, 0, 0, "the core dump"); !status)
    return status;
  if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0 || prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
      prctl(PR_SET_DUMPABLE, 0, 0, 0, 0) != 0)
    return make_error(ErrorCode::io, "cannot drop the privileges of the import process: {}", std::strerror(errno));
  return {};
}

Status forbid_system_calls() {
  std::vector<sock_filter> program = filter_program();
  sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  if (syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &filter) != 0)
    return make_error(ErrorCode::unavailable, "this kernel refuses system-call filters: {}", std::strerror(errno));
  return {};
}

} // namespace wry::pipeline
