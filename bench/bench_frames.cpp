// Listens to a running instrument: frames missed and the time from a joint state to its frame, corrected
// beside nominal, for the same messages in one run.
//   bench_frames [seconds, default 60]       with instrument.launch rate:=1000 nominal_rate:=1000
//   margin:=1, the machine homed and moving, and a promoted calibration (beyond the margin frames are
//   withheld, not missed)
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <tf2_msgs/TFMessage.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace {

struct Seen {
  double joints = 0.0, corrected = 0.0, nominal = 0.0;  // s, wall clock at arrival; 0: not yet
  int correctedTimes = 0;
};

std::map<std::uint64_t, Seen> seen;  // by stamp, ns

/// CPU seconds that a node of this machine has used so far, found by its name.
double cpuOf(const std::string& node) {
  const std::string command = "pgrep -f '__name:=" + node + "( |$)' | head -1";
  FILE* pipe = popen(command.c_str(), "r");
  int pid = 0;
  if (pipe == nullptr || fscanf(pipe, "%d", &pid) != 1) pid = 0;
  if (pipe != nullptr) pclose(pipe);
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string word;
  double ticks = 0.0;
  for (int i = 1; stat >> word && i <= 15; ++i)
    if (i == 14 || i == 15) ticks += std::stod(word);
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const std::size_t at =
      std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

void report(const char* name, const std::vector<double>& latency, std::size_t wanted, double cpu,
            double seconds) {
  std::printf(
      "%-22s frames %6zu of %6zu, missed %4zu | latency median %7.1f us, 99 %% %7.1f us | CPU %4.1f %%\n",
      name, latency.size(), wanted, wanted - latency.size(), 1e6 * quantile(latency, 0.5),
      1e6 * quantile(latency, 0.99), 100.0 * cpu / seconds);
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "bench_frames", ros::init_options::AnonymousName);
  const double seconds = argc > 1 ? std::atof(argv[1]) : 60.0;
  ros::NodeHandle node;
  const ros::TransportHints fast = ros::TransportHints().tcpNoDelay();
  const auto joints = node.subscribe<sensor_msgs::JointState>(
      "joint_states", 10000,
      [](const sensor_msgs::JointStateConstPtr& m) {
        seen[m->header.stamp.toNSec()].joints = ros::WallTime::now().toSec();
      },
      ros::VoidConstPtr(), fast);
  const auto frames = node.subscribe<tf2_msgs::TFMessage>(
      "/tf", 10000,
      [](const tf2_msgs::TFMessageConstPtr& m) {
        const double now = ros::WallTime::now().toSec();
        for (const auto& t : m->transforms) {
          Seen& s = seen[t.header.stamp.toNSec()];
          if (t.child_frame_id == "probe_tip_corrected") s.corrected = now, ++s.correctedTimes;
          if (t.child_frame_id == "x_slide") s.nominal = now;
        }
      },
      ros::VoidConstPtr(), fast);
  const ros::WallTime warm = ros::WallTime::now() + ros::WallDuration(2.0);
  while (ros::ok() && ros::WallTime::now() < warm)
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.01));
  seen.clear();
  const std::vector<std::string> names = {"compensation", "robot_state_publisher", "axis_driver"};
  std::vector<double> cpu;
  for (const std::string& name : names) cpu.push_back(cpuOf(name));
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(seconds);
  while (ros::ok() && ros::WallTime::now() < end)
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.01));
  for (std::size_t i = 0; i < names.size(); ++i) cpu[i] = cpuOf(names[i]) - cpu[i];

  std::vector<double> corrected, nominal, correctedOfBoth, nominalOfBoth;
  std::size_t wanted = 0, doubled = 0;
  // Without both ends, where a message of one kind may lie outside.
  const std::uint64_t first = seen.empty() ? 0 : seen.begin()->first + 100000000u,
                      last = seen.empty() ? 0 : seen.rbegin()->first - 100000000u;
  for (const auto& [stamp, s] : seen) {
    if (stamp < first || stamp > last || s.joints == 0.0) continue;
    ++wanted;
    const double at = 1e-9 * static_cast<double>(stamp % 1000000000000ULL);
    const double base = static_cast<double>(stamp / 1000000000000ULL) * 1000.0;
    const auto since = [&](double wall) { return (wall - base) - at; };
    if (s.corrected != 0.0) corrected.push_back(since(s.corrected));
    if (s.nominal != 0.0) nominal.push_back(since(s.nominal));
    if (s.corrected != 0.0 && s.nominal != 0.0) {
      correctedOfBoth.push_back(since(s.corrected));
      nominalOfBoth.push_back(since(s.nominal));
    }
    doubled += s.correctedTimes > 1;
  }
  std::printf("%.0f s, %zu joint states (%.1f a second)\n", seconds, wanted,
              static_cast<double>(wanted) / (seconds - 0.2));
  report("compensation", corrected, wanted, cpu[0], seconds);
  report("robot_state_publisher", nominal, wanted, cpu[1], seconds);
  std::printf(
      "doubled frames %zu | median ratio over the %zu messages that both answered: %.3f | axis_driver CPU "
      "%.1f %%\n",
      doubled, correctedOfBoth.size(), quantile(correctedOfBoth, 0.5) / quantile(nominalOfBoth, 0.5),
      100.0 * cpu[2] / seconds);
  return 0;
}
