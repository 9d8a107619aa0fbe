#include "tests/cli/slurm_support.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <random>
#include <thread>

#include <unistd.h>

#include "tests/cli/program_support.h"

namespace wry::cli_test {

namespace fs = std::filesystem;

namespace {

/// Ports that another farm on this machine is unlikely to have.
int port(int offset) {
  return 20000 + 4 * (getpid() % 8000) + offset;
}

void end_process(const fs::path& pid_file) {
  const std::string text = fs::exists(pid_file) ? read_text(pid_file) : std::string();
  const pid_t pid = static_cast<pid_t>(std::atol(text.c_str()));
  if (pid <= 1 || ::kill(pid, SIGTERM) != 0)
    return;
  for (int i = 0; i < 300; ++i) {
    const std::string state = read_text("/proc/" + std::to_string(pid) + "/stat");
    if (state.empty() || state.find(") Z") != std::string::npos)
      return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ::kill(pid, SIGKILL);
}

} // namespace

bool shell(const std::string& command) {
  return std::system(("{ " + command + "; } >/dev/null 2>&1").c_str()) == 0;
}

bool SlurmFarm::is_installed() {
  return geteuid() == 0 && shell("command -v sbatch && command -v slurmctld && command -v slurmd && command -v munged");
}

SlurmFarm::SlurmFarm(const fs::path& folder)
    : m_folder(folder) {
  for (const char* part : {"ctld", "n1", "n2", "run"})
    fs::create_directories(m_folder / part);
  fs::permissions(m_folder, fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec |
                                fs::perms::others_read | fs::perms::others_exec);
  std::mt19937 random(std::random_device{}());
  std::string key(1024, '\0');
  for (char& byte : key)
    byte = static_cast<char>(random());
  write_text(m_folder / "munge.key", key);
  fs::permissions(m_folder / "munge.key", fs::perms::owner_read | fs::perms::owner_write);
  write_configuration();
  // Left to find out by itself, slurmd does not start where no cgroups are mounted; this farm uses none.
  write_text(m_folder / "cgroup.conf", "CgroupPlugin=cgroup/v1\n");
  const std::string f = m_folder.string();
  setenv("SLURM_CONF", (f + "/slurm.conf").c_str(), 1);
  if (!shell("munged --force --num-threads=2 --key-file=" + f + "/munge.key --socket=" + f +
             "/run/munge.sock --pid-file=" + f + "/run/munged.pid --log-file=" + f + "/munged.log --seed-file=" + f +
             "/munge.seed"))
    m_problem = "munged does not start";
  for (const char* daemon : {"slurmctld -c", "slurmd -N n1", "slurmd -N n2"}) {
    if (m_problem.empty() && !shell(std::string(daemon) + " -f " + f + "/slurm.conf"))
      m_problem = std::string(daemon) + " does not start";
  }
  for (int i = 0; m_problem.empty() && !shell("test \"$(sinfo --noheader --states=idle --format=%D)\" = 2"); ++i) {
    if (i > 100)
      m_problem = "the nodes do not become idle";
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

SlurmFarm::~SlurmFarm() {
  for (const char* name : {"n1.pid", "n2.pid", "ctld.pid", "munged.pid"})
    end_process(m_folder / "run" / name);
  unsetenv("SLURM_CONF");
}

void SlurmFarm::write_configuration() const {
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  std::ofstream conf(m_folder / "slurm.conf");
  const std::string f = m_folder.string();
  conf << "ClusterName=wrytest\nSlurmctldHost=" << host << "(127.0.0.1)\nSlurmctldPort=" << port(0)
       << "\nSlurmUser=root\nSlurmdUser=root\nAuthType=auth/munge\nCredType=cred/munge\nAuthInfo=socket=" << f
       << "/run/munge.sock\nStateSaveLocation=" << f << "/ctld\nSlurmdSpoolDir=" << f << "/%n\nSlurmctldPidFile=" << f
       << "/run/ctld.pid\nSlurmdPidFile=" << f << "/run/%n.pid\nSlurmctldLogFile=" << f
       << "/ctld.log\nSlurmdLogFile=" << f
       << "/%n.log\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n"
          "SelectTypeParameters=CR_Core\nReturnToService=2\n"
          "SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,sched_interval=1\nMpiDefault=none\n"
          "JobCompType=jobcomp/none\nAccountingStorageType=accounting_storage/none\n"
          "JobAcctGatherType=jobacct_gather/none\nSwitchType=switch/none\nKillWait=5\nSlurmdTimeout=10\n";
  for (int node = 1; node <= 2; ++node)
    conf << "NodeName=n" << node << " NodeHostname=" << host << " NodeAddr=127.0.0.1 Port=" << port(node)
         << " CPUs=2 RealMemory=500\n";
  conf << "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n";
}

void SlurmFarm::kill_node(const std::string& node) {
  const std::string text = read_text(m_folder / "run" / (node + ".pid"));
  if (const long pid = std::atol(text.c_str()); pid > 1)
    ::kill(static_cast<pid_t>(pid), SIGKILL);
  for (const fs::directory_entry& process : fs::directory_iterator("/proc")) {
    const long pid = std::atol(process.path().filename().c_str());
    if (pid <= 1)
      continue;
    // What this farm's node runs has its name and this farm's configuration in its environment.
    const std::string environment = read_text(process.path() / "environ");
    if (environment.find("SLURMD_NODENAME=" + node) != std::string::npos &&
        environment.find(m_folder.string()) != std::string::npos)
      ::kill(static_cast<pid_t>(pid), SIGKILL);
  }
  shell("scontrol update NodeName=" + node + " State=DOWN Reason=killed");
}

std::string SlurmFarm::logs() const {
  std::string text;
  for (const char* name : {"ctld.log", "n1.log", "n2.log"}) {
    const std::string log = read_text(m_folder / name);
    text += "---- " + std::string(name) + "\n" + log.substr(log.size() - std::min<std::size_t>(log.size(), 1500));
  }
  return text;
}

} // namespace wry::cli_test
