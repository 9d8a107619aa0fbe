#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace wry::cli_test {

/// A real Slurm on loopback: munged, slurmctld and two nodes on this host, all below one folder, ended with the object.
/// SLURM_CONF points at it as long as it lives.
class SlurmFarm {
public:
  explicit SlurmFarm(const std::filesystem::path& folder);
  ~SlurmFarm();
  SlurmFarm(const SlurmFarm&) = delete;
  SlurmFarm& operator=(const SlurmFarm&) = delete;

  /// Empty when both nodes are idle; else why there is no farm.
  const std::string& problem() const { return m_problem; }
  /// Kills a node: its daemon and everything that it runs; then the controller is told that it is down.
  void kill_node(const std::string& node);
  /// What the logs of the farm say, for messages.
  std::string logs() const;

  /// Whether the programs of Slurm and munge are installed and this user may start them.
  static bool is_installed();

private:
  void write_configuration() const;
  std::filesystem::path m_folder;
  std::string m_problem;
};

/// Whether a shell command succeeds; its output goes nowhere.
bool shell(const std::string& command);

} // namespace wry::cli_test
